// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <apps/report/step_report.hpp>
#include <cerrno>
#include <cstdio>
#include <mapjoin/io/files/system_call.hpp>
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
  return fmt::format("{}, {}: moved {:.3f} m, {:.4f} rad; chi2 {:.2f}, dof {}; {} variables in {} iteration{}{}\n", maps, poses,
                     added.metres, added.radians, added.chi2, added.dof, added.eliminated, added.iterations,
                     added.iterations == 1 ? "" : "s", added.joined_anew ? "; all joined anew" : "");
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
  if (path.empty()) return StepReport(path, -1, is_shown);
  const int descriptor =
      path == "-" ? ::dup(STDOUT_FILENO) : ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return call_failed(path, errno, ErrorKind::kCannotWrite);
  return StepReport(path, descriptor, is_shown);
}

StepReport::StepReport(std::filesystem::path path, int descriptor, bool is_shown)
    : path_(std::move(path)), descriptor_(descriptor), is_shown_(is_shown) {}

StepReport::StepReport(StepReport&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), is_shown_(other.is_shown_) {}

StepReport::~StepReport() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Expected<void> StepReport::add(const Step& step) {
  if (is_shown_) std::fputs(for_people(step).c_str(), stderr);
  if (descriptor_ < 0) return {};
  const int failure = write_all(descriptor_, for_programs(step));
  // A reader that has gone away has had all it wanted.
  if (failure == 0 || failure == EPIPE) return {};
  return call_failed(path_ == "-" ? "standard output" : path_, failure, ErrorKind::kCannotWrite);
}

}  // namespace mapjoin::apps
