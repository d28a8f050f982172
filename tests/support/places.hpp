// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Paths that the tests need, as the build knows them. One generated source defines them, so that no other one depends on them.

#include <filesystem>
#include <string>

namespace mapjoin::testing {

namespace places {
extern const char* const command;
extern const char* const bundled_data;
extern const char* const documents;
extern const char* const test_sources;
extern const char* const manual;
extern const char* const examples;
}  // namespace places

/// The command under test.
inline const std::string kCommand = places::command;
/// The folder of the logs that come with the project.
inline const std::filesystem::path kBundledData = places::bundled_data;
/// The folder docs.
inline const std::filesystem::path kDocuments = places::documents;
/// The folder tests.
inline const std::filesystem::path kTestSources = places::test_sources;
/// The folder that man pages, completion and docs/commands were written to.
inline const std::filesystem::path kManual = places::manual;
/// The folder of the programs of docs/library.md.
inline const std::filesystem::path kExamples = places::examples;

}  // namespace mapjoin::testing
