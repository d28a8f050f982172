// SPDX-License-Identifier: BSD-3-Clause
// The program for libFuzzer: `mapjoin_fuzz --target=NAME [libFuzzer's options] CORPUS`.

#include <tbb/global_control.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <tests/fuzz/targets.hpp>

namespace {

void (*run)(std::string_view bytes) = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  // One thread alone, so that an input always takes the same course.
  static const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  constexpr std::string_view kOption = "--target=";
  for (int i = 1; i < *argc; ++i) {
    const std::string_view argument = (*argv)[i];
    if (!argument.starts_with(kOption)) continue;
    for (const auto& target : mapjoin::fuzz::kTargets) {
      if (target.name == argument.substr(kOption.size())) run = target.run;
    }
  }
  if (run) return 0;
  std::fputs("Usage: mapjoin_fuzz --target=NAME [OPTION...] CORPUS, where NAME is one of\n", stderr);
  for (const auto& target : mapjoin::fuzz::kTargets) {
    std::fprintf(stderr, "  %.*s\n", static_cast<int>(target.name.size()), target.name.data());
  }
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  run({reinterpret_cast<const char*>(data), size});
  return 0;
}
