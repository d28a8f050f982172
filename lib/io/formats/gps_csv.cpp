// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/formats/gps_csv.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <vector>

namespace mapjoin {
namespace {

using Columns = std::vector<std::string>;

Expected<void> check(const Columns& columns, const std::string& place) {
  const auto lacks = [&](std::string_view what) {
    return bad_input(
        fmt::format("{}: names no column {}: a table of fixes has time or pose, latitude, longitude, sd_east, "
                    "sd_north and, in space, height and sd_up",
                    place, what));
  };
  if (!has_column(columns, "time") && !has_column(columns, "pose")) return lacks("time or pose");
  if (has_column(columns, "time") && has_column(columns, "pose")) {
    return bad_input(place + ": names both columns time and pose, and a fix is of the one or of the other");
  }
  for (const std::string_view needed : {"latitude", "longitude", "sd_east", "sd_north"}) {
    if (!has_column(columns, needed)) return lacks(needed);
  }
  return check_named_once(
      columns, {"time", "pose", "session", "latitude", "longitude", "height", "sd_east", "sd_north", "sd_up"}, place);
}

double coordinate(TextScanner& text, const GpsRange& range) {
  const double value = text.number();
  if (!range.contains(value))
    text.reject(fmt::format("an angle from {:g} to {:g} degrees is expected", range.least, range.most));
  return value;
}

double height(TextScanner& text) {
  const double value = text.number();
  if (!kHeights.contains(value)) text.reject("a height from -1e7 to 1e7 m is expected");
  return value;
}

double deviation(TextScanner& text) {
  const double value = text.number();
  if (!kDeviations.contains(value)) text.reject("a standard deviation is from 1e-6 to 1e6 m");
  return value;
}

GpsFix read_fix(const Columns& columns, TextScanner& text) {
  GpsFix fix{text.place().line, {}, {}, {}, {}};
  for (const std::string& column : columns) {
    if (column == "time") {
      fix.when = read_time(text);
    } else if (column == "pose") {
      fix.when = text.key();
    } else if (column == "session") {
      fix.session = read_session(text);
    } else if (column == "latitude") {
      fix.place.latitude = coordinate(text, kLatitudes);
    } else if (column == "longitude") {
      fix.place.longitude = coordinate(text, kLongitudes);
    } else if (column == "height") {
      fix.place.height = height(text);
    } else if (column == "sd_east") {
      fix.deviation.x() = deviation(text);
    } else if (column == "sd_north") {
      fix.deviation.y() = deviation(text);
    } else if (column == "sd_up") {
      fix.deviation.z() = deviation(text);
    } else {
      text.word();
    }
  }
  return fix;
}

}  // namespace

Expected<GpsFixes> read_gps_csv(std::string_view bytes, const std::string& file) {
  const Columns columns = csv_columns(bytes);
  if (auto named = check(columns, header_place(bytes, file)); !named) return tl::unexpected(named.error());
  GpsFixes fixes{file, has_column(columns, "height") && has_column(columns, "sd_up"), {}};
  const std::string words = cells_as_words(bytes);
  TextScanner text(file, words);
  text.next_line();
  return text.each_line([&] { fixes.fixes.push_back(read_fix(columns, text)); }).and_then([&]() -> Expected<GpsFixes> {
    if (fixes.fixes.empty()) return bad_input(file + ": has no fixes behind its header");
    return std::move(fixes);
  });
}

Expected<GpsFixes> read_gps_csv(const std::filesystem::path& path) {
  return FileBytes::read(path).and_then([&](const FileBytes& bytes) { return read_gps_csv(bytes.view(), path.string()); });
}

}  // namespace mapjoin
