// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One run of a subcommand, from reading to the report: the work that subcommands share. All of it may fail() (see
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

/// The results of a study.
struct StudyOutput {
  std::string text;                                        ///< Text for people.
  std::string json;                                        ///< JSON for programs, by docs/report.md.
  std::vector<std::pair<std::string, std::string>> files;  ///< Files of the folder: name and content.
};

class CommandRun {
 public:
  /// The run works on as many threads as its options say. `options` must outlive it.
  CommandRun(const std::string& command, const Options& options, std::stop_token stop);

  /// Checks, before the work, that the outputs can be written, and reads the truth, if one is given.
  void prepare(const NamedFiles& outputs);
  /// The truth; only after prepare(), and if one is given.
  const TruthFile& truth() const { return *truth_; }
  /// Takes the truth of the run on a whole log, for that on a part, instead of prepare().
  void take_truth_of(const CommandRun& whole) { truth_ = whole.truth_; }
  /// Demands that the truth, if given, has a pose or a feature of the input; kUsage.
  template <typename Data>
  void demand_truth(const Data& data) const;
  /// The inputs as one log, as read; with --parts largest and without --associate only its largest part.
  AnyLog open_input();
  /// The inputs as one log, after take_input(), with the fixes of --gps as priors.
  AnyLog read_log();
  /// The inputs as local maps, after take_input(); kUsage if options say how a log is read.
  AnyMaps read_maps();
  /// Gives a log or local maps the weights asked for (kUsage for a store, which was built with its own), finds the features of
  /// --associate, and leaves out what --robust rejects; the report tells of both.
  template <typename Input>
  Input take_input(Input input);
  /// The result of `work` on the input, a log or local maps.
  template <typename Work>
  auto with_log_or_maps(Work&& work) {
    return may_hold_maps(options_.input) ? std::visit(work, read_maps()) : std::visit(work, read_log());
  }
  /// Fails with kInterrupted if a stop was requested.
  void check_interrupted() const;

  /// The options of run(), with the progress of this run.
  const RunOptions& run_options() const { return run_options_; }
  Progress& progress() { return progress_; }
  const Options& options() const { return options_; }
  const std::stop_token& stop() const { return stop_; }

  /// A log with the times that the options give its poses.
  Expected<AnyLog> stamped(AnyLog any) const;

  /// Takes the errors of a map against a truth into the report.
  template <int Dim>
  void measure(const GlobalMap<Dim>& map, const TruthFile& truth, const ErrorOptions& options = {});
  /// Takes a result into the report, with its certainty; kInterrupted if a stop was requested.
  template <int Dim>
  void take(RunResult<Dim>& result);
  /// Checks, before the work, that a map of these poses and features can be written as the output; kUsage.
  void check_names(const PoseIds& poses, const FeatureIds& features) const;
  /// Takes a result and, if there is an output, writes the map as one file, in the format of its extension, with the files that
  /// options ask for beside it. `log` gives edges; null if unknown.
  template <int Dim>
  void write_map(RunResult<Dim>& result, const Log<Dim>* log);

  /// True if there are several inputs, also in one store, and neither an option nor the store says whether they share features:
  /// their maps have to fit.
  bool asks_features() const {
    return options_.features_undecided && run_report.has_several_inputs && !run_report.features_are_shared;
  }
  /// A sentence that features of the same ids lie differently in the maps of two parts of the inputs, if the map of all does
  /// not fit or did not converge; nullopt otherwise, and if the options settle what ids mean.
  template <typename Data>
  std::optional<std::string> features_apart(const Data& data, const RunFigures& figures) const;
  /// Bad input with the sentence of features_apart(), if there is one.
  template <typename Data>
  void check_shared_features(const Data& data, const RunFigures& figures) const {
    if (const auto apart = features_apart(data, figures)) fail(ErrorKind::kBadInput, run_report.input + ": " + *apart);
  }

  /// Writes the association of each sighting beside the output, if features were associated.
  void write_associations();
  /// Writes an extra file; for the inliers `log` must not be null. kCannotWrite.
  template <int Dim>
  Expected<void> write_extra(Extra extra, const RunResult<Dim>& result, const Log<Dim>* log,
                             const std::filesystem::path& file) const;

  /// Writes the outcome: `json` for programs if a report is asked for, `text` for people on standard output, if there is a
  /// summary.
  void tell(const std::string& json, const std::string& text);
  /// Tells report and summary; the exit code of how the work ended.
  ExitCode conclude();
  /// Writes the files of a study into the folder, if there is one, then tells its results.
  void hand_over(const StudyOutput& output, std::optional<OutputFolder>& folder);

  RunReport run_report;
  /// True if the command tells of parts that nothing ties itself: --robust leaves them as they are, and is no error.
  bool tells_of_parts = false;

 private:
  /// Finds out which features are the same; kUsage for a store if names are not to hold, by which its local maps were built.
  template <typename Data>
  void associate_features(Data& data);
  /// Data with its features associated, with --robust so that outliers do not mislead it.
  template <typename Data>
  Expected<Associated<Data>> association_of(const Data& data, const AssociationOptions& association) const;
  /// Fails with the reason why parts were not aligned, unless the largest part of a log is asked for, which is then taken,
  /// with the associations of its sightings. Bad input.
  template <typename Data>
  void settle_untied(const std::vector<UntiedParts>& untied, Data& data);
  std::vector<std::filesystem::path> inputs() const;
  /// The largest part of a log.
  static AnyLog largest(const AnyLog& any);
  /// Like demand_truth(), but with --parts all only says that the truth has nothing of a part, which is then not measured.
  template <typename Data>
  void settle_truth(const Data& data);
  /// Says which files beside a map of one file were there before, but for records of the stores that were joined. They may
  /// belong to the user: none is removed.
  void say_what_is_left();
  /// Says which files that options ask for are not written, since nothing lies beside a stream.
  void say_what_is_left_out() const;
  /// Turns the fixes of --gps into priors of a log, except those that --robust rejects.
  template <int Dim>
  void attach_gps(Log<Dim>& log);
  /// The options of --robust, which must have been asked for.
  RobustOptions robust_options() const;
  /// Leaves out what --robust rejects in a log or a set of local maps. Bad input in parts that nothing ties, unless the command
  /// tells of them.
  template <typename Input>
  void reject_outliers(Input& input);
  /// Puts the covariances asked for into the map of a result, and their medians and the consistency with the truth into the
  /// report.
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
