// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/viewer/fog_plan.hpp"
#include "volute/viewer/medium_probe.hpp"
#include "volute/viewer/paint_tool.hpp"
#include "volute/viewer/pick_wall.hpp"
#include "volute/viewer/viewer_view.hpp"

namespace volute {

/// Painting on the maps of fog of the document, one of which is in hand.
class FogPainting {
 public:
  FogPainting(ViewerSettings& settings, ViewerDocument& document)
      : settings_(settings), document_(document) {}

  PaintTool& tool() { return maps_[chosen_].tool; }

  const PaintTool& tool() const { return maps_[chosen_].tool; }

  /// What the document's maps are called; none or one: there is nothing to choose.
  std::vector<std::string> names() const;

  /// Which of them is in hand.
  std::size_t chosen() const { return chosen_; }

  void choose(std::size_t map);

  /// The document has changed. `another`: its files give the maps' names.
  void take(const DocumentInfo& info, bool another);

  void drop();

  /// Whether fog was painted that no file has.
  bool unsaved() const;

  /// Takes such a map in hand, the first but for so many; false: there is none.
  bool chooseUnsaved(std::size_t passed);

  /// Hands what was painted to the document.
  void send() { send(chosen_); }

  void save();

  /// What was not saved by now cannot be.
  void endSaving();

  void undo();
  void redo();

  /// The map from above, in colours, as a texture: row 0 at the largest y.
  GLuint plan();

 private:
  struct Map {
    PaintTool tool{};
    std::string target{};  ///< where it would be saved, while another is in hand
    std::optional<std::size_t> savedVersion{};  ///< what is on its way to a file

    bool unsaved() const { return tool.has() && tool.painter().changed(); }
  };

  void send(std::size_t map);

  ViewerSettings& settings_;
  ViewerDocument& document_;
  std::vector<Map> maps_ =
      std::vector<Map>(1);     ///< of the document, in its order; without any, one of none
  std::vector<Map> others_{};  ///< whose fog was removed, and may come back
  std::size_t chosen_ = 0;
  FogPlan plan_;
};

/// What a pointer is over, and what it puts there.
class PointerTools {
 public:
  PointerTools(ViewerView& view, ViewerDocument& document) : view_(view), document_(document) {}

  /// Size of the window in this frame [points].
  void setSize(int width, int height) { width_ = width, height_ = height; }

  /// What the media are under it; nothing where its ray meets none, and no surface.
  std::optional<MediumProbe::Reading> probeAt(double x, double y) {
    return probeIn(document_, probe_, x, y);
  }

  /// The same of what another file shows there.
  std::optional<MediumProbe::Reading> probeOther(ViewerDocument& other, double x, double y) {
    return probeIn(other, otherProbe_, x, y);
  }

  /// A surface, else a place as far away as the pivot.
  Vec3 placeUnder(double x, double y) const;

  /// What a ray meets, or, where that is nothing, a place as far away as the camera's target,
  /// facing the eye.
  WallPlace placeAlong(const Segment& ray) const;

  /// The camera turns around what is there.
  void pivotAt(double x, double y);

  /// A click sets one end of the ruler, the next one the other.
  void measureAt(double x, double y);

  /// Its ends, none to two [m].
  const std::vector<Vec3>& ruler() const { return ruler_; }

  void forgetRuler() { ruler_.clear(); }

  /// Adds a sign or a light where the middle of the picture looks at, a clip around what there is.
  void add(SceneEdit::Kind kind);

  /// The next click puts the sign or the lamp of this path there; empty: none.
  void place(const std::string& path) { placing_ = path; }

  const std::string& placing() const { return placing_; }

  void putAt(double x, double y);  ///< what placing() names

 private:
  Segment rayAt(double x, double y) const {
    return view_.camera().camera(width_, height_).ray(x, y);
  }

  std::optional<MediumProbe::Reading> probeIn(const ViewerDocument& document, MediumProbe& probe,
                                              double x, double y) const;

  ViewerView& view_;
  ViewerDocument& document_;
  int width_ = 1, height_ = 1;
  MediumProbe probe_, otherProbe_;
  std::string placing_;
  std::vector<Vec3> ruler_;
};

struct ViewerTools {
  FogPainting painting;
  PointerTools pointer;
};

}  // namespace volute
