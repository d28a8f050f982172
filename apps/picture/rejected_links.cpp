// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/links.hpp>
#include <apps/picture/log_names.hpp>
#include <apps/picture/table_lines.hpp>
#include <apps/report/run_report.hpp>
#include <apps/report/verdict.hpp>
#include <string_view>

namespace mapjoin::apps {
namespace fs = std::filesystem;

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
  const LogNames names = LogNames::of_run(folder, map);
  const auto found = [&](const auto& id) {
    const auto index = names(id);
    if (!index) fail_not_of_map(file);
    return *index;
  };
  each_line(file, [&](TextScanner& line, const std::string&) {
    const std::string_view kind = line.word();
    if (kind == kFix) return;
    const bool is_observation = kind == to_string(PartKind::kObservation);
    const std::uint64_t from = line.key();
    const std::uint64_t to = line.key();
    for (int column = 0; column < 3; ++column) line.word();  // chi2, probability, why
    const auto session = [&] { return read_session(line); };
    const PoseIndex base = found(PoseId{session(), from});
    if (is_observation) {
      links.push_back({base, found(FeatureId{to}), true});
    } else {
      links.push_back({base, found(PoseId{session(), to}), true});
    }
  });
}

#define MAPJOIN_INSTANTIATE(Dim) template void add_rejected_links(const fs::path&, const GlobalMap<Dim>&, std::vector<Link>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
