// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Compresses a synthetic fire, loads it as a tree, and renders one frame.
#include <fmt/format.h>

#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/render/render.hpp"
#include "volute/synth/synth.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace {

volute::Status pictureOfAFire() {
  volute::Progress progress;
  VOLUTE_ASSIGN(auto source, volute::SyntheticSource::create({.size = 32, .frames = 16}, progress));
  VOLUTE_TRY(volute::compress(*source, "fire.volute", {}, progress));

  VOLUTE_ASSIGN(const auto reader, volute::VoluteReader::open("fire.volute"));
  VOLUTE_ASSIGN(const auto tree, volute::Tree4d::load(reader, {}, progress));
  fmt::print("{} nodes take {} bytes; the volume would take {}\n", tree.nodeCount(),
             tree.memoryBytes(), tree.info().rawBytes());

  const int frame = tree.info().frameAt(0.4);
  const auto slice = std::make_shared<const volute::BrickSlice>(tree.extractSlice(frame));
  const volute::AnyMedium fire(volute::VoxelMedium(slice, /*emission*/ 1.0, /*extinction*/ 0.0));
  const auto camera = volute::Camera::framing(fire.bounds(), 256, 256);
  VOLUTE_ASSIGN(const auto image, volute::render(camera, {&fire, 1}, {}, progress));
  return volute::writeImage("fire.png", volute::exposed(image, volute::suggestExposure(image)));
}

}  // namespace

int main() {
  if (const auto done = pictureOfAFire(); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}
