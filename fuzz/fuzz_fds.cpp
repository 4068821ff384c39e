// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>

#include "volute/base/parallel.hpp"
#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_case.hpp"

// An input is four lengths (u16, little endian) and as many files: case.smv, a.sf, a.s3d, and
// a.s3d.sz. The third is also a.q, a PLOT3D file, for indices that name one.

namespace {

constexpr int kColumns = 16;  // of the raster on which buildings are understood: 200 take 0.1 s
constexpr const char* kNames[] = {"case.smv", "a.sf", "a.s3d", "a.s3d.sz"};

const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const std::filesystem::path memory = "/dev/shm";
    auto made =
        (std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path()) /
        ("volute-fuzz-fds-" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] { std::filesystem::remove_all(folder()); });
    return made;
  }();
  return path;
}

void save(const char* name, std::span<const std::uint8_t> bytes) {
  std::ofstream(folder() / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

void saveFiles(std::span<const std::uint8_t> data) {
  std::size_t place = 8;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t wanted = data[2 * i] + 256U * data[2 * i + 1];
    const std::size_t length = std::min(wanted, data.size() - place);
    save(kNames[i], data.subspan(place, length));
    if (i == 2)
      save("a.q", data.subspan(place, length));
    place += length;
  }
}

void require(bool holds) {
  if (!holds)
    std::abort();
}

// Errors are fine; crashes, hangs and depths that are no numbers are not.
void look(volute::FdsCase& opened, double time) {
  const auto field = opened.field(time);
  if (!field)
    return;
  const volute::Box3 box = field->bounds();
  const double length = box.size().norm();
  if (!std::isfinite(length))
    return;
  const volute::Segment line{box.min, box.size() / length, 0, length};
  volute::FdsDepth depth;
  field->depths({&line, 1}, {&depth, 1});
  require(std::isfinite(depth.value) && depth.value >= 0 && !std::isnan(depth.high));
  require(depth.low <= depth.value * (1 + 1e-9) && depth.value <= depth.high * (1 + 1e-9));
  (void)opened.obstructions(time).blocked(line);
  (void)volute::FdsBuilding(opened.index(), time, kColumns).quads();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::ThreadLimit limit(1);
  if (size < 8)
    return 0;
  saveFiles({data, size});
  for (const char* source : {"", "s3d", "plot3d-extinction"}) {
    volute::FdsOptions options;
    options.source = source;
    options.maxMemory = std::uint64_t{32} << 20;
    auto opened = volute::FdsCase::open(folder() / kNames[0], options);
    if (!opened)
      continue;
    look(*opened, opened->times().front());
    look(*opened, 0.5 * (opened->times().front() + opened->times().back()));
  }
  return 0;
}
