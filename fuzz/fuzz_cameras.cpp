// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/capture/open_capture.hpp"

// An input is the kind, a line, and its files: "json" and "opencv" one, "colmap" cameras.txt and
// images.txt, "colmap-binary" cameras.bin and images.bin, with a line "%%" between them. Errors are
// fine; cameras whose numbers are none are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("cameras");
  std::string_view rest = volute::fuzz::textOf(data, size);
  const std::size_t line = rest.find('\n');
  if (line == rest.npos)
    return 0;
  const std::string_view kind = rest.substr(0, line);
  rest.remove_prefix(line + 1);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    std::filesystem::remove(entry.path());
  std::filesystem::path file = folder.path();
  if (kind == "json") {
    file = folder.save("a.json", rest);
  } else if (kind == "opencv") {
    file = folder.save("a.yml", rest);
  } else {
    const bool text = kind == "colmap";
    folder.save(text ? "cameras.txt" : "cameras.bin", volute::fuzz::nextPart(rest));
    folder.save(text ? "images.txt" : "images.bin", volute::fuzz::nextPart(rest));
  }
  (void)volute::openCalibration(file, {});
  return 0;
}
