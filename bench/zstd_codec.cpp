// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <zstd.h>

#include <Eigen/Core>
#include <algorithm>

#include "bench/file_codec.hpp"
#include "bench/scratch.hpp"
#include "volute/base/half.hpp"

namespace volute::bench {
namespace {

constexpr int kLevel = 19;

/// To the nearest, ties to even.
Half toHalf(float value) {
  return {Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(value))};
}

/// The bytes of the whole array, as float32 or rounded to float16.
class ZstdCodec final : public FileCodec {
 public:
  explicit ZstdCodec(bool half) : half_(half) {}

  Setting setting() const override { return Setting::kNone; }

  Result<float> encode(const Sequence& sequence, double,
                       const std::filesystem::path& folder) const override {
    std::vector<Half> halves(half_ ? sequence.values.size() : 0);
    if (half_)
      std::ranges::transform(sequence.values, halves.begin(), toHalf);
    const auto raw = half_ ? std::as_bytes(std::span<const Half>(halves))
                           : std::as_bytes(std::span(sequence.values));
    std::vector<std::byte> bytes(ZSTD_compressBound(raw.size()));
    const std::size_t size =
        ZSTD_compress(bytes.data(), bytes.size(), raw.data(), raw.size(), kLevel);
    if (ZSTD_isError(size))
      return fail(ErrorCode::kTooLarge, "zstd: {}", ZSTD_getErrorName(size));
    bytes.resize(size);
    VOLUTE_TRY(writeScratch(file(folder), bytes));
    return 1.0f;
  }

  Status decode(const VolumeInfo&, const std::filesystem::path& folder,
                std::span<float> values) const override {
    if (!half_)
      return decompress(folder, std::as_writable_bytes(values));
    std::vector<Half> halves(values.size());
    VOLUTE_TRY(decompress(folder, std::as_writable_bytes(std::span(halves))));
    std::ranges::transform(halves, values.begin(), toFloat);
    return {};
  }

 private:
  static std::filesystem::path file(const std::filesystem::path& folder) {
    return folder / "sequence.zst";
  }

  static Status decompress(const std::filesystem::path& folder, std::span<std::byte> raw) {
    VOLUTE_ASSIGN(const auto bytes, readScratch(file(folder)));
    if (ZSTD_decompress(raw.data(), raw.size(), bytes.data(), bytes.size()) != raw.size())
      return fail(ErrorCode::kInvalidData, "zstd cannot read back what it wrote");
    return {};
  }

  bool half_;
};

}  // namespace

MadeCodec makeZstdFloatCodec() {
  return std::make_unique<ZstdCodec>(false);
}

MadeCodec makeZstdHalfCodec() {
  return std::make_unique<ZstdCodec>(true);
}

}  // namespace volute::bench
