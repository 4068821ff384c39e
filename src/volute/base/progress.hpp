// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string_view>

#include "volute/base/remark.hpp"

namespace volute {

/// What a long call reports to, and asks whether to go on. The default says nothing and never
/// stops. Called from the thread that made the long call.
class Progress {
 public:
  virtual ~Progress() = default;

  /// `done` of `total` units of `stage` are finished; total 0 means that nobody knows.
  virtual void report(std::string_view stage, double done, double total) {
    (void)stage, (void)done, (void)total;
  }

  /// What is going on within the stage, in a few words that replace the last ones: "frame 12".
  virtual void detail(std::string_view text) { (void)text; }

  /// Something worth a person's attention that does not stop the work.
  virtual void remark(const Remark& remark) { (void)remark; }

  /// True once the caller wants to stop; the long call then fails with ErrorCode::kCancelled and
  /// leaves nothing behind.
  virtual bool cancelled() const { return false; }
};

}  // namespace volute
