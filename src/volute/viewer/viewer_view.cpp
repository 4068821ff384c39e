// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "volute/image/picture_style.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/color_view.hpp"

namespace volute {

void ViewerView::forget() {
  begun_ = false;
  cameraPath_.forget();
  exposure_ = {exposure_.value};
  settings_.look.exposure.reset();
}

bool ViewerView::begin(int width, int height) {
  if (std::exchange(begun_, true))
    return false;
  camera_.setMode(ViewCamera::Mode::kOrbit);
  reset(width, height);
  const auto& look = document_.info()->look;
  if (!look)
    return true;
  settings_.look = *look;
  if (look->exposure)
    exposure_ = {*look->exposure, true};
  camera_.setMode(look->walks ? ViewCamera::Mode::kWalk : ViewCamera::Mode::kOrbit);
  return true;
}

void ViewerView::reset(int width, int height) {
  const DocumentInfo* document = document_.info();
  if (!document)
    return;
  const auto& start = document->startView;
  if (!start) {
    whole(width, height);
    return;
  }
  camera_.set(*start);
  if (start->moves)
    camera_.fit(document->content, width, height, insets(width));
  if (start->walks)
    camera_.setMode(ViewCamera::Mode::kWalk);
}

void ViewerView::whole(int width, int height) {
  if (!document_.info())
    return;
  camera_.setMode(ViewCamera::Mode::kOrbit);
  camera_.frame(document_.info()->content, width, height, insets(width));
}

void ViewerView::lookFrom(const Vec3& side) {
  camera_.setMode(ViewCamera::Mode::kOrbit);
  camera_.lookAlong(-side);
}

ViewCamera::Insets ViewerView::insets(int width) const {
  ViewCamera::Insets insets;
  if (!settings_.panels)
    return insets;
  const PanelLayout& layout = settings_.layout;
  const auto taken = [](float panel) {
    return static_cast<double>(kPanelMargin + panel + kPanelGap);
  };
  if (layout.isOpen(SidePanel::kPicture) || layout.isOpen(SidePanel::kPaint))
    insets.left = taken(layout.width(SidePanel::kPicture));
  const DocumentInfo* document = document_.info();
  if (layout.isOpen(SidePanel::kScene) && document && !document->parameters.empty())
    insets.right = taken(layout.width(SidePanel::kScene));
  constexpr double kFree = 0.35;
  if (width - insets.left - insets.right < kFree * width)
    insets.left = insets.right = 0;  // a panel over the picture, for a while
  constexpr double kTimePanel = 84;  // two rows, about; it may not have been drawn yet
  if (playback_.timeline().moves())
    insets.bottom = kTimePanel;
  return insets;
}

ViewLook ViewerView::look() const {
  ViewLook look = settings_.look;
  look.speed = playback_.timeline().speed();
  look.walks = camera_.mode() == ViewCamera::Mode::kWalk;
  look.time = playback_.timeline().time();
  look.loop.reset();
  if (playback_.timeline().loopsPart())
    look.loop = {playback_.timeline().loopBegin(), playback_.timeline().loopEnd()};
  if (exposure_.found)
    look.exposure = exposure_.value;
  return look;
}

const Result<const ViewTransform*>& ViewerView::colorView(int tone) const {
  auto& view = colorViews_[tone == 4 ? 0 : 1];
  if (!view)
    view = openColorView(tone == 4 ? "aces" : "ocio");
  return *view;
}

std::string ViewerView::toneError() const {
  const int tone = settings_.look.tone;
  return tone > 3 && !colorView(tone) ? colorView(tone).error().message : "";
}

DisplayLook ViewerView::display() const {
  DisplayLook look;
  look.exposure = exposure_.value * std::exp2(settings_.look.stops);
  const DocumentInfo* document = document_.info();
  if (!document)
    return look;
  look.tone = !document->measured ? ToneCurve::kFilmic
              : document->burns   ? ToneCurve::kShoulder
                                  : ToneCurve::kNone;
  constexpr ToneCurve kCurves[] = {ToneCurve::kNone, ToneCurve::kFilmic, ToneCurve::kShoulder};
  const int tone = settings_.look.tone;
  if (tone > 0 && tone <= 3)
    look.tone = kCurves[tone - 1];
  if (tone > 3 && colorView(tone))
    look.tone = ToneCurve::kFilmic, look.view = *colorView(tone);
  look.background = document->background;
  if (document->grey && settings_.look.colors > 0)
    look.map = settings_.look.colors == 1 ? ColorMap::kViridis : ColorMap::kInferno;
  return look;
}

Rgb ViewerView::backgroundShown() const {
  const DisplayLook look = display();
  const Rgb light = look.exposure * look.background;
  if (look.view) {
    std::array<float, 3> values{float(light[0]), float(light[1]), float(light[2])};
    look.view->apply(values);
    return {values[0], values[1], values[2]};
  }
  const Rgb toned = toneMapped(look.tone, light);
  return toned.unaryExpr([](double v) { return srgbEncode(std::clamp(v, 0.0, 1.0)); });
}

void ViewerView::lookForSomething(const DocumentInfo& document) {
  const int version = picture_.state().version;
  if (looked_ == version)
    return;
  looked_ = version;
  const ViewScene* scene = picture_.scene();
  const Image light = picture_.sampledLight(document.background);
  constexpr double kSeen = 1.0 / 512;  // of white: half a level of a display
  Rgb low = Rgb::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < light.pixels.size(); ++i) {
    const auto c = i % 3;
    low[c] = std::min<double>(low[c], light.pixels[i]);
    high[c] = std::max<double>(high[c], light.pixels[i]);
  }
  blank_ = scene && scene->quads.empty() && scene->lines.empty() &&
           display().exposure * (high - low).maxCoeff() < kSeen;
}

void ViewerView::draw(const PictureRequest& request) {
  document_.loader().setOpenGl(picture_.mayUseGl(request.renderer));
  if (const Status drawn = picture_.update(request); !drawn)
    document_.refuseScene(drawn.error());
  // At once, and better once the picture is fine.
  const DocumentInfo* document = document_.info();
  const LoadedScene* scene = document_.scene();
  if (!document || !scene)
    return;
  const bool fine = !scene->coarse && picture_.settled(request);
  if (exposure_.found) {
    if (fine && !request.moving && picture_.shown())
      lookForSomething(*document);
    return;
  }
  const bool first = !exposure_.tried && picture_.shown() && !picture_.state().stale;
  if (!first && !fine)
    return;
  exposure_.value =
      document->measured
          ? 1
          : suggestExposure({picture_.sampledLight(document->background)}, ToneCurve::kFilmic);
  exposure_.tried = true;
  exposure_.found = fine;
}

}  // namespace volute
