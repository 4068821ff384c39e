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

  Status decodePart(const VolumeInfo&, const std::filesystem::path& folder,
                    const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
                    std::span<float> values) const override {
    VOLUTE_ASSIGN(const auto reader, VoluteReader::open(file(folder)));
    return reader.readBox(begin, end, values);
  }

 private:
  static std::filesystem::path file(const std::filesystem::path& folder) {
    return folder / "sequence.volute";
  }
};

}  // namespace

void copyPart(const VolumeInfo& info, std::span<const float> frames, int first,
              const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
              std::span<float> values) {
  const auto channels = static_cast<std::size_t>(info.channels);
  const auto line = static_cast<std::size_t>(end[3] - begin[3]) * channels;
  float* to = values.data();
  for (int t = begin[0]; t < end[0]; ++t)
    for (int z = begin[1]; z < end[1]; ++z)
      for (int y = begin[2]; y < end[2]; ++y, to += line) {
        const std::size_t row = (static_cast<std::size_t>(t - first) * info.z + z) * info.y + y;
        std::copy_n(&frames[(row * info.x + begin[3]) * channels], line, to);
      }
}

Status FileCodec::decodePart(const VolumeInfo& info, const std::filesystem::path& folder,
                             const BlockGrid::Index4& begin, const BlockGrid::Index4& end,
                             std::span<float> values) const {
  std::vector<float> all(info.values());
  VOLUTE_TRY(decode(info, folder, all));
  copyPart(info, all, 0, begin, end, values);
  return {};
}

MadeCodec makeVoluteCodec() {
  return std::make_unique<VoluteCodec>();
}

std::span<const FileCodecEntry> fileCodecs() {
  static constexpr FileCodecEntry kTable[] = {
      {"Volute", makeVoluteCodec},         {"zfp 4D", makeZfp4dCodec},
      {"zfp 3D", makeZfp3dCodec},          {"NanoVDB FpN, zip", makeNanoVdbCodec},
      {"OpenVDB half, zip", makeVdbCodec},
  };
  return kTable;
}

}  // namespace volute::bench
