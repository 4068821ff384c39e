// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/gltf_camera.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/io/gltf_text.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxText = std::uint64_t{64} << 20;  ///< [bytes], buffers in it included
constexpr std::size_t kMaxNodes = 1'000'000;
constexpr std::size_t kDeepest = 256;  ///< nodes below nodes

/// All of a .gltf, the first chunk of a .glb.
Result<std::string> textOf(const InputFile& file) {
  constexpr std::uint64_t kHeader = 20, kLengthAt = 12;
  std::array<char, kHeader> header{};
  const bool long_ = file.size() >= kHeader;
  if (long_)
    VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(header))));
  const bool binary = long_ && std::memcmp(header.data(), "glTF", 4) == 0;
  std::uint64_t begin = 0, size = file.size();
  if (binary) {
    std::uint32_t length = 0;
    std::memcpy(&length, header.data() + kLengthAt, sizeof length);
    begin = kHeader, size = length;
  }
  if (size > kMaxText)
    return fail(ErrorCode::kTooLarge, "{}: {} bytes of JSON, more than is read of a camera's file",
                file.path().string(), size);
  std::string text(size, '\0');
  VOLUTE_TRY(file.read(begin, std::as_writable_bytes(std::span(text))));
  return text;
}

/// A camera of the scene, the node that holds it and those above it.
struct Found {
  const Json* camera = nullptr;
  Mat4 placed;
  std::string name;
  std::vector<std::size_t> nodes;
};

template <std::size_t N>
std::array<double, N> numbersOf(const Json& node, const char* name, std::array<double, N> usual) {
  return node.value(name, usual);
}

Mat4 transformOf(const Json& node) {
  if (node.contains("matrix"))
    return Mat4(node.at("matrix").get<std::array<double, 16>>().data());
  const auto t = numbersOf<3>(node, "translation", {0, 0, 0}),
             s = numbersOf<3>(node, "scale", {1, 1, 1});
  const auto q = numbersOf<4>(node, "rotation", {0, 0, 0, 1});
  return affine(turnOfQuaternion(Vec4(q.data())) * Vec3(s.data()).asDiagonal(), Vec3(t.data()));
}

/// Adds the cameras of a node and of what is below it.
/// @param left  nodes that may still be visited
void addCameras(const Json& gltf, std::size_t number, Found above, std::vector<Found>& found,
                std::size_t& left) {
  if (above.nodes.size() > kDeepest || left-- == 0)
    throw std::invalid_argument("nodes that contain each other");
  const Json& node = gltf.at("nodes").at(number);
  above.placed = above.placed * transformOf(node);
  above.nodes.push_back(number);
  if (node.contains("camera")) {
    found.push_back(above);
    found.back().camera = &gltf.at("cameras").at(node.at("camera").get<std::size_t>());
    found.back().name = node.value("name", found.back().camera->value("name", "without a name"));
  }
  for (const Json& child : node.value("children", Json::array()))
    addCameras(gltf, child.get<std::size_t>(), above, found, left);
}

std::vector<Found> camerasOf(const Json& gltf) {
  std::vector<Found> found;
  std::size_t left = kMaxNodes;
  const Json& scene = gltf.at("scenes").at(gltf.value("scene", std::size_t{0}));
  for (const Json& root : scene.value("nodes", Json::array()))
    addCameras(gltf, root.get<std::size_t>(), {nullptr, Mat4::Identity(), {}, {}}, found, left);
  return found;
}

bool moves(const Json& gltf, const std::vector<std::size_t>& nodes) {
  for (const Json& animation : gltf.value("animations", Json::array())) {
    for (const Json& channel : animation.at("channels")) {
      const auto target = channel.at("target").value("node", SIZE_MAX);
      if (std::ranges::find(nodes, target) != nodes.end())
        return true;
    }
  }
  return false;
}

Result<CameraDescription> cameraOf(const Json& gltf, const std::string& file) {
  const std::vector<Found> found = camerasOf(gltf);
  if (found.size() != 1) {
    std::vector<std::string> names;
    for (const Found& one : found) names.push_back(one.name);
    return fail(
        ErrorCode::kInvalidData, "{}: its scene has {}; expected one camera", file,
        found.empty() ? "no camera" : fmt::format("the cameras {}", fmt::join(names, ", ")));
  }
  const auto& [json, placed, name, nodes] = found.front();
  if (moves(gltf, nodes)) {
    return fail(ErrorCode::kUnsupported,
                "{}: its camera moves; expected a file for each frame, without animation", file);
  }
  const auto turned = [](const Vec3& p) { return Vec3(p.x(), -p.z(), p.y()); };
  CameraDescription camera;
  camera.view.eye = turned(placed.col(3).head<3>());
  camera.view.target = camera.view.eye - turned(placed.col(2).head<3>().normalized());
  camera.view.up = turned(placed.col(1).head<3>().normalized());
  const bool pinhole = json->at("type") == "perspective";
  const double size = pinhole ? json->at("perspective").at("yfov").get<double>()
                              : json->at("orthographic").at("ymag").get<double>();
  if (pinhole) {
    camera.fov = size * 180 / std::numbers::pi;
    if (const auto stated = json->at("perspective").find("aspectRatio");
        stated != json->at("perspective").end())
      camera.aspect = stated->get<double>();
  } else {
    camera.ortho = 2 * size;
    camera.aspect = json->at("orthographic").at("xmag").get<double>() / size;
  }
  if (!placed.allFinite() || !camera.view.target.allFinite() || !camera.view.up.allFinite() ||
      !(size > 0) || (pinhole && !(size < std::numbers::pi)))
    return fail(ErrorCode::kInvalidData, "{}: its camera has no place or no field of view", file);
  return camera;
}

}  // namespace

Result<CameraDescription> readGltfCamera(const std::string& file) {
  VOLUTE_ASSIGN(const auto input, InputFile::open(file));
  VOLUTE_ASSIGN(const auto text, textOf(input));
  VOLUTE_ASSIGN(const Json gltf, parseGltf(text, file));
  try {
    return cameraOf(gltf, file);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInvalidData, "{}: not a whole glTF 2.0 file: {}", file, error.what());
  }
}

}  // namespace volute
