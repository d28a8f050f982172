// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line: subcommands, their options as declared, all violations of those given, and their actions.

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

/// The number that the whole of `word` spells, if it is finite.
template <typename T>
std::optional<T> number_in(const std::string& word) {
  T value{};
  const char* const end = word.data() + word.size();
  const auto [rest, failure] = std::from_chars(word.data(), end, value);
  if (failure != std::errc() || rest != end || !std::isfinite(static_cast<double>(value))) return std::nullopt;
  return value;
}

/// The argument for further inputs, as the help and messages name it.
inline constexpr const char* kFurther = "FURTHER";

/// A subcommand. Values that options are bound to must outlive it; its action can own them.
class Subcommand {
 public:
  /// The work of a subcommand, once its options are valid; may fail() (see exit_code.hpp).
  using Action = std::function<ExitCode(const std::stop_token&)>;
  /// Takes the word given for an option; returns a violation, as the end of a sentence that begins with the option, if it is
  /// wrong.
  using Take = std::function<std::optional<std::string>(const std::string& word)>;

  Subcommand(CLI::App& parent, const std::string& name, const std::string& description);
  Subcommand(const Subcommand&) = delete;
  Subcommand& operator=(const Subcommand&) = delete;

  std::string name() const;
  /// Sets the examples below the options in the help.
  void examples(const std::string& lines);
  /// The heading of the options that follow in the help.
  void group(const std::string& heading) { group_ = heading; }
  /// An argument that must be given.
  void argument(const std::string& name, std::filesystem::path& value, const std::string& help);
  /// One or several paths that must be given.
  void arguments(const std::string& name, std::vector<std::filesystem::path>& values, const std::string& help);
  /// One or several words that must be given, after the other arguments.
  void words(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// The argument kFurther: any number of paths, after the other arguments.
  void further(std::vector<std::filesystem::path>& values, const std::string& help);
  void flag(const std::string& name, bool& value, const std::string& help);
  /// A flag with an optional word, --name=word; `take` is given "" if there is none.
  void flag(const std::string& name, const std::string& help, Take take);
  /// A flag that makes `value` false.
  void refusal(const std::string& name, bool& value, const std::string& help);
  /// An option that takes a path; `-`, for standard output, only if `kind` ends in "|-".
  void path(const std::string& names, std::filesystem::path& value, const std::string& kind, const std::string& help,
            bool is_required = false);
  void option(const std::string& name, const std::string& kind, const std::string& help, Take take);

  /// A list of items separated by commas, each parsed by `item`; repeated ones count once. If `item` rejects a word, also an
  /// empty one after a final comma, `violation` ends the sentence.
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

  /// Former words of an option, which it still accepts, and the present word for each.
  using Aliases = std::map<std::string, std::string>;

  /// An option that takes a word of an enum; the value as it stands is the default, which the help names.
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

  /// An option that takes a finite number from `least` to `most`; whole if T is. The value as it stands is the default, which
  /// the help names unless it ends with one, as in "[all processors]".
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

  /// Adds a check, called after parsing, for violations, in words, by options that are valid one by one.
  void check(std::function<std::vector<std::string>()> violations) { checks_.push_back(std::move(violations)); }
  /// Refuses an option that does nothing unless the option that it belongs to, `of`, is asked for.
  void only_with(const std::string& option, const std::string& of, std::function<bool()> is_asked) {
    check([this, option, of, is_asked = std::move(is_asked)]() -> std::vector<std::string> {
      if (!is_given(option) || is_asked()) return {};
      return {option + " is of " + of};
    });
  }
  void act(Action action) { action_ = std::move(action); }

  /// True if there is such an option.
  bool has(const std::string& name) const;
  /// True if there is such an option, and it is a choice that has this word.
  bool has_choice(const std::string& name, const std::string& word) const;
  /// True if the option exists and was given.
  bool is_given(const std::string& name) const;
  bool is_chosen() const;
  /// Checks the options, then acts; kUsage with every violation, if there are any.
  ExitCode run(const std::stop_token& stop) const;

 private:
  CLI::Option& grouped(CLI::Option& option) const;

  CLI::App* app_;
  std::string group_;
  std::vector<std::string> violations_;
  std::vector<std::function<std::vector<std::string>()>> checks_;
  Action action_;
};

/// Adds `--part K/N`, one of N parts of a piece of work, each done on its own: calls take(K, N), 1 ≤ K ≤ N, if it is given.
void add_part(Subcommand& command, const std::string& help, const std::function<void(std::size_t, std::size_t)>& take);

/// Declares the options and the action of a subcommand; each is defined in a file of its own.
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
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< Subcommands in the order of the help.
};

/// A subcommand, what it does, and the function that declares it.
struct Command {
  const char* name;
  const char* description;
  void (*declare)(Subcommand&);
};

/// The command line of a program, its subcommands in the order of the help.
CommandLine command_line(const std::string& program, const std::string& description, std::span<const Command> commands);
/// The command line of `mapjoin`.
CommandLine command_line();

}  // namespace mapjoin::apps
