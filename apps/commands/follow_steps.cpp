// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <apps/commands/follow_steps.hpp>
#include <apps/console.hpp>
#include <apps/exit_code.hpp>
#include <apps/report/json.hpp>
#include <cerrno>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {
namespace {

/// The closures left out and taken back, in words: "; 2 closures left out; 1 closure taken back".
std::string closures_for_people(const RobustlyAdded& done) {
  std::string text;
  if (!done.rejected.empty()) text += fmt::format("; {} left out", plural(done.rejected.size(), "closure"));
  if (!done.readmitted.empty()) text += fmt::format("; {} taken back", plural(done.readmitted.size(), "closure"));
  if (done.no_verdict) text += "; no verdict on closures: " + done.no_verdict->message;
  return text;
}

Json ends_of(const std::vector<ClosureName>& closures) {
  Json ends = Json::array();
  for (const ClosureName& closure : closures) ends.push_back({closure.base.key, closure.target.key});
  return ends;
}

/// What was added, in words: "map 3, pose 20 to 30".
std::string subject_of(const Step& step) {
  if (!step.way) return "what came late";
  const std::string maps = step.count == 1 ? fmt::format("map {}", step.first)
                                           : fmt::format("maps {} to {}", step.first, step.first + step.count - 1);
  return fmt::format("{}, {} to {}", maps, to_string(step.way->begin), key_text(step.way->end.key));
}

std::string for_people(const Step& step) {
  const AddedUpdate& added = step.done.added;
  const std::string subject = subject_of(step);
  if (!added.is_joined) return fmt::format("{}: waits, nothing ties it to the others yet\n", subject);
  return fmt::format("{}: moved {:.3f} m, {:.4f} rad; chi2 {:.2f}, dof {}; {} variables in {}{}{}\n", subject, added.metres,
                     added.radians, added.chi2, added.dof, added.eliminated, plural(added.iterations, "iteration"),
                     added.batch_adopted ? "; all joined anew" : "", closures_for_people(step.done));
}

std::string for_programs(const Step& step) {
  const AddedUpdate& added = step.done.added;
  Json line = {{"map", step.first},
               {"maps", step.count},
               {"first_pose", step.way ? Json(step.way->begin.key) : Json()},
               {"last_pose", step.way ? Json(step.way->end.key) : Json()},
               {"joined", added.is_joined},
               {"moved_m", added.metres},
               {"moved_rad", added.radians},
               {"chi2", added.chi2},
               {"dof", added.dof},
               {"eliminated", added.eliminated},
               {"iterations", added.iterations},
               {"converged", added.converged},
               {"joined_anew", added.batch_adopted},
               {"cpu_seconds", step.seconds}};
  if (step.left_out) {
    line["left_out"] = *step.left_out;
    line["rejected"] = ends_of(step.done.rejected);
    line["readmitted"] = ends_of(step.done.readmitted);
    line["judged"] = step.done.is_judged && !step.done.no_verdict;
  }
  return line.dump() + '\n';
}

}  // namespace

StepReport::StepReport(const std::filesystem::path& path, bool quiet)
    : path_(is_stdout(path) ? "standard output" : path), is_shown_(!quiet && ::isatty(STDERR_FILENO) == 1) {
  if (is_stdout(path)) file_ = File(stdout, [](std::FILE*) { return 0; });
  if (is_stdout(path) || path.empty()) return;
  file_ = File(std::fopen(path.c_str(), "ae"), std::fclose);
  if (!file_) demand(call_failed(path_, errno, ErrorKind::kCannotWrite));
}

void StepReport::add(const Step& step) {
  if (is_shown_) std::fputs(for_people(step).c_str(), stderr);
  if (file_ && !std::exchange(is_begun_, true)) begin();
  if (!file_ || (std::fputs(for_programs(step).c_str(), file_.get()) >= 0 && std::fflush(file_.get()) == 0)) return;
  // No error if the reader has gone away: it has had all it wanted.
  if (errno != EPIPE) demand(call_failed(path_, errno, ErrorKind::kCannotWrite));
}

/// Empties a plain file; a pipe or a device has nothing to empty.
void StepReport::begin() {
  struct ::stat status {};
  const int descriptor = ::fileno(file_.get());
  if (file_.get() == stdout || ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (::ftruncate(descriptor, 0) != 0) demand(call_failed(path_, errno, ErrorKind::kCannotWrite));
}

}  // namespace mapjoin::apps
