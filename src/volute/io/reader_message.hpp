// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace volute::detail {

/// Replies and requests of a reader's process are at most this many bytes.
inline constexpr std::size_t kMaxMessage = 128 << 10;

/// The fixed part of a message, in both directions; the text follows.
struct ReaderHeader {
  std::uint64_t valueCount = 0;
  double seconds = 0;
  std::int32_t code = -1;  // of replies: an ErrorCode, or -1 for success
};

/// `descriptors` go along. False when the other end is gone.
bool sendReaderMessage(int socket, const ReaderHeader& header, std::string_view text,
                       std::span<const int> descriptors = {});

/// False when the other end is gone or sent something else. Descriptors that nobody asked for are
/// closed by the system.
bool receiveReaderMessage(int socket, ReaderHeader& header, std::string& text,
                          std::span<int> descriptors = {});

}  // namespace volute::detail
