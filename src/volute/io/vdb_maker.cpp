// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Writes a cache with every type, class, transform and metadata of OpenVDB, and compares two such
// caches, for tests: volute_vdb_maker make FOLDER; volute_vdb_maker compare A B TOLERANCE;
// volute_vdb_maker extremes FOLDER.
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/PointIndexGrid.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <limits>

namespace {

using namespace openvdb;
using Truncated = points::TypedAttributeArray<int32_t, points::TruncateCodec>;  // OpenVDB does not
                                                                                // know it by itself
using Foreign = Grid<tree::Tree4<float, 4, 3, 2>::Type>;                        // nor this

template <class GridType, class Value>
typename GridType::Ptr puff(const std::string& name, int frame, Value valueAt) {
  auto grid = GridType::create();
  grid->setName(name);
  auto accessor = grid->getAccessor();
  for (int x = -5; x < 9; ++x)
    for (int y = 0; y < 12; ++y)
      for (int z = 3; z < 14 + frame; ++z) {
        if ((x - 2) * (x - 2) + (y - 6) * (y - 6) + (z - 8) * (z - 8) < 36)
          accessor.setValue(Coord(x, y, z), valueAt(x, y, z));
      }
  return grid;
}

template <class T>
void setMeta(MetaMap& map, const std::string& name, const T& value) {
  map.insertMeta(name, TypedMetadata<T>(value));
}

void putMetadata(MetaMap& map, int frame) {
  setMeta(map, "bool", true), setMeta(map, "double", 1.0 / 3), setMeta(map, "float", .1f);
  setMeta(map, "int32", int32_t{-7 - frame}), setMeta(map, "int64", int64_t{1} << 40);
  setMeta(map, "string", std::string("caf\xc3\xa9")), setMeta(map, "long", std::string(20000, 'x'));
  setMeta(map, "vec2i", Vec2i(1, 2)), setMeta(map, "vec2s", Vec2s(1, 2)),
      setMeta(map, "vec2d", Vec2d(1, 2));
  setMeta(map, "vec3i", Vec3i(1, 2, 3)), setMeta(map, "vec3s", Vec3s(1, 2, 3)),
      setMeta(map, "vec3d", Vec3d(1, 2, .3));
  setMeta(map, "vec4i", Vec4i(1, 2, 3, 4)), setMeta(map, "vec4s", Vec4s(1, 2, 3, 4));
  setMeta(map, "vec4d", Vec4d(1, 2, 3, 4)), setMeta(map, "mat4s", math::Mat4s::identity());
  setMeta(map, "mat4d", math::Mat4d::identity());
  UnknownMetadata unknown("somebody's own");
  unknown.setValue({1, 2, 3, 0, 255});
  map.insertMeta("unknown", unknown);
}

void make(const std::filesystem::path& folder, int frame) {
  GridPtrVec grids;
  const auto add = [&](const GridBase::Ptr& grid, GridClass kind = GRID_UNKNOWN) {
    if (kind != GRID_UNKNOWN)
      grid->setGridClass(kind);
    grids.push_back(grid);
    return grid;
  };
  const auto number = [](auto scale) {
    return [scale](int x, int y, int z) {
      return static_cast<decltype(scale)>(scale * (1 + std::abs(x + 2 * y + 3 * z)));
    };
  };
  const auto uniform = math::Transform::createLinearTransform(.25);
  add(puff<Int32Grid>("id", frame, number(int32_t{3})))->setTransform(uniform);
  const auto density = puff<FloatGrid>("density", frame, number(.01f));
  density->tree().addTile(1, Coord(64, 0, 0), .5f, true);
  density->tree().addTile(2, Coord(0, 256, 0), .25f, true);
  add(density, GRID_FOG_VOLUME);
  putMetadata(*density, frame);
  density->setTransform(std::make_shared<math::Transform>(
      std::make_shared<math::UniformScaleTranslateMap>(.25, Vec3d(1, 2, 3))));
  add(puff<FloatGrid>("density", frame, number(.5f)))
      ->setTransform(uniform);  // the same name again
  add(puff<FloatGrid>("density[7]", frame, number(.5f)))->setTransform(uniform);
  add(puff<FloatGrid>("", frame, number(.25f)));
  const auto half = add(puff<FloatGrid>("half", frame, number(.5f)));
  half->setSaveFloatAsHalf(true);
  half->setTransform(
      std::make_shared<math::Transform>(std::make_shared<math::ScaleMap>(Vec3d(.1, .2, .3))));
  add(puff<DoubleGrid>("double", frame, number(.125)))
      ->setTransform(std::make_shared<math::Transform>(
          std::make_shared<math::TranslationMap>(Vec3d(4, 5, 6))));
  add(puff<Int64Grid>("big id", frame, number(int64_t{1} << 40)));
  add(puff<BoolGrid>("burnt", 0, [](int x, int y, int z) { return (x + y + z) % 3 == 0; }));
  add(puff<MaskGrid>("mask", 0, [](int, int, int) { return true; }));
  add(puff<Vec3SGrid>("v", frame,
                      [](int x, int y, int z) { return Vec3s(.1f * x, .1f * y, .1f * z); }),
      GRID_STAGGERED)
      ->setVectorType(VEC_CONTRAVARIANT_RELATIVE);
  add(puff<Vec3DGrid>("vd", frame,
                      [](int x, int y, int z) { return Vec3d(.1 * x, .1 * y, .1 * z); }));
  add(puff<Vec3IGrid>("cell", frame, [](int x, int y, int z) { return Vec3i(x, y, z); }));
  const auto holes = puff<FloatGrid>("holes", frame, number(1.f));
  holes->tree().setValue(Coord(0, 5, 8), std::numeric_limits<float>::quiet_NaN());
  add(holes);
  const auto sphere = tools::createLevelSetSphere<FloatGrid>(4.f, Vec3f(0, 0, 0), .5f);
  sphere->setName("surface");
  add(sphere);
  std::vector<Vec3f> places;
  for (int i = 0; i < 500; ++i)
    places.emplace_back(.01f * (i % 150), .01f * (i % 110), .01f * (i % 70 + frame));
  const auto particles =
      points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(places, *uniform);
  particles->setName("particles");
  add(particles);
  const auto flags =
      points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(places, *uniform);
  points::appendAttribute(flags->tree(), "flag", Truncated::attributeType());
  flags->setName("flags");
  add(flags);
  add(puff<Foreign>("foreign", frame, number(.5f)));
  math::Mat4d turn = math::Mat4d::identity();
  turn.postRotate(math::Z_AXIS, .6);
  turn.postScale(Vec3d(.1, .2, .1));
  turn.postTranslate(Vec3d(frame, 0, 0));
  add(puff<FloatGrid>("turned", frame, number(.5f)))
      ->setTransform(math::Transform::createLinearTransform(turn));
  add(puff<FloatGrid>("frustum", frame, number(.5f)))
      ->setTransform(
          math::Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(20)), .5, 10, .1));
  if (frame == 2)
    add(puff<Int32Grid>("late", 0, number(int32_t{1})));
  MetaMap file;
  putMetadata(file, 0);
  char name[32];
  std::snprintf(name, sizeof name, "all_%04d.vdb", frame);
  io::File(folder / name).write(grids, file);
}

/// A block of 10^3 voxels of 1 that begins at the index 0, in several places.
void place(const std::filesystem::path& folder) {
  const auto write = [&](const std::string& name, const math::Transform::Ptr& transform,
                         const MetaMap& file = {}) {
    const auto grid = FloatGrid::create();
    grid->setName("density");
    grid->setGridClass(GRID_FOG_VOLUME);
    grid->fill(CoordBBox(Coord(0), Coord(9)), 1.f);
    grid->setTransform(transform);
    io::File(folder / (name + ".vdb")).write(GridPtrVec{grid}, file);
  };
  const auto affine = [](const math::Mat4d& matrix) {
    return std::make_shared<math::Transform>(std::make_shared<math::AffineMap>(matrix));
  };
  const auto rows = [](const std::array<double, 16>& numbers) {
    return math::Mat4d(numbers.data());
  };
  // Row vectors: scaled, sheared along x by y, turned by 30 degrees about z, moved.
  math::Mat4d skew = rows({.1, 0, 0, 0, .04, .2, 0, 0, 0, 0, .1, 0, 0, 0, 0, 1});
  math::Mat4d turned = math::Mat4d::identity();
  turned.preScale(Vec3d(.1, .2, .1));
  turned.postRotate(math::Z_AXIS, M_PI / 6);
  turned.postTranslate(Vec3d(3, 2, 1));
  skew.postRotate(math::Z_AXIS, M_PI / 6);
  skew.postTranslate(Vec3d(3, 2, 1));
  write("turned", affine(turned)), write("skewed", affine(skew));
  write("mirrored", affine(rows({-.1, 0, 0, 0, 0, .1, 0, 0, 0, 0, .1, 0, 1, 0, 0, 1})));
  for (int frame = 1; frame <= 3; ++frame)
    write("moving_000" + std::to_string(frame),
          std::make_shared<math::Transform>(std::make_shared<math::UniformScaleTranslateMap>(
              frame == 3 ? .2 : .1, Vec3d(.02 * frame, 0, 0))));
  // Half of them by a program whose up axis is y.
  MetaMap houdini;
  setMeta(houdini, "creator", std::string("Houdini/GEO_VDBTranslator"));
  const auto unit = math::Transform::createLinearTransform(.1);
  write("upright_0001", unit, houdini), write("upright_0002", unit);
  // By programs that say who they are in other ways, and with names that say nothing.
  const auto named = [&](const std::string& name, std::initializer_list<const char*> grids,
                         GridClass kind, const std::function<void(MetaMap&)>& mark) {
    GridPtrVec all;
    for (const char* one : grids) {
      const auto grid = FloatGrid::create();
      grid->setName(one);
      grid->setGridClass(kind);
      grid->fill(CoordBBox(Coord(0), Coord(9)), 1.f);
      grid->setTransform(unit);
      mark(*grid);
      all.push_back(grid);
    }
    MetaMap file;
    if (name == "ember")
      setMeta(file, "creator", std::string("EmberGen 1.2"));
    io::File(folder / (name + ".vdb")).write(all, file);
  };
  const auto nothing = [](MetaMap&) {};
  named("ember", {"density"}, GRID_FOG_VOLUME, nothing);
  named("bifrost", {"voxel_field"}, GRID_FOG_VOLUME,
        [](MetaMap& map) { setMeta(map, "_bifrost_volume_index", int32_t{0}); });
  named("mantaflow", {"density"}, GRID_FOG_VOLUME, [](MetaMap& map) {
    setMeta(map, "file_base_resolution", Vec3i(10));
    setMeta(map, "file_voxel_size", .1f);
  });
  named("thrice", {"density", "density", "density"}, GRID_FOG_VOLUME, nothing);
  named("unnamed", {"", ""}, GRID_FOG_VOLUME, nothing);
  named("amount", {"amount"}, GRID_UNKNOWN, nothing);
  // 10 voxels of 0.01 m at z = 0, twice as wide at z = 0.5.
  write("frustum", math::Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(10)), .5, 5, .1));
  // As flat as OpenVDB lets through.
  write("flat", affine(rows({.1, 0, 0, 0, .1, 1e-12, 0, 0, 0, 0, .1, 0, 0, 0, 0, 1})));
}

void makeKinds(const std::filesystem::path& folder);

/// What is within the format and beyond what anybody expects.
void makeExtremes(const std::filesystem::path& folder) {
  const auto write = [&](const std::string& name, const FloatGrid::Ptr& grid) {
    grid->setName("density");
    grid->setGridClass(GRID_FOG_VOLUME);
    grid->setTransform(math::Transform::createLinearTransform(.25));
    io::File(folder / (name + ".vdb")).write(GridPtrVec{grid});
  };
  const auto block = [](const Coord& at, float background = 0, float value = 1) {
    const auto grid = FloatGrid::create(background);
    for (int i = 0; i < 512; ++i)
      grid->tree().setValue(at.offsetBy(i & 7, i >> 3 & 7, i >> 6), value + .001f * (i % 7));
    return grid;
  };
  // 2 x 2 x 4 constant regions of 4096^3: 1.1e12 voxels.
  const auto tiles = block(Coord(-8, 0, 0));
  for (int i = 0; i < 16; ++i)
    tiles->tree().addTile(3, Coord(4096 * (i & 1), 4096 * (i >> 1 & 1), 4096 * (i >> 2)), .5f,
                          true);
  write("tiles", tiles);
  // From one end of 32 bits to the other.
  const auto corners = block(Coord(-2147483647 - 1));
  corners->tree().setValue(Coord(2147483647), 1.f);
  write("corners", corners);
  write("background_0001", block(Coord(0)));
  write("background_0002", block(Coord(0), .5f));
  const auto hidden = block(Coord(0));
  hidden->tree().setValueOff(Coord(9, 0, 0), std::numeric_limits<float>::quiet_NaN());
  hidden->tree().setValueOff(Coord(10, 0, 0), std::numeric_limits<float>::infinity());
  hidden->tree().setValueOff(Coord(40, 0, 0), 7.f);
  // In a leaf that reaches into the box of what is active: one in it, and one beyond.
  hidden->tree().setValue(Coord(-3, 3, 3), 1.f);
  hidden->tree().setValueOff(Coord(-1, 3, 3), 2.f);
  hidden->tree().setValueOff(Coord(-6, 3, 3), 5.f);
  write("hidden", hidden);
  const auto unset = FloatGrid::create(std::numeric_limits<float>::quiet_NaN());
  unset->tree().setValue(Coord(0), 1.f);
  write("unset", unset);
  makeKinds(folder);
}

/// One grid whose values, class, precision and place are of another kind in each frame.
void makeKinds(const std::filesystem::path& folder) {
  const auto block = [&]<class GridType>(int frame, const Vec3d& at, double size) {
    const auto grid =
        puff<GridType>("density", frame, [](int x, int, int) { return .125f * (6 + x); });
    const auto transform = math::Transform::createLinearTransform(size);
    transform->postTranslate(at);
    grid->setTransform(transform);
    return grid;
  };
  const auto write = [&](int frame, const GridBase::Ptr& grid) {
    io::File(folder / ("kinds_000" + std::to_string(frame) + ".vdb")).write(GridPtrVec{grid});
  };
  const auto fog = block.operator()<FloatGrid>(1, Vec3d(0, 0, 0), .25);
  fog->setGridClass(GRID_FOG_VOLUME);
  write(1, fog);
  const auto half = block.operator()<FloatGrid>(2, Vec3d(.5, 0, 0), .25);
  half->setSaveFloatAsHalf(true);
  write(2, half);
  const auto none = block.operator()<DoubleGrid>(3, Vec3d(0, .25, 0), .25);
  none->setGridClass(GRID_UNKNOWN);
  write(3, none);
}

/// Two frames, at .5 and 1 s, of grids that are all empty, and of one that is not coded.
void makeHollow(const std::filesystem::path& folder) {
  for (const int frame : {3, 4}) {
    GridPtrVec grids{FloatGrid::create(.5f), Vec3DGrid::create(), createLevelSet<FloatGrid>(.1)};
    const std::array names{"density", "velocity", "surface"};
    const auto id = puff<Int32Grid>("id", frame, [](int x, int, int) { return x + 6; });
    for (std::size_t i = 0; i < grids.size(); ++i) grids[i]->setName(names[i]);
    grids[0]->setGridClass(GRID_FOG_VOLUME);
    grids[0]->setTransform(math::Transform::createLinearTransform(.2));
    setMeta(*grids[1], "note", std::string("still air"));
    MetaMap file;
    setMeta(file, "creator", std::string("a test"));
    const auto write = [&](const std::string& name, const GridPtrVec& of) {
      for (const auto& grid : of) setMeta(*grid, "volute:time", .5 * (frame - 2));
      io::File(folder / (name + "_000" + std::to_string(frame) + ".vdb")).write(of, file);
    };
    write("empty", grids), write("kept", {id}), write("one", {grids[0]});
  }
}

int differences = 0;

template <class... Text>
void differs(const Text&... text) {
  ++differences;
  ((std::cout << text << ' '), ...) << '\n';
}

void compareMetadata(const std::string& where, const MetaMap& a, const MetaMap& b) {
  const auto listed = [](const MetaMap& map) {
    std::map<std::string, std::string> all;
    for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
      if (it->first.starts_with("file_"))
        continue;
      std::ostringstream bytes;
      it->second->write(bytes);
      all[it->first] = it->second->typeName() + bytes.str();
    }
    return all;
  };
  const auto one = listed(a), other = listed(b);
  for (const auto& [name, value] : one) {
    const auto found = other.find(name);
    if (found == other.end() || found->second != value)
      differs(where, "metadata", name);
  }
  for (const auto& [name, value] : other) {
    if (!one.contains(name))
      differs(where, "new metadata", name);
  }
}

double apart(float a, float b) {
  return std::abs(a - b);
}

double apart(double a, double b) {
  return std::abs(a - b);
}

template <class T>
double apart(const math::Vec3<T>& a, const math::Vec3<T>& b) {
  return std::max({apart(a[0], b[0]), apart(a[1], b[1]), apart(a[2], b[2])});
}

template <class GridType>
bool compareTrees(const std::string& name, const GridBase& a, const GridBase& b, double tolerance) {
  if (!a.isType<GridType>() || !b.isType<GridType>())
    return false;
  const auto &one = static_cast<const GridType&>(a).tree(),
             &other = static_cast<const GridType&>(b).tree();
  if (!one.hasSameTopology(other))
    differs(name, "topology");
  auto it = one.cbeginValueOn();
  for (auto to = other.cbeginValueOn(); it && to; ++it, ++to) {
    if (it.getCoord() != to.getCoord() || !(apart(*it, *to) <= tolerance)) {
      differs(name, "value at", it.getCoord(), *it, *to);
      break;
    }
  }
  return true;
}

/// Points with all their attributes: how their arrays are packed may differ.
bool comparePoints(const std::string& name, const GridBase& a, const GridBase& b) {
  if (!a.isType<points::PointDataGrid>() || !b.isType<points::PointDataGrid>())
    return false;
  const auto &one = static_cast<const points::PointDataGrid&>(a).tree(),
             &other = static_cast<const points::PointDataGrid&>(b).tree();
  if (!one.hasSameTopology(other) || one.leafCount() != other.leafCount())
    differs(name, "topology");
  auto it = one.cbeginLeaf();
  for (auto to = other.cbeginLeaf(); it && to; ++it, ++to) {
    if (it->origin() != to->origin() || it->attributeSet() != to->attributeSet()) {
      differs(name, "points at", it->origin());
      break;
    }
  }
  return true;
}

/// As OpenVDB writes it, but for the random identifier.
std::string bytesOf(const GridBase::Ptr& grid) {
  std::ostringstream out(std::ios::binary);
  io::Stream(out).write(GridPtrVec{grid});
  return std::move(out).str().erase(21, 36);
}

void compare(const std::string& a, const std::string& b, double tolerance) {
  io::File one(a), other(b);
  one.open(), other.open();
  compareMetadata("file", *one.getMetadata(), *other.getMetadata());
  auto to = other.beginName();
  for (auto it = one.beginName(); it != one.endName(); ++it) {
    const std::string name = it.gridName();
    if (to == other.endName() || to.gridName() != name) {
      differs(name, "is missing, or elsewhere");
      continue;
    }
    ++to;
    const auto gridA = one.readGrid(name), gridB = other.readGrid(name);
    if (gridA->type() != gridB->type() || gridA->getName() != gridB->getName() ||
        gridA->saveFloatAsHalf() != gridB->saveFloatAsHalf())
      differs(name, gridA->type(), gridB->type(), gridA->getName(), gridB->getName());
    compareMetadata(name, *gridA, *gridB);
    if (gridA->transform() != gridB->transform() ||
        gridA->transform().mapType() != gridB->transform().mapType())
      differs(name, "transform");
    const bool coded =
        name != "holes" && (compareTrees<FloatGrid>(name, *gridA, *gridB, tolerance) ||
                            compareTrees<DoubleGrid>(name, *gridA, *gridB, tolerance) ||
                            compareTrees<Vec3SGrid>(name, *gridA, *gridB, tolerance) ||
                            compareTrees<Vec3DGrid>(name, *gridA, *gridB, tolerance));
    if (!coded && bytesOf(gridA) != bytesOf(gridB) && !comparePoints(name, *gridA, *gridB))
      differs(name, "bytes");
    std::cout << io::GridDescriptor::nameAsString(name) << ' ' << gridA->type() << ' '
              << gridA->activeVoxelCount() << '\n';
  }
}

}  // namespace

int main(int count, char** arguments) {
  initialize();
  Truncated::registerType();
  Foreign::registerGrid();
  const std::string verb = count > 1 ? arguments[1] : "";
  if (verb == "make" && count == 3) {
    for (const int frame : {1, 2, 3}) make(arguments[2], frame);
    return 0;
  }
  if (verb == "place" && count == 3) {
    place(arguments[2]);
    return 0;
  }
  if (verb == "extremes" && count == 3) {
    makeExtremes(arguments[2]);
    return 0;
  }
  if (verb == "hollow" && count == 3) {
    makeHollow(arguments[2]);
    return 0;
  }
  if (verb == "compare" && count == 5)
    compare(arguments[2], arguments[3], std::atof(arguments[4]));
  else
    return 2;
  return differences == 0 ? 0 : 1;
}
