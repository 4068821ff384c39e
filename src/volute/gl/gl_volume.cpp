// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_volume.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "volute/gl/gl_part.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/grid/voxel_march.hpp"

namespace volute {
namespace {

constexpr int kSide = BrickSlice::kSide;

/// Voxels, or the cells between their centres.
CellGrid cellsOf(const Box3& bounds, const std::array<int, 3>& voxels, Basis basis) {
  const Vec3 voxel = bounds.size().cwiseQuotient(Vec3(voxels[0], voxels[1], voxels[2]));
  if (basis == Basis::kBox)
    return {bounds.min, voxel, voxels};
  return {bounds.min - 0.5 * voxel, voxel, {voxels[0] + 1, voxels[1] + 1, voxels[2] + 1}};
}

/// What both kinds of volume tell the shader.
void bindCells(const GlProgram& program, const std::string& prefix, const Vec3& origin,
               const CellGrid& cells, const CellRange& range, double emission, double extinction,
               const Mat3& turn = Mat3::Identity(), const Vec3& offset = Vec3::Zero()) {
  const auto name = [&](const char* rest) { return prefix + rest; };
  const Vec3 unturned = turn.transpose() * (origin - offset);
  const Vec3 inCells = (unturned - cells.origin).cwiseQuotient(cells.cell);
  program.set(name("origin").c_str(), inCells);
  program.set(name("turn").c_str(), Mat3(turn.transpose()));
  program.set(name("perMetre").c_str(), Vec3(cells.cell.cwiseInverse()));
  program.set(name("lo").c_str(), range.begin);
  program.set(name("hi").c_str(), range.end);
  program.set(name("emission").c_str(), static_cast<float>(emission));
  program.set(name("extinction").c_str(), static_cast<float>(extinction));
}

/// Of cells that are turned, then moved.
Box3 turnedBounds(const CellGrid& cells, const Mat3& turn, const Vec3& offset) {
  const Vec3 size = cells.cell.cwiseProduct(Vec3(cells.count[0], cells.count[1], cells.count[2]));
  Box3 box;
  for (int i = 0; i < 8; ++i) {
    const Vec3 share(i & 1, i >> 1 & 1, i >> 2);
    box.extend(turn * (cells.origin + size.cwiseProduct(share)) + offset);
  }
  return box;
}

ShaderPart settings(int channels, Basis basis) {
  return {"volume settings", fmt::format("#define M_CHANNELS {}\n#define M_TRILINEAR {}\n",
                                         channels, basis == Basis::kTrilinear ? 1 : 0)};
}

/// The tree and the atlas come after the type of their values and before the march.
std::vector<ShaderPart> volumeParts(int channels, Basis basis, ShaderPart voxels) {
  return {settings(channels, basis),
          {"volume settings",
           "#if M_CHANNELS == 1\n#define M_VALUE float\n#else\n#define M_VALUE vec3\n#endif\n"},
          std::move(voxels),
          {"volume.glsl", glsl::kVolume}};
}

GlMediumTraits traitsOf(int channels, Basis basis, double emission, double extinction) {
  GlMediumTraits traits;
  traits.constant = basis == Basis::kBox;
  traits.absorbs = extinction != 0;
  traits.points = traits.constant ? 1 : 2;
  if (channels == 1 && extinction != 0)
    traits.color = Rgb::Constant(emission / extinction);
  return traits;
}

/// The bricks that are not empty, in one 3D texture.
struct GlVolumeAtlas {
  GlTexture bricks, atlas;
  std::array<int, 3> atlasBricks{};
  CellGrid cells;
  CellRange range;
  int channels = 1;
  Basis basis = Basis::kBox;
};

/// How many bricks fit side by side on each axis, for `count` of them.
Result<std::array<int, 3>> arrange(std::int64_t count, int side, int channels) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  const int across = most / side;
  const int up = most / (side * channels);
  const auto cube = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(count))));
  const int x = std::clamp(cube, 1, across);
  const int y = std::clamp<int>(static_cast<int>((count + x - 1) / x), 1, x);
  std::int64_t z = (count + std::int64_t{x} * y - 1) / (std::int64_t{x} * y);
  if (z > up) {
    return fail(
        ErrorCode::kTooLarge,
        "a volume has {} bricks that are not empty, and the graphics device's textures hold "
        "{}; render with --renderer cpu",
        count, std::int64_t{across} * across * up);
  }
  return std::array<int, 3>{x, y, static_cast<int>(std::max<std::int64_t>(z, 1))};
}

/// One layer of bricks of the atlas, shape (height, rows * side, columns * side), from row to row.
void fillLayer(const MarchGrid& grid, std::span<const std::int32_t> begins, int side, int columns,
               int rows, std::vector<float>& layer) {
  const int height = side * grid.channels;  // of a brick, along z
  for (std::size_t b = 0; b < begins.size(); ++b) {
    const std::size_t column = b % columns, row = b / columns;
    const float* from = grid.values + begins[b];
    for (int z = 0; z < height; ++z) {
      for (int y = 0; y < side; ++y, from += side) {
        const std::size_t line = (static_cast<std::size_t>(z) * rows + row) * side + y;
        std::copy_n(from, side, &layer[(line * columns + column) * side]);
      }
    }
  }
}

Result<GlVolumeAtlas> makeVolumeAtlas(const BrickSlice& slice) {
  GlVolumeAtlas made;
  made.channels = slice.channels();
  made.basis = slice.basis();
  made.cells = cellsOf(slice.bounds(), {slice.x(), slice.y(), slice.z()}, slice.basis());
  // The march grid holds on to the slice only while the atlas is made of it.
  const std::shared_ptr<const BrickSlice> alias(std::shared_ptr<void>(), &slice);
  const auto grid = makeMarchGrid(alias, made.cells, 0, 0);
  if (!grid->fits)
    return fail(
        ErrorCode::kTooLarge,
        "a volume of more than 8 GiB is not rendered by OpenGL; render with --renderer cpu");
  const int side = grid->trilinear ? kSide + 1 : kSide;
  std::array<int, 3> count{};
  for (int axis = 0; axis < 3; ++axis) count[axis] = (made.cells.count[axis] + kSide - 1) / kSide;
  made.range = {made.cells.count, {0, 0, 0}};
  std::vector<std::int32_t> numbers, begins;
  for (int z = 0; z < count[2]; ++z) {
    for (int y = 0; y < count[1]; ++y) {
      for (int x = 0; x < count[0]; ++x) {
        const std::int32_t begin =
            grid->table[(z + 1) * grid->tableStride[2] + (y + 1) * grid->tableStride[1] + x + 1];
        numbers.push_back(begin < 0 ? -1 : static_cast<std::int32_t>(begins.size()));
        if (begin < 0)
          continue;
        begins.push_back(begin);
        const std::array<int, 3> brick{x, y, z};
        for (int axis = 0; axis < 3; ++axis) {
          made.range.begin[axis] = std::min(made.range.begin[axis], brick[axis] * kSide);
          made.range.end[axis] = std::max(
              made.range.end[axis], std::min((brick[axis] + 1) * kSide, made.cells.count[axis]));
        }
      }
    }
  }
  const auto stored = static_cast<std::int64_t>(begins.size());
  VOLUTE_ASSIGN(made.atlasBricks, arrange(stored, side, made.channels));
  const auto [columns, rows, layers] = made.atlasBricks;
  const int height = side * made.channels;
  VOLUTE_TRY(checkTextureSize("a volume's table of bricks", count[0], count[1], count[2]));
  made.bricks = makeTexture3d(GL_R32I, count[0], count[1], count[2]);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage3D(made.bricks.name(), 0, 0, 0, 0, count[0], count[1], count[2], GL_RED_INTEGER,
                      GL_INT, numbers.data());
  made.atlas = makeTexture3d(GL_R32F, columns * side, rows * side, layers * height);
  std::vector<float> layer(static_cast<std::size_t>(columns) * side * rows * side * height);
  const std::int64_t perLayer = std::int64_t{columns} * rows;
  for (int z = 0; z < layers; ++z) {
    const std::int64_t from = z * perLayer;
    const std::int64_t to = std::min(stored, from + perLayer);
    if (from >= to)
      break;
    fillLayer(*grid, std::span(begins).subspan(from, to - from), side, columns, rows, layer);
    glTextureSubImage3D(made.atlas.name(), 0, 0, 0, z * height, columns * side, rows * side, height,
                        GL_RED, GL_FLOAT, layer.data());
  }
  return made;
}

class AtlasMedium final : public GlMedium {
 public:
  AtlasMedium(const GlVolume& volume, std::shared_ptr<const GlVolumeAtlas> atlas)
      : volume_(volume), atlas_(std::move(atlas)) {}

  std::string key() const override {
    return fmt::format("atlas {} {}", atlas_->channels, static_cast<int>(atlas_->basis));
  }

  std::vector<ShaderPart> parts() const override {
    return volumeParts(atlas_->channels, atlas_->basis, {"volume_atlas.glsl", glsl::kVolumeAtlas});
  }

  GlMediumTraits traits() const override {
    return traitsOf(atlas_->channels, atlas_->basis, volume_.emission, volume_.extinction);
  }

  GlNeeds needs() const override {
    double cells = 3;
    for (int axis = 0; axis < 3; ++axis)
      cells += atlas_->range.end[axis] - atlas_->range.begin[axis];
    return {
        .textures = 2, .cells = cells, .roundsPerCell = atlas_->basis == Basis::kBox ? 5.0 : 12.1};
  }

  Box3 bounds() const override { return turnedBounds(atlas_->cells, volume_.turn, volume_.offset); }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    bindCells(program, prefix, view.origin, atlas_->cells, atlas_->range, volume_.emission,
              volume_.extinction, volume_.turn, volume_.offset);
    program.set((prefix + "atlasBricks").c_str(), atlas_->atlasBricks);
    program.set((prefix + "bricks").c_str(), bindings.texture);
    glBindTextureUnit(static_cast<GLuint>(bindings.texture++), atlas_->bricks.name());
    program.set((prefix + "atlas").c_str(), bindings.texture);
    glBindTextureUnit(static_cast<GLuint>(bindings.texture++), atlas_->atlas.name());
  }

 private:
  GlVolume volume_;
  std::shared_ptr<const GlVolumeAtlas> atlas_;
};

class VolumePart final : public GlPart {
 public:
  explicit VolumePart(GlVolume volume) : volume_(std::move(volume)) {}

  std::string name() const override { return "volume"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    VOLUTE_ASSIGN(auto atlas, picture.resources.upload<GlVolumeAtlas>(volume_.slice, name(), [&] {
      return makeVolumeAtlas(*volume_.slice);
    }));
    return std::make_unique<AtlasMedium>(volume_, std::move(atlas));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlVolume volume = volume_;
    volume.extinction *= factor;
    return glPart(std::move(volume));
  }

 private:
  GlVolume volume_;
};

/// The arrays of TreeData, one after the other.
struct GlTreeData {
  GlBuffer words;
  std::vector<std::pair<const char*, int>> arrays;  ///< where each begins [words]
  const TreeData* data = nullptr;  ///< for its small numbers; the medium holds the tree
};

/// Appends arrays as they are in memory, each from a whole word on.
class Words {
 public:
  template <class T>
  int add(const std::vector<T>& values) {
    const std::size_t begin = words_.size();
    words_.resize(begin + (values.size() * sizeof(T) + 3) / 4);
    if (!values.empty())
      std::memcpy(words_.data() + begin, values.data(), values.size() * sizeof(T));
    return static_cast<int>(begin);
  }

  const std::vector<std::uint32_t>& words() const { return words_; }

 private:
  std::vector<std::uint32_t> words_;
};

Result<GlTreeData> makeTreeData(const Tree4d& tree) {
  const TreeData& data = tree.data();
  static_assert(sizeof(TreeData::Group) == 8 && sizeof(TreeData::Entry) == 16);
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (static_cast<std::int64_t>(tree.memoryBytes()) > most) {
    return fail(ErrorCode::kTooLarge,
                "a tree of {} MiB does not fit in the graphics device's buffers of {} MiB; render "
                "fewer frames, or with --renderer cpu",
                tree.memoryBytes() >> 20, most >> 20);
  }
  GlTreeData made;
  made.data = &data;
  Words words;
  std::vector<std::int32_t> levels;
  for (const TreeData::Level& level : data.levels) {
    levels.push_back(std::bit_cast<std::int32_t>(level.scale));
    levels.push_back(level.wide ? 1 : 0);
    levels.push_back(level.wide ? words.add(level.wide16) : words.add(level.narrow8));
    levels.push_back(words.add(level.escapeIndex));
    levels.push_back(static_cast<std::int32_t>(level.escapeIndex.size()));
    words.add(level.escapeValue);
  }
  made.arrays = {{"masks", words.add(data.masks)},
                 {"groups", words.add(data.groups)},
                 {"childMasks", words.add(data.childMasks)},
                 {"childBases", words.add(data.childBases)},
                 {"levels", words.add(levels)},
                 {"entries", words.add(data.entries)},
                 {"occupied", words.add(data.occupied)}};
  made.words = makeBuffer(words.words());
  return made;
}

/// The cells that voxels of occupied bricks reach into. (Tree4d::occupiedBox is of the voxels
/// before compression, which leaves small values around them.)
CellRange occupiedCells(const TreeData& data, int frame, const CellGrid& cells, Basis basis) {
  const int reach = basis == Basis::kTrilinear ? 1 : 0;
  CellRange range{cells.count, {0, 0, 0}};
  for (int z = 0; z < data.bricks[0]; ++z) {
    for (int y = 0; y < data.bricks[1]; ++y) {
      for (int x = 0; x < data.bricks[2]; ++x) {
        if (!data.isOccupied(frame, z * kSide, y * kSide, x * kSide))
          continue;
        const std::array<int, 3> brick{x, y, z};
        for (int axis = 0; axis < 3; ++axis) {
          range.begin[axis] = std::min(range.begin[axis], brick[axis] * kSide);
          range.end[axis] = std::max(
              range.end[axis], std::min((brick[axis] + 1) * kSide + reach, cells.count[axis]));
        }
      }
    }
  }
  return range;
}

class TreeMedium final : public GlMedium {
 public:
  TreeMedium(const GlTreeVolume& volume, std::shared_ptr<const GlTreeData> tree)
      : volume_(volume), tree_(std::move(tree)) {}

  std::string key() const override {
    return fmt::format("tree {} {}", tree_->data->channels, static_cast<int>(volume_.basis));
  }

  std::vector<ShaderPart> parts() const override {
    return volumeParts(tree_->data->channels, volume_.basis,
                       {"volume_tree.glsl", glsl::kVolumeTree});
  }

  GlMediumTraits traits() const override {
    return traitsOf(tree_->data->channels, volume_.basis, volume_.emission, volume_.extinction);
  }

  /// The walks take 15 coefficients a node, a node a level.
  GlNeeds needs() const override {
    const TreeData& data = *tree_->data;
    const double cells = 3.0 + data.extents[1] + data.extents[2] + data.extents[3];
    const int corners = volume_.basis == Basis::kTrilinear ? 8 : 1;
    return {.storage = 1, .cells = cells, .roundsPerCell = 16.0 * corners * data.entryLevels};
  }

  Box3 bounds() const override { return turnedBounds(cells(), volume_.turn, volume_.offset); }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    const TreeData& data = *tree_->data;
    const CellRange range = volume_.skip == GlTreeSkip::kNothing
                                ? CellRange{{0, 0, 0}, cells().count}
                                : occupiedCells(data, volume_.frame, cells(), volume_.basis);
    bindCells(program, prefix, view.origin, cells(), range, volume_.emission, volume_.extinction,
              volume_.turn, volume_.offset);
    const auto name = [&](const char* rest) { return prefix + rest; };
    program.set(name("skips").c_str(), volume_.skip == GlTreeSkip::kBricks ? 1 : 0);
    program.set(name("extents").c_str(), data.extents);
    program.set(name("frame").c_str(), volume_.frame);
    program.set(name("entryLevels").c_str(), data.entryLevels);
    program.set(name("entryCounts").c_str(), data.entryCounts);
    program.set(name("brickCounts").c_str(), data.bricks);
    program.set(name("range").c_str(), std::array{data.minimum, data.maximum});
    for (const auto& [array, begin] : tree_->arrays) program.set(name(array).c_str(), begin);
    program.bindStorage(name("Tree").c_str(), bindings.storage++, tree_->words);
  }

 private:
  CellGrid cells() const {
    const auto& extents = tree_->data->extents;
    return cellsOf(volume_.bounds, {extents[3], extents[2], extents[1]}, volume_.basis);
  }

  GlTreeVolume volume_;
  std::shared_ptr<const GlTreeData> tree_;
};

class TreePart final : public GlPart {
 public:
  explicit TreePart(GlTreeVolume volume) : volume_(std::move(volume)) {}

  std::string name() const override { return "tree"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    VOLUTE_ASSIGN(auto tree, picture.resources.upload<GlTreeData>(volume_.tree, name(), [&] {
      return makeTreeData(*volume_.tree);
    }));
    return std::make_unique<TreeMedium>(volume_, std::move(tree));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlTreeVolume volume = volume_;
    volume.extinction *= factor;
    return glPart(std::move(volume));
  }

 private:
  GlTreeVolume volume_;
};

}  // namespace

std::shared_ptr<const GlPart> glPart(GlVolume volume) {
  return std::make_shared<VolumePart>(std::move(volume));
}

std::shared_ptr<const GlPart> glPart(GlTreeVolume volume) {
  return std::make_shared<TreePart>(std::move(volume));
}

}  // namespace volute
