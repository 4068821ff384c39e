// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// A matrix of a file, or a plain number as 1 x 1.
struct OpenCvMatrix {
  int rows = 0, columns = 0;
  std::vector<double> values;
};

/// The matrices and numbers of a file by OpenCV's FileStorage, in the file's order.
class OpenCvStorage {
 public:
  /// False: there is one of this name.
  bool add(const std::string& name, OpenCvMatrix matrix) {
    if (!places_.emplace(name, list_.size()).second)
      return false;
    list_.emplace_back(name, std::move(matrix));
    return true;
  }

  const OpenCvMatrix* find(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? nullptr : &list_[found->second].second;
  }

  /// Texts, lists and other structures, of which nothing but the names is kept.
  std::vector<std::string> others;

  auto begin() const { return list_.begin(); }

  auto end() const { return list_.end(); }

 private:
  std::vector<std::pair<std::string, OpenCvMatrix>> list_;
  std::unordered_map<std::string, std::size_t> places_;
};

/// Reads .yml, .yaml, .xml and .json. Strings and other structures are left out; what `isNeeded`
/// says of a name is a whole matrix or number, else the file is refused, as where a name is there
/// twice.
[[nodiscard]] Result<OpenCvStorage> readOpenCvStorage(const std::filesystem::path& file,
                                                      bool (*isNeeded)(std::string_view));

}  // namespace volute
