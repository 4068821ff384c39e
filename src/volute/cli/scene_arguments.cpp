// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_arguments.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/cli/file_kind.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/scene/kinds.hpp"

namespace volute::cli {

using OrderedJson = nlohmann::ordered_json;

namespace {

/// Members of the media of a scene that the command line overrides.
constexpr const char* kOfScenes[] = {"basis", "interpolate"};

}  // namespace

std::vector<Option> mediumOptions(FieldUse use) {
  registerUsualMedia();
  std::vector<const FieldTable*> tables;
  for (const MediumKind* kind : mediumKinds()) {
    if (kind->list() == "media" && !kind->assumes())
      tables.push_back(&kind->fields());
  }
  return fieldOptions(tables, use);
}

Result<OrderedJson> mediumMembers(const std::string& path, const Arguments& arguments) {
  registerUsualMedia();
  VOLUTE_TRY(refuseIdle(arguments, {shownKind(path)}));
  if (isScenePath(path))
    return OrderedJson::object();
  const MediumKind& kind = *mediumKindOf(path, true);
  if (kind.assumes())
    return OrderedJson::object();
  VOLUTE_ASSIGN(auto members, membersOf(kind.fields(), arguments));
  const auto rate = arguments.find<double>("fps");
  if (rate && kind.fields().find("fps"))
    members["fps"] = *rate;
  return OrderedJson(std::move(members));
}

Error aboutOptions(Error error, const std::string& path) {
  constexpr std::string_view kEntry = "/media/0";
  if (isScenePath(path) || error.path != path || !error.member.starts_with(kEntry) ||
      error.statement.empty())
    return error;
  const std::string_view rest = std::string_view(error.member).substr(kEntry.size());
  if (!rest.starts_with('/')) {
    error.message = fmt::format("{}{}: {}", path, rest, error.statement);
    return error;
  }
  const std::size_t end = std::min(rest.find_first_of("/[", 1), rest.size());
  const std::string option =
      optionOfMember(mediumKindOf(path, true)->fields(), std::string(rest.substr(1, end - 1)));
  if (option.empty())
    return error;
  error.member = fmt::format("{}{}", option, rest.substr(end));
  error.message = error.statement;
  error.path.clear();
  error.code = ErrorCode::kInvalidArgument;
  return error;
}

Result<SceneOptions> sceneOptions(const std::string& path, const Arguments& arguments,
                                  const Context& context) {
  SceneOptions options;
  options.maxMemory = context.maxMemory;
  options.files.partial = arguments.flag("partial");
  VOLUTE_ASSIGN(options.members, mediumMembers(path, arguments));
  for (const char* name : kOfScenes) {
    if (isScenePath(path) && arguments.given(name))
      (*options.overrides)[name] = arguments.get<std::string>(name);
  }
  return options;
}

Result<Scene> openScene(const std::string& path, const Arguments& arguments, Context& context,
                        bool measured) {
  VOLUTE_ASSIGN(auto options, sceneOptions(path, arguments, context));
  VOLUTE_ASSIGN(options.files.lightCache, lightCache(arguments, context));
  if (const auto scattering = arguments.find<std::string>("scattering"))
    options.multiple = *scattering == "multiple";
  if (arguments.flag("by-pieces") && context.team.size() > 1)
    options.files.team = &context.team;
  addUsualMembers(path,
                  {.measured = measured,
                   .depth = arguments.given("aov"),
                   .tree = arguments.find<std::string>("volume-method") == "tree",
                   .moves = arguments.given("shutter"),
                   .values = arguments.given("colormap")},
                  options);
  auto opened = Scene::open(path, options, context.progress);
  if (!opened)
    return tl::unexpected(aboutOptions(std::move(opened.error()), path));
  for (const char* name : kOfScenes) {
    const auto has = [&](const MediumEntry& entry) { return entry.kind->fields().find(name); };
    if (isScenePath(path) && arguments.given(name) &&
        std::ranges::none_of(opened->description().media, has))
      return fail(ErrorCode::kInvalidArgument, "--{} has no effect: {} has no volume", name, path);
  }
  return opened;
}

std::vector<Option> lightCacheOptions() {
  using enum ValueKind;
  return {{.name = "cache",
           .kind = kFile,
           .value = "DIR",
           .help = "folder for cached light of lamps in smoke, or none; if not given, "
                   "volute/light in the user's cache folder"},
          {.name = "cache-size",
           .kind = kBytes,
           .value = "BYTES",
           .help = "maximum size of that cache",
           .initial = "1G"}};
}

Result<std::shared_ptr<const LightCache>> lightCache(const Arguments& arguments, Context& context) {
  const auto limit =
      arguments.find<Bytes>("cache-size").value_or(Bytes()).count;  // not of all commands
  const auto folder = arguments.find<std::string>("cache");
  if (folder == "none" && arguments.given("cache-size"))
    return fail(ErrorCode::kInvalidArgument, "--cache-size has no effect with --cache none");
  if (limit == 0 || folder == "none")
    return nullptr;
  if (folder) {
    VOLUTE_ASSIGN(auto cache, LightCache::open(*folder, limit));
    return std::make_shared<const LightCache>(std::move(cache));
  }
  if (LightCache::usualFolder().empty())
    return nullptr;
  auto cache = LightCache::open(LightCache::usualFolder(), limit);
  if (cache)
    return std::make_shared<const LightCache>(std::move(*cache));
  context.progress.remark("light is not kept: " + cache.error().message);
  return nullptr;
}

Result<GlSmokeMethod> smokeMethodOf(const Arguments& arguments, bool gl) {
  const auto name = arguments.get<std::string>("smoke-method");
  if (!gl && name != "auto") {
    return fail(ErrorCode::kInvalidArgument,
                "--smoke-method: {} is a way to draw with OpenGL; add --renderer gl", name);
  }
  return name == "auto"    ? GlSmokeMethod::kAuto
         : name == "march" ? GlSmokeMethod::kMarch
                           : GlSmokeMethod::kProject;
}

Status takeCamera(const Arguments& arguments, RenderRequest& request) {
  ViewParts parts{arguments.find<Vec3>("eye"),
                  arguments.find<Vec3>("target"),
                  {},
                  arguments.find<double>("fov"),
                  arguments.find<double>("ortho")};
  if (arguments.given("up"))  // it has a default
    parts.up = arguments.find<Vec3>("up");
  if (const auto file = arguments.find<std::string>("camera")) {
    if (parts.any())
      return fail(
          ErrorCode::kInvalidArgument,
          "--camera names a whole view; leave out --eye, --target, --up, --fov and --ortho");
    VOLUTE_ASSIGN(request.camera, readCamera(*file));
    return {};
  }
  if (!parts.any())
    return {};
  VOLUTE_ASSIGN(auto members, membersOf(cameraFields(), arguments));
  const bool placed = parts.eye && parts.target, whole = placed && (parts.fov || parts.ortho);
  const Vec3 up = parts.up.value_or(Vec3::UnitZ());
  const Vec3 eye = parts.eye.value_or(Vec3::Zero());
  const Vec3 aside = up.norm() > 0 ? up.unitOrthogonal() : Vec3(Vec3::UnitX());
  const Vec3 target = placed ? *parts.target : Vec3(eye + aside);
  // What is left open must not be what is wrong.
  members["eye"] = {eye.x(), eye.y(), eye.z()};
  members["target"] = {target.x(), target.y(), target.z()};
  if (!parts.fov && !parts.ortho)
    members["fov"] = Camera::kUsualFov;
  VOLUTE_ASSIGN(auto camera, parseCamera(members, {}));
  whole ? void(request.camera = camera) : void(request.parts = parts);
  return {};
}

}  // namespace volute::cli
