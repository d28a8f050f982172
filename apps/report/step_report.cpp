// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <apps/report/step_report.hpp>
#include <cerrno>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/model/counted.hpp>
#include <nlohmann/json.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

std::string for_people(const Step& step) {
  const AddedPart& added = step.added;
  const std::string maps = step.count == 1 ? fmt::format("map {}", step.first)
                                           : fmt::format("maps {} to {}", step.first, step.first + step.count - 1);
  const std::string poses = fmt::format("{} to {}", to_string(step.begin), step.end.key);
  if (!added.is_joined) return fmt::format("{}, {}: waits, nothing ties it to the others yet\n", maps, poses);
  return fmt::format("{}, {}: moved {:.3f} m, {:.4f} rad; chi2 {:.2f}, dof {}; {} variables in {}{}\n", maps, poses,
                     added.metres, added.radians, added.chi2, added.dof, added.eliminated,
                     counted(added.iterations, "iteration"), added.joined_anew ? "; all joined anew" : "");
}

std::string for_programs(const Step& step) {
  const AddedPart& added = step.added;
  const nlohmann::ordered_json line = {{"map", step.first},
                                       {"maps", step.count},
                                       {"first_pose", step.begin.key},
                                       {"last_pose", step.end.key},
                                       {"joined", added.is_joined},
                                       {"moved_m", added.metres},
                                       {"moved_rad", added.radians},
                                       {"chi2", added.chi2},
                                       {"dof", added.dof},
                                       {"eliminated", added.eliminated},
                                       {"iterations", added.iterations},
                                       {"converged", added.converged},
                                       {"joined_anew", added.joined_anew},
                                       {"cpu_seconds", step.seconds}};
  return line.dump() + '\n';
}

}  // namespace

Expected<StepReport> StepReport::open(const std::filesystem::path& path, bool quiet) {
  const bool is_shown = !quiet && ::isatty(STDERR_FILENO) == 1;
  const auto left_open = [](std::FILE*) { return 0; };
  if (path == "-") return StepReport("standard output", File(stdout, left_open), is_shown);
  if (path.empty()) return StepReport(path, File(nullptr, left_open), is_shown);
  File file(std::fopen(path.c_str(), "we"), std::fclose);
  if (!file) return call_failed(path, errno, ErrorKind::kCannotWrite);
  return StepReport(path, std::move(file), is_shown);
}

StepReport::StepReport(std::filesystem::path path, File file, bool is_shown)
    : path_(std::move(path)), file_(std::move(file)), is_shown_(is_shown) {}

Expected<void> StepReport::add(const Step& step) {
  if (is_shown_) std::fputs(for_people(step).c_str(), stderr);
  const bool is_written = !file_ || (std::fputs(for_programs(step).c_str(), file_.get()) >= 0 && std::fflush(file_.get()) == 0);
  // A reader that has gone away has had all it wanted.
  if (is_written || errno == EPIPE) return {};
  return call_failed(path_, errno, ErrorKind::kCannotWrite);
}

}  // namespace mapjoin::apps
