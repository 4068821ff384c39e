// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::vector<std::uint8_t> bytesOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Of a file that tools/corpus.py made: the length of each input, and its bytes.
bool replayPack(const std::vector<std::uint8_t>& pack, int& inputs) {
  for (std::size_t at = 0; at < pack.size(); ++inputs) {
    std::size_t length = 0;
    if (pack.size() - at < 4)
      return false;
    for (int i = 3; i >= 0; --i) length = 256 * length + pack[at + static_cast<std::size_t>(i)];
    at += 4;
    if (pack.size() - at < length)
      return false;
    // A copy, so that reading past its end is seen by sanitizers.
    const auto begin = pack.begin() + static_cast<std::ptrdiff_t>(at);
    const std::vector<std::uint8_t> input(begin, begin + static_cast<std::ptrdiff_t>(length));
    LLVMFuzzerTestOneInput(input.data(), input.size());
    at += length;
  }
  return true;
}

}  // namespace

/// Feeds every file of the folder argv[1], and all inputs of argv[1].pack where there is one, to a
/// fuzz target, in a build without a fuzzer.
int main(int argc, char** argv) {
  if (argc != 2)
    return 2;
  int inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    const auto bytes = bytesOf(entry.path());
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    ++inputs;
  }
  const bool whole = replayPack(bytesOf(std::string(argv[1]) + ".pack"), inputs);
  std::printf("%d inputs\n", inputs);
  if (!whole)
    std::fprintf(stderr, "%s.pack is cut off\n", argv[1]);
  return whole && inputs > 0 ? 0 : 1;
}
