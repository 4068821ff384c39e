// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Peers that Debian does not have, built from their sources when a benchmark wants them: a library
// of two C functions for each, bench/peers/NAME.cpp.
#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "bench/file_codec.hpp"
#include "bench/scratch.hpp"

namespace volute::bench {
namespace {

namespace fs = std::filesystem;

// As bench/peers/peer.hpp declares them.
using Encode = std::size_t (*)(const float* values, const std::size_t* sides, double tolerance,
                               unsigned char** bytes);
using Decode = int (*)(const unsigned char* bytes, std::size_t size, const std::size_t* sides,
                       float* values);

class SourceCodec final : public FileCodec {
 public:
  SourceCodec(std::string name, bool byFrames, Encode encode, Decode decode)
      : name_(std::move(name)), byFrames_(byFrames), encode_(encode), decode_(decode) {}

  Setting setting() const override { return Setting::kTolerance; }

  Result<float> encode(const Sequence& sequence, double setting,
                       const fs::path& folder) const override {
    VOLUTE_TRY(forEachFile(sequence.info, 0, sequence.info.frames, [&](int c, int t) -> Status {
      const std::vector<float> values = channelOf(sequence.info, sequence.values, c, t);
      unsigned char* bytes = nullptr;
      const std::size_t size =
          encode_(values.data(), sidesOf(sequence.info).data(), setting, &bytes);
      if (size == 0)
        return fail(ErrorCode::kUnsupported, "{} cannot encode with a tolerance of {}", name_,
                    setting);
      const Status written =
          writeScratch(file(folder, c, t), {reinterpret_cast<std::byte*>(bytes), size});
      std::free(bytes);
      return written;
    }));
    return 1.0f;
  }

  Status decode(const VolumeInfo& info, const fs::path& folder,
                std::span<float> values) const override {
    return decodeFrames(info, folder, 0, info.frames, values);
  }

  Status decodePart(const VolumeInfo& info, const fs::path& folder, const BlockGrid::Index4& begin,
                    const BlockGrid::Index4& end, std::span<float> values) const override {
    if (!byFrames_)
      return FileCodec::decodePart(info, folder, begin, end, values);
    std::vector<float> frames(static_cast<std::size_t>(end[0] - begin[0]) * info.frameValues());
    VOLUTE_TRY(decodeFrames(info, folder, begin[0], end[0], frames));
    copyPart(info, frames, begin[0], begin, end, values);
    return {};
  }

 private:
  /// Of an array of a file: t, z, y, x.
  std::array<std::size_t, 4> sidesOf(const VolumeInfo& info) const {
    return {static_cast<std::size_t>(byFrames_ ? 1 : info.frames), static_cast<std::size_t>(info.z),
            static_cast<std::size_t>(info.y), static_cast<std::size_t>(info.x)};
  }

  static fs::path file(const fs::path& folder, int channel, int frame) {
    return folder / fmt::format("{}_{:04}.peer", channel, frame);
  }

  template <class Work>
  Status forEachFile(const VolumeInfo& info, int first, int end, Work&& work) const {
    for (int c = 0; c < info.channels; ++c)
      for (int t = first; t < (byFrames_ ? end : first + 1); ++t) VOLUTE_TRY(work(c, t));
    return {};
  }

  /// What a file holds: a channel, of all frames or of one.
  std::vector<float> channelOf(const VolumeInfo& info, std::span<const float> all, int channel,
                               int frame) const {
    const std::size_t count = byFrames_ ? info.frameValues() : info.values();
    const auto part = all.subspan(byFrames_ ? frame * info.frameValues() : 0, count);
    std::vector<float> values;
    values.reserve(count / static_cast<std::size_t>(info.channels));
    for (auto i = static_cast<std::size_t>(channel); i < count;
         i += static_cast<std::size_t>(info.channels))
      values.push_back(part[i]);
    return values;
  }

  Status decodeFrames(const VolumeInfo& info, const fs::path& folder, int first, int end,
                      std::span<float> values) const {
    const auto channels = static_cast<std::size_t>(info.channels);
    return forEachFile(info, first, end, [&](int c, int t) -> Status {
      VOLUTE_ASSIGN(const auto bytes, readScratch(file(folder, c, t)));
      const std::size_t begin = byFrames_ ? (t - first) * info.frameValues() : 0;
      const std::size_t count = (byFrames_ ? info.frameValues() : info.values()) / channels;
      std::vector<float> room(channels == 1 ? 0 : count);
      float* to = channels == 1 ? &values[begin] : room.data();
      if (decode_(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                  sidesOf(info).data(), to) != 0)
        return fail(ErrorCode::kInvalidData, "{} cannot read back what it wrote", name_);
      for (std::size_t i = 0; i < room.size(); ++i)
        values[begin + i * channels + static_cast<std::size_t>(c)] = room[i];
      return {};
    });
  }

  std::string name_;
  bool byFrames_;
  Encode encode_;
  Decode decode_;
};

/// For a shell.
std::string quoted(const fs::path& path) {
  std::string text = "'";
  for (const char c : path.string()) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::span<const SourceCodecEntry> sourceCodecs() {
  static constexpr SourceCodecEntry kTable[] = {
      {"SZ3", "-I include -lzstd", false},
      {"SPERR", "-DUSE_VANILLA_CONFIG -DSPERR_VERSION_MAJOR=0 -I include src/*.cpp", true},
  };
  return kTable;
}

MadeCodec makeSourceCodec(const SourceCodecEntry& entry, const fs::path& sources,
                          const fs::path& scratch) {
  const fs::path own = sources / entry.name;
  std::error_code ignored;
  if (!fs::is_directory(own, ignored)) {
    return fail(ErrorCode::kNotFound,
                "{}: there is no folder {}; expected the peer's sources in it", sources.string(),
                entry.name);
  }
  const fs::path library = scratch / fmt::format("{}.so", entry.name);
  const fs::path said = scratch / fmt::format("{}.txt", entry.name);
  const fs::path adapter = fs::path(VOLUTE_BENCH_PEERS) / fmt::format("{}.cpp", entry.name);
  const std::string command = fmt::format(
      "cd {} && c++ -std=c++20 -O3 -march=native -w -fPIC -shared -I {} {} {} -o {} > {} 2>&1",
      quoted(fs::absolute(own)), quoted(VOLUTE_BENCH_PEERS), quoted(adapter), entry.build,
      quoted(library), quoted(said));
  if (std::system(command.c_str()) != 0) {
    std::ifstream stream(said);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t at = text.find("error");
    return fail(ErrorCode::kUnsupported, "{} cannot be built from {}: {}", entry.name, own.string(),
                text.substr(at == std::string::npos ? 0 : at, 200));
  }
  void* handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  const auto encode =
      handle ? reinterpret_cast<Encode>(::dlsym(handle, "volute_peer_encode")) : nullptr;
  const auto decode =
      handle ? reinterpret_cast<Decode>(::dlsym(handle, "volute_peer_decode")) : nullptr;
  if (!encode || !decode)
    return fail(ErrorCode::kUnsupported, "{} was built and cannot be loaded", entry.name);
  return std::make_unique<SourceCodec>(std::string(entry.name), entry.byFrames, encode, decode);
}

}  // namespace volute::bench
