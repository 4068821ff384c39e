// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

TEST(Report, SaysTheSameToPeopleAndPrograms) {
  Report report;
  report.add("relative_rms", 0.003).add("output", "a.volute").add("complete", true, "");
  EXPECT_EQ(report.text(), "relative rms  0.003\noutput        a.volute\n");
  EXPECT_EQ(report.json().dump(), R"({"relative_rms":0.003,"output":"a.volute","complete":true})");
}

TEST(Report, WhatJsonCannotSayIsNullOrReplaced) {
  Report report;
  report.add("psnr", INFINITY).add("name", "\xff.npy");
  EXPECT_EQ(nlohmann::json::parse(dumpJson(report.json()))["psnr"], nullptr);
}

TEST(Report, BytesAreReadable) {
  EXPECT_EQ(bytesText(0), "0 bytes");
  EXPECT_EQ(bytesText(9999), "9999 bytes");
  EXPECT_EQ(bytesText(67108864), "67.1 MB");
  EXPECT_EQ(bytesText(999600), "1 MB");
  EXPECT_EQ(bytesText(UINT64_MAX), "18.4 EB");
}

}  // namespace
}  // namespace volute
