// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/io/store/map_rows.hpp>
#include <mapjoin/io/store/records.hpp>
#include <mapjoin/io/store/store.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using store::Contents;
using store::Database;
using store::Statement;

/// The bounds of a batch, which is one transaction. They depend on the maps alone, and so does every byte of the file, even if
/// an interrupted build goes on after the last whole batch.
constexpr std::size_t kBatchMaps = 256;
constexpr std::size_t kBatchBytes = std::size_t{8} << 20;

tl::unexpected<Error> cannot_write(const fs::path& path, const std::string& reason) {
  return tl::unexpected(Error{ErrorKind::kCannotWrite, fmt::format("{}: {}", path.string(), reason)});
}

/// True if an earlier build left exactly these contents in the file; bad input if it is damaged, kCannotWrite if it is another
/// program's database.
template <int Dim>
Expected<bool> is_this_build(Database& database, const fs::path& path, const Contents<Dim>& contents) {
  const auto tables = database.integer("SELECT count(*) FROM sqlite_master");
  if (!tables) return tl::unexpected(tables.error());
  const auto application = database.integer("PRAGMA application_id");
  if (!application) return tl::unexpected(application.error());
  const auto version = database.integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*tables == 0 && *application == 0) return false;
  if (*application != store::kApplicationId) return cannot_write(path, "is in the way, and not a mapjoin store");
  if (*version != store::kVersion) return false;
  return store::check_database(database).and_then([&] { return store::holds_contents(database, contents); });
}

/// Opens and locks a database: unfinished work of an interrupted build is rolled back, and other builds are kept out until the
/// end.
Expected<Database> open_locked(const fs::path& path) {
  return Database::open(path).and_then([](Database&& database) {
    return database.execute("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE").map([&] { return std::move(database); });
  });
}

/// The database at `path` with the contents in it, inside an open transaction; `found_damaged` tells if a damaged one was
/// there.
template <int Dim>
Expected<Database> open_with(const fs::path& path, const Contents<Dim>& contents, bool& found_damaged) {
  auto database = open_locked(path);
  const auto found = database.and_then([&](Database& left) { return is_this_build(left, path, contents); });
  if (found && *found) return database;
  found_damaged = !found && found.error().kind == ErrorKind::kBadInput;
  if (!found && !found_damaged) return tl::unexpected(found.error());
  std::error_code ignored;
  fs::remove(path, ignored);  // While it is locked.
  if (database) *database = Database();
  fs::remove(path.string() + "-journal", ignored);
  database = open_locked(path);
  if (!database) return database;
  return store::write_contents(*database, contents).and_then([&] { return database->execute("COMMIT; BEGIN"); }).map([&] {
    return std::move(*database);
  });
}

/// Puts the new name on the disk, if the folder can be opened.
void sync_folder(const fs::path& path) {
  const Descriptor folder = Descriptor::to_read(path);
  if (folder.value() >= 0) ::fsync(folder.value());
}

}  // namespace

fs::path unfinished_store(const fs::path& path) {
  return link_target(path).string() + ".partial";  // A link stays a link.
}

template <int Dim>
StoreWriter<Dim>::StoreWriter(fs::path path, Database database, Statement insert, std::vector<Segment> segments)
    : path_(std::move(path)), database_(std::move(database)), insert_(std::move(insert)), segments_(std::move(segments)) {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (segments_[i].is_map) maps_.push_back(i);
  }
}

template <int Dim>
Expected<StoreWriter<Dim>> StoreWriter<Dim>::open(const fs::path& path, const Log<Dim>& log,
                                                  const std::vector<Segment>& segments, const std::string& options,
                                                  const Portion& portion, const Share& share, bool features_are_shared) {
  const fs::path target = link_target(path);
  std::error_code ignored;
  const fs::file_status there = fs::symlink_status(target, ignored);
  if (fs::exists(there) && !fs::is_regular_file(there)) {
    return cannot_write(path, "a store must be a plain file; give it another name");
  }
  if (has_levers(log.graph)) return cannot_write(path, "a store has no place for priors with levers");
  if (count_losses(log.graph) > 0) return cannot_write(path, "a store has no place for losses of factors");
  bool found_damaged = false;
  const Contents<Dim> contents{log, segments, options, portion, share, features_are_shared};
  auto database = open_with(unfinished_store(path), contents, found_damaged);
  if (!database) return tl::unexpected(database.error());
  take_permissions_of(target, unfinished_store(path));
  auto insert =
      database->prepare("INSERT INTO maps VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, crc32(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8))");
  if (!insert) return tl::unexpected(insert.error());
  StoreWriter writer(target, std::move(*database), std::move(*insert), segments);
  writer.found_damaged_ = found_damaged;
  writer.features_ = indices(log.features);
  const auto done = writer.database_->integer("SELECT count(*) FROM maps");
  const auto undetermined = writer.database_->integer("SELECT count(*) FROM maps WHERE base IS NULL");
  if (!done || !undetermined) return tl::unexpected(done ? undetermined.error() : done.error());
  writer.done_ = std::min(static_cast<std::size_t>(*done), writer.maps_.size());  // Maps are added in order.
  writer.undetermined_ = static_cast<std::size_t>(*undetermined);
  return writer;
}

template <int Dim>
Expected<void> StoreWriter<Dim>::add(std::size_t segment, const std::optional<LocalMap<Dim>>& map) {
  if (to_do().empty() || segment != to_do().front()) throw std::invalid_argument("not the next segment of a store");
  if (map && !store::is_map_of(*map, segments_[segment], features_)) {
    throw std::invalid_argument("not a local map of the next segment of a store");
  }
  insert_->bind(static_cast<std::int64_t>(segment));
  const auto inserted = map ? insert(*map) : insert_->step();
  if (!inserted) return tl::unexpected(inserted.error());
  ++done_;
  if (!map) ++undetermined_;
  if (++batch_maps_ < kBatchMaps && batch_bytes_ < kBatchBytes) return {};
  batch_maps_ = batch_bytes_ = 0;
  return database_->execute("COMMIT; BEGIN");
}

template <int Dim>
Expected<bool> StoreWriter<Dim>::insert(const LocalMap<Dim>& map) {
  const std::string poses = store::encode_all(map.poses);
  const std::string features = store::encode_all(map.features);
  const std::string pose_estimates = store::encode_all(map.pose_estimates);
  const std::string feature_estimates = store::encode_all(map.feature_estimates);
  const std::string information = store::encode_upper(map.information);
  batch_bytes_ += information.size();
  insert_->bind(std::int64_t{map.base.value}).bind(map.chi2);
  insert_->bind(poses).bind(features).bind(pose_estimates).bind(feature_estimates).bind(information);
  return insert_->step();
}

template <int Dim>
Expected<void> StoreWriter<Dim>::finish() {
  if (!database_) throw std::logic_error("a store is finished twice");
  if (!to_do().empty()) throw std::logic_error("a store is finished before its maps are");
  const fs::path partial = unfinished_store(path_);
  if (auto committed = database_->execute("COMMIT; PRAGMA journal_mode = OFF"); !committed) return committed;
  insert_.reset();
  // The lock lasts until the file has its name, so that no other build takes it for an interrupted one.
  std::error_code error;
  fs::remove(partial.string() + "-journal", error);
  fs::rename(partial, path_, error);
  database_.reset();
  if (error) return cannot_write(path_, error.message());
  sync_folder(fs::absolute(path_).parent_path());
  return {};
}

template <int Dim>
Expected<void> write_store(const SubmapSet<Dim>& set, const fs::path& path) {
  if (!set.graph.pose_factors.empty() || !set.graph.feature_factors.empty()) {
    throw std::invalid_argument("a store holds a set of local maps alone");
  }
  Log<Dim> log;  // Everything in the store but the maps.
  log.source = set.source;
  log.poses = set.poses;
  log.features = set.features;
  log.graph.fixed = set.graph.fixed;
  log.conventions = set.conventions;
  auto store = StoreWriter<Dim>::open(path, log, set.segments, "", {}, {}, set.features_are_shared);
  if (!store) return tl::unexpected(store.error());
  for (std::size_t k = store->done().size(); k < set.graph.submaps.size(); ++k) {
    if (auto added = store->add(k, set.graph.submaps[k]); !added) return added;
  }
  return store->finish();
}

template class StoreWriter<2>;
template class StoreWriter<3>;
template Expected<void> write_store<2>(const SubmapSet<2>&, const fs::path&);
template Expected<void> write_store<3>(const SubmapSet<3>&, const fs::path&);

}  // namespace mapjoin
