// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/file_kind.hpp"

#include <algorithm>

#include "volute/io/image_file.hpp"
#include "volute/io/unread_mesh.hpp"
#include "volute/media/smoke/scene_smoke.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

/// One of them, and many.
struct KindWords {
  std::string_view thing, things;
};

KindWords wordsOf(std::string_view kind) {
  if (kind == kSceneKind)
    return {"a scene", "scenes"};
  if (kind == kVoluteKind)
    return {"a .volute file", ".volute files"};
  if (kind == kPictureKind)
    return {"a picture", "pictures"};
  const auto found = std::ranges::find_if(
      mediumKinds(), [&](const MediumKind* one) { return one->fields().name == kind; });
  VOLUTE_ASSERT(found != mediumKinds().end());
  return {(*found)->singular(), (*found)->plural()};
}

/// "smoke on meshes and FDS cases".
/// @param refused  whose volumes of voxels are none of `kinds`
std::string thingsOf(const std::vector<std::string_view>& kinds, std::string_view refused) {
  std::string text;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    text += i == 0 ? "" : i + 1 < kinds.size() ? ", " : " and ";
    text += wordsOf(kinds[i]).things;
    text += refused == kVoluteKind && kinds[i] == "volume" ? " of other formats" : "";
  }
  return text;
}

std::string_view mediumName(const std::string& file) {
  registerUsualMedia();
  if (isUnreadMesh(file))  // opening it says so
    return smokeFields().name;
  return mediumKindOf(file, true)->fields().name;
}

}  // namespace

FileKind shownKind(const std::string& file) {
  if (isScenePath(file))
    return {kSceneKind, file, ": write it there"};
  return {mediumName(file), file};
}

FileKind readKind(const std::string& file) {
  return {isScenePath(file)     ? kSceneKind
          : isVolutePath(file)  ? kVoluteKind
          : isPicturePath(file) ? kPictureKind
                                : mediumName(file),
          file};
}

Status refuseIdle(const Arguments& arguments, const std::vector<FileKind>& files) {
  for (const Option& option : arguments.options()) {
    const bool serves = std::ranges::any_of(files, [&](const FileKind& of) {
      return std::ranges::find(option.kinds, of.kind) != option.kinds.end();
    });
    if (!arguments.given(option.name) || option.kinds.empty() || serves || files.empty())
      continue;
    return fail(ErrorCode::kInvalidArgument, "--{} is for {}; {} is {}{}", option.name,
                thingsOf(option.kinds, files.front().kind), files.front().file,
                wordsOf(files.front().kind).thing, files.front().advice);
  }
  return {};
}

}  // namespace volute::cli
