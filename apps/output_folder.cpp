// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <apps/output_folder.hpp>
#include <mapjoin/io/system_call.hpp>
#include <system_error>
#include <utility>

namespace mapjoin::apps {
namespace fs = std::filesystem;
namespace {

tl::unexpected<Error> cannot_write(const fs::path& path, const std::error_code& reason) {
  return call_failed(path, reason.value(), ErrorKind::kCannotWrite);
}

/// The folders on the way to `path` that are not there, innermost first.
std::vector<fs::path> missing(const fs::path& path) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, ignored); folder = folder.parent_path()) {
    folders.push_back(folder);
  }
  return folders;
}

}  // namespace

Expected<OutputFolder> OutputFolder::create(const fs::path& path) {
  OutputFolder folder;
  folder.path_ = path;
  folder.made_ = missing(path);
  folder.aside_ = path / fmt::format(".mapjoin-{}", ::getpid());
  std::error_code failure;
  fs::create_directories(path, failure);
  if (!failure && !fs::is_directory(path)) failure = std::make_error_code(std::errc::not_a_directory);
  if (!failure) fs::create_directory(folder.aside_, failure);
  if (failure) return cannot_write(path, failure);
  return folder;
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : path_(std::move(other.path_)), aside_(std::exchange(other.aside_, {})), made_(std::move(other.made_)) {}

OutputFolder::~OutputFolder() {
  if (aside_.empty()) return;
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
  for (const fs::path& folder : made_) fs::remove(folder, ignored);  // Not where something is in it.
}

Expected<void> OutputFolder::commit(const std::vector<std::string>& names) {
  std::error_code failure;
  for (const std::string& name : names) {
    if (!fs::is_directory(fs::symlink_status(file(name), failure))) continue;
    return cannot_write(file(name), std::make_error_code(std::errc::is_a_directory));
  }
  for (const std::string& name : names) {
    fs::rename(aside(name), file(name), failure);
    if (failure) return cannot_write(file(name), failure);
  }
  return {};
}

Expected<std::optional<OutputFolder>> output_folder(const fs::path& path) {
  if (path.empty()) return std::nullopt;
  return OutputFolder::create(path).map([](OutputFolder&& folder) { return std::optional(std::move(folder)); });
}

}  // namespace mapjoin::apps
