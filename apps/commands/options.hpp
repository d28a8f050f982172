// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The options that several subcommands share.

#include <apps/commands/subcommand.hpp>
#include <apps/console.hpp>
#include <filesystem>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The treatment of a log in disconnected parts.
enum class Parts : std::uint8_t { kRefuse, kLargest, kAll };
constexpr auto enum_names(Parts) {
  return std::to_array<EnumName<Parts>>({{Parts::kRefuse, "refuse"}, {Parts::kLargest, "largest"}, {Parts::kAll, "all"}});
}

struct Options {
  std::filesystem::path input;
  std::vector<std::filesystem::path> further;  ///< Further inputs, each a session of its own.
  std::filesystem::path output;                ///< Path of the output; empty: none.
  ReadOptions read;
  MergeOptions merging;             ///< Options for merging several inputs.
  bool features_undecided = false;  ///< True if no option says whether inputs share features.
  std::filesystem::path stamps;     ///< File of the times of poses; empty: none.
  bool ids_are_nanoseconds = false;
  std::filesystem::path gps;  ///< Table of fixes; empty: none.
  GpsOptions of_gps;
  Parts parts = Parts::kRefuse;
  Covariance covariance = Covariance::kOriginal;
  Inflation inflation;
  Share share;  ///< Share of the local maps to build.
  RunOptions run = without_verdict();
  double confidence = RobustOptions().confidence;  ///< Confidence of the next two.
  std::optional<AssociationOptions> association;   ///< Set to find out which features are the same before the work.
  std::optional<RobustOptions> robust;             ///< Set to leave out outliers before the work.
  bool strict = false;                             ///< True if the exit code tells that a map does not fit.
  bool covariances = false;                        ///< True to write covariances.
  bool relations = false;                          ///< True to write relations.
  std::filesystem::path truth;                     ///< File of the truth; empty: none.
  double most_memory_mb = 0.0;                     ///< Bound on the memory of covariances (MB); 0: what the machine has.
  int jobs = 0;                                    ///< Number of threads; 0: one per processor.
  std::filesystem::path report;                    ///< File of the report; empty: none; by is_stdout() standard output.
  bool quiet = false;

  bool report_on_stdout() const { return is_stdout(report); }
  /// True if there is a summary: with --quiet, and beside a report or an output on standard output, there is none.
  bool has_summary() const { return !quiet && !report_on_stdout() && !is_stdout(output); }
};

/// Help text of an argument LOG (see open_log()).
inline const std::string kLogFormats =
    "The log, known by its content: g2o, TORO, iSAM, GTSAM, MAT or text, also as gzip; or a folder of UTIAS MRCLAM data, or of "
    "a run";

/// Help text of an argument that may be a log or local maps (see may_hold_maps()).
inline const std::string kLogOrMaps = "A log, the folder of a run, a store, or a folder or archive of local maps";

/// The files that a truth is read from (see TruthFile), for the help texts of --truth.
inline const std::string kTruthFiles = ".tum or .csv (poses only), g2o with vertices, or the folder of a run";

/// Help text of an output MAP (see write_map_file()).
inline const std::string kMapFile = "Write the map: .g2o, .tum (poses only), .csv (features beside it), .mat";

/// Splitting into local maps of so many poses, or "auto"; nullopt for another word.
std::optional<SplitOptions> split_by_poses(const std::string& word);

/// A splitting as --poses-per-map and its like name it: "20", "auto", "10 m", "15 features".
std::string in_words(const SplitOptions& split);

/// A note that a splitting cuts the log into no local map, so that joining is full SLAM.
std::string no_map_in_words(const SplitOptions& split);

/// Refuses other weights than those of a store, by which its maps were built.
[[noreturn]] void refuse_weights_of_store();

/// Gives a log or a set of local maps the weights asked for; kUsage for what a store has other weights of already than a file.
template <typename Data>
void take_weights(const Options& options, Data& data) {
  const bool is_as_given = data.conventions.covariance == Covariance::kOriginal && data.conventions.inflation == Inflation{};
  if (options.inflation != Inflation{} && !is_as_given) refuse_weights_of_store();
  if (options.covariance == Covariance::kIdentity) use_identity_covariance(data);
  if (options.inflation != Inflation{}) inflate(options.inflation, data);
}

/// The number of threads that the run works on.
std::size_t thread_count(const Options& options);

/// The refusal, in words, of an option of logs for an input that holds local maps.
std::string is_for_a_log(const std::filesystem::path& input, const std::string& option);
/// Adds the options for lenient reading of files of others: --skip-unknown, --skip-self-edges, --skip-undeclared,
/// --identity-where-missing; `of` is behind what each does.
void add_leniency(Subcommand& command, Options& options, const std::string& of);
/// Adds the options for reading a log: --g2o-error, --rotation-information, --repair-information, --covariance, --from; and
/// those for lenient reading.
void add_reading(Subcommand& command, Options& options);
/// Adds the options for lenient reading for a command whose truth alone may be a log.
void add_reading_of_truth(Subcommand& command, Options& options);
/// Adds an argument for further inputs after `input`, whose kind the help names ("logs"), --features and --keep-copies.
void add_further(Subcommand& command, Options& options, const std::string& kind);
/// Adds --parts: refuse, the largest, or all of them, for commands that make a map of each.
void add_parts(Subcommand& command, Options& options);
/// Adds --parts for commands that make one map: refuse, or the largest.
void add_one_part(Subcommand& command, Options& options);
/// Adds further logs by add_further(), and --stamps, --ids-are-nanoseconds.
void add_further_logs(Subcommand& command, Options& options);
/// --gps, --gps-lever, --gps-apart: fixes of a satellite receiver hold the map.
void add_gps(Subcommand& command, Options& options);
/// Adds the part of add_reading() for inputs other than g2o: --repair-information, --covariance.
void add_weights(Subcommand& command, Options& options);
/// Adds --inflate, behind the options for reading a log or local maps.
void add_inflation(Subcommand& command, Options& options);
/// Adds the options for cutting a log: --poses-per-map, --metres-per-map, --features-per-map.
void add_splitting(Subcommand& command, Options& options);
/// --part
void add_share(Subcommand& command, Options& options);
/// A violation, in words, if options of add_splitting() or add_share() are given for local maps, which are cut already.
std::vector<std::string> check_uncut(const Subcommand& command, const Options& options);
/// --schedule, --state, --start, --batch, --seed
void add_schedule(Subcommand& command, Options& options);
/// --no-polish
void add_polish(Subcommand& command, Options& options);
/// --method, --max-iterations
void add_solver(Subcommand& command, Options& options);
/// --engine
void add_engine(Subcommand& command, Options& options);
/// --no-verdict, --strict: the fit is tested unless it is refused.
void add_verdict(Subcommand& command, Options& options);
/// --associate, --association: the names of features are ignored.
void add_association(Subcommand& command, Options& options);
/// --robust: wrong closures, observations and features of local maps are left out; `told` says in the help where they are
/// named.
void add_robust(Subcommand& command, Options& options, const std::string& told);
/// Adds --confidence for the options that `of` names, which must be added before.
void add_confidence(Subcommand& command, Options& options, const std::string& of);
/// --covariances, --relations, --truth, --max-memory
void add_certainty(Subcommand& command, Options& options);
/// --max-memory
void add_most_memory(Subcommand& command, Options& options, const std::string& help);
/// --jobs, --quiet
void add_running(Subcommand& command, Options& options);
/// --jobs, --report, --quiet
void add_reporting(Subcommand& command, Options& options);

}  // namespace mapjoin::apps
