// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fds.hpp"

#include <algorithm>
#include <bit>

#include "volute/gl/gl_lamps.hpp"
#include "volute/gl/gl_part.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

/// What fds.glsl reads, one array after the other.
class FdsWords {
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
    words += 9 + lattice.valueCount() + lattice.cellCount() / 32 + 1;
  }
  return words;
}

/// What a field's arrays are known by.
std::vector<const void*> identityOf(const FdsField& field) {
  std::vector<const void*> identity{&field.grid()};
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    identity.push_back(&field.values(i));
    identity.push_back(&field.cells(i));
  }
  return identity;
}

/// A field's arrays, one after the other.
struct GlFdsData {
  explicit GlFdsData(const FdsField& of) : field(of), middle(of.bounds().centre()) {
    const FdsGrid& grid = field.grid();
    FdsWords all;
    for (int axis = 0; axis < 3; ++axis) {
      partCount[axis] = static_cast<int>(grid.partPlanes()[axis].size()) - 1;
      partPlanes[axis] = all.addPlanes(grid.partPlanes()[axis], middle[axis]);
    }
    table = all.size();
    for (const std::int32_t lattice : grid.parts()) all.add(lattice);
    FdsWords records;
    for (std::size_t i = 0; i < grid.lattices().size(); ++i) {
      const FdsLattice& lattice = grid.lattices()[i];
      for (int axis = 0; axis < 3; ++axis)
        records.add(all.addPlanes(lattice.planes[axis], middle[axis]));
      for (int axis = 0; axis < 3; ++axis) records.add(lattice.cells(axis));
      records.add(all.add(field.values(i).value));
      records.add(all.addGas(field.cells(i)));
      records.add(lattice.nodal ? 1 : 0);
      nodal = nodal || lattice.nodal;
    }
    lattices = all.size();
    for (const std::uint32_t word : records.words()) all.add(std::bit_cast<std::int32_t>(word));
    words = makeBuffer(all.words());
  }

  FdsField field;  ///< so that no other one's arrays get its addresses
  Vec3 middle;
  bool nodal = false;
  std::array<int, 3> partCount{}, partPlanes{};
  int table = 0, lattices = 0;
  GlBuffer words;
};

constexpr double kFdsRoundsPerCell = 12;

/// That one ray may pass: as if the narrowest were everywhere.
double maxCells(const FdsField& field) {
  Vec3 narrowest = field.bounds().size();
  for (const FdsLattice& lattice : field.grid().lattices()) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& planes = lattice.planes[axis];
      for (std::size_t i = 1; i < planes.size(); ++i)
        narrowest[axis] = std::min(narrowest[axis], planes[i] - planes[i - 1]);
    }
  }
  return field.bounds().size().cwiseQuotient(narrowest).sum();
}

class FdsOnDevice final : public GlMedium {
 public:
  FdsOnDevice(const GlFds& fds, std::shared_ptr<const GlFdsData> data, GlLamps lamps)
      : fds_(fds), data_(std::move(data)), lamps_(std::move(lamps)) {}

  std::string key() const override { return "fds " + lamps_.key(); }

  std::vector<ShaderPart> parts() const override {
    return {{"light_field.glsl", lamps_.functions()}, {"fds.glsl", glsl::kFds}};
  }

  GlMediumTraits traits() const override {
    GlMediumTraits traits;
    traits.constant = !data_->nodal && !lamps_.any();
    traits.absorbs = !fds_.glow;
    traits.points = lamps_.any() ? 4 : data_->nodal ? 2 : 1;
    if (!lamps_.any() && !fds_.glow)
      traits.color = fds_.field.source();
    return traits;
  }

  GlNeeds needs() const override {
    GlNeeds needs = lamps_.needs();
    needs.storage += 1;
    needs.cells += maxCells(data_->field);
    needs.roundsPerCell += kFdsRoundsPerCell;
    return needs;
  }

  Box3 bounds() const override { return data_->field.bounds(); }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    const auto name = [&](const char* rest) { return prefix + rest; };
    const Rgb sent = fds_.glow ? *fds_.glow : Rgb(fds_.scale * fds_.field.source());
    program.set(name("origin").c_str(), Vec3(view.origin - data_->middle));
    program.set(name("partCount").c_str(), data_->partCount);
    program.set(name("partPlanes").c_str(), data_->partPlanes);
    program.set(name("table").c_str(), data_->table);
    program.set(name("lattices").c_str(), data_->lattices);
    program.set(name("extinction").c_str(), fds_.glow ? 0.0F : static_cast<float>(fds_.scale));
    program.set(name("source").c_str(), Vec3(sent));
    program.bindStorage(name("Words").c_str(), bindings.storage++, data_->words);
    lamps_.bind(program, prefix, view.origin, bindings);
  }

 private:
  GlFds fds_;
  std::shared_ptr<const GlFdsData> data_;
  GlLamps lamps_;
};

/// kTooLarge where it does not fit into one of the device's buffers.
Result<GlFdsData> makeFdsData(const FdsField& field) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  const std::size_t bytes = 4 * wordsOf(field);
  if (std::cmp_greater(bytes, most)) {
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "an FDS case of {} MiB does not fit in the graphics device's buffers of {} MiB",
                bytes >> 20, most >> 20);
  }
  return GlFdsData(field);
}

class FdsPart final : public GlPart {
 public:
  explicit FdsPart(GlFds fds) : fds_(std::move(fds)) {}

  std::string name() const override { return fds_.glow ? "fire" : "FDS smoke"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    const auto held = std::make_shared<const FdsField>(fds_.field);
    const std::shared_ptr<const void> source(held, &held->values(0));
    // The same lattices with the same values.
    const auto holds = [&](const GlFdsData& made) {
      return identityOf(made.field) == identityOf(fds_.field);
    };
    VOLUTE_ASSIGN(auto data, picture.resources.upload<GlFdsData>(
                                 source, name(), [&] { return makeFdsData(fds_.field); }, holds));
    GlLamps lamps;
    if (fds_.lit) {
      VOLUTE_ASSIGN(lamps, GlLamps::make(fds_.lit, fds_.surfaces, name(), picture.resources));
    }
    return std::make_unique<FdsOnDevice>(fds_, std::move(data), std::move(lamps));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlFds fds = fds_;
    if (!fds.glow)
      fds.scale *= factor;
    return glPart(std::move(fds));
  }

 private:
  GlFds fds_;
};

}  // namespace

std::shared_ptr<const GlPart> glPart(GlFds fds) {
  return std::make_shared<FdsPart>(std::move(fds));
}

}  // namespace volute
