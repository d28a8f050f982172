// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_ceres: full SLAM of a log by Ceres from dead reckoning, as fast as it goes: analytic Jacobians, stopped at the first
// chi2 that is as good as the optimum. The result goes to standard output, as JSON.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <mapjoin/io/open.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <tests/support/starts.hpp>

#include "ceres_slam.hpp"
#include "speed_programs.hpp"

namespace mapjoin {
namespace {

struct Arguments {
  std::filesystem::path log;
  double optimum = 0.0;
  bench::CeresOptions ceres;
};

template <int Dim>
void solve(const Log<Dim>& log, const Arguments& arguments) {
  bench::CeresOptions options = arguments.ceres;
  options.enough_chi2 = arguments.optimum * (1.0 + bench::kAsGood);
  const auto result = bench::solve_by_ceres(log, testing::odometry_start(log), options);
  const nlohmann::json json = {{"chi2", log_chi2(log, result.values).total()}, {"iterations", result.iterations}};
  fmt::print("{}\n", json.dump());
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  using mapjoin::Arguments;
  Arguments arguments;
  const std::map<std::string, ceres::LinearSolverType> linear{{"cholesky", ceres::SPARSE_NORMAL_CHOLESKY},
                                                              {"schur", ceres::SPARSE_SCHUR}};
  const std::map<std::string, ceres::TrustRegionStrategyType> methods{{"lm", ceres::LEVENBERG_MARQUARDT},
                                                                      {"dogleg", ceres::DOGLEG}};
  CLI::App app("Full SLAM of a log by Ceres, from dead reckoning to a chi2 as good as the optimum.", "mapjoin_ceres");
  app.add_option("log", arguments.log, "The log")->required();
  app.add_option("--optimum", arguments.optimum, "The chi2 to reach; 0: what it converges to")->capture_default_str();
  app.add_option("--linear", arguments.ceres.linear, "cholesky or schur")->transform(CLI::CheckedTransformer(linear));
  app.add_option("--method", arguments.ceres.method, "lm or dogleg")->transform(CLI::CheckedTransformer(methods));
  app.add_option("--iterations", arguments.ceres.most_iterations, "At most so many")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto log = mapjoin::open_log(arguments.log);
  if (!log) {
    fmt::print(stderr, "mapjoin_ceres: {}\n", log.error().message);
    return 3;
  }
  std::visit([&](const auto& any) { mapjoin::solve(any, arguments); }, *log);
  return 0;
}
