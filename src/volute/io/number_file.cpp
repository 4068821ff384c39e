// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/number_file.hpp"

#include <algorithm>
#include <cstring>

namespace volute {

Status NumberFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (offset > size_ || bytes.size() > size_ - offset) {
    return fail(ErrorCode::kTruncated, "{}: ends at byte {}, before its values do", path().string(),
                size_);
  }
  if (unpacked_.empty())
    return file_.read(begin_ + offset, bytes);
  std::memcpy(bytes.data(), unpacked_.data() + offset, bytes.size());
  return {};
}

Status NumberFile::read(const NumberType& type, std::uint64_t offset, std::span<float> values) {
  if (type.isFloat() && offset_ == 0)
    return read(offset, std::as_writable_bytes(values));
  constexpr std::size_t kPiece = std::size_t{1} << 18;  // values
  const std::size_t size = type.size();
  bytes_.resize(std::min(kPiece, values.size()) * size);
  for (std::size_t at = 0; at < values.size(); at += kPiece) {
    const auto piece = values.subspan(at, std::min(kPiece, values.size() - at));
    VOLUTE_TRY(read(offset + at * size, std::span(bytes_).first(piece.size() * size)));
    const auto beyond =
        toFloats(type, bytes_.data(), static_cast<std::ptrdiff_t>(size), piece, rounding_, offset_);
    if (beyond) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: the value {:g} is beyond float32, in which values are kept; expected at most "
          "3.4e38: scale them",
          path().string(), *beyond);
    }
  }
  return {};
}

}  // namespace volute
