// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace volute {

/// The undo and redo stacks of a scene.
class SceneHistory {
 public:
  /// Records a change from `before`. Consecutive changes with the same non-empty name, as of a
  /// dragged slider, are one.
  void note(nlohmann::ordered_json before, const std::string& name) {
    future_.clear();
    if (name.empty() || name != last_ || past_.empty())
      past_.push_back(std::move(before));
    last_ = name;
    if (past_.size() > kMax)
      past_.pop_front();
  }

  bool canUndo() const { return !past_.empty(); }

  bool canRedo() const { return !future_.empty(); }

  /// The scene before the last change; expects canUndo().
  const nlohmann::ordered_json& before() const { return past_.back(); }

  /// Likewise; canRedo().
  const nlohmann::ordered_json& after() const { return future_.back(); }

  /// The last change was undone: the scene is before(); it was `now`.
  void undone(nlohmann::ordered_json now) {
    past_.pop_back();
    future_.push_back(std::move(now));
    last_.clear();
  }

  /// It has become after().
  void redone(nlohmann::ordered_json now) {
    future_.pop_back();
    past_.push_back(std::move(now));
    last_.clear();
  }

  /// Changes all scenes that it gives back, as where a file was renamed.
  template <class Change>
  void changeAll(Change&& change) {
    for (auto& scene : past_) change(scene);
    for (auto& scene : future_) change(scene);
    last_.clear();
  }

  void clear() { *this = {}; }

 private:
  static constexpr std::size_t kMax = 200;

  std::deque<nlohmann::ordered_json> past_;
  std::vector<nlohmann::ordered_json> future_;
  std::string last_;
};

}  // namespace volute
