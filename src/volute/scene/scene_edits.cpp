// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_edits.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/media/medium_kind.hpp"
#include "volute/media/placement_parameters.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;
using EditKind = SceneEdit::Kind;

constexpr double kSignOffWall = 0.02;  ///< [m]: how thick signs are
constexpr double kSpotOffWall = 0.1;   ///< [m]
constexpr double kBeside = 0.8;        ///< [m] from what was duplicated

OrderedJson jsonOf(const Vec3& v) {
  return OrderedJson::array({v.x(), v.y(), v.z()});
}

/// Three numbers of an object; `usual` where they are not there.
Vec3 vectorIn(const OrderedJson& object, const char* key, const Vec3& usual) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array() || found->size() != 3)
    return usual;
  return {(*found)[0].get<double>(), (*found)[1].get<double>(), (*found)[2].get<double>()};
}

OrderedJson& listOf(OrderedJson& json, const char* name) {
  OrderedJson& list = json[name];
  if (!list.is_array())
    list = OrderedJson::array();
  return list;
}

/// "exit", "exit 2", "exit 3": one that no sign has yet.
std::string freeName(const OrderedJson& signs, std::string name) {
  const auto taken = [&](const std::string& wanted) {
    return std::ranges::any_of(
        signs, [&](const OrderedJson& sign) { return sign.value("name", "") == wanted; });
  };
  const auto last = name.find_last_of(' ');
  const bool numbered = last != std::string::npos && last + 1 < name.size() &&
                        std::all_of(name.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                                    name.end(), [](unsigned char c) { return std::isdigit(c); });
  if (numbered)
    name.resize(last);
  if (!taken(name))
    return name;
  int number = 2;
  while (taken(fmt::format("{} {}", name, number))) ++number;
  return fmt::format("{} {}", name, number);
}

void placeSpot(OrderedJson& light, const SceneEdit& edit) {
  const Vec3 normal = edit.normal.normalized();
  const Vec3 position = edit.position + kSpotOffWall * normal;
  light["position"] = jsonOf(position);
  light["target"] = jsonOf(position + normal);
}

void placeSign(OrderedJson& sign, const SceneEdit& edit) {
  const Vec3 normal = edit.normal.normalized();
  sign["position"] = jsonOf(edit.position + kSignOffWall * normal);
  sign["normal"] = jsonOf(normal);
}

std::string addSign(OrderedJson& json, const SceneEdit& edit) {
  OrderedJson& signs = listOf(json, "signs");
  OrderedJson sign = {{"name", freeName(signs, "exit")}};
  placeSign(sign, edit);
  sign["size"] = {0.6, 0.3};
  sign["emitting"] = true;
  signs.push_back(sign);
  return fmt::format("sign '{}' is added", sign["name"].get<std::string>());
}

/// At its reach 1 arrives on each area that faces it.
std::string addSpot(OrderedJson& json, const SceneEdit& edit) {
  OrderedJson spot = {{"kind", "spot"}};
  placeSpot(spot, edit);
  spot["angle"] = 100.0;
  const double intensity = std::max(edit.reach * edit.reach, 1.0);
  spot["intensity"] = {intensity, intensity, intensity};
  listOf(json, "lights").push_back(std::move(spot));
  return "a lamp is added";
}

std::string addLight(OrderedJson& json, OrderedJson light, const char* what) {
  listOf(json, "lights").push_back(std::move(light));
  return what;
}

std::string addClip(OrderedJson& json, const SceneEdit& edit) {
  const bool box = edit.kind == EditKind::kAddClipBox;
  OrderedJson clip = {{"kind", box ? "box" : "plane"}};
  if (box)
    clip["min"] = jsonOf(edit.bounds.min), clip["max"] = jsonOf(edit.bounds.max);
  else
    clip["point"] = jsonOf(edit.position), clip["normal"] = jsonOf(edit.normal.normalized());
  listOf(json, "clip").push_back(std::move(clip));
  return box ? "a clip box is added" : "a clip plane is added";
}

/// The list that a path is of, and the place in it.
struct EntryPlace {
  OrderedJson* list = nullptr;
  std::size_t index = 0;
  const char* what = "light";

  bool sign() const { return what == std::string_view("sign"); }

  OrderedJson& entry() const { return (*list)[index]; }
};

Result<EntryPlace> placeOf(OrderedJson& json, const std::string& path) {
  constexpr std::pair<const char*, const char*> kLists[] = {
      {"signs", "sign"}, {"lights", "light"}, {"clip", "clip"}};
  for (const auto& [name, what] : kLists) {
    const std::string begin = fmt::format("/{}/", name);
    const std::string number = path.starts_with(begin) ? path.substr(begin.size()) : "";
    const bool digits =
        !number.empty() && number.size() < 9 &&
        std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c); });
    if (!digits || !json.contains(name))
      continue;
    const auto index = static_cast<std::size_t>(std::stoul(number));
    if (index < json[name].size())
      return EntryPlace{&json[name], index, what};
  }
  return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such sign, light or clip", path);
}

Result<std::string> duplicate(OrderedJson& json, const std::string& path) {
  VOLUTE_ASSIGN(const EntryPlace place, placeOf(json, path));
  OrderedJson copy = place.entry();
  // Along a sign's own rows, so that it stays on its wall; a lamp goes along x.
  Vec3 aside = Vec3::UnitX();
  if (place.sign()) {
    const Vec3 level = Vec3::UnitZ().cross(vectorIn(copy, "normal", Vec3::UnitX()));
    if (level.norm() > 0)
      aside = level.normalized();
    copy["name"] = freeName(*place.list, copy.value("name", "sign"));
  }
  for (const char* key : {"position", "target", "point", "min", "max"}) {
    if (copy.contains(key))
      copy[key] = jsonOf(vectorIn(copy, key, Vec3::Zero()) + kBeside * aside);
  }
  place.list->insert(place.list->begin() + static_cast<std::ptrdiff_t>(place.index) + 1, copy);
  return fmt::format("the {} is there twice", place.what);
}

Result<std::string> removeAt(OrderedJson& json, const std::string& path) {
  VOLUTE_ASSIGN(const EntryPlace place, placeOf(json, path));
  place.list->erase(place.index);
  return fmt::format("the {} is removed", place.what);
}

Result<std::string> placeAt(OrderedJson& json, const SceneEdit& edit) {
  VOLUTE_ASSIGN(const EntryPlace place, placeOf(json, edit.path));
  if (place.sign())
    placeSign(place.entry(), edit);
  else if (place.entry().value("kind", "") == "spot")
    placeSpot(place.entry(), edit);
  else
    return fail(ErrorCode::kInvalidArgument, "{}: this light comes from everywhere or from afar",
                edit.path);
  return std::string();
}

/// An entry of a list that a medium has, such as "/media/0/profile/knots/1"; nothing where there is
/// none.
Result<std::optional<std::string>> editEntry(OrderedJson& json, const std::string& path,
                                             bool more) {
  const std::size_t list = path.find('/', 1);
  const std::size_t key = list == std::string::npos ? list : path.find('/', list + 1);
  if (key == std::string::npos)
    return std::nullopt;
  const OrderedJson::json_pointer entry(path.substr(0, key));
  if (!json.contains(entry))
    return std::nullopt;
  const nlohmann::json plain = json[entry];
  const auto kind = mediumKindOf(plain, path.substr(1, list - 1), "scene", path);
  if (!kind)
    return std::nullopt;
  return (*kind)->editEntry(json[entry], path.substr(key + 1), more);
}

/// What both kinds have in common.
void copyLook(const OrderedJson& from, OrderedJson& to, double brighter) {
  const double emission = brighter * from.value("emission", 1.0);
  if (emission != 1)
    to["emission"] = emission;
  if (const double extinction = from.value("extinction", 0.0); extinction != 0)
    to["extinction"] = brighter * extinction;
  if (from.contains("time"))
    to["time"] = from["time"];
}

/// The entry of a list, which is taken out of it; null where there is none of this kind.
OrderedJson taken(OrderedJson& json, const char* list, const std::string& path, const char* kind) {
  const std::string begin = fmt::format("/{}/", list);
  for (std::size_t i = 0; json.contains(list) && i < json[list].size(); ++i) {
    if (path != begin + std::to_string(i))
      continue;
    OrderedJson entry = json[list][i];
    if (kind && entry.value("kind", "") != kind)
      return {};
    json[list].erase(i);
    return entry;
  }
  return {};
}

/// The volume's light is that of the file's own size, so what was scaled becomes as bright.
Result<std::string> makeBillboard(OrderedJson& json, const SceneEdit& edit) {
  const OrderedJson volume = taken(json, "media", edit.path, "volume");
  if (volume.is_null() || edit.bounds.empty())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such volume", edit.path);
  Placement placement;
  if (volume.contains("transform")) {
    VOLUTE_ASSIGN(placement, placementFrom(nlohmann::json(volume["transform"])));
  }
  const PlacementWords words = wordsOf(placement, edit.bounds);
  const Vec3 size = words.scale.cwiseProduct(edit.bounds.size());
  OrderedJson board = {{"volume", volume.at("file")}};
  board["position"] = jsonOf(words.middle);
  board["size"] = {size.head<2>().norm(), size.z()};  // as wide as it is from any side
  copyLook(volume, board, words.scale.z());
  listOf(json, "billboards").push_back(std::move(board));
  return std::string("the volume is a billboard");
}

Result<std::string> makeVolume(OrderedJson& json, const SceneEdit& edit) {
  const OrderedJson board = taken(json, "billboards", edit.path, nullptr);
  if (board.is_null() || edit.bounds.empty())
    return fail(ErrorCode::kInvalidArgument, "{}: the scene has no such billboard", edit.path);
  const double scale = board.at("size").at(1).get<double>() / edit.bounds.size().z();
  OrderedJson volume = {{"kind", "volume"}, {"file", board.at("volume")}};
  copyLook(board, volume, 1 / scale);
  const Vec3 position = vectorIn(board, "position", Vec3::Zero());
  setPlacement(volume, {Vec3::Constant(scale), position - scale * edit.bounds.centre()},
               edit.bounds, "middle", {position.x(), position.y(), position.z()});
  listOf(json, "media").push_back(std::move(volume));
  if (json["billboards"].empty())
    json.erase("billboards");
  return std::string("the billboard is a volume");
}

}  // namespace

Result<std::string> applyEdit(OrderedJson& json, const SceneEdit& edit) {
  switch (edit.kind) {
    case EditKind::kAddSign:
      return addSign(json, edit);
    case EditKind::kAddSpot:
      return addSpot(json, edit);
    case EditKind::kAddSun:
      return addLight(
          json, {{"kind", "sun"}, {"direction", {0.4, 0.5, -0.6}}, {"radiance", {2, 1.9, 1.7}}},
          "a sun is added");
    case EditKind::kAddAmbient:
      return addLight(json, {{"kind", "ambient"}, {"radiance", {0.2, 0.2, 0.2}}},
                      "light from everywhere is added");
    case EditKind::kAddClipBox:
    case EditKind::kAddClipPlane:
      return addClip(json, edit);
    case EditKind::kDuplicate:
    case EditKind::kRemove: {
      const bool more = edit.kind == EditKind::kDuplicate;
      VOLUTE_ASSIGN(auto done, editEntry(json, edit.path, more));
      if (done)
        return std::move(*done);
      return more ? duplicate(json, edit.path) : removeAt(json, edit.path);
    }
    case EditKind::kBillboard:
      return makeBillboard(json, edit);
    case EditKind::kVolume:
      return makeVolume(json, edit);
    case EditKind::kPlace:
      return placeAt(json, edit);
    case EditKind::kCamera:
      json["camera"] = writeFields(cameraFields(), &edit.camera, "");
      return std::string();
  }
  return std::string();
}

}  // namespace volute
