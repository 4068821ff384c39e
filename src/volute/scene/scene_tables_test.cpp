// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/scene/scene.hpp"

namespace volute {
namespace {

using testing::HasSubstr;

/// All tables, and those of objects in objects.
std::vector<const FieldTable*> allTables() {
  std::vector<const FieldTable*> tables{&cameraFields(), &lookFields()};
  for (const SceneList& list : sceneLists())
    tables.insert(tables.end(), list.tables.begin(), list.tables.end());
  for (std::size_t i = 0; i < tables.size(); ++i) {
    for (const FieldRow& field : tables[i]->fields) {
      if (field.table && std::ranges::find(tables, field.table) == tables.end())
        tables.push_back(field.table);
    }
  }
  return tables;
}

/// The value that a struct has by itself is one that its row allows: what would be read back.
TEST(SceneTables, DefaultsAreWithinTheirRanges) {
  int checked = 0;
  for (const FieldTable* table : allTables()) {
    for (const FieldRow& field : table->fields) {
      SCOPED_TRACE(std::string(table->name) + "/" + std::string(field.name));
      EXPECT_FALSE(field.help.empty());
      const FieldValue usual = usualValue(*table, field);
      if (!usual.is_number())
        continue;
      EXPECT_TRUE(field.holds(usual.get<double>())) << usual;
      ++checked;
    }
  }
  EXPECT_GT(checked, 20);
}

/// A slider leads nowhere that the reader refuses.
TEST(SceneTables, SlidersStayWithinTheReadersRanges) {
  int checked = 0;
  for (const FieldTable* table : allTables()) {
    for (const FieldRow& field : table->fields) {
      const FieldSlider& slider = field.slider;
      if (slider.label.empty() ||
          (field.type != FieldType::kNumber && field.type != FieldType::kInteger &&
           field.type != FieldType::kNumbers))
        continue;
      SCOPED_TRACE(std::string(table->name) + "/" + std::string(field.name));
      const double least = std::isfinite(slider.least) ? slider.least : field.least;
      const double most = std::isfinite(slider.most) ? slider.most : field.most;
      EXPECT_GE(least, field.least);
      EXPECT_LE(most, field.most);
      ++checked;
    }
  }
  EXPECT_GT(checked, 15);
}

TEST(SceneTables, MembersOfTheOtherKindOfSmokeAreRefused) {
  const auto message = [](const char* medium) -> std::string {
    Progress quiet;
    const auto json = nlohmann::ordered_json::parse(
        fmt::format(R"({{"format": "volute-scene-1", "media": [{}]}})", medium));
    const auto scene = Scene::make(json, "scene.json", {}, quiet);
    return scene ? "no error" : scene.error().message;
  };
  EXPECT_EQ(
      message(R"({"kind": "smoke", "case": "a.pvd", "quantity": "extinction", "fire": false})"),
      "scene.json: /media/0/fire: is for FDS cases, and this is smoke on a mesh");
  EXPECT_THAT(
      message(R"({"kind": "smoke", "case": "a.smv", "quantity": "extinction"})"),
      HasSubstr("scene.json: /media/0/quantity: is for smoke on meshes, and this is an FDS case"));
  EXPECT_THAT(message(R"({"kind": "smoke", "case": "a.smv", "walls": true})"),
              HasSubstr("/media/0/walls"));
  const std::string deep = std::string(1000000, 'x') + ".smv";
  EXPECT_THAT(
      message(fmt::format(R"({{"kind": "smoke", "case": "{}", "walls": true}})", deep).c_str()),
      HasSubstr("and this is an FDS case"));
}

}  // namespace
}  // namespace volute
