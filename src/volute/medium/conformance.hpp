// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/medium/conformance_checks.hpp"

// A new medium gets all checks by one line in its test:
//
//   VOLUTE_CONFORMANCE(Voxels, conformance::underTest(makeVoxels(), {.planes = ..., .region =
//   ...}));
//
// and links volute::medium_conformance.

namespace volute::conformance {

inline void PrintTo(const Check& check, std::ostream* stream) {
  *stream << check.name;
}

}  // namespace volute::conformance

/// One test for each check. `makeUnderTest` is an expression that gives a MediumUnderTest.
#define VOLUTE_CONFORMANCE(Name, ...)                                                         \
  class Name##Conformance : public ::testing::TestWithParam<::volute::conformance::Check> {}; \
  TEST_P(Name##Conformance, Holds) {                                                          \
    const ::volute::conformance::MediumUnderTest tested = __VA_ARGS__;                        \
    if (GetParam().linearOnly && !tested.linear)                                              \
      GTEST_SKIP() << "has no coefficients";                                                  \
    EXPECT_THAT(GetParam().run(tested), ::testing::IsEmpty());                                \
  }                                                                                           \
  INSTANTIATE_TEST_SUITE_P(Check, Name##Conformance,                                          \
                           ::testing::ValuesIn(::volute::conformance::checks()),              \
                           [](const auto& info) { return std::string(info.param.name); })
