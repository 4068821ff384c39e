// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_message.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace volute::detail {
namespace {

constexpr std::size_t kMaxDescriptors = 4;

/// Room for descriptors beside a message.
union ControlBuffer {
  cmsghdr header;
  char bytes[CMSG_SPACE(kMaxDescriptors * sizeof(int))];
};

}  // namespace

bool sendReaderMessage(int socket, const ReaderHeader& header, std::string_view text,
                       std::span<const int> descriptors) {
  text = text.substr(0, kMaxMessage);
  iovec parts[2] = {{const_cast<ReaderHeader*>(&header), sizeof header},
                    {const_cast<char*>(text.data()), text.size()}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  ControlBuffer control{};
  if (!descriptors.empty()) {
    message.msg_control = control.bytes;
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(part), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(sizeof header + text.size());
}

bool receiveReaderMessage(int socket, ReaderHeader& header, std::string& text,
                          std::span<int> descriptors) {
  text.resize(kMaxMessage);
  iovec parts[2] = {{&header, sizeof header}, {text.data(), text.size()}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  ControlBuffer control{};
  if (!descriptors.empty()) {
    message.msg_control = control.bytes;
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
  }
  ssize_t received = 0;
  do {
    received = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  } while (received < 0 && errno == EINTR);
  if (received < static_cast<ssize_t>(sizeof header))
    return false;
  text.resize(static_cast<std::size_t>(received) - sizeof header);
  if (descriptors.empty())
    return true;
  const cmsghdr* part = CMSG_FIRSTHDR(&message);
  if (!part || part->cmsg_type != SCM_RIGHTS ||
      part->cmsg_len != CMSG_LEN(descriptors.size_bytes()))
    return false;
  std::memcpy(descriptors.data(), CMSG_DATA(part), descriptors.size_bytes());
  return true;
}

}  // namespace volute::detail
