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

  void remark(const Remark& remark) override {
    remarks_.push_back(remark);
    next_.remark(remark);
  }

  bool cancelled() const override { return next_.cancelled(); }

  const std::vector<Remark>& remarks() const { return remarks_; }

  std::vector<std::string> sentences() const {
    std::vector<std::string> sentences;
    for (const Remark& remark : remarks_) sentences.push_back(remark.sentence);
    return sentences;
  }

 private:
  Progress& next_;
  std::vector<Remark> remarks_;
};

}  // namespace volute
