// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/advice.hpp"

#include <gtest/gtest.h>

#include "volute/base/packed_error.hpp"

namespace volute {
namespace {

/// An interface that has all settings but "absent".
std::string named(const std::string& setting, const std::string& value) {
  if (setting == "absent")
    return "";
  return value.empty() ? "<" + setting + ">" : "<" + setting + " " + value + ">";
}

TEST(Advice, NamesOnlyWhatTheInterfaceHas) {
  EXPECT_EQ(
      adviceText({Hint::set("bounds"), Hint::raise("absent"), Hint::raise("max_memory")}, named),
      "give <bounds>, or raise <max_memory>");
  EXPECT_EQ(adviceText({Hint::set("renderer", "cpu")}, named), "use <renderer cpu>");
  EXPECT_EQ(adviceText({Hint::set("partial").so("shows the rest")}, named),
            "<partial> shows the rest");
  EXPECT_EQ(adviceText({Hint::choose("field"), Hint::leaveOut("up"), Hint::lower("size")}, named),
            "choose one with <field>, or leave out <up>, or lower <size>");
  EXPECT_EQ(adviceText({{Hint::Change::kRaise, "max_memory", "3G"}}, named),
            "raise <max_memory> to 3G");
  EXPECT_EQ(adviceText({Hint::set("absent")}, named), "");
}

TEST(Advice, MembersOfAScene) {
  EXPECT_EQ(
      adviceText({Hint::set("/media/0/up", "y").so("turns y upwards"),
                  Hint::set("/media/0/factor", "2"), Hint::choose("/media/0/field")},
                 named),
      "\"up\": \"y\" in /media/0 turns y upwards, or use \"factor\": 2 in /media/0, or choose "
      "one with \"field\" in /media/0");
}

TEST(Advice, AnErrorBeginsWithTheSettingUnlessItIsOfAFile) {
  Error error = failFor("slice", ErrorCode::kInvalidArgument, Hint::leaveOut("slice"),
                        "'{}' is not a plane", "w")
                    .value();
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(fullText(error, named), "<slice>: 'w' is not a plane; leave out <slice>");
  error.member = "absent";
  EXPECT_EQ(fullText(error, named), "absent: 'w' is not a plane; leave out <slice>");
  error.path = "s.json", error.member = "/media/0";
  EXPECT_EQ(fullText(error, named), "'w' is not a plane; leave out <slice>");
}

TEST(Error, ToldApartIsWhatIsWrongAndWhere) {
  const Error error =
      failIn("s.json", "/media/0", ErrorCode::kNotFound, "expected {}", "a kind").value();
  EXPECT_EQ(error.message, "s.json: /media/0: expected a kind");
  EXPECT_EQ(error.path, "s.json");
  EXPECT_EQ(error.member, "/media/0");
  EXPECT_EQ(error.statement, "expected a kind");
  EXPECT_EQ(failIn("a.vdb", "", ErrorCode::kIo, "gone").value().message, "a.vdb: gone");
  const Error other = unpacked(error.code, packed(error));
  EXPECT_EQ(other.message, error.message);
  EXPECT_EQ(other.member, error.member);
  EXPECT_EQ(other.statement, error.statement);
}

TEST(Advice, OfFileKeepsWhatIsKnown) {
  const Result<int> plain = fail(ErrorCode::kIo, "no");
  EXPECT_EQ(ofFile(plain, "a.json", "/media/1").error().path, "a.json");
  EXPECT_EQ(ofFile(plain, "a.json", "/media/1").error().member, "/media/1");
  const Result<int> ofSetting = failFor("field", ErrorCode::kIo, "no");
  EXPECT_EQ(ofFile(ofSetting, "a.json").error().path, "");
  EXPECT_EQ(*ofFile(Result<int>(3), "a.json"), 3);
}

}  // namespace
}  // namespace volute
