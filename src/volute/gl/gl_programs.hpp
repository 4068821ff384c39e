// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"

namespace volute {

/// Compute programs by what they are made of. Those that the last pictures did not need are ended.
class GlPrograms {
 public:
  /// The program under this key, valid until the next pictureDone().
  /// @param parts  gives the shader where it must be linked, which is a pass named "link"
  template <class Parts>
  [[nodiscard]] Result<const GlProgram*> get(const std::string& key, const std::string& media,
                                             GlPasses& passes, Parts&& parts) {
    auto found = entries_.find(key);
    if (found == entries_.end()) {
      VOLUTE_ASSIGN(auto program, passes.run("link", media, [&] {
        const ShaderStage stage{GL_COMPUTE_SHADER, parts()};
        return GlProgram::link({&stage, 1});
      }));
      found = entries_.emplace(key, Entry{std::move(program)}).first;
    }
    found->second.used = picture_;
    return &found->second.program;
  }

  void pictureDone() {
    ++picture_;
    std::erase_if(entries_,
                  [&](const auto& item) { return item.second.used + kKeptPictures < picture_; });
  }

  std::size_t size() const { return entries_.size(); }

  static constexpr int kKeptPictures = 64;

 private:
  struct Entry {
    GlProgram program;
    std::int64_t used = 0;  // the number of the last picture
  };

  std::map<std::string, Entry> entries_;
  std::int64_t picture_ = 0;
};

}  // namespace volute
