// SPDX-License-Identifier: BSD-3-Clause
#include <apps/exit_code.hpp>
#include <apps/picture/links.hpp>
#include <apps/report/run_report.hpp>
#include <apps/report/verdict.hpp>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/run_folder.hpp>
#include <string_view>

namespace mapjoin::apps {

namespace fs = std::filesystem;

void add_rejected_links(const RunReport& run_report, std::vector<Link>& links) {
  for (const NamedRejected& rejected : run_report.rejected) {
    links.push_back({rejected.misfit.from, rejected.misfit.to, true});
  }
}

void add_rejected_links(const fs::path& file, const PoseIds& poses, const FeatureIds& features, std::vector<Link>& links) {
  const auto found = [&](const auto& index_of, const auto& id) {
    const auto index = index_of(id);
    if (!index) demand(not_of_map_beside(file));
    return index.value();
  };
  const IndexOf pose_of(poses);
  const IndexOf feature_of(features);
  demand(each_row(file, [&](const std::vector<std::string>&, TextScanner& line) {
    const std::string_view kind = line.word();
    if (kind == kFix) return;
    const bool is_observation = kind == to_string(PartKind::kObservation);
    const std::uint64_t from = line.key();
    const std::uint64_t to = line.key();
    for (int column = 0; column < 3; ++column) line.word();  // chi2, probability, why
    const auto session = [&] { return read_session(line); };
    const PoseIndex base = found(pose_of, PoseId{session(), from});
    if (is_observation) {
      links.push_back({base, found(feature_of, FeatureId{to}), true});
    } else {
      links.push_back({base, found(pose_of, PoseId{session(), to}), true});
    }
  }));
}

}  // namespace mapjoin::apps
