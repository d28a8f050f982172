// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files of a folder, or of a tar archive, one at a time.

#include <filesystem>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// True if the content of a file begins as a ustar (POSIX or GNU) archive.
bool is_tar_archive(std::string_view bytes);

/// True for the files that are wanted, by their name without folders.
using WantFile = std::function<bool(const std::string& name)>;
/// Takes a file's full name, for messages, and its content, which lives as long as the call. An error ends the visit.
using VisitFile = std::function<Expected<void>(const std::filesystem::path& path, std::string_view bytes)>;

/// Visits the wanted files directly inside a folder, in the order of their names, or anywhere inside a tar archive, itself
/// gzipped or not, in its order; gzip of each is undone. The first error is returned.
Expected<void> visit_files(const std::filesystem::path& folder_or_archive, const WantFile& want, const VisitFile& visit);

}  // namespace mapjoin
