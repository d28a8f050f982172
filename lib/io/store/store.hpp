// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// mapjoin's own store: one SQLite file with a whole log, its segments and the local maps built from it (docs/store.md).

#include <cstddef>
#include <filesystem>
#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// What a store is called until it is done: `path`.partial, beside the file that a link of this name leads to.
std::filesystem::path unfinished_store(const std::filesystem::path& path);

/// Writes a store map by map, so that a build that is killed loses little and can go on. The finished file is the same, byte
/// for byte, however often the build was interrupted.
template <int Dim>
class StoreWriter {
 public:
  /// Begins the store as unfinished_store(path). One that an interrupted build left there goes on where it holds the
  /// same log, segments and options; else, or where it is damaged, it is begun afresh. Of a portion, the log has all poses and
  /// features and some of the factors. kCannotWrite where that cannot be, or where another program's database has that name.
  static Expected<StoreWriter> open(const std::filesystem::path& path, const Log<Dim>& log,
                                    const std::vector<Segment>& segments, const std::string& options,
                                    const Portion& portion = {});

  /// Indices of the segments that are maps, ascending: those that need no further work, and the others.
  std::span<const std::size_t> done() const { return std::span(maps_).first(done_); }
  std::span<const std::size_t> to_do() const { return std::span(maps_).subspan(done_); }
  /// How many of them did not determine a map.
  std::size_t undetermined() const { return undetermined_; }
  /// Whether an unfinished store was there and damaged.
  bool found_damaged() const { return found_damaged_; }

  /// The map of the first segment of to_do(); nothing where the segment turned out not to determine one, and is
  /// to be read as a raw segment. Safe on the disk within 256 maps or 8 MiB. Throws std::invalid_argument for another segment.
  Expected<void> add(std::size_t segment, const std::optional<LocalMap<Dim>>& map);

  /// Every segment that is a map must be done; throws std::logic_error otherwise. The file takes the name `path`.
  Expected<void> finish();

 private:
  StoreWriter(std::filesystem::path path, store::Database database, store::Statement insert);
  /// Inserts the map of the segment that is bound already.
  Expected<bool> insert(const LocalMap<Dim>& map);

  std::filesystem::path path_;
  std::optional<store::Database> database_;
  std::optional<store::Statement> insert_;
  std::vector<std::size_t> maps_;  ///< The segments that are maps.
  std::size_t done_ = 0;           ///< How many of them.
  std::size_t undetermined_ = 0;
  std::size_t batch_maps_ = 0;
  std::size_t batch_bytes_ = 0;
  bool found_damaged_ = false;
};

/// The file decides which.
using AnyStoredMaps = std::variant<StoredMaps<2>, StoredMaps<3>>;

/// Whether the file begins as a mapjoin store, of whatever version, does.
bool is_store(const std::filesystem::path& path);

/// Bad input: not a mapjoin store, one of another version, an unfinished one, or a damaged one. The file is not trusted: it is
/// checked whole, and so is all it holds.
Expected<AnyStoredMaps> read_store(const std::filesystem::path& path);

/// Writes local maps of others, which are read faster so than from their many files, as a store without any observation, whose
/// log has the poses and features only. As StoreWriter: the file appears whole, kCannotWrite where it cannot. Throws
/// std::invalid_argument where the set has observations beside its maps.
template <int Dim>
Expected<void> write_store(const SubmapSet<Dim>& set, const std::filesystem::path& path);

/// Whether a store holds maps of which nothing else is known.
template <int Dim>
bool has_maps_alone(const StoredMaps<Dim>& stored);

/// These maps as a set, read from `path`.
template <int Dim>
SubmapSet<Dim> submap_set_of(StoredMaps<Dim> stored, const std::filesystem::path& path);

}  // namespace mapjoin
