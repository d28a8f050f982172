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

/// The name of a store until it is done: `path`.partial, beside the file to which a link of this name leads.
std::filesystem::path unfinished_store(const std::filesystem::path& path);

/// Writes a store map by map, so that a killed build loses little and can go on. The finished file is the same, byte for byte,
/// however often the build was interrupted.
template <int Dim>
class StoreWriter {
 public:
  /// Begins the store as unfinished_store(path). A store that an interrupted build left there goes on if it holds the same log,
  /// segments, options, portion, share and word on features; otherwise, or if it is damaged, it is begun afresh. For a portion,
  /// the log has all poses and features and some of the factors. kCannotWrite if the file cannot be written, if another
  /// program's database has that name, or if a prior has a lever or a factor a loss.
  static Expected<StoreWriter> open(const std::filesystem::path& path, const Log<Dim>& log,
                                    const std::vector<Segment>& segments, const std::string& options,
                                    const Portion& portion = {}, const Share& share = {}, bool features_are_shared = false);

  /// Indices of the segments that are maps, ascending: done() need no further work, to_do() are the others.
  std::span<const std::size_t> done() const { return std::span(maps_).first(done_); }
  std::span<const std::size_t> to_do() const { return std::span(maps_).subspan(done_); }
  /// The number of segments in done() that did not determine a map.
  std::size_t undetermined() const { return undetermined_; }
  /// True if an unfinished store was there and damaged.
  bool found_damaged() const { return found_damaged_; }

  /// Adds the map of the first segment of to_do(); nullopt if the segment did not determine one, and is to be read as a raw
  /// segment. Safe on the disk within 256 maps or 8 MiB. Throws std::invalid_argument for another segment, and for a map
  /// that is not one of the segment, with valid numbers.
  Expected<void> add(std::size_t segment, const std::optional<LocalMap<Dim>>& map);

  /// Gives the file the name `path`. Throws std::logic_error unless every segment that is a map is done.
  Expected<void> finish();

 private:
  StoreWriter(std::filesystem::path path, store::Database database, store::Statement insert, std::vector<Segment> segments);
  /// Inserts the map of the segment that is already bound.
  Expected<bool> insert(const LocalMap<Dim>& map);

  std::filesystem::path path_;
  std::optional<store::Database> database_;
  std::optional<store::Statement> insert_;
  std::vector<Segment> segments_;
  std::vector<std::size_t> maps_;  ///< Indices of the segments that are maps.
  std::size_t done_ = 0;           ///< Number of segments in `maps_` that are done.
  std::size_t undetermined_ = 0;
  IndexRange<FeatureIndex> features_;
  std::size_t batch_maps_ = 0;
  std::size_t batch_bytes_ = 0;
  bool found_damaged_ = false;
};

/// The content of a store, in the dimension of its file.
using AnyStoredMaps = std::variant<StoredMaps<2>, StoredMaps<3>>;

/// True if the file begins as a mapjoin store does, of whatever version.
bool is_store(const std::filesystem::path& path);

/// Reads a finished store. The file is not trusted: all of it is checked. Bad input: not a mapjoin store, or one that is of
/// another version, unfinished or damaged.
Expected<AnyStoredMaps> read_store(const std::filesystem::path& path);

/// Writes local maps of others as a store without any observation, which is read faster than their many files; its log has the
/// poses and features, and no factors. As with StoreWriter, the file appears whole; otherwise kCannotWrite. Throws
/// std::invalid_argument if the set has observations beside its maps, or a map that StoreWriter refuses.
template <int Dim>
Expected<void> write_store(const SubmapSet<Dim>& set, const std::filesystem::path& path);

/// True if a store holds maps, and no factors beside them.
template <int Dim>
bool has_maps_alone(const StoredMaps<Dim>& stored);

/// The maps of a store as a set, whose source is `path`.
template <int Dim>
SubmapSet<Dim> submap_set_of(StoredMaps<Dim> stored, const std::filesystem::path& path);

}  // namespace mapjoin
