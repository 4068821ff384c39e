// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// libzfp in accuracy mode, variable rate, one thread (its decoder has no other).
#include <zfp.h>

#include <cmath>

#include "bench/file_codec.hpp"
#include "bench/scratch.hpp"

namespace volute::bench {
namespace {

template <class T, void (*kFree)(T*)>
struct Freed {
  void operator()(T* object) const { kFree(object); }
};

using Field = std::unique_ptr<zfp_field, Freed<zfp_field, zfp_field_free>>;
using Stream = std::unique_ptr<zfp_stream, Freed<zfp_stream, zfp_stream_close>>;
using Bits = std::unique_ptr<bitstream, Freed<bitstream, stream_close>>;

/// Channel `channel` of `frames` frames of interleaved values.
Field fieldOf(const VolumeInfo& info, float* values, int channel, bool is4d) {
  const std::ptrdiff_t c = info.channels, x = c * info.x, y = x * info.y, z = y * info.z;
  Field field(
      is4d ? zfp_field_4d(values + channel, zfp_type_float, info.x, info.y, info.z, info.frames)
           : zfp_field_3d(values + channel, zfp_type_float, info.x, info.y, info.z));
  if (is4d) {
    zfp_field_set_stride_4d(field.get(), c, x, y, z);
  } else {
    zfp_field_set_stride_3d(field.get(), c, x, y);
  }
  return field;
}

class ZfpCodec final : public FileCodec {
 public:
  explicit ZfpCodec(bool is4d) : is4d_(is4d) {}

  Setting setting() const override { return Setting::kTolerance; }

  /// zfp rounds a tolerance down to a power of two. Scaling the data reaches those in between.
  Result<float> encode(const Sequence& sequence, double setting,
                       const std::filesystem::path& folder) const override {
    const double power = std::exp2(std::floor(std::log2(setting)));
    const auto scale = static_cast<float>(power / setting);
    std::vector<float> values(sequence.values);
    for (float& value : values) value *= scale;
    VOLUTE_TRY(forEachFile(sequence.info, folder, 0, sequence.info.frames, values,
                           [&](const auto& file, zfp_field* field) {
                             const Stream stream(zfp_stream_open(nullptr));
                             zfp_stream_set_accuracy(stream.get(), power);
                             std::vector<std::byte> bytes(
                                 zfp_stream_maximum_size(stream.get(), field));
                             const Bits bits(stream_open(bytes.data(), bytes.size()));
                             zfp_stream_set_bit_stream(stream.get(), bits.get());
                             zfp_write_header(stream.get(), field, ZFP_HEADER_FULL);
                             bytes.resize(zfp_compress(stream.get(), field));
                             return writeScratch(file, bytes);
                           }));
    return 1 / scale;
  }

  Status decode(const VolumeInfo& info, const std::filesystem::path& folder,
                std::span<float> values) const override {
    return decodeFrames(info, folder, 0, info.frames, values);
  }

  /// Where each frame has a file, of those that are wanted.
  Status decodePart(const VolumeInfo& info, const std::filesystem::path& folder,
                    const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
                    std::span<float> values) const override {
    if (is4d_)
      return FileCodec::decodePart(info, folder, begin, end, values);
    std::vector<float> frames(static_cast<std::size_t>(end[0] - begin[0]) * info.frameValues());
    VOLUTE_TRY(decodeFrames(info, folder, begin[0], end[0], frames));
    copyPart(info, frames, begin[0], begin, end, values);
    return {};
  }

 private:
  Status decodeFrames(const VolumeInfo& info, const std::filesystem::path& folder, int first,
                      int end, std::span<float> values) const {
    return forEachFile(info, folder, first, end, values,
                       [&](const auto& file, zfp_field* field) -> Status {
                         VOLUTE_ASSIGN(auto bytes, readScratch(file));
                         const Bits bits(stream_open(bytes.data(), bytes.size()));
                         const Stream stream(zfp_stream_open(bits.get()));
                         const Field stated(zfp_field_alloc());
                         if (!zfp_read_header(stream.get(), stated.get(), ZFP_HEADER_FULL) ||
                             !zfp_decompress(stream.get(), field)) {
                           return fail(ErrorCode::kInvalidData,
                                       "{}: zfp cannot read back what it wrote", file.string());
                         }
                         return {};
                       });
  }

  /// Calls work(path, field) for each file: one a channel, or one a channel and frame.
  template <class Work>
  Status forEachFile(const VolumeInfo& info, const std::filesystem::path& folder, int first,
                     int end, std::span<float> values, Work&& work) const {
    for (int c = 0; c < info.channels; ++c) {
      for (int t = first; t < (is4d_ ? 1 : end); ++t) {
        const Field field = fieldOf(info, &values[(t - first) * info.frameValues()], c, is4d_);
        VOLUTE_TRY(work(folder / fmt::format("{}_{:04}.zfp", c, t), field.get()));
      }
    }
    return {};
  }

  bool is4d_;
};

}  // namespace

MadeCodec makeZfp4dCodec() {
  return std::make_unique<ZfpCodec>(true);
}

MadeCodec makeZfp3dCodec() {
  return std::make_unique<ZfpCodec>(false);
}

}  // namespace volute::bench
