// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The types of a typed test suite: the plane and space. In a test the dimension is TypeParam::value.

#include <gtest/gtest.h>

#include <type_traits>

namespace mapjoin::testing {

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;

}  // namespace mapjoin::testing
