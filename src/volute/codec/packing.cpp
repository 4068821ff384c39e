// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/packing.hpp"

#include <zstd.h>

#include <memory>

namespace volute {
namespace {

constexpr std::byte kStored{0};
constexpr std::byte kZstd{1};

// Higher levels gain 2 % at ten times the time; the planes have little for a match finder.
constexpr int kZstdLevel = 3;

// Below this many bytes a Huffman table costs more than a plane gains by having its own.
constexpr std::size_t kOwnTableBytes = 1024;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }

  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// One context a thread: making one costs more than a small segment.
ZSTD_CCtx* compressionContext() {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  return context.get();
}

ZSTD_DCtx* decompressionContext() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  return context.get();
}

// Compresses behind the first byte of `out`; 0 when it does not fit.
std::size_t zstdInto(std::span<std::byte> out,
                     std::initializer_list<std::span<const std::byte>> planes, std::size_t total) {
  ZSTD_CCtx* context = compressionContext();
  if (!context)
    return 0;
  ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
  ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, kZstdLevel);
  ZSTD_CCtx_setPledgedSrcSize(context, total);
  ZSTD_outBuffer output{out.data(), out.size(), 1};
  std::size_t done = 0;
  for (const auto& plane : planes) {
    done += plane.size();
    const bool last = done == total;
    ZSTD_inBuffer input{plane.data(), plane.size(), 0};
    const auto directive = last                             ? ZSTD_e_end
                           : plane.size() >= kOwnTableBytes ? ZSTD_e_flush
                                                            : ZSTD_e_continue;
    const std::size_t left = ZSTD_compressStream2(context, &output, &input, directive);
    if (ZSTD_isError(left) || (directive != ZSTD_e_continue && left != 0))
      return 0;
    if (last)
      return output.pos;
  }
  return 0;
}

}  // namespace

std::vector<std::byte> pack(std::initializer_list<std::span<const std::byte>> planes) {
  std::size_t total = 0;
  for (const auto& plane : planes) total += plane.size();
  if (total == 0)
    return {};
  std::vector<std::byte> out(1 + total);
  const std::size_t compressed = zstdInto(out, planes, total);
  if (compressed != 0) {
    out[0] = kZstd;
    out.resize(compressed);
    return out;
  }
  out[0] = kStored;
  auto place = out.begin() + 1;
  for (const auto& plane : planes) place = std::copy(plane.begin(), plane.end(), place);
  return out;
}

Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, std::uint64_t limit) {
  if (packed.empty())
    return fail(ErrorCode::kInvalidData, "is empty");
  const std::byte method = packed[0];
  packed = packed.subspan(1);
  if (method == kStored) {
    if (packed.size() > limit) {
      return fail(ErrorCode::kInvalidData, "holds {} bytes; expected at most {}", packed.size(),
                  limit);
    }
    return std::vector<std::byte>(packed.begin(), packed.end());
  }
  if (method != kZstd) {
    return fail(ErrorCode::kInvalidData, "is packed by the unknown method {}",
                static_cast<int>(method));
  }
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    return fail(ErrorCode::kInvalidData, "is not a zstd frame that states its size");
  }
  if (size > limit)
    return fail(ErrorCode::kInvalidData, "holds {} bytes; expected at most {}", size, limit);
  std::vector<std::byte> content(static_cast<std::size_t>(size));
  ZSTD_DCtx* context = decompressionContext();
  if (!context)
    return fail(ErrorCode::kTooLarge, "needs more memory to be unpacked than there is");
  const std::size_t written =
      ZSTD_decompressDCtx(context, content.data(), content.size(), packed.data(), packed.size());
  if (ZSTD_isError(written) || written != content.size()) {
    return fail(ErrorCode::kInvalidData, "does not unpack to the {} bytes that it states", size);
  }
  return content;
}

}  // namespace volute
