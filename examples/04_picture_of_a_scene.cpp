// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Opens a file of any kind that Volute shows, or a scene, and writes a picture of it at a time:
//   example_04 fire.volute 0.4 fire.png

#include <fmt/format.h>

#include <cstdlib>

#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/reader_helper.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace {

/// Prints Volute's remarks.
class Remarks final : public volute::Progress {
  void remark(const volute::Remark& remark) override {
    fmt::print(stderr, "{}\n", remark.sentence);
  }
};

volute::Status takePicture(const char* file, double time, const char* picture) {
  Remarks progress;
  VOLUTE_ASSIGN(auto scene, volute::Scene::open(file, {}, progress));
  fmt::print("{}: {}, {} stored times\n", file, scene.media().front()->info().size,
             scene.times().size());

  const auto camera = scene.camera() ? volute::makeCamera(*scene.camera(), {320, 240})
                                     : volute::Camera::framing(scene.bounds(), 320, 240);

  // The scene at one time, for this view: walls in the way may be left out. It is immutable: other
  // threads may render it, too.
  VOLUTE_ASSIGN(
      const auto snapshot,
      scene.at({.time = time, .factor = scene.law().factor(), .eye = volute::seenFrom(camera)},
               progress));

  volute::CpuRenderer renderer;
  VOLUTE_ASSIGN(const auto image,
                renderer.render(snapshot, camera, {.background = snapshot.background}, progress));
  return volute::writeImage(picture, volute::exposed(image, volute::suggestExposure(image)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: {} FILE TIME PICTURE.png\n", argv[0]);
    return 2;
  }
  // From now on, files of other programs are read in a confined process.
  const volute::ReaderHelper helper;
  if (const auto done = takePicture(argv[1], std::atof(argv[2]), argv[3]); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
