// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_outliers: how well wrong closures and wrong identities, planted into logs, are told from right ones, as CSV.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "choice.hpp"
#include "map_identities.hpp"
#include "outlier_score.hpp"
#include "robust_methods.hpp"

namespace mapjoin::bench {
namespace {

/// A public data set by its usual name, and its file below the folder of all of them.
struct NamedSet {
  const char* name;
  const char* file;
};
constexpr std::array kSets = {NamedSet{"intel", "pose-graphs-2d/intel.g2o.gz"},
                              NamedSet{"CSAIL", "pose-graphs-2d/CSAIL.g2o.gz"},
                              NamedSet{"MIT", "pose-graphs-2d/MIT.g2o.gz"},
                              NamedSet{"M3500", "pose-graphs-2d/manhattanOlson3500.g2o.gz"},
                              NamedSet{"manhattan", "pose-graphs-2d/manhattan.g2o.gz"},
                              NamedSet{"city10000", "pose-graphs-2d/city10000.g2o.gz"},
                              NamedSet{"ais2klinik", "pose-graphs-2d/ais2klinik.g2o.gz"},
                              NamedSet{"sphere2500", "pose-graphs-3d/sphere2500.g2o.gz"},
                              NamedSet{"torus3D", "pose-graphs-3d/torus3D.g2o.gz"},
                              NamedSet{"parking-garage", "pose-graphs-3d/parking-garage.g2o.gz"},
                              NamedSet{"cubicle", "pose-graphs-3d/cubicle.g2o.gz"},
                              NamedSet{"vicpark", "vicpark-6898/vicpark6898.g2o.gz"},
                              NamedSet{"dlr", "dlr/dlr_corrected.g2o.gz"},
                              NamedSet{"citytrees", "citytrees10000/cityTrees10000.txt"},
                              NamedSet{"vicpark-200", "vicpark-200-local-maps"},
                              NamedSet{"dlr-200", "dlr-200-local-maps"},
                              NamedSet{"sim-35188", "sim-35188/localmaps_mat.tar.gz"}};

struct Arguments {
  std::vector<std::string> sets;
  std::vector<std::string> policies;
  std::vector<double> shares = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  std::vector<std::size_t> counts = {1, 5, 50, 1000};
  std::vector<double> identities = {0.01, 0.05, 0.1, 0.2, 0.3};
  std::uint64_t seeds = 10;
  std::vector<std::string> methods = {method_names().front()};
  MethodOptions method;
};

std::filesystem::path file_of(const std::string& set) {
  const char* folder = std::getenv("MAPJOIN_DATA_DIR");
  for (const auto& [name, file] : kSets) {
    if (set == name) return std::filesystem::path(folder ? folder : "") / file;
  }
  return set;
}

/// The first columns of a row: what was planted.
struct Planting {
  std::string what;
  double share = 0.0;
  std::uint64_t seed = 1;
};

template <int Dim>
class SetBench {
 public:
  SetBench(std::string name, CleanMap<Dim> clean, const Arguments& arguments)
      : name_(std::move(name)), clean_(std::move(clean)), arguments_(arguments) {}

  void run_all() const {
    if (std::ranges::find(arguments_.shares, 0.0) != arguments_.shares.end()) {
      rows({"nothing"}, with_wrong_closures(clean_, ClosurePolicy::kRandom, 0, 1));
    }
    for (const auto& [policy, name] : enum_names(ClosurePolicy{})) {
      if (std::ranges::find(arguments_.policies, name) != arguments_.policies.end()) closures(policy);
    }
    if (!clean_.log.observations().empty()) identities();
  }

 private:
  void closures(ClosurePolicy policy) const {
    const auto own = static_cast<double>(clean_.log.closures().size());
    std::vector<std::size_t> counts;
    for (const double share : arguments_.shares) {
      if (own > 0.0 && share > 0.0) counts.push_back(static_cast<std::size_t>(std::lround(own * share / (1.0 - share))));
    }
    counts.insert(counts.end(), arguments_.counts.begin(), arguments_.counts.end());
    for (const std::size_t count : counts) {
      const double share = static_cast<double>(count) / (own + static_cast<double>(count));
      for (std::uint64_t seed = 1; seed <= arguments_.seeds; ++seed) {
        rows({to_string(policy), share, seed}, with_wrong_closures(clean_, policy, count, seed));
      }
    }
  }

  void identities() const {
    for (const double share : arguments_.identities) {
      for (std::uint64_t seed = 1; seed <= arguments_.seeds; ++seed) {
        rows({"identities", share, seed}, with_wrong_identities(clean_, share, seed));
      }
    }
  }

  void rows(const Planting& planting, const Spoilt<Dim>& spoilt) const {
    const std::string title = fmt::format("{},{},{:.3f},{}", name_, planting.what, planting.share, planting.seed);
    for (const std::string& method : arguments_.methods) {
      const auto robust = map_robustly(method, spoilt.log, clean_.values, arguments_.method);
      if (!robust) {
        fmt::print(stderr, "{},{}: {}\n", title, method, robust.error().message);
        continue;
      }
      const OutlierScore s = score(clean_, spoilt, *robust);
      fmt::print("{},{},{},{},{},{},{},{},{},{:.5f},{:.5f},{:.4g},{:.6f},{},{:.2f},{:.2f}\n", title, method, s.right,
                 s.wrong + s.undecided, s.wrong, s.wrong_rejected, s.wrong - s.wrong_rejected,
                 s.undecided - s.undecided_rejected, s.right_rejected, s.precision(), s.recall(), s.rms, s.chi2_ratio,
                 s.features_off, robust->cpu_seconds, robust->cpu_seconds / clean_.cpu_seconds);
      std::fflush(stdout);
    }
  }

  std::string name_;
  CleanMap<Dim> clean_;
  const Arguments& arguments_;
};

Expected<void> run_map_set(const std::string& name, const Arguments& arguments) {
  const MapIdentitiesOptions options{arguments.identities, arguments.seeds, arguments.method.robust};
  const auto opened = open_maps(file_of(name));
  if (!opened) return tl::unexpected(opened.error());
  return std::visit(
      [&]<typename Maps>(const Maps& maps) -> Expected<void> {
        if constexpr (requires { maps.graph; }) {
          return print_map_identities(name, maps, options);
        } else {
          return tl::unexpected(Error{ErrorKind::kUsage, "the log of a store is what wrong measurements are planted into"});
        }
      },
      *opened);
}

Expected<void> run_set(const std::string& name, const Arguments& arguments) {
  if (may_hold_maps(file_of(name))) return run_map_set(name, arguments);
  ReadOptions options;
  options.repair_information = true;
  const auto opened = open_log(file_of(name), options);
  if (!opened) return tl::unexpected(opened.error());
  return std::visit(
      [&]<int Dim>(const Log<Dim>& log) {
        return make_clean_map(log).map(
            [&](CleanMap<Dim>&& clean) { SetBench<Dim>(name, std::move(clean), arguments).run_all(); });
      },
      *opened);
}

/// Like run_set(); bad input, too, if a set is too small for what is to be planted.
Expected<void> try_set(const std::string& name, const Arguments& arguments) {
  try {
    return run_set(name, arguments);
  } catch (const std::invalid_argument& too_small) {
    return bad_input(too_small.what());
  }
}

/// Goes through all sets; returns the exit code, 3 if there is one that cannot be read, or is too small.
int run_sets(const Arguments& arguments) {
  fmt::print(
      "set,planted as,share,seed,method,right,planted,wrong,wrong rejected,wrong kept,undecided kept,right rejected,"
      "precision,recall,rms (m),chi2 over clean,features off,cpu (s),cpu over clean\n");
  int exit_code = 0;
  for (const std::string& set : arguments.sets) {
    const auto done = try_set(set, arguments);
    if (done) continue;
    fmt::print(stderr, "mapjoin_outliers: {}: {}\n", set, done.error().message);
    exit_code = 3;
  }
  return exit_code;
}

}  // namespace
}  // namespace mapjoin::bench

int main(int argc, char** argv) {
  using namespace mapjoin;
  bench::Arguments arguments;
  for (const auto& [name, file] : bench::kSets) arguments.sets.emplace_back(name);
  for (const auto& [policy, name] : enum_names(ClosurePolicy{})) arguments.policies.emplace_back(name);
  CLI::App app("Wrong closures and wrong identities, planted into logs: who finds them, as CSV.", "mapjoin_outliers");
  app.add_option("--sets", arguments.sets,
                 "Public data sets below $MAPJOIN_DATA_DIR, or files of logs or folders of local maps")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--policies", arguments.policies, "How closures are planted")
      ->delimiter(',')
      ->check(CLI::IsMember(arguments.policies))
      ->capture_default_str();
  auto* shares = app.add_option("--shares", arguments.shares, "Of wrong closures among all, in logs that have any")
                     ->delimiter(',')
                     ->check(CLI::Range(0.0, 0.99))
                     ->capture_default_str();
  auto* counts = app.add_option("--counts", arguments.counts, "Of wrong closures, beside the shares")
                     ->delimiter(',')
                     ->capture_default_str();
  auto* identities = app.add_option("--identities", arguments.identities,
                                    "Shares of wrong identities, in logs with features and in local maps")
                         ->delimiter(',')
                         ->check(CLI::Range(0.0, 0.99))
                         ->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Per policy and share")->capture_default_str();
  app.add_option("--methods", arguments.methods, "Who makes maps: mapjoin, or Ceres with one of its losses")
      ->delimiter(',')
      ->check(CLI::IsMember(bench::method_names()))
      ->capture_default_str();
  bench::add_choice(app, "--start", arguments.method.start, "Where Ceres begins; from the clean map it is an oracle");
  app.add_option("--limit", arguments.method.most_seconds, "Of Ceres, for each map (s)")->capture_default_str();
  app.add_option("--confidence", arguments.method.robust.confidence, "As of --robust")
      ->check(CLI::Range(0.01, 0.999999))
      ->capture_default_str();
  app.footer("Where any of --shares, --counts and --identities is given, those that are not are left out.");
  CLI11_PARSE(app, argc, argv);
  if (shares->count() + counts->count() + identities->count() > 0) {
    if (shares->count() == 0) arguments.shares.clear();
    if (counts->count() == 0) arguments.counts.clear();
    if (identities->count() == 0) arguments.identities.clear();
  }
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  return bench::run_sets(arguments);
}
