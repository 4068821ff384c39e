// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "fuzz/input_folder.hpp"
#include "volute/fds/geometry_file.hpp"
#include "volute/fds/iso_file.hpp"
#include "volute/fds/particle_file.hpp"

// An input is an .iso, a .ge, and a .prt5 file with two classes of particles, the same bytes for
// all. Errors are fine; places outside of the mesh, or triangles of vertices that are not there,
// are not.

namespace {

using volute::fuzz::require;

void lookAtSurfaces(const volute::FdsIsoFile& iso, const volute::FdsMesh& mesh) {
  const std::size_t frames = iso.frames().times.size();
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = iso.readFrame(i);
    if (!frame)
      continue;
    require(frame->levels.size() == frame->triangles.size());
    for (const auto& [x, y, z] : frame->vertices)
      require((volute::Vec3(x, y, z) - mesh.bounds().centre()).norm() < 10);
    for (const auto& triangle : frame->triangles) {
      for (const auto corner : triangle)
        require(static_cast<std::size_t>(corner) < frame->vertices.size());
    }
    for (const auto level : frame->levels)
      require(static_cast<std::size_t>(level) < iso.levels().size());
  }
}

void lookAtWalls(const volute::FdsGeometry& walls) {
  require(walls.surfaces.size() == walls.triangles.size());
  for (const auto& triangle : walls.triangles) {
    for (const auto corner : triangle)
      require(static_cast<std::size_t>(corner) < walls.vertices.size());
  }
}

void lookAtParticles(const volute::FdsParticleFile& file) {
  const std::size_t frames = file.frames().times.size();
  for (std::size_t i = 0; i < frames; ++i) {
    const auto classes = file.readFrame(i);
    if (!classes)
      continue;
    std::uint64_t count = 0;
    for (std::size_t one = 0; one < classes->size(); ++one) {
      const volute::FdsParticles& particles = (*classes)[one];
      count += particles.places.size();
      for (const auto& place : particles.places) require(std::isfinite(place[0] + 0 * place[2]));
      if (particles.places.empty())
        continue;
      require(particles.values.size() == file.quantitiesOf(one).size());
      for (const auto& values : particles.values) require(values.size() == particles.places.size());
    }
    require(count == file.count(i));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("fds_stored");
  static const volute::FdsMesh mesh = [] {
    volute::FdsMesh made;
    made.planes = {{{0, 0.5, 1}, {0, 0.5, 1}, {0, 0.5, 1}}};
    return made;
  }();
  const auto path = folder.save("a", volute::fuzz::textOf(data, size));
  if (const auto iso = volute::FdsIsoFile::open({0, path, {}}, mesh))
    lookAtSurfaces(*iso, mesh);
  if (const auto walls = volute::readGeometryFile(path))
    lookAtWalls(*walls);
  if (const auto particles = volute::FdsParticleFile::open({0, {0, 1}, path}))
    lookAtParticles(*particles);
  if (const auto people = volute::FdsParticleFile::openPeople(path))
    lookAtParticles(*people);
  return 0;
}
