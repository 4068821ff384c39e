// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_volume.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

#include "volute/gl/gl_part.hpp"
#include "volute/gl/gl_voxels.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/grid/voxel_march.hpp"

namespace volute {
namespace {

constexpr int kSide = BrickSlice::kSide;

ShaderPart settings(int channels, Basis basis) {
  return {
      "volume settings",
      fmt::format(
          "#define M_CHANNELS {}\n#define M_TRILINEAR {}\n#define M_SHADED 0\n#define M_LIT 0\n",
          channels, basis == Basis::kTrilinear ? 1 : 0)};
}

/// The tree and the atlas come after the type of their values and before the march.
std::vector<ShaderPart> volumeParts(int channels, Basis basis, std::vector<ShaderPart> voxels) {
  std::vector<ShaderPart> parts{
      settings(channels, basis),
      {"volume settings",
       "#if M_CHANNELS == 1\n#define M_VALUE float\n#else\n#define M_VALUE vec3\n#endif\n"}};
  std::ranges::move(voxels, std::back_inserter(parts));
  parts.push_back({"volume.glsl", glsl::kVolume});
  return parts;
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

/// The bricks that are not empty, in one 3D texture; channels stand above each other along z.
struct GlVolumeAtlas {
  GlBricks bricks;
  GlTexture atlas;
  int channels = 1;
  Basis basis = Basis::kBox;
};

Result<GlVolumeAtlas> makeVolumeAtlas(const BrickSlice& slice) {
  const CellGrid cells = cellsOf(slice.bounds(), {slice.x(), slice.y(), slice.z()}, slice.basis());
  // The march grid holds on to the slice only while the atlas is made of it.
  const std::shared_ptr<const BrickSlice> alias(std::shared_ptr<void>(), &slice);
  const auto grid = makeMarchGrid(alias, cells, 0, 0);
  if (!grid->fits)
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "a volume of more than 8 GiB is not rendered by OpenGL");
  GlVolumeAtlas made;
  made.channels = slice.channels(), made.basis = slice.basis();
  const int side = grid->trilinear ? kSide + 1 : kSide;
  VOLUTE_ASSIGN(made.bricks, makeGlBricks(cells, side, side * made.channels, *grid));
  made.atlas = made.bricks.makeAtlas(GL_R32F);
  fillAtlas<float>(made.bricks, made.atlas, GL_RED, GL_FLOAT, [&](std::size_t b) {
    return grid->values + b * static_cast<std::size_t>(grid->brickStride);
  });
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
    return volumeParts(
        atlas_->channels, atlas_->basis,
        {{"volume_table.glsl", glsl::kVolumeTable}, {"volume_atlas.glsl", glsl::kVolumeAtlas}});
  }

  GlMediumTraits traits() const override {
    return traitsOf(atlas_->channels, atlas_->basis, volume_.emission, volume_.extinction);
  }

  GlNeeds needs() const override {
    return {.textures = 2,
            .cells = atlas_->bricks.mostCells,
            .roundsPerCell = atlas_->basis == Basis::kBox ? 5.0 : 12.1};
  }

  Box3 bounds() const override {
    return turnedBounds(atlas_->bricks.cells, volume_.turn, volume_.offset);
  }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    bindCells(program, prefix, view.origin, atlas_->bricks.cells, atlas_->bricks.range,
              volume_.emission, volume_.extinction, volume_.turn, volume_.offset);
    atlas_->bricks.bind(program, prefix, bindings);
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
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "a tree of {} MiB does not fit in the graphics device's buffers of {} MiB; render "
                "fewer frames",
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
                       {{"volume_tree.glsl", glsl::kVolumeTree}});
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
