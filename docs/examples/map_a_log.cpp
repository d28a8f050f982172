// SPDX-License-Identifier: BSD-3-Clause
// map_a_log LOG: from a log in any format that is read to a map in two tables.
#include <iostream>
#include <mapjoin/mapjoin.hpp>
#include <variant>

template <int Dim>
mapjoin::Expected<void> map_of(const mapjoin::Log<Dim>& log) {
  const auto result = mapjoin::run(log, mapjoin::RunOptions{});
  if (!result) return tl::unexpected(result.error());
  std::cout << result->map.poses.size() << " poses, chi2 " << result->chi2 << " over " << result->dof
            << " degrees of freedom\n";
  return mapjoin::write_csv(result->map, "poses.csv", "features.csv");
}

int main(int argc, char** argv) {
  const auto done = mapjoin::open_log(argc > 1 ? argv[1] : "log.g2o").and_then([](const mapjoin::AnyLog& log) {
    return std::visit([](const auto& any) { return map_of(any); }, log);
  });
  if (!done) std::cerr << done.error().message << '\n';
  return done ? 0 : 1;
}
