// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <utility>

#include "volute/base/hint.hpp"

namespace volute {

/// What kind of thing a remark tells. All but kNote mean that the result may differ from what
/// the caller expects.
enum class RemarkCode {
  kNote,      ///< what is done, or was found
  kAssumed,   ///< something that was not given is assumed
  kLeftOut,   ///< a part of the input is not used
  kDamaged,   ///< data are missing or damaged
  kChanged,   ///< values were clamped, replaced or converted with loss
  kFallback,  ///< another way than the requested one was taken
  kDoubtful,  ///< the input looks wrong
};

/// "left-out".
std::string_view remarkName(RemarkCode code);

/// Something worth a person's attention that does not stop the work.
struct Remark {
  Remark() = default;

  /// A note.
  template <std::convertible_to<std::string_view> Text>
  Remark(const Text& text) : sentence(std::string_view(text)) {}

  Remark(RemarkCode kind, std::string text, Hints advice = {})
      : code(kind), sentence(std::move(text)), hints(std::move(advice)) {}

  RemarkCode code = RemarkCode::kNote;
  std::string sentence;
  std::string file{};   ///< that it is about; empty: none, or several
  std::string place{};  ///< in the file: "frame 12", "/media/0/cell"
  Hints hints{};

  bool operator==(const Remark&) const = default;

  Remark in(std::string itsFile, std::string itsPlace = {}) && {
    file = std::move(itsFile), place = std::move(itsPlace);
    return std::move(*this);
  }
};

}  // namespace volute
