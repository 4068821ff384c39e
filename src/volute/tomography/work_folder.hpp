// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/base/shared_folder.hpp"

namespace volute {

/// Where finished frames of a long run wait until the output is written: a folder "OUT.work" beside
/// it. An interrupted run that is started again finds them there, and so do other runs for the same
/// output, the last of which removes it (SharedFolder). Each frame has a key, a digest of all that
/// decides about it, and files of that name: frames with another key count as not there.
class WorkFolder {
 public:
  /// Makes the folder, or takes the one that is there. For "-" it is one in the folder for
  /// temporary files, of this process alone.
  [[nodiscard]] static Result<WorkFolder> open(const std::filesystem::path& output);

  const std::filesystem::path& path() const { return folder_.path(); }

  bool has(int frame, const std::string& key) const;

  /// True when it is there without damage: its files are read.
  bool sound(int frame, const std::string& key) const;

  /// True when any frame is there.
  bool any() const;

  /// Stores a finished frame; it is there whole or not at all.
  [[nodiscard]] Status store(int frame, const std::string& key, std::span<const float> values,
                             const nlohmann::ordered_json& record) const;

  /// The values of a frame; kInvalidData when they are damaged or not `count`.
  [[nodiscard]] Result<std::vector<float>> values(int frame, const std::string& key,
                                                  std::size_t count) const;

  [[nodiscard]] Result<nlohmann::ordered_json> record(int frame, const std::string& key) const;

  /// Removes it all unless another process uses it: the output is there.
  void remove() const;

  /// After a run: removes it unless that failed, has finished frames, and can be continued (an
  /// output of "-" cannot). Returns true if it stays for that.
  bool leave(bool done) const;

 private:
  WorkFolder(SharedFolder folder, bool temporary)
      : folder_(std::move(folder)), temporary_(temporary) {}

  /// What is in the frame's file of values, which fits its record.
  [[nodiscard]] Result<std::vector<std::byte>> packed(int frame, const std::string& key) const;
  /// The frame's file beside the values.
  [[nodiscard]] Result<nlohmann::ordered_json> stored(int frame, const std::string& key) const;
  tl::unexpected<Error> damaged(const std::filesystem::path& file) const;

  SharedFolder folder_;
  bool temporary_;  // of an output that is "-"
};

/// A digest of a text: 16 hexadecimal digits (FNV-1a, 64 bits).
std::string digestOf(std::string_view text);

}  // namespace volute
