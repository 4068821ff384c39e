// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/progress.hpp"

namespace volute {

/// Passes everything on, and keeps the remarks of a long call.
class RemarkLog final : public Progress {
 public:
  explicit RemarkLog(Progress& next) : next_(next) {}

  void report(std::string_view stage, double done, double total) override {
    next_.report(stage, done, total);
  }

  void detail(std::string_view text) override { next_.detail(text); }

  void remark(std::string_view message) override {
    remarks_.emplace_back(message);
    next_.remark(message);
  }

  bool cancelled() const override { return next_.cancelled(); }

  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  Progress& next_;
  std::vector<std::string> remarks_;
};

}  // namespace volute
