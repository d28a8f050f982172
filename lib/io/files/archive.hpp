// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files of a folder, or of a tar archive, one at a time.

#include <filesystem>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Whether the content of a file begins as that of a ustar (POSIX or GNU) archive does.
bool is_tar_archive(std::string_view bytes);

/// Which files are wanted, by their name without folders.
using WantFile = std::function<bool(const std::string& name)>;
/// Takes a file's full name, for messages, and its content, which lives as long as the call. An error ends the visit.
using VisitFile = std::function<Expected<void>(const std::filesystem::path& path, std::string_view bytes)>;

/// Visits the wanted files directly inside a folder, in the order of their names and inflated where they are gzipped, or
/// anywhere inside a tar archive, which may itself be gzipped, in its order. The first error is returned.
Expected<void> visit_files(const std::filesystem::path& folder_or_archive, const WantFile& want, const VisitFile& visit);

}  // namespace mapjoin
