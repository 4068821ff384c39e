// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/mesh_report.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/base/file_name.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/mesh_shape.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kShapes[] = {"tetrahedra", "pyramids", "wedges", "hexahedra", "polyhedra"};

/// Of a file or a series; cases are spread over files that only their reader knows.
std::optional<std::uint64_t> bytesOf(const std::string& path) {
  const std::string kind = extensionOf(path);
  if (kind == ".case" || kind == ".foam" || kind == ".pvtu")
    return std::nullopt;
  return bytesOnDisk(path);
}

void addTimes(Report& report, const MeshSource& source) {
  const auto times = source.times();
  report.add("instants", times.size(), fmt::format("{}", times.size()))
      .add("times", OrderedJson(std::vector<double>(times.begin(), times.end())),
           times.size() == 1 ? fmt::format("{} s", times.front())
                             : fmt::format("{} to {} s", times.front(), times.back()));
}

/// Files of a series that are not there.
void addMissing(Report& report, const MeshSource& source, bool& damaged) {
  OrderedJson list = OrderedJson::array();
  std::string text;
  for (std::size_t i = 0; i < source.times().size(); ++i) {
    std::error_code error;
    if (std::filesystem::exists(source.file(i), error))
      continue;
    constexpr std::size_t kShown = 5;
    if (list.size() < kShown)
      text += fmt::format("\n  {} (of {} s)", source.file(i).string(), source.times()[i]);
    else if (list.size() == kShown)
      text += "\n  ...";
    list.push_back(source.file(i).string());
  }
  damaged = damaged || !list.empty();
  report.add("missing_files", list, list.empty() ? "" : fmt::format("{}{}", list.size(), text));
}

void addCells(Report& report, const MeshContents& contents) {
  auto kinds = OrderedJson::object();
  std::string text;
  for (std::size_t i = 0; i < std::size(kShapes); ++i) {
    kinds[kShapes[i]] = contents.shapes[i];
    if (contents.shapes[i] > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", contents.shapes[i], kShapes[i]);
  }
  report.add("points", contents.size.points, fmt::format("{}", contents.size.points))
      .add("cells", contents.size.cells, fmt::format("{}: {}", contents.size.cells, text))
      .add("cell_kinds", kinds, "")
      .add("surfaces", contents.surfaces,
           contents.surfaces > 0
               ? fmt::format("{} cells without a volume, left out", contents.surfaces)
               : "")
      .add("blocks", contents.blocks,
           contents.blocks > 1
               ? fmt::format("{}, joined where their points are the same", contents.blocks)
               : "")
      .add("walls", contents.walls,
           contents.walls > 0 ? fmt::format("{} faces with cells on both sides", contents.walls)
                              : "")
      .add("ghosts", contents.size.ghosts,
           contents.size.ghosts > 0 ? fmt::format("{} cells, left out", contents.size.ghosts) : "");
}

void addMesh(Report& report, const Result<std::shared_ptr<const TetMesh>>& mesh, bool& damaged) {
  if (!mesh) {
    damaged = true;
    report.add("usable", false, "").add("mesh", nullptr, "cannot be used: " + mesh.error().message);
    return;
  }
  const MeshShape shape = shapeOf(**mesh);
  const Box3& b = (*mesh)->bounds();
  report.add("usable", true, "")
      .add("tetrahedra", (*mesh)->tets().size(),
           fmt::format("{}, with {} vertices", (*mesh)->tets().size(), (*mesh)->vertices().size()))
      .add("bounds", {b.min.x(), b.min.y(), b.min.z(), b.max.x(), b.max.y(), b.max.z()}, boxText(b))
      .add("volume", jsonNumber(shape.volume), fmt::format("{:.6g} m3", shape.volume))
      .add("parts", shape.parts,
           fmt::format("{}{}", shape.parts, shape.parts > 1 ? " that share no face" : ""))
      .add("convex", shape.convex, shape.convex ? "yes" : "no");
}

/// The range over both.
void widen(MeshFieldSummary& field, const MeshFieldSummary& other) {
  field.least = std::min(field.least, other.least);
  field.most = std::max(field.most, other.most);
  field.notFinite += other.notFinite;
}

bool isSame(const MeshFieldSummary& a, const MeshFieldSummary& b) {
  return std::string_view(a.name) == b.name && a.ofCells == b.ofCells &&
         a.components == b.components;
}

std::string kindOf(const MeshFieldSummary& field) {
  return field.components == 1   ? "scalar"
         : field.components == 3 ? "vector"
                                 : fmt::format("{} components", field.components);
}

void addFields(Report& report, const std::vector<MeshFieldSummary>& fields,
               const std::string& when) {
  OrderedJson list = OrderedJson::array();
  std::string text = fields.empty() ? "none" : when;
  for (const MeshFieldSummary& field : fields) {
    list.push_back({{"name", field.name},
                    {"of", field.ofCells ? "cells" : "points"},
                    {"components", field.components},
                    {"minimum", jsonNumber(field.least)},
                    {"maximum", jsonNumber(field.most)},
                    {"not_finite", field.notFinite}});
    text += fmt::format(
        "\n  {}: {} of {}, {}{:.6g} to {:.6g}{}", field.name, kindOf(field),
        field.ofCells ? "cells" : "points", field.components > 1 ? "length " : "", field.least,
        field.most,
        field.notFinite > 0 ? fmt::format("; {} values are not finite", field.notFinite) : "");
  }
  report.add("fields", list, text);
}

/// What is not there at all times.
void addPartial(Report& report, const MeshSource& source, const char* partial) {
  OrderedJson list = OrderedJson::array();
  std::string text = source.absentText();
  for (const Remark& said : source.remarks()) text += (text.empty() ? "" : "; ") + said.sentence;
  std::vector<std::pair<std::string, std::size_t>> counts;
  const auto lists = source.fieldNames();
  for (const auto& names : lists) {
    for (const std::string& name : names) {
      const auto known = std::ranges::find(counts, name, &decltype(counts)::value_type::first);
      if (known == counts.end())
        counts.emplace_back(name, 1);
      else
        ++known->second;
    }
  }
  for (const auto& [name, count] : counts) {
    if (count == lists.size())
      continue;
    list.push_back({{"name", name}, {"times", count}});
    text += fmt::format("{}{} is there at {} of {} times", text.empty() ? "" : "; ", name, count,
                        lists.size());
  }
  if (partial[0] != 0)
    text += fmt::format("{}{}", text.empty() ? "" : "; ", partial);
  report
      .add("absent_times",
           OrderedJson(std::vector<double>(source.absent().begin(), source.absent().end())), "")
      .add("partial_fields", list, text);
}

}  // namespace

Result<FileDescription> describeMeshCase(const std::string& path, bool values, Reading& reading) {
  MeshOptions options;
  options.maxMemory = reading.maxMemory;
  VOLUTE_ASSIGN(const auto source, MeshSource::open(path, options));
  FileDescription described;
  Report& report = described.report;
  report.add("file", path).add("kind", "mesh");
  if (const auto bytes = bytesOf(path))
    report.add("bytes", *bytes, bytesText(*bytes));
  addTimes(report, source);
  addMissing(report, source, described.damaged);
  VOLUTE_ASSIGN(const auto first, source.describe(0));
  addCells(report, first.contents);
  addMesh(report, first.mesh, described.damaged);
  std::vector<MeshFieldSummary> fields = first.fields;
  const std::size_t count = values ? source.times().size() : 1;
  for (std::size_t i = 1; i < count; ++i) {
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading instant {}", i);
    VOLUTE_ASSIGN(const auto next, source.describe(i));
    for (const MeshFieldSummary& field : next.fields) {
      const auto known =
          std::ranges::find_if(fields, [&](const auto& other) { return isSame(field, other); });
      if (known == fields.end())
        fields.push_back(field);
      else
        widen(*known, field);
    }
    reading.progress.report("reading", static_cast<double>(i + 1), static_cast<double>(count));
  }
  addPartial(report, source, first.contents.partial);
  addFields(report, fields,
            count > 1 ? "over all instants" : fmt::format("at {} s", source.times().front()));
  return described;
}

}  // namespace volute
