// SPDX-License-Identifier: BSD-3-Clause
#include "speed_programs.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <tests/support/process.hpp>

namespace mapjoin::bench {
namespace {

using Words = std::vector<std::string>;

Words mapjoin(const Surroundings& surroundings, const Words& words) {
  Words all{surroundings.programs / "mapjoin"};
  all.insert(all.end(), words.begin(), words.end());
  all.insert(all.end(), {"--report", "-"});
  return all;
}

/// The path of the map that make_map() writes.
std::filesystem::path map_of(const Data& data, const Surroundings& surroundings) {
  return surroundings.folder / (data.is_maps ? "join.g2o" : "run.g2o");
}

/// The command line of `mapjoin run` or `join`.
template <int jobs>
Words ours(const Data& data, const Surroundings& surroundings) {
  return mapjoin(surroundings, {data.is_maps ? "join" : "run", data.file, "--no-verdict", "--jobs", std::to_string(jobs)});
}

Words run_to_folder(const Data& data, const Surroundings& surroundings) {
  return mapjoin(surroundings, {"run", data.file, "--no-verdict", "--jobs", "1", "-o", surroundings.folder / "run"});
}

Words solve(const Data& data, const Surroundings& surroundings) {
  return mapjoin(surroundings, {"solve", data.file, "--schedule", "batch", "--method", "gn", "--jobs", "1"});
}

Words ceres(const Data& data, const Surroundings& surroundings, const std::string& linear, const std::string& method) {
  return {surroundings.programs / "mapjoin_ceres",
          data.file,
          "--linear",
          linear,
          "--method",
          method,
          "--optimum",
          fmt::format("{}", std::isfinite(surroundings.optimum) ? surroundings.optimum : 0.0)};
}

Words limit(const Data& data, const Surroundings& surroundings) {
  return {surroundings.programs / "mapjoin_limit", data.file, "--map", map_of(data, surroundings)};
}

double seconds_of(const ::timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

constexpr int kKilled = 1000;  // testing::Process adds the signal

std::string failure_of(const testing::Process& process, int exit_code, const Surroundings& surroundings) {
  if (exit_code == kKilled + SIGXCPU) return fmt::format("stopped after {} s", surroundings.most_seconds);
  if (exit_code > kKilled) return fmt::format("killed by signal {}", exit_code - kKilled);
  const std::string words = process.standard_error();
  return fmt::format("exit code {}: {}", exit_code, words.substr(0, words.find('\n')));
}

}  // namespace

std::vector<Program> programs_for(const Data& data) {
  using enum ProgramKind;
  if (data.is_maps) return {{"join", kOurs, ours<1>}, {"join --jobs 2", kOurs, ours<2>}, {"limit", kLimit, limit}};
  return {{"run", kOurs, ours<1>},
          {"run --jobs 2", kOurs, ours<2>},
          {"run to a folder", kOurs, run_to_folder},
          {"solve", kOther, solve},
          {"ceres cholesky lm", kOther, [](const auto& d, const auto& s) { return ceres(d, s, "cholesky", "lm"); }},
          {"ceres cholesky dogleg", kOther, [](const auto& d, const auto& s) { return ceres(d, s, "cholesky", "dogleg"); }},
          {"ceres schur lm", kOther, [](const auto& d, const auto& s) { return ceres(d, s, "schur", "lm"); }},
          {"ceres schur dogleg", kOther, [](const auto& d, const auto& s) { return ceres(d, s, "schur", "dogleg"); }},
          {"limit", kLimit, limit}};
}

void make_map(const Data& data, const Surroundings& surroundings) {
  Words words = ours<2>(data, surroundings);
  words.insert(words.end(), {"-o", map_of(data, surroundings)});
  testing::Process process(words, {});
  if (process.wait() != 0) fmt::print(stderr, "no map of {}: {}\n", data.name, process.standard_error());
}

Trial try_program(const Program& program, const Data& data, const Surroundings& surroundings) {
  testing::ProcessOptions options;
  if (program.kind == ProgramKind::kOther) options.cpu_seconds = surroundings.most_seconds;
  const auto start = std::chrono::steady_clock::now();
  testing::Process process(program.words(data, surroundings), options);
  const int exit_code = process.wait();
  Trial trial;
  trial.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  trial.cpu_seconds = seconds_of(process.usage().ru_utime) + seconds_of(process.usage().ru_stime);
  trial.memory_mb = static_cast<double>(process.usage().ru_maxrss) * 1024e-6;
  trial.said = nlohmann::json::parse(process.standard_output(), nullptr, false);
  if (trial.said.is_object() && trial.said.at("chi2").is_number()) {
    trial.chi2 = trial.said.at("chi2").get<double>();
  } else {
    trial.failure = failure_of(process, exit_code, surroundings);
  }
  if (trial.chi2 && program.kind == ProgramKind::kLimit) {
    trial.cpu_seconds = trial.said.at("cpu_seconds").get<double>();
    trial.memory_mb = trial.said.at("memory_mb").get<double>();
  }
  return trial;
}

std::optional<std::string> said_by(const std::vector<std::string>& words) {
  testing::Process process(words);
  if (process.wait() != 0) return std::nullopt;
  return process.standard_output();
}

}  // namespace mapjoin::bench
