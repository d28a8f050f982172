// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/picture/markup.hpp>
#include <apps/picture/page.hpp>

namespace mapjoin::apps {
namespace {

constexpr const char* kStyle = R"(
:root { --ink: #1c2024; --quiet: #5b6470; --line: #dfe3e8; --good: #0f6b3f; --bad: #b42318; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 76rem; background: #fff; color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 1rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; line-height: 1.3; margin: 2.75rem 0 0.5rem; }
p { max-width: 46rem; margin: 0.5rem 0 1rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.25rem 1.25rem; margin: 1.25rem 0; max-width: 60rem; }
dt { color: var(--quiet); }
dd { margin: 0; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: 0.75rem 0; }
table { border-collapse: collapse; font-size: 0.8125rem; font-variant-numeric: tabular-nums; }
.note { color: var(--quiet); font-size: 0.875rem; }
th, td { padding: 0.28rem 0.4rem; text-align: left; vertical-align: bottom; white-space: nowrap; }
th { font-weight: 600; white-space: normal; border-bottom: 2px solid var(--ink); }
td { border-bottom: 1px solid var(--line); }
th.number, td.number { text-align: right; }
td:last-child { white-space: normal; min-width: 8.75rem; }
tr.good td:last-child { color: var(--good); }
tr.bad td:last-child { color: var(--bad); }
tbody tr:hover { background: #f5f7f9; }
figure { margin: 1rem 0; }
figure > svg { display: block; max-width: 100%; height: auto; }
figcaption { color: var(--quiet); font-size: 0.875rem; max-width: 46rem; margin-top: 0.5rem; }
@media (max-width: 40rem) { body { padding: 1.25rem 1rem 3rem; } dl { grid-template-columns: 1fr; gap: 0; }
  dd { margin-bottom: 0.5rem; } h1 { font-size: 1.4rem; } }
)";

std::string class_of(RowKind kind) {
  switch (kind) {
    case RowKind::kGood:
      return " class=\"good\"";
    case RowKind::kBad:
      return " class=\"bad\"";
    case RowKind::kPlain:
      return "";
  }
  return "";
}

std::string element(const std::string& name, const std::string& attributes, const std::string& text) {
  return fmt::format("<{0}{1}>{2}</{0}>", name, attributes, escaped(text));
}

}  // namespace

void Page::heading(const std::string& text) {
  body_ += element("h2", "", text) + "\n";
}

void Page::paragraph(const std::string& text) {
  body_ += element("p", "", text) + "\n";
}

void Page::table(const Table& table, const std::string& note) {
  std::vector<std::string> attributes;
  for (std::size_t c = 0; c < table.columns.size(); ++c) attributes.push_back(is_numeric(table, c) ? " class=\"number\"" : "");
  body_ += "<div class=\"wide\"><table>\n<thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    body_ += element("th", " scope=\"col\"" + attributes[c], table.columns[c].heading);
  }
  body_ += "</tr></thead>\n<tbody>\n";
  for (const Row& row : table.rows) {
    body_ += "<tr" + class_of(row.kind) + ">";
    for (std::size_t c = 0; c < row.cells.size(); ++c)
      body_ += element("td", attributes[c], shown(row.cells[c], table.columns[c]));
    body_ += "</tr>\n";
  }
  body_ += "</tbody>\n</table></div>\n" + element("p", " class=\"note\"", note) + "\n";
}

void Page::figure(const std::string& svg, const std::string& caption) {
  body_ += "<figure>\n" + svg + element("figcaption", "", caption) + "\n</figure>\n";
}

void Page::facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  body_ += "<dl>\n";
  for (const auto& [name, text] : facts) body_ += element("dt", "", name) + element("dd", "", text) + "\n";
  body_ += "</dl>\n";
}

std::string Page::html() const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n" +
         element("title", "", title_) + "\n<style>" + kStyle + "</style>\n</head>\n<body>\n" + element("h1", "", title_) +
         "\n" + body_ + "</body>\n</html>\n";
}

}  // namespace mapjoin::apps
