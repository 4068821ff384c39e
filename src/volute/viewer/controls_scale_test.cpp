// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Panels on displays that want larger letters, in both languages, and without a mouse.
#include <nlohmann/json.hpp>

#include "volute/scene/scene_tables.hpp"
#include "volute/viewer/commands.hpp"
#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/strings_german.hpp"

namespace volute {
namespace {

class ScaleControls : public Controls {
 protected:
  void show(int width, int height, double scale) {
    ViewerInput& input = script_->input();
    input.width = width, input.height = height, input.scale = scale;
    input.columns = static_cast<int>(width * scale), input.rows = static_cast<int>(height * scale);
    script_->frames(6);  // panels find their places
  }

  void expectWhole(const std::string& what) {
    EXPECT_FALSE(app().window().controls().empty());
    for (const auto& [name, at] : app().window().controls()) {
      EXPECT_FALSE(at.cut) << name << " is cut off, " << what;
      EXPECT_GE(at.left, 0) << name << ", " << what;
      EXPECT_LE(at.right, script_->input().width) << name << ", " << what;
      EXPECT_LE(at.bottom, script_->input().height + 1) << name << ", " << what;
    }
  }
};

TEST_F(ScaleControls, NothingIsCutOffAtAnyScaleInAnyLanguage) {
  struct Display {
    int width, height;
    double scale;
  };

  std::vector<Display> all;
  for (const double scale : {1.0, 1.5, 2.0, 3.0}) {
    all.push_back({950, 570, scale}), all.push_back({660, 1060, scale});
    if (scale < 3)  // else larger than any display
      all.push_back({1280, 800, scale});
  }
  for (const Language language : {Language::kEnglish, Language::kGerman}) {
    app().language().choose(language);
    for (const char* file : {"smoke.json", "fog.json", "blob.npy", "room.smv", "smoke.vtu"}) {
      open(file);
      const bool each = file == std::string("smoke.json");
      for (const auto& [width, height, scale] : all) {
        if (!each && scale != 1 && scale != 2)
          continue;  // letters alone are as they were
        const std::string what = fmt::format("{}, {} x {} points, scale {}, language {}", file,
                                             width, height, scale, static_cast<int>(language));
        show(width, height, scale);
        const Image shown = viewer_->picture();
        EXPECT_EQ(shown.width, static_cast<int>(width * scale));
        EXPECT_EQ(shown.height, static_cast<int>(height * scale));
        expectWhole(what);
        if (script_->has("More")) {
          ASSERT_NO_FATAL_FAILURE(openMore());
        }
        expectWhole(what + ", with all of the time");
        script_->press(Key::kF1);
        script_->frames(3);
        EXPECT_TRUE(script_->has("help"));
        EXPECT_FALSE(script_->has("help is cut")) << what;
        script_->press(Key::kF1);
        script_->frames(2);
      }
    }
  }
  for (const ViewerCommand& command : viewerCommands()) app().language().of(command.name);
  for (const SceneList& list : sceneLists()) {
    for (const FieldTable* table : list.tables) {
      app().language().of(table->kind.empty() ? table->name : table->kind, false);
      for (const FieldRow& field : table->fields) {
        const std::string label(field.slider.label);
        const std::size_t bar = std::min(label.find('|'), label.size());
        app().language().of(label.substr(0, bar), true);
        app().language().of(bar < label.size() ? label.substr(bar + 1) : "", true);
        app().language().of(std::string(field.slider.section), true);
      }
    }
  }
  EXPECT_EQ(app().language().missing(), std::set<std::string>()) << "no German for these";
}

TEST_F(ScaleControls, AClickHitsWhatIsThere) {
  open("smoke.json");
  show(950, 570, 2);
  const double before = app().settings().look.stops;
  ASSERT_TRUE(script_->click("exposure", 0.1));
  EXPECT_NE(app().settings().look.stops, before);
}

/// What is between braces or after a percent sign, in order.
std::vector<std::string> placesIn(std::string_view text) {
  std::vector<std::string> places;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{')
      places.emplace_back(text.substr(i, text.find('}', i) - i));
    else if (text[i] == '%' && i + 1 < text.size() && text[i + 1] != '{' && text[i + 1] != ' ')
      places.emplace_back(text.substr(i, text.find_first_of("dfgs", i) - i + 1));
  }
  return places;
}

TEST(GermanStrings, AreThereOnceAndTakeTheSameValues) {
  std::set<std::string_view> all;
  for (const auto& [english, german] : kGermanStrings) {
    EXPECT_TRUE(all.insert(english).second) << english << " is there twice";
    EXPECT_FALSE(std::string_view(german).empty()) << english;
    EXPECT_EQ(placesIn(english), placesIn(german)) << english;
  }
}

TEST_F(ScaleControls, TheLanguageIsChosenByItsNameAndKept) {
  const ViewerOptions options{.recent = folder_.path("state/recent")};
  ASSERT_NO_FATAL_FAILURE(restart(options));
  open("blob.npy");
  const Image english = shownAt("exposure", 300, 18);
  script_->press(Key::kF3);
  script_->frames(2);
  ASSERT_TRUE(script_->click("search"));
  script_->type("german");
  script_->press(Key::kEnter);
  script_->frames(3);
  EXPECT_EQ(app().language().language(), Language::kGerman);
  EXPECT_GT(difference(english, shownAt("exposure", 300, 18)), 0.2);
  ASSERT_NO_FATAL_FAILURE(restart(options));
  EXPECT_EQ(app().language().language(), Language::kGerman);
}

/// By Tab, which also opens panels that are closed.
TEST_F(ScaleControls, EveryControlIsReachedByKeys) {
  open("smoke.json");
  for (const auto& [width, height] : {std::pair(1280, 1500), {950, 570}}) {
    SCOPED_TRACE(width);
    show(width, height, 1);
    std::set<std::string> reached, there;
    // All panels in turn, also those that are closed.
    for (int i = 0; i < 300; ++i) {
      script_->press(Key::kTab);
      script_->frames(2);
      for (const auto& [name, at] : app().window().controls()) there.insert(name);
      reached.insert(app().window().focused());
    }
    for (const char* no :
         {"times", "who draws", "stop drawing", "Volute", "Scene", "Undo change", "Redo change"})
      there.erase(no);
    std::erase_if(there, [](const std::string& name) { return name.starts_with("axis "); });
    for (const std::string& name : there)
      EXPECT_TRUE(reached.contains(name)) << name << " is not reached by keys";
    script_->press(Key::kEscape);
    script_->frames(2);
    EXPECT_FALSE(app().settings().keyboard);
  }
  // A slider is moved, and the timeline is not.
  show(1280, 1500, 1);
  const double time = app().playback().timeline().time(), stops = app().settings().look.stops;
  for (int i = 0; i < 200 && app().window().focused() != "exposure"; ++i) {
    script_->press(Key::kTab);
    script_->frames(2);
  }
  ASSERT_EQ(app().window().focused(), "exposure");
  script_->press(Key::kSpace);
  script_->frames(2);
  script_->press(Key::kRight);
  script_->frames(2);
  EXPECT_NE(app().settings().look.stops, stops);
  EXPECT_EQ(app().playback().timeline().time(), time);
  EXPECT_FALSE(app().playback().timeline().playing());
}

}  // namespace
}  // namespace volute
