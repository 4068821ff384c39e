// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How volumes and billboards are written down, opened and changed by a person.
#include <nlohmann/json.hpp>

#include "volute/base/file_name.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/placement_parameters.hpp"
#include "volute/media/volume/volume_medium.hpp"
#include "volute/media/volume/volume_report.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr double kDusk = 0.6;
constexpr std::string_view kUsual = "automatic";  ///< of a choice that the scene leaves open

bool sameGrids(const Appearance& a, const Appearance& b) {
  const auto of = [](const Appearance& one) {
    const Flames flames = one.flames.value_or(Flames());
    return std::array<std::string, 3>{flames.field, flames.temperature,
                                      one.scatters() ? one.colors : ""};
  };
  return of(a) == of(b) && a.interpolation == b.interpolation &&
         a.velocityScale == b.velocityScale && a.velocityUnit == b.velocityUnit;
}

/// Lights of a picture that somebody takes: a sun from the left, and what is around. Beside fire,
/// for which a picture is exposed, smoke is as bright as at dusk.
void addStudio(VolumePreset preset, int version, VolumeLighting& lighting) {
  const double strength = preset != VolumePreset::kFireAndSmoke ? 1 : version < 2 ? 0.15 : kDusk;
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.85, 0.08, -0.62).normalized();
  sun.intensity = strength * Rgb(8, 7.6, 7);
  lighting.lamps.push_back(sun);
  lighting.surrounding = strength * Rgb(0.1, 0.12, 0.155);
}

/// Of this file, whatever its appearance; read again where nobody has it.
Result<std::shared_ptr<VolumeMedium>> volumeOf(const std::string& file, InputOptions input,
                                               const Appearance& appearance, MediumContext& context,
                                               std::shared_ptr<LoneFrame> frame = {}) {
  input.partial = context.options.partial, input.verify = context.options.verify;
  const auto before = context.take<VolumeMedium>([&](const VolumeMedium& volume) {
    const InputOptions& options = volume.options();
    const bool sameBounds = options.bounds.has_value() == input.bounds.has_value() &&
                            (!input.bounds || (options.bounds->min == input.bounds->min &&
                                               options.bounds->max == input.bounds->max));
    return volume.path() == file && options.grid == input.grid && sameBounds &&
           options.stated == input.stated && sameGrids(volume.appearance(), appearance);
  });
  if (before)
    return before->with(appearance);
  RemarkLog remarkLog(context.reading.progress);
  Reading reading = context.reading.with(remarkLog);
  VOLUTE_ASSIGN(auto medium,
                VolumeMedium::open(file, input, appearance, reading, std::move(frame)));
  medium->remarks = remarkLog.remarks();
  return medium;
}

/// For lines of sight and optical depths, where nothing says what the values are but their unit.
/// Where that says nothing either, kInvalidArgument if it is `needed`; else the medium as it is.
Result<std::shared_ptr<VolumeMedium>> ofItsUnit(std::shared_ptr<VolumeMedium> medium, bool needed,
                                                Progress& progress) {
  const VolumeInfo& info = medium->volume();
  const auto perMetre = extinctionByUnit(info);
  if (!perMetre && needed) {
    return failFor("extinction", ErrorCode::kInvalidArgument, Hint::set("extinction"),
                   "{}: '{}' is {}, which does not say how much light it takes away: it would hide "
                   "nothing",
                   medium->path(), info.name,
                   info.unit.empty() ? "without a unit" : fmt::format("in {}", info.unit));
  }
  if (!perMetre)
    return medium;
  Appearance appearance = medium->appearance();
  appearance.extinction = *perMetre;
  auto result = medium->with(appearance);
  Remark remark(RemarkCode::kAssumed,
                fmt::format("{}: '{}' is in {} and is taken as the extinction", medium->path(),
                            info.name, info.unit),
                {Hint::set("extinction")});
  progress.remark(std::move(remark).in(medium->path()));
  return result;
}

/// What is shown of the file: choices that a scene may leave open.
void addShown(ParameterGroup& group, const OrderedJson& entry, const VolumeMedium& medium,
              const MediumFacts& facts) {
  const Appearance& appearance = medium.appearance();
  const auto add = [&](const char* label, const char* key,
                       std::initializer_list<std::span<const std::string_view>> lists) {
    std::vector<std::string_view> choices;
    for (const auto& list : lists) choices.insert(choices.end(), list.begin(), list.end());
    const std::string said = entry.value(key, std::string(choices.front()));
    group.choice(label, key, choices, said).help = volumeFields().at(key).help;
  };
  const std::string_view usual[] = {kUsual};
  group.section("what is shown");
  const std::vector<std::string_view> grids(medium.gridNames().begin(), medium.gridNames().end());
  if (grids.size() > 1)
    add("field", "field", {usual, grids});
  // What is said of its light is a look of its own.
  if (!appearance.transfer && (entry.contains("preset") || !entry.contains("emission")))
    add("preset", "preset", {usual, volumeFields().at("preset").choices});
  const auto bases = volumeFields().at("basis").choices;
  add("between voxels", "basis", {usual, appearance.shaded() ? bases.subspan(1) : bases});
  if (facts.frames > 1)
    add("between frames", "interpolate", {volumeFields().at("interpolate").choices});
  add("file's up axis", "up", {usual, volumeFields().at("up").choices});
  addTransfer(group, appearance.transfer ? &*appearance.transfer : nullptr,
              appearance.transfer ? medium.values() : ValueCounts());
  group.section("");
}

/// Where values are light: what the file shows by itself. What cannot be read is said by whoever
/// opens it.
void sayOtherLook(const std::string& file, InputOptions input, const MediumContext& context,
                  Reading& reading, const std::shared_ptr<LoneFrame>& frame) {
  Progress quiet;
  Reading silent = reading.with(quiet);
  Appearance appearance;
  const auto preset = applyPreset(VolumePreset::kAuto, file, input, appearance, silent, frame);
  if (!preset || *preset == VolumePreset::kNone)
    return;
  const char* look = *preset == VolumePreset::kFire    ? "fire"
                     : *preset == VolumePreset::kSmoke ? "smoke"
                                                       : "fire and smoke";
  if (context.options.byTree) {
    reading.progress.remark(
        Remark(RemarkCode::kAssumed,
               fmt::format("{}: its values are shown as light: the tree draws nothing else", file),
               {Hint::set("volume_method", "bricks").so(fmt::format("shows it as {}", look))})
            .in(file));
    return;
  }
  reading.progress.remark(
      Remark(RemarkCode::kNote,
             fmt::format("{}: {}: its values are shown as light, as a volute-scene-1 means it; "
                         "\"preset\": \"auto\", or {}, shows it as {}",
                         context.file, context.path, kSceneFormat, look))
          .in(context.file, context.path));
}

/// Members of an entry that change nothing.
void tellOfIdle(const Json& entry, const VolumeMedium& medium, const MediumContext& context,
                Progress& progress) {
  const Appearance& appearance = medium.appearance();
  const bool lone = medium.info().times.size() < 2;
  const char* shown = appearance.transfer ? "transfer says what is shown" : nullptr;
  const char* still = lone ? "the file has one frame" : nullptr;
  const char* grey = appearance.albedo.maxCoeff() > 0 ? nullptr : "there is no albedo";
  const char* apart = lone                                                 ? still
                      : appearance.interpolation == Interpolation::kNone   ? "interpolate is none"
                      : appearance.interpolation == Interpolation::kLinear ? "interpolate is linear"
                                                                           : nullptr;
  const bool absorbs = appearance.extinction > 0 || appearance.transfer;
  const bool dark = entry.contains("extinction") && !absorbs;  // faded out
  const char* thin =
      absorbs || dark ? nullptr : "nothing extinguishes light, and so nothing scatters it";
  const std::pair<const char*, const char*> members[] = {
      {"emission", shown},   {"extinction", shown},     {"albedo", shown},
      {"flames", shown},     {"preset", shown},         {"time", still},
      {"fps", still},        {"velocity_scale", apart}, {"velocity_unit", apart},
      {"color_field", grey}, {"asymmetry", thin}};
  const bool inScene = extensionOf(context.file) == ".json";
  for (const auto& [member, why] : members) {
    if (!why || !entry.contains(member))
      continue;
    progress.remark(
        Remark{RemarkCode::kLeftOut, fmt::format("{}: {}{} has no effect: {}", context.file,
                                                 inScene ? context.path + '/' : "", member, why)}
            .in(context.file, context.path + '/' + member));
  }
}

/// What plain values stand for where they are no extinction by themselves.
void tellPlainValues(const VolumeMedium& medium, Progress& progress) {
  const VolumeInfo& info = medium.volume();
  const Appearance& appearance = medium.appearance();
  if (appearance.surface || appearance.shaded())
    return;
  std::string text;
  if (info.levelSet)
    text = "is a level set: it counts as 1 inside and as 0 outside, with an edge of one voxel";
  else if (info.channels == 3 && appearance.extinction != 0)
    text = "has three channels, whose mean is taken as the extinction";
  if (text.empty())
    return;
  progress.remark(
      Remark(RemarkCode::kAssumed, fmt::format("{}: '{}' {}", medium.path(), info.name, text))
          .in(medium.path()));
}

class VolumeKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return volumeFields(); }

  Result<std::shared_ptr<SceneMedium>> open(const Json& stated,
                                            MediumContext& context) const override {
    const bool sightOnly = context.options.sightOnly;
    const bool alone = extensionOf(context.file) != ".json";
    const bool byUnit = (sightOnly || context.options.depths) && context.version >= 2 &&
                        !stated.contains("extinction") && !stated.contains("transfer");
    // Fire does not absorb by default; an optical depth of nothing would say nothing. A preset that
    // is asked for has an extinction of its own.
    const bool ofOne =
        byUnit && alone && !sightOnly && (!stated.contains("preset") || stated["preset"] == "none");
    Json entry = stated;
    if (ofOne)
      entry["extinction"] = 1;
    VOLUTE_ASSIGN(auto volume,
                  readAs<SceneVolume>(volumeFields(), entry, {context.file, context.path}));
    const FieldOrigin origin{context.file, context.path};
    RemarkLog remarkLog(context.reading.progress);
    Reading reading = context.reading.with(remarkLog);
    InputOptions input = volume.input;
    input.partial = context.options.partial, input.verify = context.options.verify;
    const bool said =
        entry.contains("preset") || entry.contains("emission") || entry.contains("transfer");
    // Pictures are smooth where the file does not want otherwise; measurements take its own.
    const bool pictures = !context.options.measured && !context.options.byTree;
    const bool looks = context.version >= 2 && !said && pictures;
    const auto frame = std::make_shared<LoneFrame>();
    const bool otherLook = context.version < 2
                               ? pictures && !context.options.sightOnly
                               : context.options.byTree && !context.options.measured;
    if (otherLook && !said)
      sayOtherLook(volume.file, input, context, reading, frame);
    VOLUTE_ASSIGN(const auto preset,
                  applyPreset(
                      looks                        ? VolumePreset::kAuto
                      : volume.appearance.transfer ? VolumePreset::kNone
                                                   : volume.preset,
                      volume.file, input, volume.appearance, reading, frame,
                      [&](const char* name) { return entry.contains(name); }, byUnit));
    volume.input.grid = input.grid;
    VOLUTE_TRY(readFields(volumeFields(), entry, origin, &volume));  // what is said stands
    Appearance& appearance = volume.appearance;
    if (appearance.transfer) {
      appearance.emission = appearance.extinction = 0;
      appearance.albedo = Rgb::Zero();
      appearance.flames.reset();
    }
    const bool dark = entry.contains("extinction") && appearance.extinction == 0;  // faded out
    if (dark)
      appearance.albedo = Rgb::Zero();
    if (!appearance.transfer && !dark && entry.contains("albedo") && !(appearance.extinction > 0)) {
      return origin.wrong(FieldRow{.name = "albedo"},
                          "what extinguishes no light scatters none; say an extinction above 0");
    }
    if (entry.contains("extinction") && !dark && isNumpyPath(volume.file) && !volume.input.bounds &&
        !entry.contains("transform")) {
      remarkLog.remark(
          Remark(RemarkCode::kAssumed,
                 fmt::format("{}: no bounds are stated; the longest side is 1 m", volume.file),
                 {Hint::set("bounds")})
              .in(volume.file));
    }
    if (appearance.shaded() && appearance.basis == Basis::kBox) {
      return origin.wrong(FieldRow{.name = "basis"},
                          "what is lit or burns is drawn over the trilinear or the cubic basis");
    }
    appearance.refines = pictures;
    appearance.basisByView = pictures && context.version >= 2 && !appearance.basis;
    if (!appearance.basis && (appearance.shaded() || !context.options.measured))
      appearance.basis = Basis::kTrilinear;
    VolumeLighting lighting;
    lighting.firstSky = context.version < 2;
    lighting.albedo = appearance.albedo, lighting.asymmetry = appearance.asymmetry;
    lighting.lamps = context.lights.lamps;
    lighting.surrounding = context.lights.ambient;
    lighting.multiple = context.lights.multiple;
    lighting.surfaces = context.geometry;
    if (appearance.surface)
      lighting.lamps.clear(), lighting.surrounding = Rgb::Zero();  // they are the scene's
    if (preset != VolumePreset::kNone && context.lights.lamps.empty() &&
        !(context.lights.ambient.maxCoeff() > 0) && context.lights.suns.empty())
      addStudio(preset, context.version, lighting);
    if (appearance.extinction > 0 && !appearance.scatters() && !context.lights.suns.empty()) {
      remarkLog.remark(Remark(RemarkCode::kDoubtful,
                              fmt::format("{}: {}: it scatters no light of the sun; say its albedo",
                                          context.file, context.path))
                           .in(context.file, context.path));
    }
    VOLUTE_ASSIGN(auto medium, volumeOf(volume.file, volume.input, appearance, context, frame));
    if (byUnit && !appearance.surface && (ofOne || !said || appearance.extinction > 0)) {
      const VolumeInfo& info = medium->volume();
      const bool needed = ofOne ? !info.unit.empty() && !info.levelSet : sightOnly && !said;
      if (!ofOne || extinctionByUnit(info) != 1) {  // else it is so already
        VOLUTE_ASSIGN(medium, ofItsUnit(std::move(medium), needed, remarkLog));
      }
    }
    tellOfIdle(entry, *medium, context, remarkLog);
    tellPlainValues(*medium, remarkLog);
    medium->remarks.insert(medium->remarks.begin(), remarkLog.remarks().begin(),
                           remarkLog.remarks().end());
    medium->setLighting(std::move(lighting));
    return std::shared_ptr<SceneMedium>(std::move(medium));
  }

  /// What no other kind takes: reading it says what is wrong with it.
  bool opens(const std::string&) const override { return true; }

  Result<FileDescription> describe(const std::string& path, const DescribeRequest& request,
                                   Reading& reading) const override {
    return describeVolume(path, request, reading);
  }

  /// Of what a preset has chosen, too.
  void addParameters(ParameterGroup& group, const OrderedJson& entry, const SceneMedium& medium,
                     MediumFacts facts) const override {
    SceneVolume volume;
    if (!readFields(volumeFields(), Json(entry), {}, &volume))
      return;
    volume.appearance = dynamic_cast<const VolumeMedium&>(medium).appearance();
    addShown(group, entry, dynamic_cast<const VolumeMedium&>(medium), facts);
    addSliders(group, volumeFields(), &volume, facts);
  }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson& value, const std::vector<double>& numbers) const override {
    if (value == kUsual)
      return entry.erase(key), true;
    if (key.starts_with("transfer/")) {
      const auto& volume = dynamic_cast<const VolumeMedium&>(medium);
      return setTransfer(entry, key, value.is_string() ? value.get<std::string>() : "", numbers,
                         volume.values(), volume.info().bounds.size().norm());
    }
    if (!key.starts_with("transform/"))
      return false;
    setPlacement(entry, dynamic_cast<const VolumeMedium&>(medium).appearance().placement,
                 medium.info().fileBounds, key.substr(key.find('/') + 1), numbers);
    return true;
  }

  Result<std::optional<std::string>> editEntry(OrderedJson& entry, const std::string& key,
                                               bool more) const override {
    return editTransfer(entry, key, more);
  }
};

class BillboardKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return billboardFields(); }

  std::string_view list() const override { return "billboards"; }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto board,
                  readAs<SceneBillboard>(billboardFields(), entry, {context.file, context.path}));
    VOLUTE_ASSIGN(const auto volume, volumeOf(board.file, {}, board.appearance, context));
    return std::make_shared<BillboardMedium>(*volume, board);
  }
};

}  // namespace

const MediumKind& volumeKind() {
  static const VolumeKind kind;
  return kind;
}

const MediumKind& billboardKind() {
  static const BillboardKind kind;
  return kind;
}

}  // namespace volute
