// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <tests/fuzz/folder.hpp>

namespace mapjoin::fuzz {
namespace {

constexpr std::string_view kBefore = "==> ";
constexpr std::string_view kBehind = " <==\n";

bool is_name(std::string_view name) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.'; };
  return !name.empty() && name.size() < 64 && name[0] != '.' && std::all_of(name.begin(), name.end(), is_plain);
}

}  // namespace

Files files_in(std::string_view bytes) {
  Files files;
  while (bytes.starts_with(kBefore)) {
    bytes.remove_prefix(kBefore.size());
    const std::size_t name_end = bytes.find(kBehind);
    if (name_end == bytes.npos) break;
    const std::string_view name = bytes.substr(0, name_end);
    bytes.remove_prefix(name_end + kBehind.size());
    const std::size_t end = std::min(bytes.find(kBefore), bytes.size());
    if (is_name(name)) files[std::string(name)] = bytes.substr(0, end);
    bytes.remove_prefix(end);
  }
  return files;
}

void Folder::hold(const Files& files) {
  for (const auto& entry : std::filesystem::directory_iterator(path())) std::filesystem::remove(entry);
  for (const auto& [name, content] : files) folder_.file(name, content);
}

}  // namespace mapjoin::fuzz
