// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "volute/fds/fortran_file.hpp"
#include "volute/fds/frame_times.hpp"
#include "volute/fds/smv_index.hpp"

namespace volute {

/// Particles of one class in one mesh at one time.
struct FdsParticles {
  std::vector<std::array<float, 3>> places;  ///< [m], finite
  std::vector<std::vector<float>> values;    ///< of each quantity of the class, one a particle
  std::vector<std::int32_t> numbers;         ///< of people, which stay with them
};

/// .prt5: where particles are (FDS User's Guide, "Lagrangian Particles" among the formats of
/// output files). Record markers are checked when it is opened, places when they are read.
class FdsParticleFile {
 public:
  /// The file must have as many classes as the index says.
  [[nodiscard]] static Result<FdsParticleFile> open(const FdsParticleEntry& entry);

  /// People of FDS+Evac (DUMP_EVAC in its evac.f90): their places are followed by the body's angle,
  /// diameters and height, which are not read. kInvalidData for other particles.
  [[nodiscard]] static Result<FdsParticleFile> openPeople(const std::filesystem::path& path);

  const FdsFrameIndex& frames() const { return frames_; }

  std::size_t classes() const { return quantities_.size(); }

  /// What is stored of a class besides its places.
  const std::vector<FdsLabels>& quantitiesOf(std::size_t one) const { return quantities_[one]; }

  /// How many particles of all classes a frame has.
  std::uint64_t count(std::size_t frame) const { return counts_[frame]; }

  /// Of each class; kInvalidData for a place that is not finite.
  [[nodiscard]] Result<std::vector<FdsParticles>> readFrame(std::size_t frame) const;

 private:
  explicit FdsParticleFile(FortranFile file) : file_(std::move(file)) {}

  Result<std::uint64_t> readHeader(std::int64_t least, std::int64_t most);
  Status findFrames(std::uint64_t offset);
  Status readClass(std::uint64_t& offset, std::size_t one, std::size_t frame, FdsParticles* into,
                   std::uint64_t& count) const;

  FortranFile file_;
  std::uint64_t floats_ = 3;                        // of a particle's place
  std::vector<std::vector<FdsLabels>> quantities_;  // of each class
  FdsFrameIndex frames_;
  std::vector<std::uint64_t> counts_;  // of each frame
};

}  // namespace volute
