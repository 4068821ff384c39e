// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_geometry.hpp"

#include <Eigen/LU>
#include <cmath>

#include "volute/base/content_hash.hpp"
#include "volute/io/json_members.hpp"
#include "volute/io/surface_file.hpp"
#include "volute/scene/fog_file.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

/// Vertices of smoke lie on the walls that the geometry shows, but for the rounding of two files:
/// of the geometry's size, and of coordinates as float.
constexpr double kLift = 1e-5;
constexpr double kTransformRounding = 2.5e-7;
constexpr double kRight = 1e-6;  ///< how far from 90 degrees a volume's axes may be, as a cosine

/// +y of the file becomes +z, as in glTF's own convention: (x, y, z) -> (x, -z, y).
Mat4 yUpwards() {
  Mat4 turn = Mat4::Identity();
  turn.row(1) << 0, 0, -1, 0;
  turn.row(2) << 0, 1, 0, 0;
  return turn;
}

Result<SceneGeometry> parseEntry(const Json& json, const std::string& file,
                                 const std::string& path) {
  constexpr std::string_view kNames[] = {"file", "transform", "up"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneGeometry entry;
  VOLUTE_TRY(members.text("file", entry.file, "the name of a .glb, .gltf, .obj or .vtp file"));
  entry.file = besides(file, entry.file);
  if (!isSurfacePath(entry.file)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: '{}' is no known geometry; expected .glb, .gltf, .obj or .vtp", file,
                members.where("file"), entry.file);
  }
  if (members.has("transform")) {
    VOLUTE_ASSIGN(entry.transform,
                  parseTransform(members.at("transform"), file, members.where("transform")));
  }
  std::string up = "z";
  if (members.has("up"))
    VOLUTE_TRY(members.text("up", up, "\"y\" or \"z\""));
  if (up != "y" && up != "z")
    return fail(ErrorCode::kInvalidData, "{}: {}: '{}' is unknown; expected y or z", file,
                members.where("up"), up);
  if (up == "y")
    entry.transform = entry.transform * yUpwards();
  return entry;
}

Status parseBillboardSize(const Members& members, const std::string& file, BillboardOptions& options) {
  const Json size = members.has("size") ? members.at("size") : Json();
  if (!size.is_array() || size.size() != 2)
    return fail(ErrorCode::kInvalidData, "{}: {}: expected [width, height] [m]", file,
                members.where("size"));
  VOLUTE_ASSIGN(options.width, jsonToNumber(size[0], file, members.where("size") + "[0]"));
  VOLUTE_ASSIGN(options.height, jsonToNumber(size[1], file, members.where("size") + "[1]"));
  if (options.width > 0 && options.height > 0)
    return {};
  return fail(ErrorCode::kInvalidData, "{}: {}: expected two numbers of more than 0 [m]", file,
              members.where("size"));
}

Status parseAlpha(const Members& members, const std::string& file, BillboardOptions& options) {
  if (!members.has("alpha"))
    return {};
  std::string alpha;
  VOLUTE_TRY(members.text("alpha", alpha, "\"transmittance\" or \"intensity\""));
  if (alpha != "transmittance" && alpha != "intensity") {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: '{}' is unknown; expected transmittance or intensity", file,
                members.where("alpha"), alpha);
  }
  options.alpha =
      alpha == "intensity" ? BillboardAlpha::kIntensity : BillboardAlpha::kTransmittance;
  return {};
}

Result<SceneBillboard> parseBillboard(const Json& json, const std::string& file,
                                      const std::string& path) {
  constexpr std::string_view kNames[] = {"volume",   "position",   "size", "alpha",
                                         "emission", "extinction", "time", "rows"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneBillboard board;
  VOLUTE_TRY(members.text("volume", board.file, "the name of a volume"));
  board.file = besides(file, board.file);
  if (!members.has("position"))
    return fail(ErrorCode::kInvalidData, "{}: {}: is missing; expected three numbers [m]", file,
                members.where("position"));
  VOLUTE_TRY(members.vector("position", board.options.position));
  VOLUTE_TRY(parseBillboardSize(members, file, board.options));
  VOLUTE_TRY(parseAlpha(members, file, board.options));
  VOLUTE_TRY(members.number("emission", board.appearance.emission));
  VOLUTE_TRY(members.number("extinction", board.appearance.extinction));
  VOLUTE_TRY(members.integer("rows", board.options.rows, 1, 4096));
  if (members.has("time")) {
    VOLUTE_ASSIGN(board.appearance.clock,
                  parseClock(members.at("time"), file, members.where("time")));
  }
  return board;
}

}  // namespace

Result<Mat4> parseTransform(const Json& json, const std::string& file, const std::string& path) {
  if (!json.is_array() || json.size() != 16) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected 16 numbers, row-major", file, path);
  }
  Mat4 matrix;
  for (int i = 0; i < 16; ++i) {
    VOLUTE_ASSIGN(matrix(i / 4, i % 4),
                  jsonToNumber(json[i], file, fmt::format("{}[{}]", path, i)));
  }
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: expected 0, 0, 0, 1 as the last four of the numbers, which are row-major",
                file, path);
  }
  if (!(std::abs(matrix.determinant()) > 0))
    return fail(ErrorCode::kInvalidData, "{}: {}: makes everything flat", file, path);
  return matrix;
}

Result<Placement> parsePlacement(const Json& json, const std::string& file,
                                 const std::string& path) {
  VOLUTE_ASSIGN(const Mat4 matrix, parseTransform(json, file, path));
  const Mat3 linear = matrix.topLeftCorner<3, 3>();
  Placement placement;
  placement.scale = linear.colwise().norm().transpose();
  placement.offset = matrix.topRightCorner<3, 1>();
  placement.turn = linear * placement.scale.cwiseInverse().asDiagonal();
  const Mat3 square = placement.turn.transpose() * placement.turn - Mat3::Identity();
  if (square.cwiseAbs().maxCoeff() > kRight) {
    return fail(ErrorCode::kUnsupported,
                "{}: {}: shears the volume; expected moving, turning, mirroring and scaling along "
                "the volume's axes",
                file, path);
  }
  return placement;
}

Result<std::vector<SceneGeometry>> parseGeometry(const Json& json, const std::string& file,
                                                 const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<SceneGeometry> entries;
  for (std::size_t i = 0; i < json.size(); ++i) {
    VOLUTE_ASSIGN(auto entry, parseEntry(json[i], file, fmt::format("{}/{}", path, i)));
    entries.push_back(std::move(entry));
  }
  return entries;
}

Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                   const Reading& reading) {
  TriangleMesh all;
  for (const SceneGeometry& entry : entries) {
    VOLUTE_ASSIGN(const auto mesh, readSurfaces(entry.file, reading.maxMemory));
    const auto first = static_cast<std::uint32_t>(all.materials.size());
    for (Triangle triangle : transformed(mesh.triangles, entry.transform)) {
      triangle.material += first;
      all.triangles.push_back(triangle);
    }
    all.materials.insert(all.materials.end(), mesh.materials.begin(), mesh.materials.end());
  }
  return TriangleScene::build(std::move(all.triangles), std::move(all.materials));
}

std::function<void(const Segment&, std::size_t, std::vector<Interval>&)> fogShadows(
    const TriangleScene& geometry, const std::vector<FogSun>& suns) {
  if (geometry.empty())
    return {};
  return [geometry, suns](const Segment& segment, std::size_t sun, std::vector<Interval>& dark) {
    geometry.shadows(segment, {suns[sun].towards}, dark);
  };
}

Blocks blocksOf(const TriangleScene& geometry) {
  if (geometry.empty())
    return {};
  return [geometry](std::span<const Segment> segments, std::span<std::uint8_t> blocked) {
    const double lift = kLift * (1 + geometry.bounds().size().maxCoeff());
    std::vector<Segment> lifted(segments.begin(), segments.end());
    for (Segment& segment : lifted)
      segment.begin += lift + kTransformRounding * segment.origin.cwiseAbs().maxCoeff();
    geometry.occluded(lifted, blocked);
  };
}

std::string keyOf(const TriangleScene& geometry) {
  ContentHash hash;
  for (const Triangle& triangle : geometry.triangles()) {
    for (const Vec3& corner : triangle.corners) hash.add(std::span<const double>(corner.data(), 3));
  }
  return hash.digits();
}

Result<std::vector<SceneBillboard>> parseBillboards(const Json& json, const std::string& file,
                                                    const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<SceneBillboard> boards;
  for (std::size_t i = 0; i < json.size(); ++i) {
    VOLUTE_ASSIGN(auto board, parseBillboard(json[i], file, fmt::format("{}/{}", path, i)));
    boards.push_back(std::move(board));
  }
  return boards;
}

}  // namespace volute
