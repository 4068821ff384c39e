// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace volute {

/// What a scene was before its last changes, and what it was before they were undone.
class SceneHistory {
 public:
  /// The scene has been changed from `before`. Changes in a row that have the same name, which is
  /// not empty, count as one: a slider that is drawn.
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

  /// It has become before(); `now` is what it was.
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

  void clear() { *this = {}; }

 private:
  static constexpr std::size_t kMax = 200;

  std::deque<nlohmann::ordered_json> past_;
  std::vector<nlohmann::ordered_json> future_;
  std::string last_;
};

}  // namespace volute
