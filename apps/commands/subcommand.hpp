// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line: subcommands, with their options as they are declared, everything that is wrong with those given, and what
// they do.

#include <apps/exit_code.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace mapjoin::apps {

/// The whole of `word` as a number, finite where it is not whole: int, std::int64_t, std::uint64_t or double.
template <typename T>
std::optional<T> number_in(const std::string& word);

/// What stands between the commas of a list; a comma at its end has an empty word behind it.
std::vector<std::string> words_between_commas(const std::string& list);

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
  void flag(const std::string& name, bool& value, const std::string& help);
  /// A flag that makes `value` false.
  void refusal(const std::string& name, bool& value, const std::string& help);
  void path(const std::string& names, std::filesystem::path& value, const std::string& kind, const std::string& help,
            bool is_required = false);
  void option(const std::string& name, const std::string& kind, const std::string& help, Take take);

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
    std::vector<std::string> all;
    std::string given_by_default;
    for (const auto& [meaning, word] : words) {
      all.emplace_back(word);
      if (meaning == value) given_by_default = word;
    }
    option(name, joined(all, "|"), help + " [" + given_by_default + "]", [&value, words, all, aliases](const std::string& given) {
      const auto former = aliases.find(given);
      const std::string& word = former == aliases.end() ? given : former->second;
      for (const auto& [meaning, name_of_choice] : words) {
        if (name_of_choice != word) continue;
        value = meaning;
        return std::optional<std::string>();
      }
      return std::optional<std::string>("not " + joined(all, " or "));
    });
  }

  /// A number from `least` to `most` (and finite); whole where T is. The value as it stands is the default, which the help
  /// names unless it ends with one, as in "[all processors]".
  template <typename T>
  void number(const std::string& name, T& value, T least, const std::string& kind, std::string help,
              T most = std::numeric_limits<T>::max());

  /// Called after parsing: what is wrong, in words, with options that are right one by one.
  void check(std::function<std::vector<std::string>()> violations) { checks_.push_back(std::move(violations)); }
  void act(Action action) { action_ = std::move(action); }

  /// False, too, where there is no such option.
  bool is_given(const std::string& name) const;
  bool is_chosen() const;
  /// kUsage with every violation where there is one.
  ExitCode run(const std::stop_token& stop) const;

 private:
  static std::string joined(const std::vector<std::string>& words, const std::string& separator);
  CLI::Option& grouped(CLI::Option& option) const;

  CLI::App* app_;
  std::string group_;
  std::vector<std::string> violations_;
  std::vector<std::function<std::vector<std::string>()>> checks_;
  Action action_;
};

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

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

CommandLine command_line();

}  // namespace mapjoin::apps
