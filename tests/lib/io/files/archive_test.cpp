// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <tests/support/data.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using testing::tar_member;
using testing::tar_of;
using testing::write_gzip;

class ArchiveTest : public ::testing::Test {
 protected:
  /// The names and contents of the files not called "other", in the order of the visit.
  Expected<std::vector<std::pair<std::string, std::string>>> visit(const fs::path& path) {
    std::vector<std::pair<std::string, std::string>> seen;
    const auto done = visit_files(
        path, [](const std::string& name) { return name != "other"; },
        [&](const fs::path& file, std::string_view bytes) -> Expected<void> {
          seen.emplace_back(file.filename().string(), bytes);
          return {};
        });
    if (!done) return tl::unexpected(done.error());
    return seen;
  }
  testing::TemporaryFolder folder;
  const std::string long_text = std::string(3000, 'a').append("end");  // for a sum g++ 12 has a false warning
};

TEST_F(ArchiveTest, GivesTheWantedMembersPlainOrGzipped) {
  const std::string tar = tar_of({{"maps/b", "short"}, {"maps/other", "unwanted"}, {"maps/c", long_text}, {"empty", ""}});
  folder.file("plain.tar", tar);
  write_gzip(folder.path() / "maps.tar.gz", tar);
  for (const char* name : {"plain.tar", "maps.tar.gz"}) {
    EXPECT_TRUE(is_tar_archive(FileBytes::read(folder.path() / name)->view()));
    const auto seen = visit(folder.path() / name);
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_THAT(*seen, ElementsAre(Pair("empty", ""), Pair("b", "short"), Pair("c", long_text)));
  }
}

TEST_F(ArchiveTest, GivesTheWantedFilesOfAFolderInOrderAndInflated) {
  folder.file("b", "plain");
  folder.file("other", "unwanted");
  write_gzip(folder.path() / "a.gz", long_text);
  const auto seen = visit(folder.path());
  ASSERT_TRUE(seen) << seen.error().message;
  EXPECT_THAT(*seen, ElementsAre(Pair("a.gz", long_text), Pair("b", "plain")));
}

TEST_F(ArchiveTest, GivesGzippedMembersInflated) {
  write_gzip(folder.path() / "packed", long_text);
  const std::string packed = testing::bytes_of(folder.path() / "packed");
  folder.file("maps.tar", tar_of({{"a.gz", packed}, {"b", "plain"}}));
  const auto seen = visit(folder.path() / "maps.tar");
  ASSERT_TRUE(seen) << seen.error().message;
  EXPECT_THAT(*seen, ElementsAre(Pair("a.gz", long_text), Pair("b", "plain")));

  folder.file("maps.tar", tar_of({{"a.gz", packed.substr(0, 40)}}));
  EXPECT_THAT(visit(folder.path() / "maps.tar").error().message, HasSubstr("maps.tar/a.gz: the gzip stream is cut off"));
}

TEST_F(ArchiveTest, RefusesAnArchiveThatIsCutShort) {
  const fs::path path = folder.path() / "maps.tar";
  const std::string tar = tar_of({{"a", long_text}});
  folder.file("maps.tar", tar.substr(0, 2000));
  EXPECT_THAT(visit(path).error().message, HasSubstr("maps.tar: damaged archive: it ends inside 'a'"));

  folder.file("maps.tar", tar_of({{"\x1b[2J\n", long_text}}).substr(0, 2000));
  EXPECT_THAT(visit(path).error().message, HasSubstr("it ends inside '?[2J?'"));

  write_gzip(path, tar);
  folder.file("maps.tar", testing::bytes_of(path).substr(0, 60));
  EXPECT_THAT(visit(path).error().message, HasSubstr("maps.tar: the gzip stream is cut off"));
}

TEST_F(ArchiveTest, RefusesAnArchiveThatIsCutBetweenMembers) {
  const std::string tar = tar_of({{"a", "short"}, {"b", "short"}});
  for (const std::size_t size : {1024u, 2048u, 2100u}) {
    folder.file("maps.tar", tar.substr(0, size));
    EXPECT_THAT(visit(folder.path() / "maps.tar").error().message, HasSubstr("maps.tar: damaged archive: it is cut off"))
        << size;
  }
}

TEST_F(ArchiveTest, KnowsMembersByTheirLongNames) {
  const std::string name(99, 'n');
  const std::string long_name = std::string(120, 'd') + "/" + name + ".txt";
  const std::string record = " path=" + long_name + "\n";
  for (const std::string& header :
       {tar_member("././@LongLink", long_name + '\0', 'L'),
        tar_member("PaxHeaders/1", "13 mtime=1.5\n" + std::to_string(record.size() + 3) + record, 'x') +
            tar_member("GlobalHead", "14 comment=no\n", 'g')}) {
    folder.file("maps.tar", header + tar_of({{long_name.substr(0, 99), "first"}, {"second", "short"}}));
    const auto seen = visit(folder.path() / "maps.tar");
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_THAT(*seen, ElementsAre(Pair(name + ".txt", "first"), Pair("second", "short")));
  }
}

TEST_F(ArchiveTest, RefusesRecordsOfAHeaderThatAreNone) {
  for (const std::string records : {"path=a\n", "99 path=a\n", "0 path=a\n", "2 path=a\n"}) {
    folder.file("maps.tar", tar_member("PaxHeaders/1", records, 'x') + tar_of({{"a", "short"}}));
    EXPECT_THAT(visit(folder.path() / "maps.tar").error().message, HasSubstr("a member's header is wrong")) << records;
  }
}

TEST_F(ArchiveTest, RefusesAHeaderWithAWrongSizeOrChecksum) {
  const fs::path path = folder.path() / "maps.tar";
  for (const std::size_t at : {std::size_t{124}, std::size_t{150}, std::size_t{10}}) {
    std::string tar = tar_of({{"a", long_text}});
    tar[at] = '9';
    folder.file("maps.tar", tar);
    EXPECT_THAT(visit(path).error().message, HasSubstr("a member's header is wrong")) << at;
  }
}

TEST_F(ArchiveTest, NamesWhatIsNeitherFolderNorArchive) {
  EXPECT_THAT(visit(folder.path() / "absent").error().message, HasSubstr("absent: No such file"));
  const fs::path notes = folder.file("notes", "some text");
  EXPECT_THAT(visit(notes).error().message, HasSubstr("notes: neither a folder nor a tar archive"));
}

TEST_F(ArchiveTest, ReadsAnArchiveThatTarMade) {
  std::size_t files = 0, size = 0;
  const auto done = visit_files(
      testing::data_file("vicpark-200-local-maps/localmaps_txt.tar.gz"), [](const std::string&) { return true; },
      [&](const fs::path&, std::string_view bytes) -> Expected<void> {
        ++files;
        size += bytes.size();
        return {};
      });
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(files, 200u);
  EXPECT_EQ(size, 11538729u);
}

}  // namespace
}  // namespace mapjoin
