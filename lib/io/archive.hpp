// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files of a folder, or of a tar archive, one at a time.

#include <filesystem>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin {

/// Whether the file, inflated where it is gzipped, begins as a ustar (POSIX or GNU) archive does. False where it cannot be
/// read.
bool is_tar_archive(const std::filesystem::path& path);

/// The whole file, inflated where it is gzipped; at most 4 GiB.
Expected<std::string> read_whole_file(const std::filesystem::path& path);

/// Which files are wanted, by their name without folders.
using WantFile = std::function<bool(const std::string& name)>;
/// Takes the file's full name, for messages, and its content. An error ends the visit.
using VisitFile = std::function<Expected<void>(const std::filesystem::path& path, std::string&& bytes)>;

/// Visits the wanted files directly inside a folder, in the order of their names and inflated where they are gzipped, or
/// anywhere inside a tar archive, which may itself be gzipped, in its order. The first error is returned.
Expected<void> visit_files(const std::filesystem::path& folder_or_archive, const WantFile& want, const VisitFile& visit);

}  // namespace mapjoin
