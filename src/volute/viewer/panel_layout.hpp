// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>

namespace volute {

/// The panels at the window's sides: two on the left, one below the other, and one on the right.
enum class SidePanel { kPicture, kPaint, kScene };

/// Between panels and the window's border [pixels].
inline constexpr float kPanelMargin = 10;

/// Between panels [pixels].
inline constexpr float kPanelGap = 4;

/// Which side panels are open, how wide and how high, so that the middle of the picture stays free.
/// In a window with room for both sides they are open from the beginning; in a small one all are
/// closed, and opening one closes the others. On the left the upper one closes when the lower one
/// is opened and does not fit below it. Nothing moves under a hand: from when a button goes down to
/// the frame after it is up, all stays where it is. All lengths in pixels.
class PanelLayout {
 public:
  /// Once a frame. `below`: what the panel of time takes at the bottom, the gap to it included.
  /// `held`: a button of the mouse is down.
  void fit(float width, float height, float below, bool held = false);

  /// Whether all stays where it was in the frame before.
  bool still() const { return still_; }

  /// Whether both sides can be open at once.
  bool roomy() const { return roomy_.value_or(true); }

  bool isOpen(SidePanel panel) const { return of(panel).open; }

  /// A person opened or closed it.
  void set(SidePanel panel, bool open);

  /// How high it would be if it had the room, as it was drawn; 0: it is not there.
  void measure(SidePanel panel, float height);

  /// Where the lower one on the left begins, which would follow what ends at `above`.
  float lowerTop(float above);

  /// Width of a panel that is open.
  float width(SidePanel panel) const;

  /// As it is: titles of closed ones leave room for those on the other side.
  float shownWidth(SidePanel panel) const;

  /// That it may have; the upper one on the left leaves the lower one its own.
  float most(SidePanel panel) const;

 private:
  static constexpr float kTitle = 19;  ///< of a closed one

  struct Of {
    bool open = false;
    float height = 0;
  };

  Of& of(SidePanel panel) { return panels_[static_cast<std::size_t>(panel)]; }

  const Of& of(SidePanel panel) const { return panels_[static_cast<std::size_t>(panel)]; }

  void closeWhatDoesNotFit();

  std::optional<bool> roomy_;
  float width_ = 0, height_ = 0;  ///< the window's
  float free_ = 0;                ///< from the upper margin to what is below
  float lowerTop_ = 0;
  bool held_ = false, still_ = false;
  std::array<Of, 3> panels_{Of{.height = kTitle}};  ///< the first is always there
  SidePanel last_ = SidePanel::kPicture;            ///< that was opened
};

}  // namespace volute
