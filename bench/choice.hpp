// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Options of benchmarks that take the words of an enum.

#include <CLI/CLI.hpp>
#include <map>
#include <mapjoin/model/enum_names.hpp>
#include <string>

namespace mapjoin::bench {

/// Adds an option that takes the words of an enum; the value as it stands is the default.
template <NamedEnum Enum>
void add_choice(CLI::App& app, const std::string& option, Enum& value, const std::string& help = {}) {
  std::map<std::string, Enum> values;
  for (const auto& [named, name] : enum_names(Enum())) values.emplace(name, named);
  const auto take = [&value, values](const std::string& name) { value = values.at(name); };
  app.add_option_function<std::string>(option, take, help)->check(CLI::IsMember(values))->default_str(to_string(value));
}

}  // namespace mapjoin::bench
