// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/picture/links.hpp>
#include <apps/report/run_report.hpp>
#include <apps/report/verdict.hpp>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <string>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;

/// Calls read(line, first word of the header) for each line below the header of a CSV file, at its first word.
template <typename Read>
void each_line(const fs::path& file, Read&& read) {
  const FileBytes bytes = FileBytes::read(file).value();
  const std::string text = with_blanks(bytes.view());
  TextScanner line(file.string(), text);
  line.next_line();
  const std::string header(line.word());
  demand(line.each_line([&] {
    read(line, header);
    while (!line.at_end_of_line()) line.word();
  }));
}

PoseIds pose_names(const fs::path& file) {
  PoseIds names;
  each_line(file, [&](TextScanner& line, const std::string& header) {
    const std::uint32_t session = header == "session" ? read_session(line) : 0;
    names.push_back({session, line.key()});
  });
  return names;
}

FeatureIds feature_names(const fs::path& file) {
  FeatureIds names;
  each_line(file, [&](TextScanner& line, const std::string&) { names.push_back({line.key()}); });
  return names;
}

/// Whether these are the names of a map, but for those of further sessions and of features, which may have others in a g2o
/// file.
template <int Dim>
bool are_of(const GlobalMap<Dim>& map, const PoseIds& poses, const FeatureIds& features) {
  if (poses.size() != map.poses.size() || features.size() != map.features.size()) return false;
  return std::ranges::all_of(indices(poses), [&](PoseIndex p) { return poses[p].session != 0 || poses[p] == map.pose_ids[p]; });
}

}  // namespace

void add_rejected_links(const RunReport& run_report, std::vector<Link>& links) {
  for (const NamedRejected& rejected : run_report.rejected) {
    links.push_back({rejected.misfit.from, rejected.misfit.to, true});
  }
}

template <int Dim>
void add_rejected_links(const fs::path& folder, const GlobalMap<Dim>& map, std::vector<Link>& links) {
  const fs::path file = folder / "rejected.csv";
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return;
  const PoseIds poses = pose_names(folder / "poses.csv");
  const FeatureIds features = feature_names(folder / "features.csv");
  const auto fail_not_of_map = [&] { fail(ErrorKind::kBadInput, file.string() + ": is not of the map beside it"); };
  if (!are_of(map, poses, features)) fail_not_of_map();
  const IndexOf pose_of(poses);
  const IndexOf feature_of(features);
  const auto found = [&](const auto& index) {
    if (!index) fail_not_of_map();
    return *index;
  };
  each_line(file, [&](TextScanner& line, const std::string&) {
    const std::string_view kind = line.word();
    if (kind == kRejectedFix) return;
    const bool is_observation = kind == to_string(PartKind::kObservation);
    const std::uint64_t from = line.key();
    const std::uint64_t to = line.key();
    for (int column = 0; column < 3; ++column) line.word();  // chi2, probability, why
    const auto session = [&] { return read_session(line); };
    const PoseIndex base = found(pose_of({session(), from}));
    if (is_observation) {
      links.push_back({base, found(feature_of({to})), true});
    } else {
      links.push_back({base, found(pose_of({session(), to})), true});
    }
  });
}

#define MAPJOIN_INSTANTIATE(Dim) template void add_rejected_links(const fs::path&, const GlobalMap<Dim>&, std::vector<Link>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
