// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/project.hpp"

#include <algorithm>
#include <memory>

#include "volute/base/assert.hpp"
#include "volute/tomography/projector.hpp"

namespace volute {

Image projectVolume(std::span<const float> volume, const VolumeGeometry& geometry, Basis basis,
                    const Camera& camera, int raysPerPixel) {
  VOLUTE_ASSERT(volume.size() == 3 * geometry.voxels());
  std::vector<std::uint8_t> filled(geometry.voxels());
  for (std::size_t i = 0; i < filled.size(); ++i)
    filled[i] = volume[3 * i] != 0 || volume[3 * i + 1] != 0 || volume[3 * i + 2] != 0;
  const auto support = std::make_shared<const Support>(geometry, basis, filled);
  std::vector<float> unknowns(4 * support->size());
  for (std::size_t i = 0; i < support->size(); ++i)
    std::copy_n(&volume[3 * static_cast<std::size_t>(support->voxels()[i])], 3, &unknowns[4 * i]);
  const ProjectorView view{&camera, {}};
  const Projector projector({&view, 1}, support, raysPerPixel, 0);
  std::vector<float> sums(4 * projector.rows());
  projector.forward(unknowns, sums);
  Image image(camera.width(), camera.height());
  for (std::size_t row = 0; row < projector.rows(); ++row)
    std::copy_n(&sums[4 * row], 3,
                &image.pixels[3 * static_cast<std::size_t>(projector.pixels()[row].pixel)]);
  return image;
}

Image asSeenBy(const TomographyView& view, Image inColour) {
  for (std::size_t i = 0; view.grey && i + 2 < inColour.pixels.size(); i += 3) {
    float* light = &inColour.pixels[i];
    std::fill_n(light, 3, (light[0] + light[1] + light[2]) / 3);
  }
  return inColour;
}

}  // namespace volute
