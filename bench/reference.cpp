// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_reference: the optimum of a log, or of a set of local maps, as Ceres finds it from a start of one's choice.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <string>
#include <tests/support/ceres_reference.hpp>

#include "choice.hpp"
#include "reference_start.hpp"

namespace mapjoin {
namespace {

struct Arguments {
  std::filesystem::path file;
  std::string start = "odometry";
  ReadOptions read;
  bool identity = false;
  testing::ReferenceOptions solver;
};

void add_options(CLI::App& app, Arguments& arguments) {
  using Method = testing::ReferenceMethod;
  const std::map<std::string, Method> methods{{"lm", Method::kLevenbergMarquardt}, {"dogleg", Method::kDogleg}};
  app.add_option("file", arguments.file, "The log or the local maps")->required();
  app.add_option("--start", arguments.start, "odometry, tree, values, tum:FILE or g2o:FILE")->capture_default_str();
  app.add_option("--method", arguments.solver.method, "lm or dogleg")->transform(CLI::CheckedTransformer(methods));
  app.add_option("--iterations", arguments.solver.max_iterations, "At most so many")->capture_default_str();
  bench::add_choice(app, "--g2o-error", arguments.read.pose_error);
  bench::add_choice(app, "--rotation-information", arguments.read.rotation_information);
  app.add_flag("--repair-information", arguments.read.repair_information, "Take the nearest semidefinite matrix");
  app.add_flag("--identity", arguments.identity, "Replace every information matrix by the identity");
  app.add_flag("--verbose", arguments.solver.verbose, "Show every iteration");
}

template <int Dim>
void print_parts(const Log<Dim>& log, const Values<Dim>& state) {
  const Chi2 chi2 = log_chi2(log, state);
  fmt::print("  odometry {:.6f}, closures {:.6f}, observations {:.6f}, priors {:.6f}\n", chi2.odometry, chi2.closures,
             chi2.observations, chi2.priors);
}
template <int Dim>
void print_parts(const SubmapSet<Dim>&, const Values<Dim>&) {}

template <typename Data>
Expected<void> optimise(const Data& data, const Arguments& arguments) {
  const auto start = bench::start_of(data, arguments.start);
  if (!start) return tl::unexpected(start.error());
  const auto result = testing::ceres_optimum(data, *start, arguments.solver);
  fmt::print("start ({})  chi2 {:.6f}\n", arguments.start, result.initial_chi2);
  fmt::print("optimum  chi2 {:.6f}, {} iterations, {}\n", result.chi2, result.iterations,
             result.converged ? "converged" : "not converged");
  print_parts(data, result.values);
  return {};
}

Expected<void> run(const Arguments& arguments) {
  const auto weighed_as_asked = [&](auto& data) {
    if (arguments.identity) use_identity_covariance(data);
    return optimise(data, arguments);
  };
  const bool is_archive = arguments.file.string().find(".tar") != std::string::npos;
  if (is_archive || std::filesystem::is_directory(arguments.file)) {
    auto set = read_local_map_set(arguments.file, arguments.read);
    if (!set) return tl::unexpected(set.error());
    return std::visit(weighed_as_asked, *set);
  }
  auto opened = open_log(arguments.file, arguments.read);
  if (!opened) return tl::unexpected(opened.error());
  return std::visit(weighed_as_asked, *opened);
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  mapjoin::Arguments arguments;
  CLI::App app("Optimises a log, or a folder or archive of local maps, by Ceres.", "mapjoin_reference");
  mapjoin::add_options(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const auto done = mapjoin::run(arguments);
  if (!done) fmt::print(stderr, "mapjoin_reference: {}\n", done.error().message);
  return done ? 0 : 3;
}
