// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line: subcommands, with their options as they are declared, everything that is wrong with those given, and what
// they do.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <stop_token>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace mapjoin::apps {

/// The whole of `word` as a number, finite where it is not whole.
template <typename T>
std::optional<T> number_in(const std::string& word) {
  T value{};
  const char* const end = word.data() + word.size();
  const auto [rest, failure] = std::from_chars(word.data(), end, value);
  if (failure != std::errc() || rest != end || !std::isfinite(static_cast<double>(value))) return std::nullopt;
  return value;
}

/// Values that options are bound to must outlive the subcommand; its action can own them.
class Subcommand {
 public:
  /// What it does once its options are right; may fail() (see exit_code.hpp).
  using Action = std::function<ExitCode(const std::stop_token&)>;
  /// Takes the word given for an option; a violation, as the end of a sentence that begins with the option, where it is wrong.
  using Take = std::function<std::optional<std::string>(const std::string& word)>;

  Subcommand(CLI::App& parent, const std::string& name, const std::string& description);
  Subcommand(const Subcommand&) = delete;
  Subcommand& operator=(const Subcommand&) = delete;

  std::string name() const;
  /// Below the options in the help.
  void examples(const std::string& lines);
  /// The heading of the options that follow in the help.
  void group(const std::string& heading) { group_ = heading; }
  /// An argument that must be given.
  void argument(const std::string& name, std::filesystem::path& value, const std::string& help);
  /// One or several.
  void arguments(const std::string& name, std::vector<std::filesystem::path>& values, const std::string& help);
  /// One or several words, behind the others.
  void words(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// None or several, behind the others.
  void further(const std::string& name, std::vector<std::filesystem::path>& values, const std::string& help);
  void flag(const std::string& name, bool& value, const std::string& help);
  /// A flag that may bring a word along, --name=word; `take` is given none ("") where it does not.
  void flag(const std::string& name, const std::string& help, Take take);
  /// A flag that makes `value` false.
  void refusal(const std::string& name, bool& value, const std::string& help);
  void path(const std::string& names, std::filesystem::path& value, const std::string& kind, const std::string& help,
            bool is_required = false);
  void option(const std::string& name, const std::string& kind, const std::string& help, Take take);

  /// Items with commas between them, each of which `item` makes of its word; a repeated one counts once. Where it makes nothing
  /// of a word, not even of the empty one behind a comma at the end, `violation` ends the sentence.
  template <typename T>
  void list(const std::string& name, const std::string& kind, const std::string& help, std::vector<T>& values,
            std::optional<T> (*item)(const std::string& word), const std::string& violation) {
    option(name, kind, help, [&values, item, violation](const std::string& list) -> std::optional<std::string> {
      values.clear();
      std::istringstream words(list + ",");
      for (std::string word; std::getline(words, word, ',');) {
        const std::optional<T> value = item(word);
        if (!value) return violation;
        if (std::ranges::find(values, *value) == values.end()) values.push_back(*value);
      }
      return std::nullopt;
    });
  }

  /// Former words of an option, which it still takes, and those that stand for them now.
  using Aliases = std::map<std::string, std::string>;

  /// One of the words of an enum; the value as it stands is the default, which the help names.
  template <NamedEnum Enum>
  void choice(const std::string& name, Enum& value, const std::string& help, const Aliases& aliases = {}) {
    choice(name, value, enum_names(value), help, aliases);
  }
  template <typename T, std::size_t Count>
  void choice(const std::string& name, T& value, const std::array<EnumName<T>, Count>& words, const std::string& help,
              const Aliases& aliases = {}) {
    const auto listed = [words](std::string_view separator) {
      std::vector<std::string_view> names;
      for (const auto& [meaning, word] : words) names.push_back(word);
      return fmt::format("{}", fmt::join(names, separator));
    };
    const std::string_view by_default = std::ranges::find(words, value, &EnumName<T>::value)->name;
    option(name, listed("|"), fmt::format("{} [{}]", help, by_default),
           [=, &value](const std::string& given) -> std::optional<std::string> {
             const auto former = aliases.find(given);
             const std::string_view word = former == aliases.end() ? given : former->second;
             const auto meant = std::ranges::find(words, word, &EnumName<T>::name);
             if (meant == words.end()) return "not " + listed(" or ");
             value = meant->value;
             return std::nullopt;
           });
  }

  /// A number from `least` to `most` (and finite); whole where T is. The value as it stands is the default, which the help
  /// names unless it ends with one, as in "[all processors]".
  template <typename T>
  void number(const std::string& name, T& value, T least, const std::string& kind, std::string help,
              T most = std::numeric_limits<T>::max()) {
    if (!help.ends_with(']'))
      help += std::is_integral_v<T> ? fmt::format(" [{}]", value) : fmt::format(" [{:.6g}]", static_cast<double>(value));
    option(name, kind, help, [&value, least, most](const std::string& word) -> std::optional<std::string> {
      const std::optional<T> given = number_in<T>(word);
      if (!given || *given < least || *given > most) {
        const std::string end = most < std::numeric_limits<T>::max() ? fmt::format("to {}", most) : "on";
        return fmt::format("not a {} from {} {}", std::is_integral_v<T> ? "whole number" : "number", least, end);
      }
      value = *given;
      return std::nullopt;
    });
  }

  /// Called after parsing: what is wrong, in words, with options that are right one by one.
  void check(std::function<std::vector<std::string>()> violations) { checks_.push_back(std::move(violations)); }
  /// An option that does nothing unless what it is `of` is asked for, and is then refused.
  void only_with(const std::string& option, const std::string& of, std::function<bool()> is_asked) {
    check([this, option, of, is_asked = std::move(is_asked)]() -> std::vector<std::string> {
      if (!is_given(option) || is_asked()) return {};
      return {option + " is of " + of};
    });
  }
  void act(Action action) { action_ = std::move(action); }

  /// Whether there is such an option.
  bool has(const std::string& name) const;
  /// False, too, where there is no such option.
  bool is_given(const std::string& name) const;
  bool is_chosen() const;
  /// kUsage with every violation where there is one.
  ExitCode run(const std::stop_token& stop) const;

 private:
  CLI::Option& grouped(CLI::Option& option) const;

  CLI::App* app_;
  std::string group_;
  std::vector<std::string> violations_;
  std::vector<std::function<std::vector<std::string>()>> checks_;
  Action action_;
};

/// `--part K/N`, one of several parts of a piece of work, each done on its own: calls take(K, N), 1 ≤ K ≤ N, where it is given.
void add_part(Subcommand& command, const std::string& help, const std::function<void(std::size_t, std::size_t)>& take);

/// Each in a file of its own.
void declare_run(Subcommand& command);
void declare_build(Subcommand& command);
void declare_join(Subcommand& command);
void declare_solve(Subcommand& command);
void declare_compare(Subcommand& command);
void declare_basin(Subcommand& command);
void declare_convexity(Subcommand& command);
void declare_plot(Subcommand& command);
void declare_simulate(Subcommand& command);
void declare_info(Subcommand& command);
void declare_check(Subcommand& command);
void declare_convert(Subcommand& command);
void declare_error(Subcommand& command);
void declare_covariance(Subcommand& command);

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

/// A subcommand, what it does, and the function that declares it.
struct Command {
  const char* name;
  const char* description;
  void (*declare)(Subcommand&);
};

/// That of a program, its subcommands in the order of the help.
CommandLine command_line(const std::string& program, const std::string& description, std::span<const Command> commands);
/// That of `mapjoin`.
CommandLine command_line();

}  // namespace mapjoin::apps
