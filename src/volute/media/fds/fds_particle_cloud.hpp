// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "volute/fds/particle_file.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/io/reading.hpp"

namespace volute {

/// Particles of an FDS case as opaque marks: droplets, tracers.
class FdsParticleCloud {
 public:
  /// @param which  "all", a class as the case names it, or a quantity that is stored of particles,
  ///               whose values are their colours (viridis). kNotFound with what there is.
  [[nodiscard]] static Result<FdsParticleCloud> open(const SmvIndex& index,
                                                     const std::string& which, Reading& reading);

  /// Adds an octahedron for each, at the stored time that is nearest to `time` [s]. Of more than
  /// 100,000 every second, third ... is shown.
  [[nodiscard]] Status addTo(TriangleMesh& mesh, double time) const;

  /// A number for what addTo() adds: while it stays, so do they.
  std::uint64_t frameAt(double time) const;

  /// The lowest and highest value of the colours, or null where a class's colour is its own.
  const std::array<double, 2>* range() const { return quantity_.empty() ? nullptr : &range_; }

  /// For people: what is shown.
  std::string words() const;

 private:
  struct Part {
    std::shared_ptr<const FdsParticleFile> file;
    std::vector<int> classes;   // of the file's, which are shown; places in colours_
    std::vector<int> inFile;    // the same, their places in the file
    std::vector<int> quantity;  // of each of these, the place of quantity_
  };

  FdsParticleCloud() = default;

  Status findRange(Reading& reading);
  std::uint64_t countAt(double time) const;

  std::vector<Part> parts_;
  std::vector<Rgb> colours_;        // of the case's classes, linear
  std::vector<std::string> names_;  // of the classes that are shown
  std::string quantity_, unit_;     // of the colours; empty: each class has its own
  std::array<double, 2> range_{};
  double size_ = 0.01;  // [m], from the middle of a mark to its corners
};

}  // namespace volute
