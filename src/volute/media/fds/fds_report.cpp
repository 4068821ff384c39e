// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_report.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_files.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson boundsJson(const Box3& b) {
  return {b.min.x(), b.min.y(), b.min.z(), b.max.x(), b.max.y(), b.max.z()};
}

void addMeshes(Report& report, const SmvIndex& index) {
  constexpr std::size_t kShown = 20;
  OrderedJson list = OrderedJson::array();
  std::string text;
  std::uint64_t cells = 0;
  Box3 bounds;
  for (std::size_t i = 0; i < index.meshes.size(); ++i) {
    const FdsMesh& mesh = index.meshes[i];
    const Box3 box = mesh.bounds();
    bounds.extend(box);
    cells += mesh.cellCount();
    list.push_back({{"name", mesh.name},
                    {"cells", {mesh.cells(0), mesh.cells(1), mesh.cells(2)}},
                    {"bounds", boundsJson(box)},
                    {"obstructions", mesh.obstructions.size()}});
    if (i < kShown)
      text += fmt::format("\n  {:>4}  {} x {} x {} cells, {}", i + 1, mesh.cells(0), mesh.cells(1),
                          mesh.cells(2), boxText(box));
    if (i == kShown)
      text += "\n  ...";
  }
  report
      .add("meshes", list, fmt::format("{}, {} cells together{}", index.meshes.size(), cells, text))
      .add("cells", cells, "")
      .add("bounds", boundsJson(bounds), boxText(bounds));
}

void addDevices(Report& report, const SmvIndex& index) {
  constexpr std::size_t kShown = 20;
  OrderedJson list = OrderedJson::array();
  std::string text = fmt::format("{}", index.devices.size());
  for (const FdsDevice& device : index.devices) {
    OrderedJson events = OrderedJson::array();
    std::string changes;
    for (const FdsEvent& event : device.events) {
      events.push_back({{"time", event.time}, {"active", event.shown}});
      changes +=
          fmt::format(", {} at {} s", event.shown ? "active" : "idle", plainNumber(event.time));
    }
    list.push_back({{"label", device.label},
                    {"quantity", device.quantity},
                    {"position", {device.position.x(), device.position.y(), device.position.z()}},
                    {"active", device.active},
                    {"events", events}});
    if (list.size() <= kShown) {
      text += fmt::format("\n  {} ({}) at {} m, {}{}", device.label, device.quantity,
                          vectorText(device.position), device.active ? "active" : "idle", changes);
    }
  }
  if (list.size() > kShown)
    text += fmt::format("\n  and {} more (JSON lists all)", list.size() - kShown);
  report.add("devices", list, text);
}

/// 2D slices, by where they lie.
void addSlices(Report& report, const SmvIndex& index) {
  std::map<std::string, int> planes;
  for (const FdsSliceEntry& slice : index.slices) {
    if (!slice.nodes)
      continue;
    const FdsMesh& mesh = index.meshes[static_cast<std::size_t>(slice.mesh)];
    for (int axis = 0; axis < 3; ++axis) {
      const int node = slice.nodes->begin[axis];
      if (node != slice.nodes->end[axis])
        continue;
      const auto& places = mesh.planes[axis];
      const auto at = static_cast<std::size_t>(node);
      const double place =
          slice.cellCentred && node > 0 ? 0.5 * (places[at - 1] + places[at]) : places[at];
      ++planes[fmt::format("{} at {} = {} m", slice.labels.quantity, "xyz"[axis],
                           plainNumber(place))];
    }
  }
  auto list = OrderedJson::object();
  std::string text;
  for (const auto& [name, count] : planes) {
    list[name] = count;
    text += fmt::format("\n  {}{}", name, count > 1 ? fmt::format(" ({} meshes)", count) : "");
  }
  report.add(
      "slices", list,
      planes.empty() ? "none in a plane" : fmt::format("in {} planes{}", planes.size(), text));
}

void addContents(Report& report, const SmvIndex& index) {
  std::size_t obstructions = 0;
  std::size_t vents = 0;
  for (const FdsMesh& mesh : index.meshes) {
    obstructions += mesh.obstructions.size();
    vents += mesh.vents.size();
  }
  const auto events = obstructionEvents(index);
  report.add(
      "obstructions", obstructions,
      fmt::format("{}{}", obstructions,
                  events.empty() ? ""
                                 : fmt::format(", some come and go at {} times from {} to {} s",
                                               events.size(), events.front(), events.back())));
  report.add("obstruction_events", OrderedJson(events), "");
  report.add("vents", vents, fmt::format("{}", vents));
  addDevices(report, index);
  addSlices(report, index);
  std::map<std::string, int> quantities;
  for (const auto& slice : index.slices) ++quantities["slices of " + slice.labels.quantity];
  for (const auto& smoke : index.smoke) ++quantities["smoke3d of " + smoke.labels.quantity];
  if (!index.plots.empty())
    quantities["PLOT3D files"] = static_cast<int>(index.plots.size());
  auto files = OrderedJson::object();
  std::string text;
  for (const auto& [name, count] : quantities) {
    files[name] = count;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name);
  }
  report.add("files", files, text);
}

/// Each file's frames; for people those of each kind together, and each file that is not whole.
/// Returns how many are not whole.
std::size_t addFiles(Report& report, const SmvIndex& index) {
  constexpr std::size_t kShown = 50;

  struct FilesOfAKind {
    std::size_t files = 0, least = SIZE_MAX, most = 0;
    std::vector<std::string> faults;
  };

  OrderedJson list = OrderedJson::array();
  std::map<std::string, FilesOfAKind> kinds;
  std::size_t faults = 0;
  const auto checks = checkFiles(index);
  for (const FdsFileCheck& check : checks) {
    OrderedJson one{{"file", check.path.filename().string()},
                    {"kind", check.kind},
                    {"mesh", check.mesh + 1},
                    {"state", nameOf(check.state)},
                    {"frames", check.times.size()}};
    if (!check.times.empty())
      one["times"] = {check.times.front(), check.times.back()};
    if (!check.reason.empty())
      one["reason"] = check.reason;
    list.push_back(std::move(one));
    FilesOfAKind& kind = kinds[check.kind];
    ++kind.files;
    kind.least = std::min(kind.least, check.times.size());
    kind.most = std::max(kind.most, check.times.size());
    if (check.state == FdsFileState::kWhole)
      continue;
    ++faults;
    kind.faults.push_back(
        fmt::format("mesh {}: {}: {}", check.mesh + 1, nameOf(check.state), check.reason));
  }
  std::string text = faults == 0 ? fmt::format("all {} are there and whole", checks.size())
                                 : fmt::format("{} of {} are not whole", faults, checks.size());
  std::size_t shown = 0;
  for (const auto& [name, kind] : kinds) {
    if (kind.least == kind.most && kind.faults.empty() && name.starts_with("PLOT3D"))
      continue;
    text += fmt::format("\n  {}: {} files", name, kind.files);
    if (kind.most > 0)
      text +=
          fmt::format(", {}{} frames",
                      kind.least == kind.most ? "" : fmt::format("{} to ", kind.least), kind.most);
    for (const std::string& fault : kind.faults) {
      if (++shown <= kShown)
        text += "\n    " + fault;
    }
  }
  if (shown > kShown)
    text += fmt::format("\n    and {} more", shown - kShown);
  if (!checks.empty())
    report.add("data_files", list, text);
  return faults;
}

void addSources(Report& report, const FdsCase& opened) {
  OrderedJson list = OrderedJson::array();
  std::string others;
  for (const FdsSource& source : opened.sources()) {
    list.push_back({{"name", source.name},
                    {"description", source.description},
                    {"fills_meshes", source.volume},
                    {"files", source.parts.size()}});
    if (source.name != opened.source().name)
      others += (others.empty() ? "" : ", ") + source.name;
  }
  const auto times = opened.times();
  report
      .add("source", opened.source().name,
           fmt::format("{}: {}{}", opened.source().name, opened.source().description,
                       others.empty() ? "" : "; others: " + others))
      .add("sources", list, "")
      .add("source_bounds", boundsJson(opened.bounds()), boxText(opened.bounds()))
      .add("frames", times.size(), fmt::format("{}", times.size()))
      .add("times", {times.front(), times.back()},
           fmt::format("{} to {} s", plainNumber(times.front()), plainNumber(times.back())));
}

Status addValues(Report& report, FdsCase& opened, Reading& reading) {
  double most = 0;
  double mostTime = 0;
  const auto times = opened.times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading frame {}", i);
    VOLUTE_ASSIGN(const FdsField field, opened.field(times[i]));
    for (std::size_t lattice = 0; lattice < field.grid().lattices().size(); ++lattice) {
      for (const float value : field.values(lattice).value) {
        if (value > most)
          most = value, mostTime = times[i];
      }
    }
    reading.progress.report("reading", static_cast<double>(i + 1),
                            static_cast<double>(times.size()));
  }
  report.add("most_extinction", jsonNumber(most),
             fmt::format("{:.4g} 1/m at {} s (visibility {:.3g} m with C = 3)", most,
                         plainNumber(mostTime), 3 / most));
  return {};
}

}  // namespace

Result<Report> describeFdsCase(const std::string& path, const DescribeRequest& request,
                               Reading& reading) {
  VOLUTE_ASSIGN(const SmvIndex index, SmvIndex::read(path, reading.maxMemory));
  Report report;
  report.add("file", path)
      .add("kind", "fds")
      .add("version", index.version)
      .add("title", index.title);
  report.add("ended", index.ended, index.ended ? "yes" : "no: running, or stopped early");
  addMeshes(report, index);
  addContents(report, index);
  const std::size_t faults = addFiles(report, index);
  FdsOptions options;
  options.source = request.field;
  options.maxMemory = reading.maxMemory;
  auto opened = FdsCase::open(path, options);
  if (!opened && opened.error().code == ErrorCode::kNotFound && request.field.empty()) {
    report.add("source", nullptr, "none: " + opened.error().message);
    return report;
  }
  if (!opened)
    return tl::unexpected<Error>(opened.error());
  addSources(report, *opened);
  std::string text;
  OrderedJson sentences = OrderedJson::array();
  for (const Remark& remark : opened->remarks()) {
    sentences.push_back(remark.sentence);
    text += "\n  " + remark.sentence;
  }
  report.add("remarks", sentences,
             !text.empty() ? text
             : faults == 0 ? "none: all files are whole"
                           : "none on the source of smoke");
  if (request.values)
    VOLUTE_TRY(addValues(report, *opened, reading));
  return report;
}

}  // namespace volute
