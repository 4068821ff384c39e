// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/comparison.hpp"

#include <algorithm>
#include <cmath>

#include "volute/scene/scene.hpp"
#include "volute/viewer/language.hpp"

namespace volute {
namespace {

/// Of a medium: "smoke" of "smoke: hall.pvd".
std::string_view kindOf(const Parameter& parameter) {
  return std::string_view(parameter.group).substr(0, parameter.group.find(':'));
}

/// Whether it is how the first medium looks, and not where it is or what is shown of it.
bool isLook(const Parameter& parameter) {
  const bool number =
      parameter.kind == Parameter::Kind::kNumber || parameter.kind == Parameter::Kind::kColor;
  return number && parameter.section.empty() && parameter.path.starts_with("/media/0/");
}

const Parameter* twinOf(const Parameter& parameter, const DocumentInfo& info) {
  const auto found = std::ranges::find(info.parameters, parameter.path, &Parameter::path);
  const bool same = found != info.parameters.end() && found->kind == parameter.kind &&
                    kindOf(*found) == kindOf(parameter);
  return same ? &*found : nullptr;
}

}  // namespace

Status Comparison::begin(const std::string& path, const PictureMakers& makers) {
  VOLUTE_ASSIGN(auto picture, ViewPicture::create(makers));
  other_.reset(new Other{{open_, {}}, std::move(picture)});
  path_ = path;
  other_->document.open(path, std::nullopt);
  return {};
}

void Comparison::end() {
  other_.reset();
}

/// Each would have a look of its own, in which all files are about as dense.
void Comparison::giveLook(const DocumentInfo& first) {
  ViewerDocument& document = other_->document;
  if (isScenePath(path_) || path_ == first.path)
    return;
  for (const Parameter& parameter : first.parameters) {
    const Parameter* twin = isLook(parameter) ? twinOf(parameter, *document.info()) : nullptr;
    if (!twin || other_->look[parameter.path] == parameter.value)
      continue;
    other_->look[parameter.path] = parameter.value;
    if (twin->value != parameter.value)
      document.set(Parameter(*twin), parameter.value);
  }
}

std::string Comparison::remark(const DocumentInfo& first) const {
  const DocumentInfo* info = other_ ? other_->document.info() : nullptr;
  if (!info || other_->document.changing())
    return "";
  bool twins = false;
  for (const Parameter& parameter : first.parameters) {
    if (!isLook(parameter))
      continue;
    const Parameter* twin = twinOf(parameter, *info);
    if (twin && twin->value != parameter.value)
      return fmt::format(fmt::runtime(tr("not drawn with the same {}")), tr(parameter.name));
    twins = twins || twin;
  }
  return twins || path_ == first.path ? "" : tr("each is drawn with a look of its own");
}

void Comparison::update(const PictureRequest& request, double time, const DocumentInfo* first) {
  ViewerDocument& document = other_->document;
  ViewPicture& picture = other_->picture;
  if (const auto news = document.take()) {
    if (news->scene && document.scene()->scene.get() != picture.scene())
      document.loader().discard(picture.setScene(document.scene()->scene));
  }
  if (!document.info())
    return;
  if (first && !document.opening())
    giveLook(*first);
  if (!document.opening() && std::exchange(other_->requested, time) != time)
    document.loader().request(time);
  document.loader().setOpenGl(picture.mayUseGl(request.renderer));
  if (const Status drawn = picture.update(request); !drawn)
    document.refuseScene(drawn.error());
}

bool Comparison::settled(const PictureRequest& request) const {
  const ViewerDocument& document = other_->document;
  return document.idle() &&
         (!document.error().empty() ||
          (document.scene() && other_->picture.settled(request) && other_->picture.exact(request)));
}

void Comparison::addTo(DisplayLook& look) const {
  if (mode != Mode::kDifference || !other_ || !other_->picture.shown())
    return;
  look.other = other_->picture.shownLight();
  look.other.span = span;
  look.map = ColorMap::kViridis;
}

void Comparison::show(const DisplayLook& look, int width, int height) {
  if (mode != Mode::kWiper || !other_ || !other_->picture.shown())
    return;
  if (width != width_ || height != height_) {
    width_ = width, height_ = height;
    colors_ = makeTexture2d(GL_RGBA8, width, height);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    frame_ = GlFramebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors_.name(), 0);
  }
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.name());
  other_->picture.show(look, width, height);
  const int begin = static_cast<int>(std::lround(border * width));
  glBlitNamedFramebuffer(frame_.name(), static_cast<GLuint>(target), begin, 0, width, height, begin,
                         0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
}

}  // namespace volute
