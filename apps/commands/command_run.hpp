// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One run of a subcommand from reading to the last word: what run, build, join and solve have in common.

#include <tbb/global_control.h>

#include <apps/exit_code.hpp>
#include <apps/progress.hpp>
#include <apps/report/run_report.hpp>
#include <apps/truth_file.hpp>
#include <functional>
#include <mapjoin/io/open.hpp>
#include <optional>
#include <stop_token>
#include <string>

namespace mapjoin::apps {

class CommandRun {
 public:
  /// The run works on as many threads as its options say. `options` must outlive it.
  CommandRun(const std::string& command, const Options& options, std::stop_token stop);

  /// kCannotWrite where the report, or the output as files of a map, cannot be made: better now than after the work.
  Expected<void> check_report() const;
  Expected<void> check_outputs() const;
  /// The truth, where there is one, likewise before the work.
  Expected<void> read_truth();
  /// The input as a log, with the weights asked for.
  Expected<AnyLog> read_log();
  /// The same of a log that was read already.
  Expected<AnyLog> take_log(AnyLog log);
  /// The input as local maps; those of a store have the weights that they were built with (kUsage where others are asked
  /// for), others those asked for.
  Expected<AnyMaps> read_maps();
  /// What `work` makes of the input, be it a log or local maps.
  template <typename Work>
  auto with_log_or_maps(Work&& work) {
    const auto visit = [&](const auto& any) { return std::visit(work, any); };
    return may_hold_maps(options_.input) ? read_maps().and_then(visit) : read_log().and_then(visit);
  }
  /// kInterrupted where a stop was requested.
  Expected<void> check_interrupted() const;

  /// Of the options, with this run's progress.
  const RunOptions& run_options() const { return run_options_; }
  /// Of work whose `things` are counted, done and to do; must not outlive this. Empty where nobody looks.
  std::function<void(std::size_t, std::size_t)> progress(const std::string& things);
  void close_progress() { progress_.close(); }
  const Options& options() const { return options_; }
  const std::stop_token& stop() const { return stop_; }

  /// Accounts for a result, and certifies it. Bad input where the map is not finite; kInterrupted where a stop was requested.
  template <int Dim>
  Expected<void> take(RunResult<Dim>& result);
  /// Takes a result and, where there is an output, writes it as one file, in the format that the extension of the path names,
  /// with its covariances and relations beside it. `log`, where it is known, gives edges.
  template <int Dim>
  Expected<void> write_map(RunResult<Dim>& result, const Log<Dim>* log);

  /// What came of it: `json` for programs where a report is asked for, `text` for people on standard output unless that is
  /// taken or nothing is wanted there.
  Expected<void> tell(const std::function<std::string()>& json, const std::function<std::string()>& text);
  /// tell() of report and summary; the exit code by how the work ended.
  Expected<ExitCode> conclude();

  RunReport run_report;

 private:
  /// What was asked of a result's certainty: its covariances into its map; how large they are, and its errors against the
  /// truth, into the report.
  template <int Dim>
  Expected<void> certify(RunResult<Dim>& result);

  const Options& options_;
  std::stop_token stop_;
  tbb::global_control threads_;
  Progress progress_;
  RunOptions run_options_;
  std::optional<TruthFile> truth_;
};

}  // namespace mapjoin::apps
