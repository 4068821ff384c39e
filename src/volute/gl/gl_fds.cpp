// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <bit>

#include "volute/gl/gl_medium.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

/// What fds.glsl reads, one array after the other.
class Words {
 public:
  int size() const { return static_cast<int>(words_.size()); }

  void add(std::int32_t value) { words_.push_back(std::bit_cast<std::uint32_t>(value)); }

  void add(float value) { words_.push_back(std::bit_cast<std::uint32_t>(value)); }

  /// Where they begin.
  int add(std::span<const float> values) {
    const int begin = size();
    for (const float value : values) add(value);
    return begin;
  }

  /// Places on an axis, from `middle` [m].
  int addPlanes(const std::vector<double>& planes, double middle) {
    const int begin = size();
    for (const double plane : planes) add(static_cast<float>(plane - middle));
    return begin;
  }

  /// A bit for each cell: it is gas.
  int addGas(const std::vector<FdsCell>& cells) {
    const int begin = size();
    words_.resize(words_.size() + (cells.size() + 31) / 32);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i] == FdsCell::kGas)
        words_[begin + i / 32] |= std::uint32_t{1} << (i % 32);
    }
    return begin;
  }

  std::span<const std::uint32_t> words() const { return words_; }

 private:
  std::vector<std::uint32_t> words_;
};

/// An upper bound of the words of a field.
std::size_t wordsOf(const FdsField& field) {
  std::size_t words = field.grid().parts().size();
  for (const auto& planes : field.grid().partPlanes()) words += planes.size();
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    const FdsLattice& lattice = field.grid().lattices()[i];
    for (const auto& planes : lattice.planes) words += planes.size();
    words += 10 + lattice.valueCount() + lattice.cellCount() / 32 + 1;
    if (field.light(i))
      words += field.light(i)->size();
  }
  return words;
}

class FdsOnDevice final : public GlMedium {
 public:
  explicit FdsOnDevice(const GlFds& fds)
      : fds_(fds), middle_(fds.field.bounds().centre()), lit_(!fds.glow && fds.field.light(0)) {
    const FdsGrid& grid = fds.field.grid();
    Words words;
    for (int axis = 0; axis < 3; ++axis) {
      partCount_[axis] = static_cast<int>(grid.partPlanes()[axis].size()) - 1;
      partPlanes_[axis] = words.addPlanes(grid.partPlanes()[axis], middle_[axis]);
    }
    table_ = words.size();
    for (const std::int32_t lattice : grid.parts()) words.add(lattice);
    Words records;
    for (std::size_t i = 0; i < grid.lattices().size(); ++i) {
      const FdsLattice& lattice = grid.lattices()[i];
      for (int axis = 0; axis < 3; ++axis)
        records.add(words.addPlanes(lattice.planes[axis], middle_[axis]));
      for (int axis = 0; axis < 3; ++axis) records.add(lattice.cells(axis));
      records.add(words.add(fds.field.values(i).value));
      records.add(words.addGas(fds.field.cells(i)));
      records.add(lit_ ? words.add(*fds.field.light(i)) : 0);
      records.add(lattice.nodal ? 1 : 0);
      nodal_ = nodal_ || lattice.nodal;
    }
    lattices_ = words.size();
    for (const std::uint32_t word : records.words()) words.add(std::bit_cast<std::int32_t>(word));
    words_ = makeBuffer(words.words());
  }

  std::string key() const override { return lit_ ? "fds lit" : "fds"; }

  std::vector<ShaderPart> parts() const override {
    return {{"fds settings", fmt::format("#define M_LIT {}\n", lit_ ? 1 : 0)},
            {"fds.glsl", glsl::kFds}};
  }

  GlNature nature() const override {
    GlNature nature;
    nature.constant = !nodal_ && !lit_;
    nature.absorbs = !fds_.glow;
    nature.points = lit_ ? 4 : nodal_ ? 2 : 1;
    if (!lit_ && !fds_.glow)
      nature.color = fds_.field.source();
    return nature;
  }

  void bind(const GlProgram& program, const std::string& prefix, const Vec3& eye, bool,
            GlBindings& bindings) const override {
    const auto name = [&](const char* rest) { return prefix + rest; };
    const Rgb sent = fds_.glow ? *fds_.glow
                     : lit_    ? Rgb(Rgb::Constant(fds_.scale))
                               : Rgb(fds_.scale * fds_.field.source());
    program.set(name("eye").c_str(), Vec3(eye - middle_));
    program.set(name("partCount").c_str(), partCount_);
    program.set(name("partPlanes").c_str(), partPlanes_);
    program.set(name("table").c_str(), table_);
    program.set(name("lattices").c_str(), lattices_);
    program.set(name("extinction").c_str(), fds_.glow ? 0.0F : static_cast<float>(fds_.scale));
    program.set(name("source").c_str(), Vec3(sent));
    program.bindStorage(name("Words").c_str(), bindings.storage++, words_);
  }

 private:
  GlFds fds_;
  Vec3 middle_;
  bool lit_;
  bool nodal_ = false;
  std::array<int, 3> partCount_{}, partPlanes_{};
  int table_ = 0, lattices_ = 0;
  GlBuffer words_;
};

}  // namespace

Result<std::unique_ptr<GlMedium>> makeGlFds(const GlFds& fds) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  const std::size_t bytes = 4 * wordsOf(fds.field);
  if (std::cmp_greater(bytes, most)) {
    return fail(ErrorCode::kTooLarge,
                "an FDS case of {} MiB does not fit in the graphics device's buffers of {} MiB; "
                "render with --renderer cpu",
                bytes >> 20, most >> 20);
  }
  return std::make_unique<FdsOnDevice>(fds);
}

}  // namespace volute
