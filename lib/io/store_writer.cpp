// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <mapjoin/io/store.hpp>
#include <mapjoin/io/store_records.hpp>
#include <mapjoin/io/store_schema.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using store::Contents;
using store::Database;
using store::Statement;

/// A batch is one transaction. Its bounds depend on the maps alone: so does then every byte of the file, where a build that was
/// interrupted goes on after the last whole batch.
constexpr std::size_t kBatchMaps = 256;
constexpr std::size_t kBatchBytes = std::size_t{8} << 20;

fs::path partial_path(const fs::path& path) {
  return path.string() + ".partial";
}

tl::unexpected<Error> cannot_write(const fs::path& path, const std::string& reason) {
  return tl::unexpected(Error{ErrorKind::kCannotWrite, fmt::format("{}: {}", path.string(), reason)});
}

Expected<void> create_tables(Database& database) {
  std::string sql =
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", store::kApplicationId, store::kVersion);
  for (const char* table : store::kTables) sql += std::string(table) + ";";
  return database.execute(sql);
}

enum class Found { kNothing, kThisBuild, kOtherBuild };

/// What an earlier build left in the file.
template <int Dim>
Expected<Found> find(Database& database, const fs::path& path, const Contents<Dim>& contents) {
  const auto tables = database.integer("SELECT count(*) FROM sqlite_master");
  const auto application = database.integer("PRAGMA application_id");
  const auto version = database.integer("PRAGMA user_version");
  if (!tables) return tl::unexpected(tables.error());
  if (!application) return tl::unexpected(application.error());
  if (!version) return tl::unexpected(version.error());
  if (*tables == 0 && *application == 0) return Found::kNothing;
  if (*application != store::kApplicationId) return cannot_write(path, "is in the way, and not a mapjoin store");
  if (*version != store::kVersion || !store::check_database(database, path.string())) return Found::kOtherBuild;
  return store::holds_contents(database, contents).map([](bool same) { return same ? Found::kThisBuild : Found::kOtherBuild; });
}

Expected<Database> open_partial(const fs::path& path) {
  auto database = Database::open(path);
  if (!database) return database;
  // Whatever an interrupted build had not finished is rolled back here; another running build is kept out until the end. Maps
  // are large values: in large pages they are checked and read faster.
  if (auto begun = database->execute("PRAGMA page_size = 32768; PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE"); !begun) {
    return tl::unexpected(begun.error());
  }
  return database;
}

/// The database beside `path` with the contents in it, inside an open transaction.
template <int Dim>
Expected<Database> open_with(const fs::path& path, const Contents<Dim>& contents) {
  auto database = open_partial(path);
  if (!database) return database;
  const auto found = find(*database, path, contents);
  if (!found) return tl::unexpected(found.error());
  if (*found == Found::kThisBuild) return database;
  if (*found == Found::kOtherBuild) {
    std::error_code ignored;
    fs::remove(path, ignored);  // While it is locked.
    *database = Database();
    database = open_partial(path);
    if (!database) return database;
  }
  const auto written =
      create_tables(*database).and_then([&] { return store::write_contents(*database, contents); }).and_then([&] {
        return database->execute("COMMIT; BEGIN");
      });
  if (!written) return tl::unexpected(written.error());
  return database;
}

/// The new name on the disk, where the folder can be asked for that.
void sync_folder(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

template <int Dim>
StoreWriter<Dim>::StoreWriter(fs::path path, Database database, Statement insert)
    : path_(std::move(path)), database_(std::move(database)), insert_(std::move(insert)) {}

template <int Dim>
Expected<StoreWriter<Dim>> StoreWriter<Dim>::open(const fs::path& path, const Log<Dim>& log,
                                                  const std::vector<Stretch>& stretches, const std::string& options) {
  auto database = open_with(partial_path(path), Contents<Dim>{log, stretches, options});
  if (!database) return tl::unexpected(database.error());
  auto insert = database->prepare("INSERT INTO maps VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  const auto maps = database->integer("SELECT count(*) FROM maps");
  if (!insert) return tl::unexpected(insert.error());
  const auto undetermined = database->integer("SELECT count(*) FROM maps WHERE base IS NULL");
  if (!maps) return tl::unexpected(maps.error());
  if (!undetermined) return tl::unexpected(undetermined.error());

  StoreWriter writer(path, std::move(*database), std::move(*insert));
  writer.undetermined_ = static_cast<std::size_t>(*undetermined);
  for (std::size_t i = stretches.size(); i-- > 0;) {
    if (stretches[i].is_map) writer.to_do_.push_back(i);
  }
  // Maps are added in order, so those that are in are the first.
  for (std::int64_t i = 0; i < *maps && !writer.to_do_.empty(); ++i) {
    writer.done_.push_back(writer.to_do_.back());
    writer.to_do_.pop_back();
  }
  return writer;
}

template <int Dim>
Expected<void> StoreWriter<Dim>::add(std::size_t stretch, const std::optional<LocalMap<Dim>>& map) {
  if (to_do_.empty() || stretch != to_do_.back()) throw std::invalid_argument("not the next stretch of a store");
  const auto inserted = map ? insert_map(stretch, *map) : insert_span(stretch);
  if (!inserted) return inserted;
  to_do_.pop_back();
  done_.push_back(stretch);
  if (!map) ++undetermined_;
  if (++batch_maps_ < kBatchMaps && batch_bytes_ < kBatchBytes) return {};
  batch_maps_ = batch_bytes_ = 0;
  return database_->execute("COMMIT; BEGIN");
}

template <int Dim>
Expected<void> StoreWriter<Dim>::insert_span(std::size_t stretch) {
  return insert_->bind(static_cast<std::int64_t>(stretch)).step().map([](bool) {});
}

template <int Dim>
Expected<void> StoreWriter<Dim>::insert_map(std::size_t stretch, const LocalMap<Dim>& map) {
  const std::string poses = store::encode_all(map.poses);
  const std::string features = store::encode_all(map.features);
  const std::string pose_estimates = store::encode_all(map.pose_estimates);
  const std::string feature_estimates = store::encode_all(map.feature_estimates);
  const std::string information = store::encode_upper(map.information);
  batch_bytes_ += information.size();
  insert_->bind(static_cast<std::int64_t>(stretch)).bind(std::int64_t{map.base}).bind(map.chi2);
  insert_->bind_blob(poses).bind_blob(features).bind_blob(pose_estimates).bind_blob(feature_estimates).bind_blob(information);
  return insert_->step().map([](bool) {});
}

template <int Dim>
Expected<void> StoreWriter<Dim>::finish() {
  if (!to_do_.empty()) throw std::logic_error("a store is finished before its maps are");
  const fs::path partial = partial_path(path_);
  if (auto committed = database_->execute("COMMIT; PRAGMA journal_mode = OFF"); !committed) return committed;
  insert_.reset();
  // The lock lasts until the file has its name: no other build takes it for one that was interrupted.
  std::error_code error;
  fs::remove(partial.string() + "-journal", error);
  fs::rename(partial, path_, error);
  database_.reset();
  if (error) return cannot_write(path_, error.message());
  sync_folder(fs::absolute(path_).parent_path());
  return {};
}

template class StoreWriter<2>;
template class StoreWriter<3>;

}  // namespace mapjoin
