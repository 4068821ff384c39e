// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How volumes and billboards are written down, opened and changed by a person.
#include <cmath>

#include "volute/base/remark_log.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/json_members.hpp"
#include "volute/media/placement_parameters.hpp"
#include "volute/media/volume/volume_medium.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

Status parseBounds(const Members& members, const std::string& file, InputOptions& input) {
  if (!members.has("bounds"))
    return {};
  const Json& json = members.at("bounds");
  const auto expected = [&] {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: expected [[x, y, z], [x, y, z]], the least first [m]", file,
                members.where("bounds"));
  };
  if (!json.is_array() || json.size() != 2)
    return expected();
  Box3 box;
  VOLUTE_ASSIGN(box.min, jsonToVector(json[0], file, members.where("bounds") + "/0"));
  VOLUTE_ASSIGN(box.max, jsonToVector(json[1], file, members.where("bounds") + "/1"));
  if (!(box.min.array() < box.max.array()).all())
    return expected();
  input.bounds = box;
  return {};
}

Status parseBasis(const Members& members, const std::string& file, Appearance& appearance) {
  if (!members.has("basis"))
    return {};
  const Json& json = members.at("basis");
  if (json != "box" && json != "trilinear")
    return fail(ErrorCode::kInvalidData, "{}: {}: expected box or trilinear", file,
                members.where("basis"));
  appearance.basis = json == "box" ? Basis::kBox : Basis::kTrilinear;
  return {};
}

/// Of this file, whatever its appearance; read again where nobody has it.
Result<std::shared_ptr<VolumeMedium>> volumeOf(const std::string& file, InputOptions input,
                                               const Appearance& appearance,
                                               MediumContext& context) {
  input.partial = context.options.partial, input.verify = context.options.verify;
  const auto before = context.take<VolumeMedium>([&](const VolumeMedium& volume) {
    const InputOptions& options = volume.layer().options();
    const bool sameBounds = options.bounds.has_value() == input.bounds.has_value() &&
                            (!input.bounds || (options.bounds->min == input.bounds->min &&
                                               options.bounds->max == input.bounds->max));
    return volume.layer().path() == file && options.grid == input.grid && sameBounds;
  });
  if (before)
    return before->with(appearance);
  RemarkLog heard(context.reading.progress);
  Reading reading{heard, context.reading.maxMemory};
  VOLUTE_ASSIGN(auto layer, VolumeLayer::open(file, input, appearance, reading));
  auto medium = std::make_shared<VolumeMedium>(std::move(layer));
  medium->remarks = heard.remarks();
  return medium;
}

void addLight(ParameterGroup& group, const Appearance& look) {
  group.amount("emission", "emission", look.emission, 100, "/m").help =
      "radiance per metre where the volume's value is 1";
  group.amount("extinction", "extinction", look.extinction, 100, "/m").help =
      "where the volume's value is 1";
}

const VolumeLayer& layerOf(const SceneMedium& medium) {
  return dynamic_cast<const VolumeMedium&>(medium).layer();
}

class VolumeKind final : public MediumKind {
 public:
  std::string_view name() const override { return "volume"; }

  std::string_view plural() const override { return "volumes of voxels"; }

  std::string_view singular() const override { return "a volume of voxels"; }

  std::vector<std::string_view> members() const override {
    return {"field", "bounds", "basis", "emission", "extinction", "transform", "time"};
  }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto volume, parseVolume(entry, context.file, context.path));
    VOLUTE_ASSIGN(auto medium, volumeOf(volume.file, volume.input, volume.appearance, context));
    return std::shared_ptr<SceneMedium>(std::move(medium));
  }

  /// What no other kind takes: reading it says what is wrong with it.
  bool opens(const std::string&) const override { return true; }

  void addParameters(ParameterGroup group, const OrderedJson&, const SceneMedium& medium,
                     bool) const override {
    const Appearance& look = layerOf(medium).appearance();
    addLight(group, look);
    addPlacement(group, look.placement, medium.info().fileBounds);
    group.clock(look.clock, medium.info());
  }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson&, const std::vector<double>& numbers) const override {
    if (!key.starts_with("transform/"))
      return false;
    setPlacement(entry, layerOf(medium).appearance().placement, medium.info().fileBounds,
                 key.substr(key.find('/') + 1), numbers);
    return true;
  }
};

class BillboardKind final : public MediumKind {
 public:
  std::string_view name() const override { return "billboard"; }

  std::string_view plural() const override { return "billboards"; }

  std::string_view singular() const override { return "a billboard"; }

  std::vector<std::string_view> members() const override {
    return {"position", "size", "alpha", "emission", "extinction", "time", "rows"};
  }

  std::string_view list() const override { return "billboards"; }

  std::vector<std::string_view> fileMembers() const override { return {"volume"}; }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto board, parseBillboard(entry, context.file, context.path));
    VOLUTE_ASSIGN(const auto volume, volumeOf(board.file, {}, board.appearance, context));
    return std::make_shared<BillboardMedium>(*volume, board);
  }

  /// A picture of a volume that turns to the eye.
  void addParameters(ParameterGroup group, const OrderedJson&, const SceneMedium& medium,
                     bool) const override {
    const auto& board = dynamic_cast<const BillboardMedium&>(medium);
    const BillboardOptions& options = board.options();
    addLight(group, board.layer().appearance());
    group
        .choice("hides", "alpha", {"transmittance", "intensity"},
                options.alpha == BillboardAlpha::kIntensity ? "intensity" : "transmittance")
        .help =
        "what is behind it: by what the volume lets through, or, for fire that does not "
        "absorb, by how bright it is";
    group.integer("rows", "rows", options.rows, 16, 512).help = "of its texture";
    group.section("placement");
    const double size = std::hypot(options.width, options.height);
    group.point("middle", "position", options.position, "m", size / 500).help = "of the rectangle";
    group.range("width", "size/0", options.width, 0.05, 10, "m").logarithmic = true;
    Parameter& height = group.range("height", "size/1", options.height, 0.05, 10, "m");
    height.logarithmic = true;
    height.help = "the volume's own height fills it";
    group.section("");
    group.clock(board.layer().appearance().clock, medium.info());
  }
};

}  // namespace

Result<SceneVolume> parseVolume(const Json& json, const std::string& file,
                                const std::string& path) {
  constexpr std::string_view kNames[] = {"kind",       "file",      "field", "bounds", "basis",
                                         "emission",   "extinction", "transform", "time"};
  if (!json.contains("file") || !json["file"].is_string())
    return fail(ErrorCode::kInvalidData, "{}: {}/file: expected the name of a volume", file, path);
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneVolume volume;
  volume.file = besides(file, json["file"].get<std::string>());
  if (members.has("field"))
    VOLUTE_TRY(members.text("field", volume.input.grid, "the name of a grid"));
  VOLUTE_TRY(parseBounds(members, file, volume.input));
  Appearance& appearance = volume.appearance;
  VOLUTE_TRY(parseBasis(members, file, appearance));
  VOLUTE_TRY(members.number("emission", appearance.emission));
  VOLUTE_TRY(members.number("extinction", appearance.extinction));
  if (members.has("transform")) {
    VOLUTE_ASSIGN(appearance.placement,
                  parsePlacement(members.at("transform"), file, members.where("transform")));
  }
  if (members.has("time")) {
    VOLUTE_ASSIGN(appearance.clock, parseClock(members.at("time"), file, members.where("time")));
  }
  return volume;
}

const MediumKind& volumeKind() {
  static const VolumeKind kind;
  return kind;
}

const MediumKind& billboardKind() {
  static const BillboardKind kind;
  return kind;
}

}  // namespace volute
