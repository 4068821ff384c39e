// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <concepts>
#include <functional>
#include <map>
#include <memory>
#include <typeindex>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

class GlPart;

/// What OpenGL draws media by, looked up by the type of the medium: a row for each kind.
/// @tparam Base  of all media, with virtual functions
template <class Base, class... Options>
class GlPartTable {
 public:
  using Parts = std::vector<std::shared_ptr<const GlPart>>;

  /// `make` gives the Result<Parts> of a Medium and the options.
  template <std::derived_from<Base> Medium, class Make>
  void add(Make make) {
    rows_[typeid(Medium)] = [make = std::move(make)](const Base& medium,
                                                     const Options&... options) -> Result<Parts> {
      return make(static_cast<const Medium&>(medium), options...);
    };
  }

  /// kUnsupported for a kind without a row.
  [[nodiscard]] Result<Parts> partsOf(const Base& medium, const Options&... options) const {
    const auto row = rows_.find(typeid(medium));
    if (row == rows_.end())
      return fail(ErrorCode::kUnsupported, "OpenGL does not draw this kind of medium");
    return row->second(medium, options...);
  }

 private:
  std::map<std::type_index, std::function<Result<Parts>(const Base&, const Options&...)>> rows_;
};

}  // namespace volute
