// SPDX-License-Identifier: BSD-3-Clause
#include <apps/commands/part_option.hpp>
#include <optional>

namespace mapjoin::apps {

void add_part(Subcommand& command, const std::string& help, const std::function<void(std::size_t, std::size_t)>& take) {
  command.option("--part", "K/N", help, [take](const std::string& word) -> std::optional<std::string> {
    const auto slash = word.find('/');
    const auto part = number_in<std::size_t>(word.substr(0, slash));
    const auto count = slash == std::string::npos ? std::nullopt : number_in<std::size_t>(word.substr(slash + 1));
    if (!part || !count || *part < 1 || *part > *count) return "not K/N with K from 1 to N, as in 2/4";
    take(*part, *count);
    return std::nullopt;
  });
}

}  // namespace mapjoin::apps
