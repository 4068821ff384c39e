// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/file_codec.hpp"

#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"

namespace volute::bench {
namespace {

class VoluteCodec final : public FileCodec {
 public:
  Setting setting() const override { return Setting::kRelativeRms; }

  Result<float> encode(const Sequence& sequence, double setting,
                       const std::filesystem::path& folder) const override {
    SequenceSource source(sequence);
    CompressOptions options;
    options.target = {ErrorTarget::Kind::kRmsOverAll, setting};
    Progress quiet;
    VOLUTE_TRY(compress(source, file(folder), options, quiet));
    return 1.0f;
  }

  Status decode(const VolumeInfo& info, const std::filesystem::path& folder,
                std::span<float> values) const override {
    VOLUTE_ASSIGN(const auto reader, VoluteReader::open(file(folder)));
    const std::size_t row = static_cast<std::size_t>(reader.blocks().frames()) * info.frameValues();
    for (int i = 0; i < reader.blocks().counts()[0]; ++i) {
      const std::size_t begin = i * row;
      VOLUTE_TRY(reader.readRow(i, values.subspan(begin, std::min(row, values.size() - begin))));
    }
    return {};
  }

 private:
  static std::filesystem::path file(const std::filesystem::path& folder) {
    return folder / "sequence.volute";
  }
};

}  // namespace

MadeCodec makeVoluteCodec() {
  return std::make_unique<VoluteCodec>();
}

std::span<const FileCodecEntry> fileCodecs() {
  static constexpr FileCodecEntry kTable[] = {
      {"Volute", makeVoluteCodec},
      {"zfp 4D", makeZfp4dCodec},
      {"zfp 3D", makeZfp3dCodec},
      {"NanoVDB FpN, zip", makeNanoVdbCodec},
      {"OpenVDB half, zip", makeVdbCodec},
      {"zstd -19, float32", makeZstdFloatCodec},
      {"zstd -19, float16", makeZstdHalfCodec},
  };
  return kTable;
}

}  // namespace volute::bench
