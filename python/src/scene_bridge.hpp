// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <tuple>

#include "bridge.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/scene/scene.hpp"
#include "volute/volume_files/memory_volumes.hpp"

// What the parts of volute._scene share.

namespace volute::python {

using OrderedJson = nlohmann::ordered_json;

inline OrderedJson jsonOf(const std::string& text) {
  return OrderedJson::parse(text);  // json.dumps wrote it
}

inline SceneOptions sceneOptions(const std::string& members, std::uint64_t maxMemory) {
  SceneOptions options;
  options.maxMemory = maxMemory;
  options.members = jsonOf(members);
  return options;
}

/// What frame_range() of the package makes of `frames`.
inline FrameRange frameRangeOf(const py::object& frames) {
  using Numbers = std::tuple<std::optional<double>, std::optional<double>, int>;
  const auto [begin, end, step] = frames.cast<Numbers>();
  return {begin, end, step};
}

inline py::tuple boundsTuple(const Box3& box) {
  const auto point = [](const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); };
  return py::make_tuple(point(box.min), point(box.max));
}

/// (name, array or Function, shape, what is said of it) of each volume in memory; of a mesh (name,
/// Mesh, None, None).
using Volumes =
    std::vector<std::tuple<std::string, py::object, std::optional<Shape>, std::optional<py::dict>>>;

/// The arrays of volumes are borrowed, and kept.
void addVolumes(MemoryVolumes& to, const Volumes& volumes);

// Each adds its part to the module.
void addSights(py::module_& m);
void addReconstruction(py::module_& m);
void addOwnKinds(py::module_& m);

}  // namespace volute::python
