// SPDX-License-Identifier: BSD-3-Clause
// Ranks killed at random moments, and runs that go on from their stores. MAPJOIN_KILLS says how many times.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <mapjoin/io/store/store.hpp>
#include <tests/mpi/kill.hpp>
#include <tests/mpi/ranks_test.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sqlite.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;

/// The number of maps in the plane whose information matrix is not of the size of their poses and features.
constexpr const char* kHalfMaps =
    "SELECT count(*) FROM maps WHERE base IS NOT NULL AND length(information) <> 4 * (3 * (length(poses) / 4) + 2 * "
    "(length(features) / 4)) * (3 * (length(poses) / 4) + 2 * (length(features) / 4) + 1)";

class Resumed : public RanksTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(call({"simulate", "--poses", "30000", "-o", path("log.g2o"), "--quiet"}).exit_code, 0);
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(call_ranks(2, command("whole")).exit_code, 0);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  std::vector<std::string> command(const std::string& name) const {
    return {"run", path("log.g2o"), "-o", path(name + ".g2o"), "--poses-per-map", "20", "--checkpoint", path(name)};
  }
  /// Waits for a share of the time of an undisturbed run or, `by_size`, until the store of the rank has grown to that share of
  /// its size.
  std::function<void(const std::function<bool()>&)> moment(bool by_size, std::size_t rank, double share) const {
    if (!by_size) return [=, this](const auto&) { sleep_for(share * seconds); };
    const std::string store = fmt::format("{}-of-2.maps", rank + 1);
    const auto size = static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(path("whole/" + store))));
    return [=, this](const std::function<bool()>& is_over) {
      std::error_code none_yet;
      while (!is_over() && !fs::exists(path("killed/" + store)) &&
             !(fs::file_size(path("killed/" + store + ".partial"), none_yet) >= size && !none_yet)) {
        sleep_for(0.001);
      }
    };
  }
  std::size_t stores(const std::string& extension) const {
    std::size_t count = 0;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(path("killed"), none)) count += entry.path().extension() == extension;
    return count;
  }
  /// Expects finished stores to be readable, and unfinished ones to hold whole maps. It looks at a copy, for looking rolls back
  /// what was not committed.
  void expect_sound() const {
    if (!fs::exists(path("killed"))) return;
    fs::copy(path("killed"), path("copy"));
    for (const auto& entry : fs::directory_iterator(path("copy"))) {
      const std::string extension = entry.path().extension();
      if (extension == ".maps") {
        const auto stored = read_store(entry.path());
        EXPECT_TRUE(stored) << stored.error().message;
      } else if (extension == ".partial") {
        EXPECT_EQ(sql_result(entry.path(), "PRAGMA integrity_check"), "ok");
        if (sql_result(entry.path(), "SELECT count(*) FROM sqlite_master") == "0") continue;  // killed before it had begun
        EXPECT_EQ(sql_result(entry.path(), kHalfMaps), "0");
      }
    }
    fs::remove_all(path("copy"));
  }

  double seconds = 0.0;
};

TEST_F(Resumed, RunsEndAtTheSameMap) {
  const char* const asked = std::getenv("MAPJOIN_KILLS");
  const int kills = asked ? std::atoi(asked) : 6;
  ASSERT_GE(kills, 6);
  Random random;
  int killed = 0;
  int in_the_build = 0;
  int resumed = 0;
  for (int k = 0; k < kills; ++k) {
    const auto victim = static_cast<std::size_t>(random.uniform(0.0, 2.0));
    const bool by_size = k % 2 == 0;
    const double share = random.uniform(0.0, 1.0);
    SCOPED_TRACE(fmt::format("kill {}: rank {} at {:.3f} of {}", k, victim, share, by_size ? "its store" : "the time"));
    const bool was_done = kill_one_of_two(command("killed"), victim, moment(by_size, victim, share));
    // A rank that is killed may have written the map already.
    const bool is_written = fs::exists(path("killed.g2o"));
    EXPECT_TRUE(is_written || !was_done);
    EXPECT_TRUE(!is_written || content_of(path("killed.g2o")) == content_of(path("whole.g2o")));
    killed += was_done ? 0 : 1;
    in_the_build += stores(".partial") > 0 ? 1 : 0;
    expect_sound();
    resumed += report_of_ranks(2, command("killed"))["local_maps"]["iterations"].is_null() ? 1 : 0;
    for (const char* file : {".g2o", "/1-of-2.maps", "/2-of-2.maps"}) {
      EXPECT_TRUE(content_of(path(std::string("killed") + file)) == content_of(path(std::string("whole") + file))) << file;
    }
    EXPECT_EQ(stores(".maps"), 2U);
    EXPECT_EQ(std::distance(fs::directory_iterator(path("killed")), {}), 2) << "nothing else is left";
    fs::remove_all(path("killed"));
    fs::remove(path("killed.g2o"));
  }
  fmt::print("of {} kills, {} before the end, {} while stores were built, {} went on from some maps\n", kills, killed,
             in_the_build, resumed);
  EXPECT_GE(killed, kills / 2);
  EXPECT_GE(in_the_build, kills / 4);
  EXPECT_GE(resumed, kills / 4);
}

}  // namespace
}  // namespace mapjoin::testing
