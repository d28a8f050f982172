// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The numbers of MAT files of version 5, for reading and for writing them.

#include <cstddef>
#include <cstdint>

namespace mapjoin::mat {

inline constexpr std::size_t kHeaderSize = 128;
inline constexpr std::size_t kTagSize = 8;  ///< Bytes of a data element's tag: its type and its number of bytes.

/// Types of data elements.
inline constexpr std::uint32_t kInt8 = 1;
inline constexpr std::uint32_t kInt32 = 5;
inline constexpr std::uint32_t kUint32 = 6;
inline constexpr std::uint32_t kDouble = 9;
inline constexpr std::uint32_t kMatrixElement = 14;
inline constexpr std::uint32_t kCompressedElement = 15;

/// Classes of matrices. Those from the first to the last hold characters or numbers; other classes, cells and structures among
/// them, hold further variables.
inline constexpr std::uint32_t kFirstMatrixClass = 4;
inline constexpr std::uint32_t kSparseClass = 5;
inline constexpr std::uint32_t kDoubleClass = 6;
inline constexpr std::uint32_t kLastMatrixClass = 15;
inline constexpr std::uint32_t kComplexFlag = 0x800;

}  // namespace mapjoin::mat
