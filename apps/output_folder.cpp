// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/output_folder.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <system_error>

namespace mapjoin::apps {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLock = ".lock";
constexpr int kMostTries = 100;

void demand_done(const fs::path& path, std::error_code failure) {
  if (failure) demand(call_failed(path, failure.value(), ErrorKind::kCannotWrite));
}
void refuse(const fs::path& path, std::errc reason) {
  demand_done(path, std::make_error_code(reason));
}

/// The folders on the path that do not exist, innermost first.
std::vector<fs::path> missing(const fs::path& path) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, ignored); folder = folder.parent_path()) {
    folders.push_back(folder);
  }
  return folders;
}

/// Makes a folder and its parents. Refuses a link, whose target may belong to the user.
void make_folder(const fs::path& folder, const fs::path& output) {
  std::error_code failure;
  std::error_code ignored;
  fs::create_directories(folder, failure);
  const fs::file_status there = fs::symlink_status(folder, ignored);
  if (fs::exists(there) && !fs::is_directory(there)) demand(in_the_way(folder, output));
  demand_done(output, failure);
}

/// Removes all but the lock.
void clear(const fs::path& aside, std::error_code& failure) {
  for (const auto& left : fs::directory_iterator(aside, failure)) {
    if (left.path().filename() != kLock) fs::remove_all(left.path(), failure);
  }
}

}  // namespace

OutputFolder::OutputFolder(fs::path path, fs::path aside, bool is_whole)
    : path_(std::move(path)), aside_(std::move(aside)), made_(missing(aside_.parent_path())), is_whole_(is_whole) {}

OutputFolder::OutputFolder(const fs::path& path) : OutputFolder(path, path / kUnfinished, false) {
  begin();
}

OutputFolder OutputFolder::whole(const fs::path& path) {
  const fs::path named = path.has_filename() ? path : path.parent_path();
  std::error_code ignored;
  if (fs::exists(named, ignored)) {
    if (!fs::is_directory(named, ignored)) refuse(path, std::errc::not_a_directory);
    if (!fs::is_empty(named, ignored)) refuse(path, std::errc::directory_not_empty);
  }
  OutputFolder folder(named, named.string() + kUnfinished, true);
  folder.begin();
  return folder;
}

/// Locks the folder `aside_` for this process, and clears it.
void OutputFolder::begin() {
  std::error_code failure;
  for (int tries = 0; !lock_.is_open(); ++tries) {
    make_folder(aside_, path_);
    take_permissions_of(path_, aside_);
    auto lock = open_alone(aside_ / kLock, path_);
    // Another process may have finished, and removed it, just now.
    if (!lock && (tries == kMostTries || fs::exists(aside_, failure))) demand(tl::unexpected(lock.error()));
    if (lock) lock_ = *std::move(lock);
  }
  clear(aside_, failure);
  demand_done(path_, failure);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (lock_.is_open() && !aside_.empty()) {
    clear(aside_, ignored);
    fs::remove(aside_ / kLock, ignored);
  }
  fs::remove(aside_, ignored);  // Fails if another process has it, whose lock is in it.
  lock_ = Descriptor();
  for (const fs::path& folder : made_) fs::remove(folder, ignored);  // Fails if something is in it.
}

void OutputFolder::commit(const std::vector<std::string>& names, const std::vector<std::string>& former) {
  is_whole_ ? appear() : replace(names, former);
}

void OutputFolder::replace(const std::vector<std::string>& names, const std::vector<std::string>& former) const {
  std::error_code failure;
  for (const std::string& name : names) {
    if (fs::is_directory(fs::symlink_status(file(name), failure))) refuse(file(name), std::errc::is_a_directory);
  }
  for (const std::string& name : former) {
    if (fs::is_directory(fs::symlink_status(file(name), failure)) || std::ranges::find(names, name) != names.end()) continue;
    fs::remove(file(name), failure);
    demand_done(file(name), failure);
  }
  for (const std::string& name : names) {
    take_permissions_of(file(name), aside(name));
    fs::rename(aside(name), file(name), failure);
    demand_done(file(name), failure);
  }
}

void OutputFolder::appear() {
  std::error_code failure;
  fs::rename(aside_, path_, failure);
  demand_done(path_, failure);
  aside_.clear();
  fs::remove(path_ / kLock, failure);
}

std::optional<OutputFolder> output_folder(const fs::path& path) {
  return path.empty() ? std::nullopt : std::optional<OutputFolder>(std::in_place, path);
}

}  // namespace mapjoin::apps
