// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_fields.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/media/field_members.hpp"
#include "volute/media/placement_parameters.hpp"

namespace volute {
namespace {

FieldValue volumeTransform(const SceneVolume& volume) {
  const Placement& placement = volume.appearance.placement;
  return transformValue(affine(placement.turn * placement.scale.asDiagonal(), placement.offset));
}

Status setVolumeTransform(SceneVolume& volume, const FieldValue& value) {
  VOLUTE_ASSIGN(volume.appearance.placement, placementFrom(value));
  return {};
}

FieldValue boundsOf(const SceneVolume& volume) {
  const auto& box = volume.input.bounds;
  if (!box)
    return {};
  return {{box->min.x(), box->min.y(), box->min.z()}, {box->max.x(), box->max.y(), box->max.z()}};
}

Status setBounds(SceneVolume& volume, const FieldValue& value) {
  Box3 box;
  if (value.size() == 2) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[static_cast<int>(axis)] = value[0][axis].get<double>();
      box.max[static_cast<int>(axis)] = value[1][axis].get<double>();
    }
  }
  if (box.empty() || !(box.min.array() < box.max.array()).all())
    return fail(ErrorCode::kInvalidData, "expected [[x, y, z], [x, y, z]], the minimum first [m]");
  volume.input.bounds = box;
  return {};
}

FieldValue upOf(const SceneVolume& volume) {
  const char up = volume.input.stated.up;
  return up == 0 ? FieldValue() : FieldValue(std::string(1, up));
}

Status setUp(SceneVolume& volume, const FieldValue& value) {
  volume.input.stated.up = value.get<std::string>().front();
  return {};
}

FieldValue rateOf(const SceneVolume& volume) {
  const auto& rate = volume.input.stated.framesPerSecond;
  return rate ? FieldValue(*rate) : FieldValue();
}

Status setRate(SceneVolume& volume, const FieldValue& value) {
  volume.input.stated.framesPerSecond = value.get<double>();
  return {};
}

void addVolumePlacement(ParameterGroup& group, const void* volume, const MediumFacts& facts) {
  addPlacement(group, static_cast<const SceneVolume*>(volume)->appearance.placement, facts.bounds);
}

/// Even light is scattered alike whatever the asymmetry.
bool scattersSuns(const void* volume, const MediumFacts& facts) {
  const Appearance& appearance = static_cast<const SceneVolume*>(volume)->appearance;
  return facts.suns && (appearance.albedo > 0).any();
}

bool hasNoTransfer(const void* volume, const MediumFacts& /*facts*/) {
  return !static_cast<const SceneVolume*>(volume)->appearance.transfer;
}

double boardStep(const void* board, const MediumFacts& /*facts*/) {
  const BillboardOptions& options = static_cast<const SceneBillboard*>(board)->options;
  return std::hypot(options.width, options.height) / 500;
}

}  // namespace

const FieldTable& volumeFields() {
  using enum FieldType;
  static constexpr std::string_view kBases[] = {"box", "trilinear", "cubic"};
  static constexpr std::string_view kInterpolations[] = {"none", "auto", "linear", "velocity"};
  static constexpr std::string_view kUps[] = {"x", "y", "z"};
  static constexpr std::string_view kLights[] = {"auto", "always", "never"};
  static constexpr std::string_view kPresets[] = {"none", "auto", "fire", "smoke",
                                                  "fire-and-smoke"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "file", .type = kFile, .access = member<&SceneVolume::file>(),
       .help = "a volume: .volute, .npy, .npz, .vdb, .nvdb, .vti, .pvd or .smv, or a pattern or folder of "
       "numbered files; an array of .nc, .h5 or .zarr (run.nc:soot)", .required = true},
      {.name = "field", .type = kText,
       .access = member<&SceneVolume::input, &InputOptions::grid>(),
       .help = "grid or field of a file with several", .otherName = "grid", .option = {"NAME"}},
      {.name = "bounds", .type = kRows, .access = customMember<SceneVolume, boundsOf, setBounds>(),
       .help = "two corners, the minimum first: states the extent of an array, crops or pads others",
       .unit = "m",
       .option = {"X0,Y0,Z0,X1,Y1,Z1"}},
      emissionField<&SceneVolume::appearance, true, hasNoTransfer>(),
      extinctionField<&SceneVolume::appearance, true, hasNoTransfer>(),
      {.name = "albedo", .type = kColor,
       .access = member<&SceneVolume::appearance, &Appearance::albedo>(),
       .help = "scattered share of the extinction; the rest is absorbed",
       .least = 0, .most = 1,
       .option = {.value = "R,G,B", .picture = true},
       .slider = {.label = "albedo", .shown = hasNoTransfer}},
      {.name = "asymmetry", .access = member<&SceneVolume::appearance, &Appearance::asymmetry>(),
       .help = "g of the Henyey-Greenstein phase function; above 0: forward scattering",
       .least = -0.99, .most = 0.99, .option = {.value = "G", .picture = true},
       .slider = {.label = "asymmetry", .least = -0.9, .most = 0.9, .shown = scattersSuns}},
      {.name = "color_field", .type = kText,
       .access = member<&SceneVolume::appearance, &Appearance::colors>(),
       .help = "a grid with three channels, or the common prefix of three (_r, _g, _b), that "
               "colours the albedo; the brightest channel of each voxel counts as 1"},
      {.name = "flames", .type = kObject,
       .access = optionalPart<&SceneVolume::appearance, &Appearance::flames>(),
       .help = "glowing black bodies in the volume", .table = &flameFields()},
      {.name = "transfer", .type = kObject,
       .access = optionalPart<&SceneVolume::appearance, &Appearance::transfer>(),
       .help = "transfer function: values as colours, instead of emission, extinction, albedo, flames "
               "and preset", .table = &transferFields()},
      {.name = "lights_scene", .type = kChoice,
       .access = member<&SceneVolume::appearance, &Appearance::lightsScene>(),
       .help = "whether its emission lights surfaces, fog and other volumes, as up to 8 lamps; auto: "
               "if it has flames", .choices = kLights},
      {.name = "preset", .type = kChoice, .access = member<&SceneVolume::preset>(),
       .help = "default appearance, from the names and ranges of the grids: fire, smoke, or both",
       .choices = kPresets,
       .option = {.value = "NAME", .more = "; auto where it is not given, except with --measured or "
                                           "--emission", .picture = true}},
      {.name = "basis", .type = kChoice,
       .access = member<&SceneVolume::appearance, &Appearance::basis>(),
       .help = "interpolation between voxel centres; cubic: B-splines, for close views; if not "
               "given, what the file states, else cubic where a voxel covers more than 3 pixels in "
               "the closest view, and trilinear elsewhere; in measured pictures the file's own",
       .choices = kBases, .option = {.value = "NAME", .scene = true}},
      {.name = "interpolate", .type = kChoice,
       .access = member<&SceneVolume::appearance, &Appearance::interpolation>(),
       .help = "between frames: velocity: move along a velocity grid (velocity, vel or v, or "
               "three with _x, _y, _z); linear: fade from one to the next; auto: velocity if "
               "there is such a grid, else linear", .choices = kInterpolations,
       .option = {.value = "HOW", .scene = true}},
      {.name = "velocity_scale",
       .access = member<&SceneVolume::appearance, &Appearance::velocityScale>(),
       .help = "factor applied to the velocity grid"},
      {.name = "velocity_unit", .type = kChoice,
       .access = member<&SceneVolume::appearance, &Appearance::velocityUnit>(),
       .help = "unit of the velocity grid; a frame is from one whole frame number to the next",
       .choices = kVelocityUnits, .option = {.value = "UNIT", .scene = true}},
      {.name = "up", .type = kChoice, .access = customMember<SceneVolume, upOf, setUp>(),
       .help = "up axis of the file, which is turned upwards before the transform; if not given, what "
               "the file says, else z", .choices = kUps, .option = {.value = "AXIS", .name = "file-up"}},
      {.name = "fps",
       .access = customMember<SceneVolume, rateOf, setRate>(),
       .help = "frames per second of a sequence, instead of the times that the file states; frame n "
               "is at (n - first) / fps", .unit = "1/s", .least = 0, .above = true},
      {.name = "transform", .type = kNumbers,
       .access = customMember<SceneVolume, volumeTransform, setVolumeTransform>(),
       .help = "moves, turns, mirrors and scales along the volume's axes; row-major, last row 0, "
               "0, 0, 1", .count = 16, .slider = {.custom = addVolumePlacement}},
      clockField<&SceneVolume::appearance, &Appearance::clock>()};
  // clang-format on
  static const FieldTable kTable = fieldTable<SceneVolume>({.name = "volume",
                                                            .sentence = "a volume of voxels",
                                                            .fields = kFields,
                                                            .kind = "volume",
                                                            .thing = "a volume of voxels",
                                                            .things = "volumes of voxels"});
  return kTable;
}

const FieldTable& flameFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "field", .type = kText, .access = member<&Flames::field>(),
       .help = "the grid of flames; if not given, everything hot glows"},
      {.name = "scale", .access = member<&Flames::scale>(), .help = "factor applied to it first",
       .least = 0, .above = true},
      {.name = "brightness", .access = member<&Flames::brightness>(),
       .help = "luminance per metre of a flame of value 1, or at the hottest temperature",
       .unit = "1/m", .least = 0,
       .slider = {.label = "brightness", .least = 0, .most = 1000, .logarithmic = true, .room = 2}},
      {.name = "coolest", .access = member<&Flames::coolest>(),
       .help = "temperature of a flame of value 0, if no grid gives it", .unit = "K", .least = 500,
       .most = 6000, .slider = {.label = "coolest"}},
      {.name = "hottest", .access = member<&Flames::hottest>(),
       .help = "temperature of a flame of value 1, if no grid gives it", .unit = "K", .least = 500,
       .most = 6000, .slider = {.label = "hottest"}},
      {.name = "temperature", .type = kText, .access = member<&Flames::temperature>(),
       .help = "the temperature grid"},
      {.name = "kelvin", .access = member<&Flames::kelvin>(),
       .help = "kelvins per unit of the temperature grid",
       .unit = "K"},
      {.name = "zero", .access = member<&Flames::zero>(), .help = "temperature of its value 0",
       .unit = "K"}};
  // clang-format on
  static const FieldTable kTable = fieldTable<Flames>(
      {.name = "flames", .sentence = "glowing black bodies in a volume", .fields = kFields});
  return kTable;
}

const FieldTable& billboardFields() {
  using enum FieldType;
  static constexpr std::string_view kAlphas[] = {"transmittance", "intensity"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "volume", .type = kFile, .access = member<&SceneBillboard::file>(),
       .help = "a volume", .required = true},
      emissionField<&SceneBillboard::appearance, false>(),
      extinctionField<&SceneBillboard::appearance, false>(),
      {.name = "alpha", .type = kChoice,
       .access = member<&SceneBillboard::options, &BillboardOptions::alpha>(),
       .help = "what hides the background: the volume's transmittance, or, for fire that does not "
               "absorb, its brightness", .choices = kAlphas, .slider = {.label = "hides"}},
      {.name = "rows", .type = kInteger,
       .access = member<&SceneBillboard::options, &BillboardOptions::rows>(),
       .help = "height of its texture [pixels]", .least = 1, .most = 4096,
       .slider = {.label = "rows", .least = 16, .most = 512}},
      {.name = "position", .type = kPoint,
       .access = member<&SceneBillboard::options, &BillboardOptions::position>(),
       .help = "centre of the rectangle", .unit = "m", .required = true,
       .slider = {.label = "middle", .section = "placement", .step = boardStep}},
      {.name = "size", .type = kNumbers,
       .access = memberPair<&SceneBillboard::options, &BillboardOptions::width,
                            &BillboardOptions::height>(),
       .help = "width and height; the volume's height fills the rectangle", .unit = "m", .least = 0,
       .above = true, .count = 2, .required = true,
       .slider = {.label = "width|height", .least = 0.05, .most = 10, .logarithmic = true,
                  .section = "placement"}},
      clockField<&SceneBillboard::appearance, &Appearance::clock>()};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<SceneBillboard>({.name = "billboard",
                                  .sentence = "a volume drawn on a rectangle that faces the camera",
                                  .fields = kFields,
                                  .thing = "a billboard",
                                  .things = "billboards"});
  return kTable;
}

}  // namespace volute
