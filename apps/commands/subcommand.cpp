// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <apps/commands/subcommand.hpp>

namespace mapjoin::apps {

namespace {

/// Refuses what names no file or folder of this kind: the empty word and, unless it stands for standard output, the word -.
CLI::Validator names_path(const std::string& kind = "") {
  const auto fault = [kind](const std::string& word) -> std::string {
    if (word.empty()) return "is empty";
    if (word != "-" || kind.ends_with("|-")) return "";
    return std::string("is -, which stands for no stream here: ") +
           (kind == "DIR" ? "name a folder, ./- if that is its name"
                          : "name /dev/stdin or /dev/stdout, or ./- for a file of that name");
  };
  return CLI::Validator(fault, "");
}

/// Lets an argument take any number of words, each as it is: of an option that allows extra words CLI11 takes [a,b] for two.
CLI::Option& take_words(CLI::Option& option) {
  constexpr int kMany = CLI::detail::expected_max_vector_size;
  return *option.expected(kMany, kMany)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
}

}  // namespace

Subcommand::Subcommand(CLI::App& parent, const std::string& name, const std::string& description)
    : app_(parent.add_subcommand(name, description)->group("Commands")) {
  app_->set_help_flag("-h,--help", "This text");
}

std::string Subcommand::name() const {
  return app_->get_name();
}

void Subcommand::examples(const std::string& lines) {
  app_->footer("Examples:\n" + lines);
}

CLI::Option& Subcommand::grouped(CLI::Option& option) const {
  if (!group_.empty()) option.group(group_);
  return option;
}

void Subcommand::argument(const std::string& name, std::filesystem::path& value, const std::string& help) {
  app_->add_option(name, value, help)->required()->check(names_path())->type_name("");
}

void Subcommand::arguments(const std::string& name, std::vector<std::filesystem::path>& values, const std::string& help) {
  take_words(*app_->add_option(name, values, help)).required()->check(names_path())->type_name("");
}

void Subcommand::words(const std::string& name, std::vector<std::string>& values, const std::string& help) {
  take_words(*app_->add_option(name, values, help)).required()->type_name("");
}

void Subcommand::further(std::vector<std::filesystem::path>& values, const std::string& help) {
  take_words(*app_->add_option(kFurther, values, help)).check(names_path())->type_name("");
}

void Subcommand::flag(const std::string& name, bool& value, const std::string& help) {
  grouped(*app_->add_flag(name, value, help));
}

void Subcommand::flag(const std::string& name, const std::string& help, Take take) {
  const auto given = std::make_shared<std::string>();
  grouped(*app_->add_flag(name, *given, help));
  check([name, given, take = std::move(take)]() -> std::vector<std::string> {
    if (given->empty()) return {};
    const std::string word = *given == "true" ? "" : *given;  // CLI11's word if there is none
    const auto violation = take(word);
    return violation ? std::vector{fmt::format("{} is \"{}\", {}", name, word, *violation)} : std::vector<std::string>{};
  });
}

void Subcommand::refusal(const std::string& name, bool& value, const std::string& help) {
  grouped(*app_->add_flag_callback(
      name, [&value] { value = false; }, help));
}

void Subcommand::path(const std::string& names, std::filesystem::path& value, const std::string& kind, const std::string& help,
                      bool is_required) {
  grouped(*app_->add_option(names, value, help)->required(is_required)->check(names_path(kind))->type_name(kind));
}

void Subcommand::option(const std::string& name, const std::string& kind, const std::string& help, Take take) {
  const auto heed = [this, name, take = std::move(take)](const std::string& word) {
    if (const auto violation = take(word)) violations_.push_back(fmt::format("{} is \"{}\", {}", name, word, *violation));
  };
  grouped(*app_->add_option_function<std::string>(name, heed, help)->type_name(kind));
}

bool Subcommand::has(const std::string& name) const {
  return app_->get_option_no_throw(name) != nullptr;
}

bool Subcommand::has_choice(const std::string& name, const std::string& word) const {
  const CLI::Option* option = app_->get_option_no_throw(name);
  std::istringstream choices(option ? option->get_type_name() : "");
  for (std::string choice; std::getline(choices, choice, '|');) {
    if (choice == word) return true;
  }
  return false;
}

bool Subcommand::is_given(const std::string& name) const {
  const CLI::Option* option = app_->get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

bool Subcommand::is_chosen() const {
  return app_->parsed();
}

ExitCode Subcommand::run(const std::stop_token& stop) const {
  std::vector<std::string> violations = violations_;
  for (const auto& check : checks_) {
    for (auto& violation : check()) violations.push_back(std::move(violation));
  }
  if (!violations.empty()) fail(ErrorKind::kUsage, fmt::format("{}", fmt::join(violations, "; ")));
  return action_(stop);
}

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
