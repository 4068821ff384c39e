// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/viewer/view_camera.hpp"
#include "volute/viewer/viewer_document.hpp"

namespace volute {

/// The camera at a time [s] of its path; what the keys leave open stays.
ViewCamera alongKeys(const ViewCamera& camera, std::vector<CameraKey> keys, double time);

/// The camera path that the scene stores: keys at times of the document.
class CameraPath {
 public:
  explicit CameraPath(ViewerDocument& document) : document_(document) {}

  const std::vector<CameraKey>& keys() const { return keys_; }

  /// Whether there is a path: two keys or more.
  bool leads() const { return keys_.size() > 1; }

  /// The document has changed.
  void take(const DocumentInfo& info);

  /// Another document: nothing stays.
  void forget() { keys_.clear(), followed_.reset(), seek_.reset(), sent_ = false; }

  /// Sets the key of this time, or moves the one that is there. Of what does not move, a key at the
  /// end follows the one before after two seconds. Says in a sentence what was done.
  void set(const ViewCamera& camera, double time);

  /// Removes the key that is nearest to the time.
  void remove(const ViewCamera& camera, double time);

  /// The time of a key that was set, once the document has it [s].
  std::optional<double> takeSeek() { return std::exchange(seek_, std::nullopt); }

  /// Where playing, or a person who changed the time, wants the camera to be; nothing: where it is.
  std::optional<ViewCamera> follow(const ViewCamera& camera, double time);

 private:
  void send(const ViewCamera& camera);

  ViewerDocument& document_;
  std::vector<CameraKey> keys_;
  std::optional<double> followed_;  ///< [s] the last time
  std::optional<double> seek_;
  bool sent_ = false;  ///< the document has still to take the keys
};

}  // namespace volute
