// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_document.hpp"

#include "volute/viewer/error_text.hpp"

namespace volute {

void ViewerDocument::open(const std::string& path, std::optional<double> time) {
  opening_.emplace(time);
  message_.clear();
  requested_ = path;
  files_.setMoved({});
  loader_.open(path, time);
}

void ViewerDocument::setFailure(std::optional<Error> failure) {
  failure_ = std::move(failure);
  error_ = failure_ ? viewerText(*failure_) : "";
}

void ViewerDocument::refuseScene(Error why) {
  sceneFailure_ = std::move(why);
  setFailure(sceneFailure_);
  scene_.reset();
}

bool ViewerDocument::idle() const {
  return loader_.idle() && !changing() && !hasNews();
}

std::optional<DocumentNews> ViewerDocument::take() {
  const int changes = loader_.changes();
  auto told = loader_.news();
  if (!told)
    return std::nullopt;
  changes_ = changes;
  loading_ = std::move(told->state);
  setFailure(loading_.error ? loading_.error : sceneFailure_);
  if (loading_.message != lastMessage_)
    say(lastMessage_ = loading_.message);
  DocumentNews news{.idle = told->idle, .frozen = std::move(told->frozen)};
  if (news.idle)
    pending_.clear();
  if (told->opened) {
    held_.clear();
    news.changed = true;
    news.another = !info_ || info_->opened != told->opened->opened;
    news.otherTimes = info_ && info_->times != told->opened->times;
    info_ = std::move(*told->opened);
    files_.setOpen(info_->path, info_->overwritten);
    if (news.another) {
      scene_.reset();  // it is the last document's
      fields_.reset();
      news.begun = std::exchange(opening_, std::nullopt);
    }
    for (Parameter& parameter : info_->parameters) {
      if (const auto waiting = pending_.find(parameter.path); waiting != pending_.end())
        held_[parameter.path] = std::exchange(parameter.value, waiting->second);
    }
  }
  if (news.idle && info_) {  // what was refused did not become true
    for (Parameter& parameter : info_->parameters) {
      if (const auto held = held_.find(parameter.path); held != held_.end())
        parameter.value = held->second;
    }
    held_.clear();
  }
  if (news.idle && opening_) {  // it cannot be opened
    opening_.reset();
    files_.setMoved(movedFileOf(requested_));
  }
  if (told->fields)
    fields_ = std::move(told->fields);
  if (told->loaded) {
    if (scene_)
      loader_.discard(std::move(scene_->scene));
    scene_ = std::move(*told->loaded);
    sceneFailure_.reset();
    news.scene = true;
  }
  return news;
}

void ViewerDocument::set(const Parameter& parameter, const std::vector<double>& value) {
  pending_[parameter.path] = value;
  for (Parameter& shown : info_->parameters) {
    if (shown.path != parameter.path)
      continue;
    held_.try_emplace(parameter.path, shown.value);
    shown.value = value;
  }
  loader_.change("set " + parameter.path,
                 [path = parameter.path, value](Document& document,
                                                Progress& progress) -> Result<std::string> {
                   VOLUTE_TRY(document.set(path, value, progress));
                   return "";
                 });
}

/// What comes after another one of its kind does not replace that.
void ViewerDocument::change(DocumentChange what) {
  pending_.clear(), held_.clear();  // their paths may be others' by then
  loader_.change(fmt::format("edit {}", ++edits_), std::move(what));
}

void ViewerDocument::edit(const SceneEdit& edit) {
  change([edit](Document& document, Progress& progress) { return document.edit(edit, progress); });
}

void ViewerDocument::add(const std::string& path) {
  files_.recent().add(path);
  change([path](Document& document, Progress& progress) { return document.add(path, progress); });
}

/// The last ones stay to be seen while the next are read.
const LoadedFields* ViewerDocument::fieldsAt(const Vec3& place) {
  const bool there = fields_ && scene_ && fields_->time == scene_->time && fields_->place == place;
  if (!there && !loading_.busy && (fieldsAsked_ != place || idle())) {
    fieldsAsked_ = place;
    loader_.requestFields(place);
  }
  return fields_ ? &*fields_ : nullptr;
}

void ViewerDocument::undo() {
  change([](Document& document, Progress& progress) -> Result<std::string> {
    VOLUTE_TRY(document.undo(progress));
    return "";
  });
}

void ViewerDocument::redo() {
  change([](Document& document, Progress& progress) -> Result<std::string> {
    VOLUTE_TRY(document.redo(progress));
    return "";
  });
}

void LeaveQuestion::leaveFor(const std::string& path) {
  for (const What what : {What::kMap, What::kScene}) {
    if (actions_.unsaved(what, 0)) {
      asked_ = Asked{path, what};
      return;
    }
  }
  go(path);
}

void LeaveQuestion::go(const std::string& path) {
  if (path.empty())
    ends_ = true;
  else
    actions_.open(path);
}

void LeaveQuestion::save() {
  asked_->saving = true;
  actions_.save(asked_->what);
}

/// What is in no file besides is asked about next.
void LeaveQuestion::discard() {
  const Asked left = *std::exchange(asked_, std::nullopt);
  const std::size_t passed = left.passed + 1;
  if (left.what == What::kMap && actions_.unsaved(What::kMap, passed))
    asked_ = Asked{left.path, What::kMap, false, passed};
  else if (left.what == What::kMap && actions_.unsaved(What::kScene, 0))
    asked_ = Asked{left.path, What::kScene};
  else
    go(left.path);
}

void LeaveQuestion::goOn() {
  if (!asked_ || !asked_->saving)
    return;
  asked_->saving = false;
  if (!actions_.unsaved(asked_->what, asked_->passed))
    discard();
}

}  // namespace volute
