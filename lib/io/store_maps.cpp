// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/store_check.hpp>
#include <mapjoin/io/store_maps.hpp>
#include <mapjoin/io/store_records.hpp>
#include <mapjoin/parallel/parallel_try.hpp>
#include <utility>

namespace mapjoin::store {
namespace {

/// Rows are read while those before them are decoded, with so much information at once (bytes), the largest part of a row:
/// little beside the maps, enough for all threads.
constexpr std::size_t kInformationAtOnce = 1 << 18;

/// A row of `maps` with a map in it, as it stands in the file.
struct Row {
  std::size_t stretch = 0;
  Index base = 0;
  double chi2 = 0.0;
  std::string poses;
  std::string features;
  std::string pose_estimates;
  std::string feature_estimates;
  std::string information;
};

/// All rows of `maps`, from the first to the last.
class Rows {
 public:
  /// A stretch whose row is empty becomes a span when that row is read.
  static Expected<Rows> open(Database& database, const std::string& file, std::vector<Stretch>& stretches) {
    return database.prepare("SELECT * FROM maps ORDER BY stretch").map([&](Statement&& select) {
      return Rows(std::move(select), file, stretches);
    });
  }

  /// The next ones that have a map; none at the end. Every stretch that is a map has its row, in order.
  Expected<std::vector<Row>> next() {
    std::vector<Row> rows;
    std::size_t information = 0;
    for (; stretch_ < stretches_->size() && information < kInformationAtOnce; ++stretch_) {
      Stretch& stretch = (*stretches_)[stretch_];
      if (!stretch.is_map) continue;
      if (const auto found = find_row(); !found) return tl::unexpected(found.error());
      stretch.is_map = !select_.is_null(1);
      if (stretch.is_map) information += rows.emplace_back(row()).information.size();
    }
    if (!rows.empty()) return rows;
    return select_.step().and_then([&](bool is_more) -> Expected<std::vector<Row>> {
      if (is_more) return bad_input(fmt::format("{}: damaged store: it has more maps than stretches", file_));
      return rows;
    });
  }

 private:
  Rows(Statement select, std::string file, std::vector<Stretch>& stretches)
      : select_(std::move(select)), file_(std::move(file)), stretches_(&stretches) {}

  Expected<void> find_row() {
    return select_.step().and_then([&](bool is_there) -> Expected<void> {
      if (!is_there) {
        return bad_input(fmt::format("{}: unfinished store: the local map of stretch {} is missing", file_, stretch_));
      }
      if (select_.integer(0) == static_cast<std::int64_t>(stretch_)) return {};
      return bad_input(fmt::format("{}: damaged store: its maps are not those of its stretches", file_));
    });
  }

  Row row() const {
    const auto bytes = [&](int column) { return std::string(select_.bytes(column)); };
    return {stretch_, static_cast<Index>(select_.integer(1)), select_.number(2), bytes(3), bytes(4), bytes(5), bytes(6),
            bytes(7)};
  }

  Statement select_;
  std::string file_;
  std::vector<Stretch>* stretches_;
  std::size_t stretch_ = 0;  ///< The next one.
};

/// Nothing where the sizes do not agree.
template <int Dim>
std::optional<LocalMap<Dim>> map_of(const Row& row) {
  LocalMap<Dim> map;
  map.base = row.base;
  map.chi2 = row.chi2;
  if (!decode_all(row.poses, map.poses) || !decode_all(row.features, map.features) ||
      !decode_all(row.pose_estimates, map.pose_estimates) || !decode_all(row.feature_estimates, map.feature_estimates)) {
    return std::nullopt;
  }
  const auto rows = static_cast<Eigen::Index>(kPoseDof<Dim> * map.poses.size() + Dim * map.features.size());
  auto information = decode_upper(row.information, rows);
  if (!information) return std::nullopt;
  map.information = std::move(*information);
  map.information.template triangularView<Eigen::StrictlyLower>() = map.information.transpose();
  return map;
}

/// Decodes and checks the maps behind those that are there.
template <int Dim>
Expected<void> take_rows(const std::vector<Row>& rows, const std::string& file, StoredMaps<Dim>& stored) {
  const std::size_t before = stored.maps.size();
  stored.maps.resize(before + rows.size());
  return parallel_try(rows.size(), [&](std::size_t k) -> Expected<void> {
    auto map = map_of<Dim>(rows[k]);
    if (!map) return bad_input(fmt::format("{}: damaged store: the sizes of map {} do not agree", file, rows[k].stretch));
    stored.maps[before + k] = std::move(*map);
    return check_map(stored.maps[before + k], stored.stretches[rows[k].stretch], stored.log, file);
  });
}

}  // namespace

template <int Dim>
Expected<void> read_maps(Database& database, const std::string& file, StoredMaps<Dim>& stored) {
  auto rows = Rows::open(database, file, stored.stretches);
  if (!rows) return tl::unexpected(rows.error());
  auto read = rows->next();
  while (read && !read->empty()) {
    Expected<std::vector<Row>> following;
    Expected<void> taken;
    // next() changes only stretches behind those of the rows that are taken.
    parallel_invoke([&] { following = rows->next(); }, [&] { taken = take_rows(*read, file, stored); });
    if (!taken) return taken;
    read = std::move(following);
  }
  return read.map([](const auto&) {});
}

template Expected<void> read_maps(Database&, const std::string&, StoredMaps<2>&);
template Expected<void> read_maps(Database&, const std::string&, StoredMaps<3>&);

}  // namespace mapjoin::store
