// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The options that several subcommands share.

#include <apps/commands/subcommand.hpp>
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

/// What becomes of a log whose parts nothing ties together.
enum class Parts : std::uint8_t { kRefuse, kLargest, kAll };
constexpr auto enum_names(Parts) {
  return std::to_array<EnumName<Parts>>({{Parts::kRefuse, "refuse"}, {Parts::kLargest, "largest"}, {Parts::kAll, "all"}});
}

struct Options {
  std::filesystem::path input;
  std::vector<std::filesystem::path> further;  ///< Inputs, each a session of its own.
  std::filesystem::path output;                ///< Empty: none.
  ReadOptions read;
  MergeOptions merging;          ///< Of several inputs.
  bool asks_features = false;    ///< Nobody said whether these share features.
  std::filesystem::path stamps;  ///< A file of times; empty: none.
  bool ids_are_nanoseconds = false;
  std::filesystem::path gps;  ///< A table of fixes; empty: none.
  GpsOptions of_gps;
  Parts parts = Parts::kRefuse;
  Covariance covariance = Covariance::kOriginal;
  Share share;  ///< Of the local maps, to be built.
  RunOptions run = without_verdict();
  double confidence = RobustOptions().confidence;  ///< Of the next two.
  std::optional<AssociationOptions> association;   ///< Find out which features are the same before the work.
  std::optional<RobustOptions> robust;             ///< Leave out what is wrong before the work.
  bool strict = false;                             ///< The exit code tells that a map does not fit.
  bool covariances = false;                        ///< Write them.
  bool relations = false;                          ///< Write them.
  std::filesystem::path truth;                     ///< Empty: none.
  double most_memory_mb = 0.0;                     ///< For covariances; 0: none given, as much as the machine has.
  int jobs = 0;                                    ///< Threads; 0: as many as there are processors.
  std::filesystem::path report;                    ///< Empty: none; "-": standard output.
  bool quiet = false;

  bool report_on_stdout() const { return report == "-"; }
};

/// What a command that takes a LOG says of it (see open_log()).
inline const std::string kLogFormats =
    "The log, known by its content: g2o, TORO, iSAM, GTSAM, MAT or text, also as gzip; or a folder of UTIAS MRCLAM data";

/// What a command that writes one MAP says of it (see write_map_file()).
inline const std::string kMapFile = "Write the map: .g2o, .tum (poses only), .csv (features beside it), .mat";

/// Local maps of so many poses, or "auto"; nothing of another word.
std::optional<SplitOptions> split_by_poses(const std::string& word);

/// Gives a log or a set of local maps the weights asked for.
template <typename Data>
void take_weights(const Options& options, Data& data) {
  if (options.covariance == Covariance::kIdentity) use_identity_covariance(data);
}

/// How many threads the run works on.
std::size_t thread_count(const Options& options);

/// How a log is read: --g2o-error, --rotation-information, --repair-information, --covariance, --from; and what is left out:
/// --skip-unknown, --skip-self-edges, --skip-undeclared, --identity-where-missing.
void add_reading(Subcommand& command, Options& options);
/// Further inputs of this kind behind `input`, "logs" or "stores", and --features.
void add_further(Subcommand& command, Options& options, const std::string& kind);
/// --parts: refused or the largest; all of them, too, where the command makes a map of each.
void add_parts(Subcommand& command, Options& options);
/// Says where all parts are asked for of a command that makes one map.
std::vector<std::string> check_one_part(const Options& options);
/// add_further() of logs, and --keep-copies, --stamps, --ids-are-nanoseconds.
void add_further_logs(Subcommand& command, Options& options);
/// --gps, --gps-lever, --gps-apart: fixes of a satellite receiver hold the map.
void add_gps(Subcommand& command, Options& options);
/// As add_reading() where there is no g2o file: --repair-information, --covariance.
void add_weights(Subcommand& command, Options& options);
/// Where a log is cut: --poses-per-map, --metres-per-map, --features-per-map.
void add_splitting(Subcommand& command, Options& options);
/// --part
void add_share(Subcommand& command, Options& options);
/// Says where rules of add_splitting() or add_share() are given for local maps, which are cut already.
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
/// --robust: wrong closures, observations and features of local maps are left out.
void add_robust(Subcommand& command, Options& options);
/// --confidence, of the options that are named `of`, which the command has before.
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
