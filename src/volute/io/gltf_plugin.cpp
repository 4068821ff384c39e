// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/base/input_file.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/gltf_text.hpp"
#include "volute/io/surface.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr int kDeepest = 256;  ///< nodes below nodes; a tree that is deeper goes in circles

/// Pictures are not read.
bool skipImage(tinygltf::Image*, const int, std::string*, std::string*, int, int,
               const unsigned char*, int, void*) {
  return true;
}

bool fileExists(const std::string& file, void*) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error);
}

std::string asItIs(const std::string& file, void*) {
  return file;
}

/// Buffers beside the file, and nothing else of this machine.
bool readBuffer(std::vector<unsigned char>* bytes, std::string* reason, const std::string& file,
                void* folder) {
  if (!isBelowFolder(file, *static_cast<const std::filesystem::path*>(folder))) {
    *reason = file + " is not below the file's own folder";
    return false;
  }
  const auto input = InputFile::open(file);
  if (!input) {
    *reason = input.error().message;
    return false;
  }
  bytes->resize(input->size());
  return input->read(0, std::as_writable_bytes(std::span(*bytes))).has_value();
}

bool writeNothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

std::string oneLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// The JSON of a file: all of it, or the first chunk.
std::string_view jsonOf(const std::vector<unsigned char>& bytes, bool binary) {
  constexpr std::size_t kLengthAt = 12, kHeader = 20;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!binary || bytes.size() < kHeader)
    return text;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + kLengthAt, sizeof length);
  return text.substr(kHeader, length);
}

Result<tinygltf::Model> loadModel(const std::filesystem::path& path) {
  const std::string name = path.string();
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  if (file.size() > 0xFFFFFFFFull)
    return fail(ErrorCode::kTooLarge, "{}: larger than 4 GiB, more than glTF can be", name);
  std::vector<unsigned char> bytes(file.size());
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(bytes))));
  const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  VOLUTE_TRY(parseGltf(jsonOf(bytes, binary), name));
  std::filesystem::path folder =
      path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(skipImage, nullptr);
  loader.SetFsCallbacks({fileExists, asItIs, readBuffer, writeNothing, &folder});
  tinygltf::Model model;
  std::string error, warning;
  const auto size = static_cast<unsigned int>(bytes.size());
  const bool loaded = binary
                          ? loader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(),
                                                        size, folder.string())
                          : loader.LoadASCIIFromString(&model, &error, &warning,
                                                       reinterpret_cast<const char*>(bytes.data()),
                                                       size, folder.string());
  if (!loaded) {
    return fail(ErrorCode::kInvalidData, "{}: not a whole glTF 2.0 file: {}", name,
                error.empty() ? "it is damaged" : oneLine(error));
  }
  return model;
}

/// A look at the numbers behind an accessor; inside its buffer as far as it goes.
struct Numbers {
  const unsigned char* first = nullptr;
  std::size_t stride = 0, count = 0;
  int component = 0;
  bool normalized = false;
};

class GltfReader {
 public:
  GltfReader(const tinygltf::Model& model, std::string file)
      : model_(model), file_(std::move(file)), reached_(model.nodes.size()) {}

  Result<TriangleMesh> read() {
    VOLUTE_TRY(checkExtensions());
    VOLUTE_TRY(readMaterials());
    const int chosen = model_.defaultScene >= 0 ? model_.defaultScene : 0;
    if (model_.scenes.empty())
      return fail(ErrorCode::kInvalidData, "{}: has no scene", file_);
    if (chosen >= static_cast<int>(model_.scenes.size()))
      return fail(ErrorCode::kInvalidData, "{}: /scene: there is no scene {}", file_, chosen);
    for (const int node : model_.scenes[chosen].nodes)
      VOLUTE_TRY(addNode(node, Mat4::Identity(), 0));
    if (mesh_.triangles.empty())
      return fail(ErrorCode::kInvalidData, "{}: its scene has no triangles", file_);
    if (const std::size_t apart = meshesElsewhere(); apart > 0) {
      mesh_.remarks.push_back(fmt::format(
          "scene {} of {} is drawn; {} of its nodes with meshes are not in it and are left out",
          chosen, model_.scenes.size(), apart));
    }
    if (!model_.animations.empty())
      mesh_.remarks.push_back(
          "its animations are not played: nodes are where the file places them");
    if (hasLines_)
      mesh_.remarks.push_back("its points and lines are not drawn, its triangles alone");
    if (!model_.textures.empty())
      mesh_.remarks.push_back("textures are not drawn, the factors of its materials alone");
    if (hasColors_)
      mesh_.remarks.push_back(
          "colours of vertices (COLOR_0) are not drawn, those of its materials alone");
    if (!model_.lights.empty())
      mesh_.remarks.push_back("its lights (KHR_lights_punctual) do not shine, the scene's alone");
    if (std::ranges::any_of(model_.materials, letsLightThrough))
      mesh_.remarks.push_back("materials that let light through (alpha) are drawn opaque");
    return std::move(mesh_);
  }

 private:
  Status checkExtensions() const {
    for (const std::string& name : model_.extensionsRequired) {
      if (name.starts_with("KHR_materials_") || name == "KHR_lights_punctual" ||
          name == "KHR_texture_transform" || name == "KHR_node_visibility" ||
          name == "KHR_mesh_quantization")
        continue;
      return fail(ErrorCode::kUnsupported,
                  "{}: needs the extension {}, which is not read; export it without", file_, name);
    }
    return {};
  }

  static bool letsLightThrough(const tinygltf::Material& material) {
    const auto found = material.extensions.find("KHR_materials_transmission");
    const bool transmits = found != material.extensions.end() &&
                           found->second.Has("transmissionFactor") &&
                           found->second.Get("transmissionFactor").GetNumberAsDouble() > 0;
    return material.alphaMode == "BLEND" || transmits;
  }

  /// Below its cutoff everywhere: textures only make alpha less.
  static bool isCutOut(const tinygltf::Material& material) {
    const auto& base = material.pbrMetallicRoughness.baseColorFactor;
    return material.alphaMode == "MASK" && base.size() == 4 && base[3] < material.alphaCutoff;
  }

  /// By KHR_node_visibility: then nor are those below it.
  static bool isHidden(const tinygltf::Node& node) {
    const auto found = node.extensions.find("KHR_node_visibility");
    if (found == node.extensions.end() || !found->second.Has("visible"))
      return false;
    const tinygltf::Value& visible = found->second.Get("visible");
    return visible.IsBool() && !visible.Get<bool>();
  }

  /// How many nodes with meshes the scene does not have.
  std::size_t meshesElsewhere() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < model_.nodes.size(); ++i)
      count += model_.nodes[i].mesh >= 0 && !reached_[i];
    return count;
  }

  /// What a surface reflects, as the factor of its model; 1 where it states none.
  static Rgb reflectance(const tinygltf::Material& from) {
    std::vector<double> factor = from.pbrMetallicRoughness.baseColorFactor;
    const auto other = from.extensions.find("KHR_materials_pbrSpecularGlossiness");
    if (other != from.extensions.end()) {  // takes the place of the usual one
      factor.clear();
      if (other->second.Has("diffuseFactor")) {
        const tinygltf::Value& diffuse = other->second.Get("diffuseFactor");
        for (std::size_t i = 0; i < diffuse.ArrayLen(); ++i)
          factor.push_back(diffuse.Get(static_cast<int>(i)).GetNumberAsDouble());
      }
    }
    return factor.size() >= 3 ? Rgb(factor[0], factor[1], factor[2]) : Rgb(Rgb::Ones());
  }

  Status readMaterials() {
    for (const tinygltf::Material& from : model_.materials) {
      Material material;
      material.baseColor = reflectance(from);
      if (from.emissiveFactor.size() >= 3)
        material.emission =
            Rgb(from.emissiveFactor[0], from.emissiveFactor[1], from.emissiveFactor[2]);
      if (const auto strength = from.extensions.find("KHR_materials_emissive_strength");
          strength != from.extensions.end() && strength->second.Has("emissiveStrength"))
        material.emission *= strength->second.Get("emissiveStrength").GetNumberAsDouble();
      if (from.extensions.contains("KHR_materials_unlit")) {  // its colour whatever shines on it
        material.emission = material.baseColor;
        material.baseColor = Rgb::Zero();
      }
      if (!(material.baseColor >= 0).all() || !(material.emission >= 0).all() ||
          !material.baseColor.isFinite().all() || !material.emission.isFinite().all()) {
        return fail(ErrorCode::kInvalidData, "{}: /materials/{}: a color that is negative", file_,
                    mesh_.materials.size());
      }
      mesh_.materials.push_back(material);
    }
    Material plain;  // of primitives without one, as the format says
    plain.baseColor = Rgb::Ones();
    mesh_.materials.push_back(plain);
    return {};
  }

  static Result<Mat4> transformOf(const tinygltf::Node& node, const std::string& where) {
    Mat4 local = Mat4::Identity();
    if (node.matrix.size() == 16) {
      for (int i = 0; i < 16; ++i) local(i % 4, i / 4) = node.matrix[i];
    } else {
      Mat3 linear = Mat3::Identity();
      if (node.rotation.size() == 4) {
        const auto& q = node.rotation;
        const Vec4 turn(q.data());
        if (!(std::abs(turn.norm() - 1) < 1e-2))
          return fail(ErrorCode::kInvalidData, "{}/rotation: expected a unit quaternion", where);
        linear = turnOfQuaternion(turn);
      }
      if (node.scale.size() == 3)
        linear = linear * Vec3(node.scale.data()).asDiagonal();
      local = affine(linear, node.translation.size() == 3 ? Vec3(node.translation.data())
                                                          : Vec3(Vec3::Zero()));
    }
    if (!local.allFinite() || local.row(3) != Vec4(0, 0, 0, 1))
      return fail(ErrorCode::kInvalidData, "{}: expected an affine transform", where);
    return local;
  }

  Status addNode(int number, const Mat4& parent, int depth, bool hidden = false) {
    if (number < 0 || number >= static_cast<int>(model_.nodes.size()))
      return fail(ErrorCode::kInvalidData, "{}: /nodes: there is no node {}", file_, number);
    if (depth > kDeepest || ++visited_ > kMaxNodes) {
      return fail(ErrorCode::kInvalidData, "{}: /nodes/{}: nodes that contain each other", file_,
                  number);
    }
    const tinygltf::Node& node = model_.nodes[number];
    reached_[static_cast<std::size_t>(number)] = true;
    hidden = hidden || isHidden(node);
    const std::string where = fmt::format("{}: /nodes/{}", file_, number);
    VOLUTE_ASSIGN(const Mat4 local, transformOf(node, where));
    const Mat4 placed = parent * local;
    if (node.mesh >= 0 && node.skin >= 0)
      return fail(ErrorCode::kUnsupported, "{}/skin: skins are not read; export it posed", where);
    if (node.mesh >= static_cast<int>(model_.meshes.size()))
      return fail(ErrorCode::kInvalidData, "{}/mesh: there is no mesh {}", where, node.mesh);
    if (node.mesh >= 0 && !hidden) {
      const auto& primitives = model_.meshes[node.mesh].primitives;
      for (std::size_t i = 0; i < primitives.size(); ++i) {
        VOLUTE_TRY(addPrimitive(primitives[i], placed,
                                fmt::format("{}: /meshes/{}/primitives/{}", file_, node.mesh, i)));
      }
    }
    for (const int child : node.children) VOLUTE_TRY(addNode(child, placed, depth + 1, hidden));
    return {};
  }

  Result<Numbers> numbersOf(int number, int components, const std::string& where) const {
    if (number < 0 || number >= static_cast<int>(model_.accessors.size()))
      return fail(ErrorCode::kInvalidData, "{}: there is no accessor {}", where, number);
    const tinygltf::Accessor& accessor = model_.accessors[number];
    if (accessor.sparse.isSparse)
      return fail(ErrorCode::kUnsupported, "{}: sparse accessors are not read", where);
    if (accessor.bufferView < 0 ||
        accessor.bufferView >= static_cast<int>(model_.bufferViews.size()))
      return fail(ErrorCode::kInvalidData, "{}: there is no buffer view {}", where,
                  accessor.bufferView);
    const tinygltf::BufferView& view = model_.bufferViews[accessor.bufferView];
    if (view.buffer < 0 || view.buffer >= static_cast<int>(model_.buffers.size()))
      return fail(ErrorCode::kInvalidData, "{}: there is no buffer {}", where, view.buffer);
    const auto& bytes = model_.buffers[view.buffer].data;
    const int unit = tinygltf::GetComponentSizeInBytes(accessor.componentType);
    if (tinygltf::GetNumComponentsInType(accessor.type) != components || unit <= 0)
      return fail(ErrorCode::kInvalidData, "{}: expected {} numbers an element", where, components);
    const std::size_t element = static_cast<std::size_t>(unit) * components;
    Numbers numbers;
    numbers.stride = view.byteStride == 0 ? element : view.byteStride;
    numbers.count = accessor.count;
    numbers.component = accessor.componentType;
    numbers.normalized = accessor.normalized;
    const bool fits =
        view.byteOffset <= bytes.size() && view.byteLength <= bytes.size() - view.byteOffset &&
        accessor.byteOffset <= view.byteLength && numbers.stride >= element &&
        (numbers.count == 0 ||
         (view.byteLength - accessor.byteOffset >= element &&
          numbers.count - 1 <= (view.byteLength - accessor.byteOffset - element) / numbers.stride));
    if (!fits)
      return fail(ErrorCode::kInvalidData, "{}: its {} elements end beyond their buffer", where,
                  numbers.count);
    numbers.first = bytes.data() + view.byteOffset + accessor.byteOffset;
    return numbers;
  }

  using ReadPosition = Vec3 (*)(const unsigned char*);

  /// @tparam kNormalized  its largest number stands for 1
  template <class Number, bool kNormalized>
  static Vec3 readPosition(const unsigned char* from) {
    Number xyz[3];
    std::memcpy(xyz, from, sizeof xyz);
    const Vec3 point(xyz[0], xyz[1], xyz[2]);
    if constexpr (kNormalized)
      return (point / std::numeric_limits<Number>::max()).cwiseMax(-1);
    return point;
  }

  template <class Number>
  static ReadPosition readWholePosition(bool normalized) {
    return normalized ? readPosition<Number, true> : readPosition<Number, false>;
  }

  /// Whole numbers are those of KHR_mesh_quantization. Null for others.
  static ReadPosition readerOf(const Numbers& numbers) {
    switch (numbers.component) {
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return readPosition<float, false>;
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return readWholePosition<std::int8_t>(numbers.normalized);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return readWholePosition<std::uint8_t>(numbers.normalized);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return readWholePosition<std::int16_t>(numbers.normalized);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return readWholePosition<std::uint16_t>(numbers.normalized);
      default:
        return nullptr;
    }
  }

  Result<std::vector<Vec3>> positionsOf(const tinygltf::Primitive& primitive, const Mat4& placed,
                                        const std::string& where) const {
    const auto found = primitive.attributes.find("POSITION");
    if (found == primitive.attributes.end())
      return fail(ErrorCode::kInvalidData, "{}: has no POSITION", where);
    VOLUTE_ASSIGN(const Numbers numbers, numbersOf(found->second, 3, where + "/POSITION"));
    const auto read = readerOf(numbers);
    if (!read)
      return fail(ErrorCode::kUnsupported,
                  "{}/POSITION: expected floats, or whole numbers of 8 or "
                  "16 bits",
                  where);
    std::vector<Vec3> positions(numbers.count);
    for (std::size_t i = 0; i < numbers.count; ++i) {
      positions[i] =
          linearPart(placed) * read(numbers.first + i * numbers.stride) + offsetPart(placed);
      if (!positions[i].allFinite())
        return fail(ErrorCode::kInvalidData, "{}/POSITION: vertex {} is not finite", where, i);
    }
    return positions;
  }

  Result<std::vector<std::uint32_t>> indicesOf(const tinygltf::Primitive& primitive,
                                               std::size_t vertices,
                                               const std::string& where) const {
    std::vector<std::uint32_t> indices;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < vertices; ++i) indices.push_back(static_cast<std::uint32_t>(i));
      return indices;
    }
    VOLUTE_ASSIGN(const Numbers numbers, numbersOf(primitive.indices, 1, where + "/indices"));
    const int unit = tinygltf::GetComponentSizeInBytes(numbers.component);
    if (numbers.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
        numbers.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        numbers.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
      return fail(ErrorCode::kInvalidData, "{}/indices: expected unsigned whole numbers", where);
    indices.reserve(numbers.count);  // no more than the buffer holds
    for (std::size_t i = 0; i < numbers.count; ++i) {
      std::uint32_t index = 0;
      std::memcpy(&index, numbers.first + i * numbers.stride, unit);
      if (index >= vertices)
        return fail(ErrorCode::kInvalidData, "{}/indices: {} names vertex {} of {}", where, i,
                    index, vertices);
      indices.push_back(index);
    }
    return indices;
  }

  Status addPrimitive(const tinygltf::Primitive& primitive, const Mat4& placed,
                      const std::string& where) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES) {
      hasLines_ = true;
      return {};
    }
    if (!primitive.targets.empty())
      return fail(ErrorCode::kUnsupported, "{}: morph targets are not read; apply them", where);
    if (primitive.extensions.contains("KHR_draco_mesh_compression"))
      return fail(ErrorCode::kUnsupported, "{}: Draco compression is not read; export without",
                  where);
    VOLUTE_ASSIGN(const auto positions, positionsOf(primitive, placed, where));
    VOLUTE_ASSIGN(const auto indices, indicesOf(primitive, positions.size(), where));
    const int last = static_cast<int>(mesh_.materials.size()) - 1;
    if (primitive.material >= last)
      return fail(ErrorCode::kInvalidData, "{}: there is no material {}", where,
                  primitive.material);
    if (primitive.material >= 0 && isCutOut(model_.materials[primitive.material]))
      return {};
    hasColors_ = hasColors_ || primitive.attributes.contains("COLOR_0");
    const auto material =
        static_cast<std::uint32_t>(primitive.material < 0 ? last : primitive.material);
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      mesh_.triangles.push_back({{positions[a], positions[b], positions[c]}, material});
    };
    if (mode == TINYGLTF_MODE_TRIANGLES && indices.size() % 3 != 0)
      return fail(ErrorCode::kInvalidData, "{}: {} indices are no triangles", where,
                  indices.size());
    const std::size_t step = mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1;
    // Pages touched for the first time cost more than what is written to them.
    if (const std::size_t more = mesh_.triangles.size() + indices.size() / step;
        more > 2 * mesh_.triangles.capacity())
      mesh_.triangles.reserve(more);
    for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
      const bool odd = mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1;
      const std::size_t first = mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i;
      add(indices[first], indices[odd ? i + 2 : i + 1], indices[odd ? i + 1 : i + 2]);
    }
    return {};
  }

  static constexpr std::size_t kMaxNodes = 1 << 22;

  const tinygltf::Model& model_;
  std::string file_;
  TriangleMesh mesh_;
  bool hasColors_ = false;     ///< of vertices
  bool hasLines_ = false;      ///< or points
  std::vector<bool> reached_;  ///< nodes of the scene
  std::size_t visited_ = 0;
};

Result<TriangleMesh> readGltf(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const tinygltf::Model model, loadModel(path));
  return GltfReader(model, path.string()).read();
}

}  // namespace
}  // namespace volute

extern "C" const volute::SurfacePlugin* voluteGltfPlugin() {
  static constexpr volute::SurfacePlugin kPlugin{volute::readGltf};
  return &kPlugin;
}
