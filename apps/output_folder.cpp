// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <apps/output_folder.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <system_error>
#include <utility>

namespace mapjoin::apps {
namespace fs = std::filesystem;
namespace {

constexpr const char* kAside = ".mapjoin-tmp";
constexpr const char* kLock = ".lock";
constexpr int kMostTries = 100;

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

/// Makes a folder, and those on the way to it. A link is none: what is in there may be somebody's.
Expected<void> make_folder(const fs::path& folder, const fs::path& output) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (!failure && !fs::is_directory(fs::symlink_status(folder, failure))) {
    failure = std::make_error_code(std::errc::not_a_directory);
  }
  if (failure) return cannot_write(output, failure);
  return {};
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

Expected<OutputFolder> OutputFolder::create(const fs::path& path) {
  OutputFolder folder(path, path / kAside, false);
  if (auto begun = folder.begin(); !begun) return tl::unexpected(begun.error());
  return folder;
}

Expected<OutputFolder> OutputFolder::create_whole(const fs::path& path) {
  const fs::path named = path.has_filename() ? path : path.parent_path();
  std::error_code ignored;
  if (fs::exists(named, ignored) && !fs::is_directory(named, ignored)) {
    return cannot_write(path, std::make_error_code(std::errc::not_a_directory));
  }
  if (fs::exists(named, ignored) && !fs::is_empty(named, ignored)) {
    return cannot_write(path, std::make_error_code(std::errc::directory_not_empty));
  }
  OutputFolder folder(named, named.string() + kAside, true);
  if (auto begun = folder.begin(); !begun) return tl::unexpected(begun.error());
  return folder;
}

/// Takes the folder aside for this process, and clears it.
Expected<void> OutputFolder::begin() {
  std::error_code failure;
  for (int tries = 0; lock_ < 0; ++tries) {
    if (auto made = make_folder(aside_, path_); !made) return made;
    const auto lock = open_alone(aside_ / kLock, path_);
    // Another process may have done with it, and removed it, just now.
    if (!lock && (tries == kMostTries || fs::exists(aside_, failure))) return tl::unexpected(lock.error());
    if (lock) lock_ = *lock;
  }
  clear(aside_, failure);
  return failure ? cannot_write(path_, failure) : Expected<void>();
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : path_(std::move(other.path_)),
      aside_(std::exchange(other.aside_, {})),
      made_(std::move(other.made_)),
      is_whole_(other.is_whole_),
      lock_(std::exchange(other.lock_, -1)) {}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (lock_ >= 0 && !aside_.empty()) {
    clear(aside_, ignored);
    fs::remove(aside_ / kLock, ignored);
  }
  fs::remove(aside_, ignored);  // Not where another process has it, whose lock is in it.
  if (lock_ >= 0) ::close(lock_);
  for (const fs::path& folder : made_) fs::remove(folder, ignored);  // Not where something is in it.
}

Expected<void> OutputFolder::commit(const std::vector<std::string>& names) {
  return is_whole_ ? appear() : replace(names);
}

Expected<void> OutputFolder::replace(const std::vector<std::string>& names) const {
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

Expected<void> OutputFolder::appear() {
  std::error_code failure;
  fs::rename(aside_, path_, failure);
  if (failure) return cannot_write(path_, failure);
  aside_.clear();
  fs::remove(path_ / kLock, failure);
  return {};
}

Expected<std::optional<OutputFolder>> output_folder(const fs::path& path) {
  if (path.empty()) return std::nullopt;
  return OutputFolder::create(path).map([](OutputFolder&& folder) { return std::optional(std::move(folder)); });
}

}  // namespace mapjoin::apps
