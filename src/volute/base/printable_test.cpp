// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/printable.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

TEST(Printable, KeepsWhatPeopleWrite) {
  const std::string text = "fen\xC3\xAAtre \xE7\x85\x99 \xF0\x9F\x94\xA5 'a/b' 100 %\tx\ny\n";
  EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatWouldSteerATerminal) {
  EXPECT_EQ(printable("\x1b[2Jred\x07"), "\\u001b[2Jred\\u0007");
  EXPECT_EQ(printable("a\rb\x7f"), "a\\u000db\\u007f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\u009b31m");
  EXPECT_EQ(printable("\xE2\x80\xAE"
                      "gnp"),
            "\\u202egnp");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\u0000b");
}

TEST(Printable, ShowsBytesThatAreNoText) {
  for (const char* bytes :
       {"\x80", "\xC0\xAF", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xE2\x80", "\x9B"}) {
    for (const char c : printable(bytes)) EXPECT_LT(static_cast<unsigned char>(c), 0x7F) << bytes;
  }
}

TEST(Printable, ANameBeginsNoMessage) {
  EXPECT_EQ(printableMessage("field 'a\nvolute: done'"), "field 'a\n    volute: done'");
  EXPECT_EQ(printableMessage("two\nlines\n"), "two\n    lines\n");
}

TEST(Printable, JsonStaysJson) {
  EXPECT_EQ(printable("{\"a\": \"\xC2\x9B\x7F\"}\n"), "{\"a\": \"\\u009b\\u007f\"}\n");
}

TEST(AsUtf8, TextThatIsNoneIsLatin1) {
  EXPECT_EQ(asUtf8("T\xFCr 3"), "Tür 3");
  EXPECT_EQ(asUtf8("Tür 3"), "Tür 3");
  EXPECT_EQ(asUtf8("\xC3"), "Ã");
  EXPECT_EQ(asUtf8(""), "");
}

}  // namespace
}  // namespace volute
