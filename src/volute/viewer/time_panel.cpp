// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "volute/base/plain_number.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

/// Whether the film's controls stand beside the time's; else they appear when they are asked for.
bool isWide(const ViewerInput& input) {
  return input.width >= 900;
}

bool isWhole(ViewerApp& app, const ViewerInput& input) {
  return isWide(input) || app.settings().timeOpen || app.playback().film();
}

constexpr float kFilmSizes = 110;  ///< [points]

void filmPart(ViewerApp& app, const ViewerInput& input) {
  if (const FilmExport* film = app.playback().film()) {
    // Elsewhere than "Make film": a click that comes too late makes no other one.
    ImGui::BeginDisabled();
    ImGui::Button(tr("Make film"));
    ImGui::EndDisabled();
    ImGui::SameLine();
    const bool cancels = ImGui::Button(tr("Cancel film"));
    app.window().mark("Cancel film");
    if (cancels)
      return app.playback().cancelFilm();
    ImGui::SameLine();
    std::string text = fmt::format("{}: {:.0f} %", film->order().target, 100 * film->share());
    if (const auto left = film->secondsLeft())
      text += fmt::format(fmt::runtime(tr(", {:.0f} s left")), std::ceil(*left));
    ImGui::ProgressBar(static_cast<float>(film->share()), {-1, 0}, text.c_str());
    return;
  }
  if (ImGui::Button(tr("Make film")))
    app.beginFilm(input);
  app.window().mark("Make film");
  ImGui::SameLine();
  const bool leads = app.view().cameraPath().leads();
  const ImGuiStyle& style = ImGui::GetStyle();
  const float others = kFilmSizes + ImGui::GetFrameHeight() + style.ItemInnerSpacing.x +
                       ImGui::CalcTextSize(tr(leads ? "path" : "orbit")).x +
                       2 * style.ItemSpacing.x;
  ImGui::SetNextItemWidth(std::clamp(ImGui::GetContentRegionAvail().x - others, 40.0F, 150.0F));
  nameBox("##film", app.settings().filmName);
  app.window().mark("film");
  hint("a .mp4 or .webm of the loop's time range, from the current view, at this speed");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(kFilmSizes);
  static const std::string kSizes[] = {"640 x 360", "1280 x 720", "1920 x 1080", "window"};
  choiceBox(app, "##size", "film size", kSizes, app.settings().filmSize);
  ImGui::SameLine();
  if (leads) {
    ImGui::Checkbox(tr("path"), &app.settings().follows);
    app.window().mark("film path");
    hint("the camera goes along its keys, in films and while it plays: K sets one");
    return;
  }
  ImGui::Checkbox(tr("orbit"), &app.settings().filmTurns);
  app.window().mark("film around");
  hint("the camera goes once around what it looks at; for a path of your own, K sets keys");
}

void stepPart(ViewerApp& app) {
  Timeline& timeline = app.playback().timeline();
  if (markedButton(app, timeline.playing() ? "Pause###play" : "Play###play", "Play"))
    timeline.play(!timeline.playing());
  ImGui::SameLine();
  if (ImGui::Button("<"))
    timeline.step(-1);
  app.window().mark("<");
  hint("one frame back");
  ImGui::SameLine();
  if (ImGui::Button(">"))
    timeline.step(1);
  app.window().mark(">");
  hint("one frame on");
}

/// "frame 3 of 48, 25 frames/s"; while it plays slower than that, how fast. Where frames are
/// missing, what their file calls it.
std::string frameText(const Playback& playback, const DocumentInfo& info) {
  const Timeline& timeline = playback.timeline();
  const double rate = timeline.rate();
  const double mean = (timeline.frames() - 1) / (timeline.last() - timeline.first());
  const double shown = playback.shownRate() / timeline.speed();
  const auto frame = static_cast<std::size_t>(timeline.frame());
  const std::string number = frame < info.numbers.size()
                                 ? fmt::format(fmt::runtime(tr(" (no. {})")), info.numbers[frame])
                                 : "";
  const std::string whole =
      fmt::format(fmt::runtime(tr("frame {} of {}{}, ")), frame + 1, timeline.frames(), number);
  if (shown > 0 && shown < 0.9 * std::min(rate, mean) && rate < 60)
    return whole + fmt::format(fmt::runtime(tr("{:.3g} of {:.3g} /s")), shown, rate);
  return whole + fmt::format("{:.3g} /s", rate);
}

void speedPart(ViewerApp& app) {
  Timeline& timeline = app.playback().timeline();
  ImGui::SetNextItemWidth(110);
  double speed = timeline.speed();
  if (sliderDouble("##speed", speed, Timeline::kSlowest, Timeline::kFastest, "%.3g x speed", true))
    timeline.setSpeed(speed);
  app.window().mark("speed");
  hint("1/8 to 8 times the file's own rate: Up, Down");
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(frameText(app.playback(), *app.document().info()).c_str());
  hint("the file's frames a second; while it plays slower, those that are shown");
}

constexpr float kLoopWidth = 130, kNarrowLoop = 96;

/// Which part is played, shown and chosen.
void loopPart(ViewerApp& app, float width) {
  Timeline& timeline = app.playback().timeline();

  enum : int { kShown, kFromHere, kToHere, kAll };

  const std::string shown = timeline.loopsPart()
                                ? fmt::format("{} - {} s", plainNumber(timeline.loopBegin(), 4),
                                              plainNumber(timeline.loopEnd(), 4))
                                : std::string("all frames");
  const std::string choices[] = {shown, "loop from here", "loop to here", "all frames"};
  int chosen = kShown;
  ImGui::SetNextItemWidth(width);
  choiceBox(app, "##loop", "loop", std::span(choices).first(timeline.loopsPart() ? 4 : 3), chosen);
  hint("what is played and filmed; from here, to here, all: I, O, L");
  if (chosen == kFromHere)
    timeline.loopFromHere();
  else if (chosen == kToHere)
    timeline.loopToHere();
  else if (chosen == kAll)
    timeline.setLoop(0, 0);
}

/// Along the slider that was drawn last: what is decoded, the loop's range, marks.
void drawTrack(ViewerApp& app) {
  const Playback& playback = app.playback();
  const Timeline& timeline = playback.timeline();
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  const float margin = 2 + 0.5F * style.GrabMinSize;
  const auto at = [&](double time) {
    const double share = (time - timeline.first()) / (timeline.last() - timeline.first());
    return from.x + margin +
           static_cast<float>(std::clamp(share, 0.0, 1.0)) * (to.x - from.x - 2 * margin);
  };
  ImDrawList* list = ImGui::GetWindowDrawList();
  constexpr ImU32 kDecoded = IM_COL32(92, 199, 178, 230), kLoop = IM_COL32(255, 190, 70, 255);
  const double frame = (timeline.last() - timeline.first()) / (timeline.frames() - 1);
  for (const double time : app.document().loading().decoded)
    list->AddRectFilled({at(time - 0.5 * frame), to.y - 3}, {at(time + 0.5 * frame), to.y},
                        kDecoded);
  if (timeline.loopsPart()) {
    const float begin = at(timeline.loopBegin()), end = at(timeline.loopEnd());
    list->AddLine({begin, from.y + 1}, {end, from.y + 1}, kLoop, 2);
    for (const float x : {begin, end}) list->AddLine({x, from.y}, {x, to.y}, kLoop, 2);
  }
  for (const CameraKey& key : app.view().cameraPath().keys()) {
    const ImVec2 middle{at(key.time), 0.5F * (from.y + to.y)};
    list->AddNgonFilled(middle, 5, IM_COL32(120, 190, 255, 255), 4);
    list->AddNgon(middle, 6, IM_COL32(12, 14, 18, 255), 4);
  }
  for (const double mark : playback.marks()) {
    const float x = at(mark);
    list->AddTriangleFilled({x - 5, from.y}, {x + 5, from.y}, {x, from.y + 7}, kLoop);
  }
}

void timeSlider(ViewerApp& app, float width) {
  Timeline& timeline = app.playback().timeline();
  double time = timeline.time();
  ImGui::SetNextItemWidth(width);
  if (sliderDouble("##time", time, timeline.first(), timeline.last(), "%.2f s"))
    timeline.seek(time);
  app.window().mark("time");
  hint(
      "below: what is decoded; I and O: the loop's range, L: all; B: a mark, Ctrl Left and Right; "
      "K: a key of the camera");
  drawTrack(app);
}

}  // namespace

float timePanelHeight(ViewerApp& app, const ViewerInput& input) {
  if (!app.playback().timeline().moves())
    return 0;
  const int rows = isWide(input) ? 2 : isWhole(app, input) ? 3 : 1;
  const ImGuiStyle& style = ImGui::GetStyle();
  return static_cast<float>(rows) * (ImGui::GetFrameHeight() + style.ItemSpacing.y) -
         style.ItemSpacing.y + 2 * style.WindowPadding.y;
}

void drawTimePanel(ViewerApp& app, const ViewerInput& input) {
  Timeline& timeline = app.playback().timeline();
  if (!timeline.moves())
    return;
  const float height = timePanelHeight(app, input);
  ImGui::SetNextWindowPos({kPanelMargin, static_cast<float>(input.height) - height - kPanelMargin});
  ImGui::SetNextWindowSize({static_cast<float>(input.width) - 2 * kPanelMargin, height});
  app.settings().timeHeight = height;
  ImGui::Begin("###Time", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoFocusOnAppearing);
  const bool wide = isWide(input), whole = isWhole(app, input);
  stepPart(app);
  if (!wide) {
    ImGui::SameLine();
    const float word =
        std::max(ImGui::CalcTextSize(tr("More")).x, ImGui::CalcTextSize(tr("Less")).x);
    const float more = word + 2 * ImGui::GetStyle().FramePadding.x;
    timeSlider(app, -more - ImGui::GetStyle().ItemSpacing.x);
    ImGui::SameLine();
    if (markedButton(app, whole ? "Less###more" : "More###more", "More"))
      app.settings().timeOpen = !whole;
    hint("speed, and films");
  }
  if (whole) {
    if (wide)
      ImGui::SameLine();
    speedPart(app);
    if (!wide) {
      ImGui::SameLine();
      loopPart(app, kNarrowLoop);
    } else {
      ImGui::SameLine(0, 30);
    }
    filmPart(app, input);
  }
  if (wide) {
    timeSlider(app, -kLoopWidth - ImGui::GetStyle().ItemSpacing.x);
    ImGui::SameLine();
    loopPart(app, kLoopWidth);
  }
  ImGui::End();
}

}  // namespace volute
