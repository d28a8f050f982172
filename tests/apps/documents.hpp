// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pages of the documents as a test reads them: their blocks of commands, and the comparison of shown output.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <tests/apps/command.hpp>
#include <tests/support/temporary_folder.hpp>
#include <vector>

namespace mapjoin::testing {

/// A fenced block, with what a comment right above it asks for:
///   <!-- not run: REASON -->   it takes too long, or builds the project
///   <!-- data: FILE… -->       it needs these files below MAPJOIN_DATA_DIR, under their last names
///   <!-- exit: CODE -->        its last command ends with this code
///   <!-- file: FILE -->        it is this file, but for its first line, the licence
struct Block {
  std::string language;
  std::vector<std::string> lines;
  std::size_t line = 0;  ///< Line of its fence, from 1.
  std::optional<std::string> not_run;
  std::vector<std::string> data;
  std::optional<std::string> exit;
  std::optional<std::string> file;

  bool holds_commands() const { return language == "sh" || language == "console"; }
};

/// The value of a comment `<!-- NAME: VALUE -->`; nullopt if it is none of this name.
inline std::optional<std::string> said(const std::string& comment, const std::string& name) {
  const std::string begin = "<!-- " + name + ": ";
  if (!comment.starts_with(begin)) return std::nullopt;
  return comment.substr(begin.size(), comment.find(" -->") - begin.size());
}

inline void heed(const std::string& comment, Block& block) {
  block.not_run = said(comment, "not run");
  block.exit = said(comment, "exit");
  block.file = said(comment, "file");
  std::istringstream files(said(comment, "data").value_or(""));
  for (std::string file; files >> file;) block.data.push_back(file);
}

inline std::vector<Block> blocks_of(const std::filesystem::path& page) {
  std::vector<Block> blocks;
  bool is_inside = false;
  std::string above;
  std::size_t number = 0;
  for (const std::string& line : lines_of(content_of(page))) {
    ++number;
    if (line.starts_with("```")) {
      is_inside = !is_inside;
      if (is_inside) {
        blocks.push_back({line.substr(3), {}, number, std::nullopt, {}, std::nullopt, std::nullopt});
        heed(above, blocks.back());
      }
    } else if (is_inside) {
      blocks.back().lines.push_back(line);
    }
    above = line;
  }
  return blocks;
}

/// A command of a console block, and what is shown below it.
struct Shown {
  std::string command;
  std::vector<std::string> output;
};

inline std::vector<Shown> shown_in(const Block& block) {
  std::vector<Shown> all;
  for (const std::string& line : block.lines) {
    if (line.starts_with("$ ")) {
      all.push_back({line.substr(2), {}});
    } else if (!all.empty()) {
      all.back().output.push_back(line);
    }
  }
  return all;
}

/// A line with what differs from call to call masked: the numbers of a line of seconds as "#", runs of spaces as one.
inline std::string masked(std::string line) {
  static const std::regex number(R"([0-9]+(\.[0-9]+)?)");
  static const std::regex spaces(" +");
  if (line.starts_with("seconds")) line = std::regex_replace(line, number, "#");
  line = std::regex_replace(line, spaces, " ");
  return line.ends_with(' ') ? line.substr(0, line.size() - 1) : line;
}

/// A unit of the last digit of a decimal number.
inline double last_unit(const std::string& digits) {
  const std::size_t end = std::min(digits.find('e'), digits.size());
  const double exponent = end < digits.size() ? std::strtod(digits.c_str() + end + 1, nullptr) : 0.0;
  return std::pow(10.0, exponent - static_cast<double>(end - digits.find('.') - 1));
}

/// True if two masked lines are equal, with decimals to 1e-6 of them or to a unit of the last digit of the one that has more
/// of them, for another processor rounds differently.
inline bool is_same(const std::string& shown, const std::string& given) {
  static const std::regex decimal(R"(-?[0-9]+\.[0-9]+(e[-+]?[0-9]+)?)");
  const std::string a = masked(shown);
  const std::string b = masked(given);
  if (std::regex_replace(a, decimal, "~") != std::regex_replace(b, decimal, "~")) return false;
  std::sregex_iterator in_b(b.begin(), b.end(), decimal);
  for (std::sregex_iterator in_a(a.begin(), a.end(), decimal); in_a != std::sregex_iterator(); ++in_a, ++in_b) {
    const double x = std::strtod(in_a->str().c_str(), nullptr);
    const double y = std::strtod(in_b->str().c_str(), nullptr);
    const double unit = std::min(last_unit(in_a->str()), last_unit(in_b->str()));
    if (std::abs(x - y) > std::max(1e-6 * std::abs(x), 1.01 * unit)) return false;
  }
  return true;
}

/// The first difference of two outputs, line by line, in words; nullopt if there is none. A shown line "…" stands for any
/// lines.
inline std::optional<std::string> difference(const std::vector<std::string>& shown, const std::vector<std::string>& given,
                                             std::size_t s = 0, std::size_t g = 0) {
  for (; s < shown.size(); ++s, ++g) {
    if (shown[s] == "…") {
      for (std::size_t from = g; from <= given.size(); ++from) {
        if (!difference(shown, given, s + 1, from)) return std::nullopt;
      }
      return "what follows the … does not";
    }
    if (g == given.size()) return "shown: " + shown[s] + "\nbut the output has ended";
    if (!is_same(shown[s], given[g])) return "shown: " + shown[s] + "\ngiven: " + given[g];
  }
  if (g < given.size()) return "not shown: " + given[g];
  return std::nullopt;
}

}  // namespace mapjoin::testing
