// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/netcdf_length.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

std::string bigEndian(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
  return out;
}

struct Variable {
  bool ofRecords = false;
  int type = 6;  ///< 2 char, 3 short, 6 double
  int values = 1;
};

/// A classic file with these variables; the last one may stand without its padding.
std::string classic(int version, std::uint64_t records, const std::vector<Variable>& variables,
                    bool padLast) {
  const int wide = version == 5 ? 8 : 4, place = version == 1 ? 4 : 8;
  const auto count = [&](std::uint64_t n) { return bigEndian(n, wide); };
  const auto name = [&](const std::string& text) {
    return count(text.size()) + text + std::string((4 - text.size() % 4) % 4, '\0');
  };
  const auto bytesOf = [](const Variable& v) {
    return static_cast<std::uint64_t>(v.values) * (v.type == 2 ? 1 : v.type == 3 ? 2 : 8);
  };
  const auto padded = [](std::uint64_t n) { return (n + 3) / 4 * 4; };
  int ofRecords = 0;
  for (const Variable& v : variables) ofRecords += v.ofRecords;
  const auto step = [&](const Variable& v) {
    return ofRecords == 1 ? bytesOf(v) : padded(bytesOf(v));
  };
  // Once to learn how long the header is.
  std::string header;
  std::vector<std::uint64_t> begins(variables.size(), 0);
  std::uint64_t end = 0;
  for (int pass = 0; pass < 2; ++pass) {
    header = fmt::format("CDF{}", static_cast<char>(version)) + count(records);
    header += bigEndian(10, 4) + count(1 + variables.size()) + name("time") + count(0);
    for (std::size_t i = 0; i < variables.size(); ++i)
      header +=
          name(fmt::format("n{}", i)) + count(static_cast<std::uint64_t>(variables[i].values));
    header += bigEndian(12, 4) + count(1) + name("title") + bigEndian(2, 4) + name("a box");
    header += bigEndian(11, 4) + count(variables.size());
    for (std::size_t i = 0; i < variables.size(); ++i) {
      header += name(fmt::format("v{}", i)) + count(variables[i].ofRecords ? 2 : 1);
      if (variables[i].ofRecords)
        header += count(0);
      header += count(1 + i) + bigEndian(0, 4) + count(0);  // no attributes
      header += bigEndian(static_cast<std::uint64_t>(variables[i].type), 4);
      header += count(padded(bytesOf(variables[i]))) + bigEndian(begins[i], place);
    }
    std::uint64_t at = header.size(), record = 0, first = 0;
    end = at;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (variables[i].ofRecords)
        continue;
      begins[i] = at;
      end = at + bytesOf(variables[i]);
      at += padded(bytesOf(variables[i]));
    }
    first = at;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (!variables[i].ofRecords)
        continue;
      begins[i] = at;
      at += step(variables[i]);
      record += step(variables[i]);
    }
    if (record > 0 && records > 0) {
      end = first + records * record;
      if (!padLast)
        end -= step(variables.back()) - bytesOf(variables.back());
    } else if (padLast) {
      end = padded(end);
    }
  }
  return header + std::string(end - header.size(), 'x');
}

TEST(NetcdfLength, WholeFilesAreAccepted) {
  const TempFolder folder;
  for (const int version : {1, 2, 5}) {
    for (const bool pad : {false, true}) {
      for (const std::vector<Variable>& variables : {std::vector<Variable>{{false, 6, 5}},
                                                     {{false, 2, 5}, {true, 6, 3}},
                                                     {{true, 6, 3}, {true, 2, 7}},
                                                     {{false, 6, 2}, {true, 3, 3}},
                                                     {{false, 2, 3}}}) {
        for (const std::uint64_t records : {0, 1, 4}) {
          writeBytes(folder / "a.e", classic(version, records, variables, pad));
          const auto checked = checkNetcdfLength(folder / "a.e");
          EXPECT_TRUE(checked) << checked.error().message;
        }
      }
    }
  }
}

TEST(NetcdfLength, NoCutIsWhole) {
  const TempFolder folder;
  for (const int version : {1, 2, 5}) {
    for (const std::vector<Variable>& variables : {std::vector<Variable>{{false, 6, 5}},
                                                   {{false, 2, 5}, {true, 6, 3}},
                                                   {{true, 6, 3}, {true, 2, 7}},
                                                   {{false, 6, 2}, {true, 3, 3}}}) {
      const std::string whole = classic(version, 4, variables, false);
      for (std::size_t length = 0; length < whole.size(); ++length) {
        writeBytes(folder / "a.e", whole.substr(0, length));
        const auto checked = checkNetcdfLength(folder / "a.e");
        ASSERT_FALSE(checked) << "version " << version << ", " << length << " of " << whole.size();
        EXPECT_EQ(checked.error().code, ErrorCode::kTruncated);
      }
    }
  }
}

TEST(NetcdfLength, CountsBeyondAnyFile) {
  const TempFolder folder;
  const std::string whole = classic(5, 4, {{true, 6, 3}}, true);
  for (std::size_t byte = 4; byte + 8 < whole.size(); ++byte) {
    std::string changed = whole;
    for (std::size_t i = 0; i < 8; ++i) changed[byte + i] = '\x7F';
    writeBytes(folder / "a.e", changed);
    (void)checkNetcdfLength(folder / "a.e");  // ends, and without reading beyond
  }
  writeBytes(folder / "a.e", "hello, this is no netCDF");
  EXPECT_THAT(checkNetcdfLength(folder / "a.e").error().message, HasSubstr("expected a netCDF"));
  EXPECT_THAT(checkNetcdfLength(folder / "b.e").error().message, HasSubstr("b.e"));
}

}  // namespace
}  // namespace volute
