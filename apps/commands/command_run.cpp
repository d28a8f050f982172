// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/console.hpp>
#include <apps/map_file.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

template <int Dim>
Expected<void> take_weights(const Options& options, MapSet<Dim>& set) {
  if (options.covariance == Covariance::kIdentity) use_identity_covariance(set);
  return {};
}
/// A store's maps are built already: with the weights that it names.
template <int Dim>
Expected<void> take_weights(const Options& options, const StoredMaps<Dim>& stored) {
  const bool are_those = options.covariance == Covariance::kOriginal || options.covariance == stored.log.conventions.covariance;
  if (are_those && !options.read.repair_information) return {};
  return tl::unexpected(Error{ErrorKind::kUsage,
                              "the weights of a store are chosen when it is built: --covariance and --repair-information go "
                              "with `mapjoin build`"});
}

template <int Dim>
bool is_finite(const GlobalMap<Dim>& map) {
  const auto is_finite = [](const auto& value) { return is_valid(value); };
  return std::all_of(map.poses.begin(), map.poses.end(), is_finite) &&
         std::all_of(map.features.begin(), map.features.end(), is_finite);
}

std::string why_not_converged(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const MinimiseResult& last = figures.polish ? *figures.polish : figures.join;
  std::string why = fmt::format("the poses inside {} local maps were not recovered to convergence", figures.unrecovered);
  if (last.status != MinimiseStatus::kConverged) {
    why = fmt::format("the {} did not converge ({} at iteration {})", figures.polish ? "polish" : "join",
                      to_string(last.status), last.iterations);
  }
  return run_report.files.empty() ? why : why + "; the result is written all the same";
}

std::string why_not_certified(const RunReport& run_report) {
  const std::string why = run_report.input + ": " + run_report.figures.no_covariances->message;
  return run_report.files.empty() ? why : why + "; the map is written without them";
}

}  // namespace

CommandRun::CommandRun(const std::string& command, const Options& options, std::stop_token stop)
    : run_report(command, options),
      options_(options),
      stop_(std::move(stop)),
      threads_(tbb::global_control::max_allowed_parallelism, thread_count(options)),
      progress_(!options.quiet),
      run_options_(options.run) {
  run_options_.progress = progress_.callback();
  run_options_.covariances = !options.truth.empty();
  run_options_.marginals = options.covariances || options.relations;
  run_options_.most_memory = static_cast<std::int64_t>(1e6 * std::min(options.most_memory_mb, 1e12));
}

std::function<void(std::size_t, std::size_t)> CommandRun::progress(const std::string& things) {
  const auto show = progress_.callback_in_words();
  if (!show) return nullptr;
  return [show, things](std::size_t done, std::size_t to_do) { show(things, done, to_do); };
}

Expected<void> CommandRun::check_report() const {
  return options_.report_on_stdout() ? Expected<void>() : check_writable(options_.report);
}

Expected<void> CommandRun::check_outputs() const {
  if (options_.output.empty()) return check_report();
  return check_map_writable(options_.output)
      .and_then([&] { return options_.covariances ? check_writable(covariance_file(options_.output)) : Expected<void>(); })
      .and_then([&] { return options_.relations ? check_writable(relation_file(options_.output)) : Expected<void>(); })
      .and_then([&] { return check_report(); });
}

Expected<void> CommandRun::read_truth() {
  if (options_.truth.empty()) return {};
  return timed(run_report.read_seconds, [&] { return TruthFile::open(options_.truth); }).map([&](TruthFile&& truth) {
    truth_ = std::move(truth);
  });
}

Expected<AnyLog> CommandRun::read_log() {
  auto log = timed(run_report.read_seconds, [&] { return open_log(options_.input, options_.read); });
  if (!log && may_hold_maps(options_.input)) {
    return bad_input(fmt::format("{}: not a log, but perhaps local maps, which `mapjoin join` takes", run_report.input));
  }
  if (!log) return log;
  return take_log(*std::move(log));
}

Expected<AnyLog> CommandRun::take_log(AnyLog log) {
  std::visit(
      [&](auto& any) {
        if (options_.covariance == Covariance::kIdentity) use_identity_covariance(any);
        run_report.describe(any);
      },
      log);
  return check_interrupted().map([&] { return std::move(log); });
}

Expected<AnyMaps> CommandRun::read_maps() {
  auto maps = timed(run_report.read_seconds, [&] { return open_maps(options_.input, options_.read); });
  if (!maps) return maps;
  const auto taken =
      std::visit([&](auto& any) { return take_weights(options_, any).map([&] { run_report.describe(any); }); }, *maps);
  return taken.and_then([&] { return check_interrupted(); }).and_then([&] { return std::move(maps); });
}

Expected<void> CommandRun::check_interrupted() const {
  if (stop_.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  return {};
}

template <int Dim>
Expected<void> CommandRun::certify(RunResult<Dim>& result) {
  if (!result.covariances) return {};
  run_report.covariances = result.covariances->estimate();
  if (result.marginals) run_report.deviations = deviations_of(*result.marginals);
  if (options_.covariances) {
    result.map.pose_covariances = result.marginals->poses;
    result.map.feature_covariances = result.marginals->features;
  }
  if (!truth_) return {};
  const auto found = timed(run_report.figures.seconds.covariances, [&] {
    return truth_->of(result.map).and_then([&](const Truth<Dim>& truth) {
      return consistency(*result.covariances, truth, stop_);
    });
  });
  return found.map([&](const Consistency& of_truth) { run_report.consistency = of_truth; });
}

template <int Dim>
Expected<void> CommandRun::take(RunResult<Dim>& result) {
  run_report.describe(result);
  if (!is_finite(result.map)) return bad_input(run_report.input + ": its numbers are too large: the map is not finite");
  return certify(result).and_then([&] { return check_interrupted(); });
}

template <int Dim>
Expected<void> CommandRun::write_map(RunResult<Dim>& result, const Log<Dim>* log) {
  if (auto taken = take(result); !taken || options_.output.empty()) return taken;
  auto files = timed(run_report.write_seconds, [&] { return write_map_file(result.map, log, options_.output); });
  if (!files) return tl::unexpected(files.error());
  run_report.files = std::move(*files);
  if (!result.marginals) return {};
  return timed(run_report.write_seconds, [&]() -> Expected<void> {
    if (options_.covariances) {
      const auto beside = covariance_file(options_.output);
      run_report.files.push_back(beside.string());
      if (auto written = write_covariances(result.map, *run_report.covariances, beside); !written) return written;
    }
    if (!options_.relations) return {};
    const auto beside = relation_file(options_.output);
    run_report.files.push_back(beside.string());
    return write_relations(result.map, *result.marginals, beside);
  });
}

Expected<void> CommandRun::tell(const std::function<std::string()>& json, const std::function<std::string()>& text) {
  progress_.close();
  if (options_.report_on_stdout()) return write_stdout(json());
  if (!options_.report.empty()) {
    if (auto written = write_file(options_.report, json()); !written) return written;
  }
  return options_.quiet ? Expected<void>() : write_stdout(text());
}

Expected<ExitCode> CommandRun::conclude() {
  const auto told = tell([&] { return report(run_report); }, [&] { return summary(run_report); });
  if (!told) return tl::unexpected(told.error());
  if (!run_report.is_joined) return ExitCode::kDone;
  const bool is_certified = !run_report.figures.no_covariances;
  if (!is_certified) say(why_not_certified(run_report));
  if (!run_report.figures.converged()) say(why_not_converged(run_report));
  return !run_report.figures.converged() ? ExitCode::kDidNotConverge : is_certified ? ExitCode::kDone : ExitCode::kBadInput;
}

template Expected<void> CommandRun::take(RunResult<2>&);
template Expected<void> CommandRun::take(RunResult<3>&);
template Expected<void> CommandRun::write_map(RunResult<2>&, const Log<2>*);
template Expected<void> CommandRun::write_map(RunResult<3>&, const Log<3>*);

}  // namespace mapjoin::apps
