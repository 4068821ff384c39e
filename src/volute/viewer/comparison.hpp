// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <string>

#include "volute/viewer/view_picture.hpp"
#include "volute/viewer/viewer_document.hpp"

namespace volute {

/// Another file, seen from the same place, at the same time and in the same light as what is open:
/// on the right of a border, or as the difference of both. Needs the context that it was made in.
class Comparison {
 public:
  enum class Mode { kWiper, kDifference };

  explicit Comparison(OpenDocument open) : open_(std::move(open)) {}

  [[nodiscard]] Status begin(const std::string& path, const PictureMakers& makers);

  void end();

  bool active() const { return other_ != nullptr; }

  const std::string& path() const { return path_; }

  /// Why it cannot be shown; empty: it can.
  const std::string& error() const { return other_->document.error(); }

  /// Draws the other file as the request says, at this time [s], and, where it is no scene but of
  /// the kind that `first` shows, with what that says of its look.
  void update(const PictureRequest& request, double time, const DocumentInfo* first);

  /// Why colours of both cannot be compared, as in a sentence; empty: they can.
  std::string remark(const DocumentInfo& first) const;

  ViewerDocument* document() { return other_ ? &other_->document : nullptr; }

  /// Whether a place of the window, so many points wide, shows the other file.
  bool isAt(double x, int width) const {
    return other_ && mode == Mode::kWiper && x >= border * width;
  }

  /// Whether there is nothing that it still has to load or draw.
  bool settled(const PictureRequest& request) const;

  /// What `picture` shows becomes the difference, where that is the mode.
  void addTo(DisplayLook& look) const;

  /// Over the picture that the bound framebuffer has, on the right of the border.
  void show(const DisplayLook& look, int width, int height);

  Mode mode = Mode::kWiper;
  double border = 0.5;  ///< share of the window's width
  double span = 0.1;    ///< the difference that has the last colour, of white

 private:
  struct Other {
    ViewerDocument document;
    ViewPicture picture;
    double requested = 0;
    std::map<std::string, std::vector<double>> look{};  ///< that it was given, by paths
  };

  void giveLook(const DocumentInfo& first);

  OpenDocument open_;
  std::string path_;
  std::unique_ptr<Other> other_;
  GlTexture colors_;
  GlFramebuffer frame_;
  int width_ = 0, height_ = 0;
};

}  // namespace volute
