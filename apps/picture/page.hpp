// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One self-contained page for a browser: text, tables and pictures, and nothing that would have to be fetched.

#include <apps/report/table.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

/// HTML that is well-formed XML, too. Text is taken as text: what looks like markup in it is none.
class Page {
 public:
  explicit Page(std::string title) : title_(std::move(title)) {}

  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// Numbers to the right, good and bad rows told apart.
  void table(const Table& table, const std::string& note);
  /// An SVG that scales to the width there is.
  void figure(const std::string& svg, const std::string& caption);
  /// Two columns of what is so named and what there is to say of it.
  void facts(const std::vector<std::pair<std::string, std::string>>& facts);

  std::string html() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace mapjoin::apps
