// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_subject.hpp"

#include "volute/cli/smoke_arguments.hpp"
#include "volute/scene/scene_file.hpp"

namespace volute::cli {
namespace {

InputOptions inputOptions(const Arguments& arguments) {
  return {.grid = arguments.find<std::string>("grid").value_or(""),
          .bounds = arguments.find<Box3>("bounds"),
          .partial = arguments.flag("partial")};
}

std::optional<Basis> basisOf(const Arguments& arguments) {
  const auto name = arguments.find<std::string>("basis");
  if (!name)
    return std::nullopt;
  return *name == "box" ? Basis::kBox : Basis::kTrilinear;
}

/// Whether the command line asks for a contour of the visibility S = C / K.
bool contoursVisibility(const Arguments& arguments) {
  return arguments.given("isosurface") ||
         (arguments.given("slice") && arguments.get<std::string>("slice-shows") == "visibility");
}

constexpr std::string_view kIdleC =
    "plays no part in a photometric picture; choose the mode threshold, or leave it out";

/// --C where nothing depends on it.
Status checkC(const Arguments& arguments, const PictureLaw& law) {
  if (!arguments.given("C") || law.mode == PictureMode::kThreshold || contoursVisibility(arguments))
    return {};
  return fail(ErrorCode::kInvalidArgument, "--C: {}", kIdleC);
}

/// The same of a scene's smoke: a remark, since a command line may choose the mode.
void remarkOnC(const SmokeDescription& smoke, const Arguments& arguments, const PictureLaw& law,
               Progress& progress) {
  const bool counts = law.mode == PictureMode::kThreshold || contoursVisibility(arguments) ||
                      smoke.model.quantity == SmokeQuantity::kVisibility || isSmvPath(smoke.file);
  if (smoke.givesC && !counts)
    progress.remark(fmt::format("{}/C: {}", smoke.where, kIdleC));
}

Result<RenderSubject> openVolumeSubject(const std::string& path, const Arguments& arguments,
                                        Context& context) {
  for (const Option& option : smokeOptions()) {
    if (arguments.given(option.name))
      return fail(ErrorCode::kInvalidArgument,
                  "--{} is for smoke on a mesh and FDS cases; {} is a volume of voxels",
                  option.name, path);
  }
  Appearance appearance;
  appearance.emission = arguments.get<double>("emission");
  // Fire does not absorb by default; an optical depth of nothing would say nothing.
  appearance.extinction =
      arguments.find<double>("extinction").value_or(arguments.given("aov") ? 1 : 0);
  appearance.basis = basisOf(arguments);
  RenderSubject subject;
  VOLUTE_ASSIGN(auto layer, VolumeLayer::open(path, inputOptions(arguments), appearance, context));
  subject.layers.push_back(std::move(layer));
  return subject;
}

Result<std::shared_ptr<const SmokeLighting>> smokeLighting(const SceneLights& lights,
                                                           const TriangleScene& geometry,
                                                           const Arguments& arguments,
                                                           Context& context) {
  SmokeLighting lighting{lights, std::nullopt, blocksOf(geometry), keyOf(geometry)};
  if (!lights.lamps.empty()) {
    VOLUTE_ASSIGN(lighting.cache, lightCache(arguments, context));
  }
  return std::make_shared<const SmokeLighting>(std::move(lighting));
}

/// A case alone: black smoke before white, so that the picture is what passes of the light.
Result<RenderSubject> openSmokeSubject(const std::string& path, const Arguments& arguments,
                                       Context& context) {
  for (const char* name : {"grid", "bounds", "emission", "extinction", "basis"}) {
    if (arguments.given(name))
      return fail(ErrorCode::kInvalidArgument, "--{} is for volumes of voxels; {} is a mesh", name,
                  path);
  }
  VOLUTE_ASSIGN(const auto description, smokeOf(path, arguments));
  if (description.model.quantity != SmokeQuantity::kVisibility)
    VOLUTE_TRY(checkC(arguments, description.law));
  VOLUTE_ASSIGN(const auto lighting, smokeLighting({}, {}, arguments, context));
  RenderSubject subject;
  VOLUTE_ASSIGN(auto smoke, SmokeLayer::open(description, lighting, context));
  subject.smokes.push_back(std::move(smoke));
  subject.law = description.law;
  subject.background = Rgb::Ones();
  return subject;
}

/// An FDS case alone, in even white light and before white.
Result<RenderSubject> openFdsSubject(const std::string& path, const Arguments& arguments,
                                     Context& context) {
  for (const char* name :
       {"grid", "bounds", "emission", "extinction", "basis", "quantity", "unit"}) {
    if (arguments.given(name)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{}: the FDS case {} says this itself; --field names one of its sources", name,
                  path);
    }
  }
  VOLUTE_ASSIGN(const auto description, smokeOf(path, arguments));
  RenderSubject subject;
  subject.lights.ambient = Rgb::Ones();
  VOLUTE_ASSIGN(auto fds, FdsLayer::open(description, subject.lights, {}, context));
  subject.fdsCases.push_back(std::move(fds));
  subject.law = description.law;
  subject.background = Rgb::Ones();
  return subject;
}

/// The scene's, or the command line's instead.
Result<PictureLaw> lawOf(const SceneDescription& scene, const Arguments& arguments) {
  PictureLaw law = scene.smokes.empty() ? PictureLaw{} : scene.smokes.front().law;
  if (const auto mode = arguments.find<std::string>("mode")) {
    VOLUTE_ASSIGN(law.mode, pictureMode(*mode));
  }
  if (const auto c = arguments.find<std::string>("C")) {
    auto found = visibilityLaw(*c);
    if (!found)
      return fail(ErrorCode::kInvalidArgument, "--C: {}", found.error().message);
    law.c = found->c;
    VOLUTE_TRY(checkC(arguments, law));
  }
  return law;
}

Status openSmokes(const SceneDescription& scene, const Arguments& arguments, RenderSubject& subject,
                  Context& context) {
  VOLUTE_ASSIGN(subject.law, lawOf(scene, arguments));
  if (scene.smokes.empty())
    return {};
  VOLUTE_ASSIGN(const auto lighting,
                smokeLighting(scene.lights, subject.geometry, arguments, context));
  for (const SmokeDescription& description : scene.smokes) {
    remarkOnC(description, arguments, subject.law, context.progress);
    if (isSmvPath(description.file)) {
      VOLUTE_ASSIGN(auto fds,
                    FdsLayer::open(description, scene.lights, blocksOf(subject.geometry), context));
      subject.fdsCases.push_back(std::move(fds));
      continue;
    }
    VOLUTE_ASSIGN(auto smoke, SmokeLayer::open(description, lighting, context));
    subject.smokes.push_back(std::move(smoke));
  }
  return {};
}

Status openBillboards(const SceneDescription& scene, RenderSubject& subject, Context& context) {
  for (const SceneBillboard& board : scene.billboards) {
    VOLUTE_ASSIGN(auto volume, VolumeLayer::open(board.file, {}, board.appearance, context));
    BillboardOptions options = board.options;
    options.shown = volume.info().bounds;
    subject.billboards.push_back({std::move(volume), options});
  }
  return {};
}

Result<RenderSubject> openScene(const std::string& path, const Arguments& arguments,
                                Context& context) {
  for (const char* name : {"grid",          "bounds",      "emission",
                           "extinction",    "field",       "quantity",
                           "unit",          "scale",       "mass-extinction",
                           "soot-yield",    "material",    "burning",
                           "density-field", "albedo",      "clamp",
                           "fire",          "fire-cutoff", "fire-temperature",
                           "devices",       "fds-slice",   "fds-slice-range"}) {
    if (!arguments.given(name))
      continue;
    return fail(ErrorCode::kInvalidArgument, "--{} is for a single file; write it into the scene",
                name);
  }
  VOLUTE_ASSIGN(auto scene, readScene(path));
  RenderSubject subject;
  subject.scene = true;
  subject.camera = scene.camera;
  subject.background = scene.background;
  subject.signs = std::move(scene.signs);
  for (SceneVolume& volume : scene.volumes) {
    volume.appearance.basis = basisOf(arguments);
    VOLUTE_ASSIGN(auto layer, VolumeLayer::open(volume.file, inputOptions(arguments),
                                                volume.appearance, context));
    subject.layers.push_back(std::move(layer));
  }
  subject.lights = scene.lights;
  VOLUTE_ASSIGN(subject.geometry, loadGeometry(scene.geometry, context));
  VOLUTE_TRY(openBillboards(scene, subject, context));
  for (FogDescription& description : scene.fogs) {
    description.scattering.shadows = fogShadows(subject.geometry, scene.lights.suns);
    VOLUTE_ASSIGN(auto fog, FogLayer::open(description, scene.lights.suns, context));
    subject.fogs.push_back(std::move(fog));
  }
  VOLUTE_TRY(openSmokes(scene, arguments, subject, context));
  return subject;
}

}  // namespace

Result<RenderSubject> openSubject(const std::string& path, const Arguments& arguments,
                                  Context& context) {
  if (extensionOf(path) == ".json")
    return openScene(path, arguments, context);
  if (isSmvPath(path))
    return openFdsSubject(path, arguments, context);
  return isSmokeCase(path) ? openSmokeSubject(path, arguments, context)
                           : openVolumeSubject(path, arguments, context);
}

}  // namespace volute::cli
