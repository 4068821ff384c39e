// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/progress.hpp"

namespace volute {

/// Passes on remarks and cancellation, but no progress: for one of several parts of a task.
class CancelOnly final : public Progress {
 public:
  explicit CancelOnly(Progress& outer) : outer_(outer) {}

  void remark(const Remark& remark) override { outer_.remark(remark); }

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  Progress& outer_;
};

/// Passes on cancellation alone.
class StopOnly final : public Progress {
 public:
  explicit StopOnly(const Progress& outer) : outer_(outer) {}

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  const Progress& outer_;
};

}  // namespace volute
