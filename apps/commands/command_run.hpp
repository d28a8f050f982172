// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One run of a subcommand from reading to the last word: what the subcommands have in common. All of it may fail() (see
// exit_code.hpp).

#include <tbb/global_control.h>

#include <apps/console.hpp>
#include <apps/exit_code.hpp>
#include <apps/output_folder.hpp>
#include <apps/outputs.hpp>
#include <apps/report/run_report.hpp>
#include <apps/truth_file.hpp>
#include <mapjoin/io/open.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

/// What a study found.
struct StudyOutput {
  std::string text;                                        ///< For people.
  std::string json;                                        ///< For programs, by docs/report.md.
  std::vector<std::pair<std::string, std::string>> files;  ///< Of the folder: name and content.
};

class CommandRun {
 public:
  /// The run works on as many threads as its options say. `options` must outlive it.
  CommandRun(const std::string& command, const Options& options, std::stop_token stop);

  /// Before the work: that the outputs can be written, and what the truth is, where there is one.
  void prepare(const NamedFiles& outputs);
  /// Once prepared, where one is given.
  const TruthFile& truth() const { return *truth_; }
  /// Instead of prepare(), for a run of a part: the truth as it is of the whole.
  void take_truth_of(const CommandRun& whole) { truth_ = whole.truth_; }
  /// kUsage where there is a truth which knows nothing of the input.
  template <typename Data>
  void demand_truth(const Data& data) const;
  /// The inputs as one log, as they are; of several parts the largest one, where that is asked for.
  AnyLog open_input();
  /// The inputs as one log, as take_input() makes it of them, and with fixes of --gps.
  AnyLog read_log();
  /// The inputs as local maps, as take_input() makes them of them.
  AnyMaps read_maps();
  /// A log or local maps with the weights asked for (kUsage for a store, which was built with its own), with features found by
  /// --associate, and without what --robust rejects. Both are told in the report.
  template <typename Input>
  Input take_input(Input input);
  /// What `work` makes of the input, be it a log or local maps.
  template <typename Work>
  auto with_log_or_maps(Work&& work) {
    return may_hold_maps(options_.input) ? std::visit(work, read_maps()) : std::visit(work, read_log());
  }
  /// kInterrupted where a stop was requested.
  void check_interrupted() const;

  /// Of the options, with this run's progress.
  const RunOptions& run_options() const { return run_options_; }
  Progress& progress() { return progress_; }
  const Options& options() const { return options_; }
  const std::stop_token& stop() const { return stop_; }

  /// A log with the times that the options give its poses.
  Expected<AnyLog> stamped(AnyLog any) const;

  /// Describes a result, and certifies it. Bad input where the map is not finite; kInterrupted where a stop was requested.
  template <int Dim>
  void take(RunResult<Dim>& result);
  /// Takes a result and, where there is an output, writes it as one file, in the format that the extension of the path names,
  /// with its covariances and relations beside it. `log`, where it is known, gives edges.
  template <int Dim>
  void write_map(RunResult<Dim>& result, const Log<Dim>* log);

  /// Whether there are several inputs, be it in one store, and nobody said whether they share features: their maps have to fit.
  bool asks_features() const { return options_.asks_features && run_report.has_several_inputs; }
  /// In words, of the map of several inputs which does not fit, that features of the same ids lie differently in parts of it;
  /// nothing where the options say what ids mean.
  template <typename Data>
  std::optional<std::string> features_apart(const Data& data, const RunFigures& figures) const;
  /// Bad input where features_apart() has something to say.
  template <typename Data>
  void check_shared_features(const Data& data, const RunFigures& figures) const {
    if (const auto apart = features_apart(data, figures)) fail(ErrorKind::kBadInput, run_report.input + ": " + *apart);
  }

  /// Writes what became of each sighting beside the output, where features were associated.
  void write_associations();
  /// Writes what an option asked for; for the inliers `log` may not be null. kCannotWrite.
  template <int Dim>
  Expected<void> write_extra(Extra extra, const RunResult<Dim>& result, const Log<Dim>* log,
                             const std::filesystem::path& file) const;

  /// What came of it: `json` for programs where a report is asked for, `text` for people on standard output unless that is
  /// taken or nothing is wanted there.
  void tell(const std::string& json, const std::string& text);
  /// tell() of report and summary; the exit code by how the work ended.
  ExitCode conclude();
  /// What a study found: its files into the folder, where there is one, then tell().
  void hand_over(const StudyOutput& output, std::optional<OutputFolder>& folder);

  RunReport run_report;

 private:
  /// Finds out which features are the same; kUsage of stores whose names do not hold, for their local maps were built by them.
  template <typename Data>
  void associate_features(Data& data);
  /// Says why parts were not aligned, unless the largest of a log's is asked for, which is then taken.
  template <typename Data>
  void settle_untied(const std::vector<UntiedParts>& untied, Data& data);
  std::vector<std::filesystem::path> inputs() const;
  /// The largest part of a log.
  static AnyLog largest(const AnyLog& any);
  /// Where poses have no times, the truth counts them in the whole log, also for a part of it. kUsage where it has times.
  template <int Dim>
  void count_truth_among(const Log<Dim>& whole);
  /// As demand_truth(); of one part among all it is said, and the part is not compared.
  template <typename Data>
  void settle_truth(const Data& data);
  /// Says which files beside a map that is one file were there before. They may be somebody's: none is removed.
  void say_what_is_left();
  /// Makes the fixes of --gps priors of a log, but for those that --robust finds wrong.
  template <int Dim>
  void attach_gps(Log<Dim>& log);
  /// Leaves out what --robust finds wrong in a log or a set of local maps; kUsage of a store, whose maps are built.
  template <typename Input>
  void reject_outliers(Input& input);
  template <int Dim>
  void reject_outliers(StoredMaps<Dim>& stored);
  /// What was asked of a result's certainty: its covariances into its map; how large they are, and its errors against the
  /// truth, into the report.
  template <int Dim>
  void certify(RunResult<Dim>& result);

  const Options& options_;
  std::stop_token stop_;
  tbb::global_control threads_;
  Progress progress_;
  RunOptions run_options_;
  std::optional<TruthFile> truth_;
};

}  // namespace mapjoin::apps
