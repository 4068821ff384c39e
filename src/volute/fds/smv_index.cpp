// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/smv_index.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "volute/base/file_name.hpp"
#include "volute/base/printable.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/geometry_file.hpp"
#include "volute/fds/smv_reader.hpp"

namespace volute {

tl::unexpected<Error> SmvReader::wrong(std::string_view expected) const {
  return fail(ErrorCode::kInvalidData, "{}: line {}: expected {}", lines_.path().string(),
              lines_.lineNumber(), expected);
}

Result<std::optional<std::string>> SmvReader::nextLine() {
  return lines_.next();
}

Result<std::string> SmvReader::need(std::string_view what) {
  VOLUTE_ASSIGN(auto line, nextLine());
  if (!line) {
    cutOff_ = true;
    return fail(ErrorCode::kTruncated, "{}: ends after line {}, where {} should be",
                lines_.path().string(), lines_.lineNumber(), what);
  }
  return std::move(*line);
}

/// A line of numbers, at least `least`; what follows them is ignored.
Result<std::vector<double>> SmvReader::numbers(std::string_view what, std::size_t least) {
  VOLUTE_ASSIGN(const std::string line, need(what));
  std::vector<double> out;
  for (const auto word : words(line)) {
    const auto value = numberOf(word);
    if (!value)
      break;
    out.push_back(*value);
  }
  if (out.size() < least)
    return wrong(fmt::format("{} ({} numbers), not '{}'", what, least, line.substr(0, 60)));
  return out;
}

Result<int> SmvReader::count(std::string_view what) {
  VOLUTE_ASSIGN(const std::string line, need(what));
  const auto found = words(line);
  const auto value = found.empty() ? std::nullopt : integerOf(found[0]);
  if (!value || *value < 0)
    return wrong(fmt::format("{}, not '{}'", what, line.substr(0, 60)));
  return *value;
}

/// The place of the mesh whose number (from 1) is the first word.
Result<int> SmvReader::meshNumber(std::string_view rest) {
  const auto found = words(rest);
  const auto value = found.empty() ? std::nullopt : integerOf(found[0]);
  if (!value || *value < 1 || *value > static_cast<int>(index_.meshes.size())) {
    return wrong(fmt::format("the number of a mesh, 1 to {}, not '{}'", index_.meshes.size(),
                             found.empty() ? "" : found[0]));
  }
  return *value - 1;
}

Status SmvReader::text(std::string& into, std::string_view what) {
  VOLUTE_ASSIGN(const std::string line, need(what));
  into = trimmed(line);
  return {};
}

Status SmvReader::readVersion(std::string_view) {
  return text(index_.version, "the version of FDS");
}

Status SmvReader::readTitle(std::string_view) {
  VOLUTE_TRY(text(index_.title, "the title"));
  index_.title = asUtf8(index_.title);
  return {};
}

Status SmvReader::readChid(std::string_view) {
  return text(index_.chid, "the name of the case");
}

Status SmvReader::readInput(std::string_view) {
  return text(inputName_, "the name of the input file");
}

Status SmvReader::readEnd(std::string_view) {
  std::string name;
  VOLUTE_TRY(text(name, "the name of the .end file"));
  std::error_code code;
  index_.ended = !name.empty() && std::filesystem::exists(index_.path.parent_path() / name, code);
  return {};
}

Status SmvReader::readMeshCount(std::string_view) {
  VOLUTE_ASSIGN(meshCount_, count("the number of meshes"));
  return {};
}

Status SmvReader::readAlbedo(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("the albedo", 1));
  index_.albedo = values[0];
  return {};
}

Status SmvReader::readFireCutoff(std::string_view) {
  VOLUTE_TRY(count("the number of cutoffs"));
  VOLUTE_ASSIGN(const auto values, numbers("the least heat release that is a fire", 1));
  if (values[0] >= 0)
    index_.fireCutoff = values[0];
  return {};
}

/// FDS 6.11: what bytes of heat release reach from and to [kW/m3].
Status SmvReader::readHeatRange(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("the least and largest heat release of a byte", 2));
  if (!(values[0] == 0 && values[1] > 0 && std::isfinite(values[1])))
    return wrong(
        fmt::format("heat release from 0 to more, not {:g} to {:g}", values[0], values[1]));
  index_.largestHeat = values[1];
  return {};
}

/// FDS 6.11: what bytes of temperature reach from and to [degrees C].
Status SmvReader::readTemperatureRange(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("the least and largest temperature of a byte", 2));
  constexpr double kAbsoluteZero = -273.15;
  if (!(values[0] >= kAbsoluteZero && values[0] < values[1] && std::isfinite(values[1]))) {
    return wrong(fmt::format("two temperatures [degrees C], the lower one first, not {:g} and {:g}",
                             values[0], values[1]));
  }
  index_.temperatureRange = {values[0], values[1]};
  return {};
}

Status SmvReader::readNorth(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("the bearing of north [degrees]", 1));
  if (!std::isfinite(values[0]))
    return wrong(fmt::format("a bearing of north in degrees, not {:g}", values[0]));
  constexpr double kTurn = 360;
  index_.north = std::remainder(values[0], kTurn);
  return {};
}

Status SmvReader::readSurface(std::string_view) {
  FdsSurface surface;
  VOLUTE_TRY(text(surface.name, "the name of a surface"));
  VOLUTE_ASSIGN(const auto thermal, numbers("a surface's temperature and emissivity", 0));
  VOLUTE_ASSIGN(const auto look, numbers("a surface's type, size and colour", 7));
  for (int c = 0; c < 4; ++c) surface.colour[c] = static_cast<float>(look[3 + c]);
  VOLUTE_ASSIGN(const auto texture, need("a surface's texture"));
  (void)thermal, (void)texture;
  index_.surfaces.push_back(std::move(surface));
  return {};
}

Result<FdsMesh*> SmvReader::lastMesh() {
  if (index_.meshes.empty())
    return wrong("GRID before what belongs to a mesh");
  return &index_.meshes.back();
}

/// Smokeview moves a mesh by it; FDS writes 0.
Status SmvReader::readOffset(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("where a mesh is moved to", 3));
  if (std::ranges::all_of(values, [](double one) { return one == 0; }))
    return {};
  return wrong("an OFFSET of 0 0 0: moved meshes are not read");
}

Status SmvReader::readGrid(std::string_view rest) {
  VOLUTE_ASSIGN(const auto values, numbers("the cells of a mesh on x, y, z", 3));
  FdsMesh mesh;
  mesh.name = trimmed(rest);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(values[axis] >= 1 && values[axis] <= 1e6) || values[axis] != std::floor(values[axis]))
      return wrong("1 to 1000000 cells on each axis");
    cells_[axis] = static_cast<int>(values[axis]);
  }
  // FDS+Evac marks its meshes; newer versions have six numbers of neighbours here.
  mesh.evacuation = values.size() == 4 && values[3] != 0;
  extent_.reset();
  index_.meshes.push_back(std::move(mesh));
  blocks_.push_back(0);
  return {};
}

/// Where a mesh begins and ends on x, y, z; the same as its nodes say.
Status SmvReader::readExtent(std::string_view) {
  VOLUTE_TRY(lastMesh());
  VOLUTE_ASSIGN(const auto values, numbers("the begin and end of a mesh on x, y, z", 6));
  extent_.emplace();
  std::copy_n(values.begin(), 6, extent_->begin());
  return {};
}

/// FDS writes both with five digits after the point.
Status SmvReader::checkPlanes(int axis, const std::vector<double>& planes) const {
  if (!extent_)
    return {};
  const double begin = (*extent_)[2 * axis];
  const double end = (*extent_)[2 * axis + 1];
  const double slack = 2e-5 + 1e-6 * (planes.back() - planes.front());
  if (std::abs(planes.front() - begin) <= slack && std::abs(planes.back() - end) <= slack)
    return {};
  return fail(
      ErrorCode::kInvalidData,
      "{}: line {}: mesh {} goes from {} to {} m on {} by its nodes (TRN{}), and from {} to "
      "{} m by its PDIM: one of them is damaged; copy the .smv file again",
      lines_.path().string(), lines_.lineNumber(), index_.meshes.size(), planes.front(),
      planes.back(), "xyz"[axis], "XYZ"[axis], begin, end);
}

Status SmvReader::readPlanes(int axis) {
  VOLUTE_ASSIGN(FdsMesh * mesh, lastMesh());
  VOLUTE_ASSIGN(const int transforms, count("the number of transform points"));
  for (int i = 0; i < transforms; ++i) VOLUTE_TRY(numbers("a point of a mesh's transform", 0));
  std::vector<double> planes;
  for (int i = 0; i <= cells_[axis]; ++i) {
    VOLUTE_ASSIGN(const auto values, numbers("the index and place of a node", 2));
    if (values[0] != i)
      return wrong(fmt::format("node {}, not {}", i, values[0]));
    if (!planes.empty() && !(values[1] > planes.back()))
      return wrong("the places of nodes to ascend");
    planes.push_back(values[1]);
  }
  VOLUTE_TRY(checkPlanes(axis, planes));
  mesh->planes[axis] = std::move(planes);
  return {};
}

Result<FdsNodeBox> SmvReader::nodeBox(std::span<const double> indices) {
  FdsNodeBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double begin = indices[2 * axis];
    const double end = indices[2 * axis + 1];
    if (!(begin >= 0 && begin <= end && end <= cells_[axis]))
      return wrong(
          fmt::format("node indices from 0 to {}, not {} to {}", cells_[axis], begin, end));
    box.begin[axis] = static_cast<int>(begin);
    box.end[axis] = static_cast<int>(end);
  }
  return box;
}

Result<int> SmvReader::surface(double number) {
  constexpr double kMax = 1e9;
  if (!(std::abs(number) <= kMax))
    return wrong(fmt::format("the number of a surface, not {:g}", number));
  return static_cast<int>(number);
}

namespace {

std::optional<FdsColour> colourOf(std::span<const double> values) {
  if (values.size() < 12)
    return std::nullopt;
  FdsColour colour;
  for (int c = 0; c < 4; ++c) colour[c] = static_cast<float>(std::clamp(values[8 + c], 0.0, 1.0));
  return colour;
}

}  // namespace

/// Before so many more obstructions or vents are read.
Status SmvReader::hold(double boxes) {
  constexpr double kEach = 350;  // [bytes], measured, with trees and surfaces that are made of them
  boxes_ += boxes;
  if (boxes_ * kEach <= static_cast<double>(maxMemory_))
    return {};
  return fail(
      ErrorCode::kTooLarge, Hint::raise("max_memory"),
      "{}: line {}: {} obstructions and vents need {:.0f} MiB, more than the {} MiB allowed",
      lines_.path().string(), lines_.lineNumber(), boxes_, boxes_ * kEach / (1 << 20),
      maxMemory_ >> 20);
}

/// An obstruction lies where its nodes are, within the cells that FDS moves it by.
Status SmvReader::checkEnds(const FdsMesh& mesh, const FdsNodeBox& box,
                            const std::array<float, 6>& ends) {
  if (std::ranges::all_of(ends, [](float end) { return end == 0; }))
    return {};  // left out, by programs that write such files for Smokeview
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = mesh.planes[axis];
    if (planes.empty())
      return {};
    const int last = static_cast<int>(planes.size()) - 1;
    for (const auto& [node, end] : {std::pair(box.begin[axis], ends[2 * axis]),
                                    std::pair(box.end[axis], ends[2 * axis + 1])}) {
      constexpr int kCells = 1;
      const double low = planes[std::max(node - kCells, 0)];
      const double high = planes[std::min(node + kCells, last)];
      const bool below = end < low && node > 0, above = end > high && node < last;
      if (below || above)
        return wrong(
            fmt::format("an obstruction that lies where its nodes are, at {} = {:g} m by "
                        "node {}, not at {:g} m",
                        "xyz"[axis], planes[node], node, end));
    }
  }
  return {};
}

Status SmvReader::readObstructions(std::string_view) {
  VOLUTE_ASSIGN(FdsMesh * mesh, lastMesh());
  VOLUTE_ASSIGN(const int number, count("the number of obstructions"));
  VOLUTE_TRY(hold(number));
  std::vector<FdsObstruction> obstructions;
  std::vector<std::array<float, 6>> ends;
  for (int i = 0; i < number; ++i) {
    VOLUTE_ASSIGN(const auto first, numbers("an obstruction's ends and surfaces", 6));
    std::ranges::transform(std::span(first).first(6), ends.emplace_back().begin(),
                           [](double end) { return static_cast<float>(end); });
    FdsObstruction& one = obstructions.emplace_back();
    for (std::size_t face = 0; face < 6 && 7 + face < first.size(); ++face) {
      VOLUTE_ASSIGN(one.surfaces[face], surface(first[7 + face]));
    }
  }
  for (FdsObstruction& one : obstructions) {
    VOLUTE_ASSIGN(const auto second, numbers("an obstruction's node indices", 6));
    VOLUTE_ASSIGN(one.nodes, nodeBox(second));
    VOLUTE_TRY(
        checkEnds(*mesh, one.nodes, ends[static_cast<std::size_t>(&one - obstructions.data())]));
    if (second.size() >= 7 && second[6] == -3)
      one.colour = colourOf(second);
    one.drawn = second.size() < 8 || second[7] != -2;
  }
  mesh->obstructions = std::move(obstructions);
  blocks_.back() |= 1;
  return {};
}

Status SmvReader::readVents(std::string_view) {
  VOLUTE_ASSIGN(FdsMesh * mesh, lastMesh());
  VOLUTE_ASSIGN(const auto counts, numbers("the number of vents", 1));
  // The second number says how many of the last ones FDS has added for the mesh's own walls.
  const bool counted = counts.size() > 1;
  if (!(counts[0] >= 0 && counts[0] <= 1e9) ||
      (counted && !(counts[1] >= 0 && counts[1] <= counts[0])))
    return wrong("the number of vents, and of these the mesh's own walls");
  const int number = static_cast<int>(counts[0]);
  VOLUTE_TRY(hold(number));
  const int firstWall = counted ? number - static_cast<int>(counts[1]) : number;
  std::vector<FdsVent> vents;
  for (int i = 0; i < number; ++i) {
    VOLUTE_ASSIGN(const auto first, numbers("a vent's ends and surface", 6));
    vents.emplace_back();
    if (first.size() > 7) {
      VOLUTE_ASSIGN(vents.back().surface, surface(first[7]));
    }
  }
  for (FdsVent& vent : vents) {
    VOLUTE_ASSIGN(const auto second, numbers("a vent's node indices", 6));
    VOLUTE_ASSIGN(vent.nodes, nodeBox(second));
    vent.colour = colourOf(second);
    vent.open = second.size() >= 8 && second[7] == 2;
    const bool outline = second.size() >= 8 && (second[7] == 2 || second[7] == -2);
    const bool invisible = second.size() >= 7 && second[6] < 0 && !vent.colour;
    vent.drawn = !outline && !invisible;
    const bool usual = vent.surface == 0 && !vent.colour;
    vent.exterior = counted ? &vent - vents.data() >= firstWall : usual;
  }
  mesh->vents = std::move(vents);
  blocks_.back() |= 2;
  return {};
}

Status SmvReader::readDevice(std::string_view) {
  FdsDevice device;
  std::string line;
  VOLUTE_TRY(text(line, "a device's label"));
  line = asUtf8(line);
  const auto mark = line.rfind('%');
  device.label = trimmed(std::string_view(line).substr(0, mark));
  if (mark != std::string::npos)
    device.quantity = trimmed(std::string_view(line).substr(mark + 1));
  VOLUTE_ASSIGN(const auto place, numbers("a device's place", 3));
  device.position = {place[0], place[1], place[2]};
  device.active = place.size() > 6 && place[6] != 0;
  index_.devices.push_back(std::move(device));
  return {};
}

Status SmvReader::readActivation(std::string_view) {
  VOLUTE_ASSIGN(const auto values, numbers("the number of a device, the time and its state", 3));
  const std::size_t number = index_.devices.size();
  if (!(values[0] >= 1 && values[0] <= static_cast<double>(number)))
    return wrong(fmt::format("the number of a device, 1 to {}, not {}", number, values[0]));
  index_.devices[static_cast<std::size_t>(values[0]) - 1].events.push_back(
      {values[1], values[2] != 0});
  return {};
}

Status SmvReader::readEvent(std::string_view rest, bool ofVent, bool shown) {
  VOLUTE_ASSIGN(const int place, meshNumber(rest));
  VOLUTE_ASSIGN(const auto values, numbers("the number of what changes, and the time", 2));
  FdsMesh& mesh = index_.meshes[place];
  const std::size_t number = ofVent ? mesh.vents.size() : mesh.obstructions.size();
  if (!(values[0] >= 1 && values[0] <= static_cast<double>(number))) {
    return wrong(fmt::format("the number of {}, 1 to {}, not {}",
                             ofVent ? "a vent" : "an obstruction", number, values[0]));
  }
  const auto one = static_cast<std::size_t>(values[0]) - 1;
  auto& events = ofVent ? mesh.vents[one].events : mesh.obstructions[one].events;
  events.push_back({values[1], shown});
  return {};
}

Status SmvReader::readGeometry(std::string_view) {
  VOLUTE_ASSIGN(auto path, file("the name of a geometry file"));
  index_.others.push_back({std::string(kFdsWallsKind), -1, std::move(path)});
  return {};
}

Status SmvReader::readCutFaces(std::string_view) {
  ++cutFaces_;
  return {};
}

Status SmvReader::handle(std::string_view line) {
  static const std::map<std::string_view, Handler> handlers = {
      {"FDSVERSION", &SmvReader::readVersion},
      {"TITLE", &SmvReader::readTitle},
      {"CHID", &SmvReader::readChid},
      {"INPF", &SmvReader::readInput},
      {"ENDF", &SmvReader::readEnd},
      {"NMESHES", &SmvReader::readMeshCount},
      {"ALBEDO", &SmvReader::readAlbedo},
      {"HRRPUVCUT", &SmvReader::readFireCutoff},
      {"HRRPUV_MINMAX", &SmvReader::readHeatRange},
      {"TEMP_MINMAX", &SmvReader::readTemperatureRange},
      {"NORTHANGLE", &SmvReader::readNorth},
      {"CSVF", &SmvReader::readTable},
      {"BNDF", &SmvReader::readBoundary},
      {"BNDC", &SmvReader::readBoundary},
      {"PRT5", &SmvReader::readParticles},
      {"EVA5", &SmvReader::readParticles},
      {"CLASS_OF_PARTICLES", &SmvReader::readParticleClass},
      {"ISOG", &SmvReader::readIsosurface},
      {"TISOG", &SmvReader::readColouredIsosurface},
      {"SURFACE", &SmvReader::readSurface},
      {"OFFSET", &SmvReader::readOffset},
      {"GRID", &SmvReader::readGrid},
      {"PDIM", &SmvReader::readExtent},
      {"TRNX", &SmvReader::readTrnx},
      {"TRNY", &SmvReader::readTrny},
      {"TRNZ", &SmvReader::readTrnz},
      {"OBST", &SmvReader::readObstructions},
      {"VENT", &SmvReader::readVents},
      {"DEVICE", &SmvReader::readDevice},
      {"DEVICE_ACT", &SmvReader::readActivation},
      {"SLCF", &SmvReader::readSliceNodes},
      {"SLCC", &SmvReader::readSliceCells},
      {"SMOKF3D", &SmvReader::readSmoke},
      {"SMOKG3D", &SmvReader::readSmoke},
      {"PL3D", &SmvReader::readPlot},
      {"SHOW_OBST", &SmvReader::showObstruction},
      {"HIDE_OBST", &SmvReader::hideObstruction},
      {"OPEN_VENT", &SmvReader::openVent},
      {"CLOSE_VENT", &SmvReader::closeVent},
      {"GEOM", &SmvReader::readGeometry},
      {"CGEOM", &SmvReader::readCutFaces},
  };
  if (line.empty() || line[0] < 'A' || line[0] > 'Z')
    return {};
  const std::string_view keyword = line.substr(0, line.find_first_of(" \t"));
  const auto found = handlers.find(keyword);
  if (found == handlers.end()) {
    // Smoke by another name than the two above is written in another way, too.
    if (keyword.starts_with("SMOK") && unreadSmoke_.empty()) {
      unreadSmoke_ = keyword;
      index_.remarks.push_back(
          {RemarkCode::kLeftOut, fmt::format("{}: 3D smoke that the index calls {} is in a format "
                                             "that is not read, and left out; FDS "
                                             "writes one that is (SMOKF3D) with SMOKE3D_VERSION=1",
                                             lines_.path().string(), keyword)});
    }
    return {};
  }
  return (this->*found->second)(line.substr(keyword.size()));
}

/// Meshes on which people walk have walls of their own where those of the building are already, and
/// no gas.
void SmvReader::leaveOutEvacuation() {
  std::vector<int> kept;
  int next = 0;
  for (const FdsMesh& mesh : index_.meshes) kept.push_back(mesh.evacuation ? -1 : next++);
  const auto left = std::ranges::count(kept, -1);
  if (left == 0)
    return;
  const auto notePeople = [&](int mesh, const std::filesystem::path& file) {
    if (mesh >= 0 && kept[static_cast<std::size_t>(mesh)] < 0)
      index_.people.push_back({index_.meshes[static_cast<std::size_t>(mesh)].name, file});
  };
  for (const FdsParticleEntry& one : index_.particles) notePeople(one.mesh, one.file);
  for (const FdsOtherFile& one : index_.others) {
    if (one.kind == kUnknownParticles)
      notePeople(one.mesh, one.file);
  }
  const auto keep = [&](auto& entries) {
    std::erase_if(entries, [&](const auto& one) {
      return one.mesh >= 0 && kept[static_cast<std::size_t>(one.mesh)] < 0;
    });
    for (auto& one : entries)
      one.mesh = one.mesh < 0 ? -1 : kept[static_cast<std::size_t>(one.mesh)];
  };
  keep(index_.slices);
  keep(index_.smoke);
  keep(index_.plots);
  keep(index_.isosurfaces);
  keep(index_.particles);
  keep(index_.others);
  std::erase_if(index_.meshes, [](const FdsMesh& mesh) { return mesh.evacuation; });
  index_.remarks.push_back(
      {RemarkCode::kLeftOut, fmt::format("{}: {} of {} meshes are of FDS+Evac: they are left out, "
                                         "with their walls and files, and the "
                                         "others are numbered without them",
                                         lines_.path().string(), left, kept.size())});
}

void SmvReader::findInput() {
  if (inputName_.empty())
    return;
  const std::filesystem::path folder = index_.path.parent_path();
  std::filesystem::path path = files_.find(folder, inputName_);
  auto input = FdsInput::read(path);
  // FDS was given a path that is there no more: its last part lies beside the index.
  const std::size_t slash = inputName_.find_last_of("/\\");
  if (!input && input.error().code == ErrorCode::kNotFound && slash != inputName_.npos) {
    path = files_.find(folder, inputName_.substr(slash + 1));
    input = FdsInput::read(path);
  }
  if (!input && input.error().code == ErrorCode::kNotFound)
    return;
  if (!input) {
    index_.remarks.push_back(
        {RemarkCode::kLeftOut, input.error().message + ": the input file is not used"});
  } else if (input->chid != index_.chid && !index_.chid.empty()) {
    index_.remarks.push_back(
        {RemarkCode::kLeftOut, fmt::format("{}: is the input of '{}', not of '{}': it is not used",
                                           path.string(), input->chid, index_.chid)});
  } else {
    index_.input = std::make_shared<const FdsInput>(std::move(*input));
  }
}

Status SmvReader::finish() {
  const std::string name = lines_.path().string();
  if (index_.meshes.empty())
    return fail(ErrorCode::kInvalidData, "{}: has no GRID: not the .smv file of an FDS case", name);
  for (FdsMesh& mesh : index_.meshes) {
    for (int axis = 0; axis < 3; ++axis) {
      if (mesh.planes[axis].size() < 2)
        return fail(ErrorCode::kInvalidData, "{}: mesh '{}' has no node places", name, mesh.name);
    }
    const auto byTime = [](const FdsEvent& a, const FdsEvent& b) { return a.time < b.time; };
    for (auto& one : mesh.obstructions)
      std::stable_sort(one.events.begin(), one.events.end(), byTime);
    for (auto& one : mesh.vents) std::stable_sort(one.events.begin(), one.events.end(), byTime);
  }
  for (FdsDevice& device : index_.devices) {
    std::stable_sort(device.events.begin(), device.events.end(),
                     [](const FdsEvent& a, const FdsEvent& b) { return a.time < b.time; });
  }
  leaveOutEvacuation();
  if (index_.meshes.empty())
    return fail(ErrorCode::kInvalidData, "{}: has meshes of FDS+Evac alone, without gas", name);
  findInput();
  if (const std::string remark = files_.remark(); !remark.empty())
    index_.remarks.push_back(fmt::format("{}: {}", name, remark));
  if (lines_.endedWithinLine() || cutOff_) {
    index_.remarks.push_back(
        {RemarkCode::kDamaged,
         fmt::format("{}: ends within line {}: what it names there is left out", name,
                     lines_.lineNumber() + 1)});
  }
  int walls = 0;
  std::string lost;
  std::erase_if(index_.others, [&](const FdsOtherFile& other) {
    std::error_code code;
    if (other.kind != kFdsWallsKind)
      return false;
    const bool there = std::filesystem::exists(other.file, code);
    ++(there ? walls : cutFaces_);
    if (!there)
      lost = ": " + printable(other.file.filename().string());
    return !there;
  });
  if (!lost.empty() || (cutFaces_ > 0 && walls == 0)) {
    index_.remarks.push_back(
        {RemarkCode::kLeftOut,
         fmt::format("{}: warning: walls made of triangles (GEOM) are not there{}: they are not "
                     "drawn and block "
                     "no sight line, so that signs may count as seen through them",
                     name, lost)});
  }
  if (walls > 0 || cutFaces_ > 0) {
    index_.remarks.push_back(
        {RemarkCode::kAssumed, fmt::format("{}: the gas of cells that walls made of triangles "
                                           "(GEOM) cut counts as the files have it "
                                           "(.s3d: clear in their corners within walls): values "
                                           "beside such walls are less certain",
                                           name)});
  }
  for (const auto& [quantity, number] : skippedSlices_) {
    index_.remarks.push_back(
        {RemarkCode::kLeftOut,
         fmt::format(
             "{}: {} slices of '{}' on cut cells are left out: only structured ones are read", name,
             number, quantity)});
  }
  return {};
}

Result<SmvIndex> SmvReader::read() {
  for (;;) {
    VOLUTE_ASSIGN(const auto line, nextLine());
    if (!line)
      break;
    const Status status = handle(*line);
    if (status)
      continue;
    // A case that runs appends entries: a cut-off one is left out. Meshes must be whole.
    const bool later =
        line->starts_with("SL") || line->starts_with("SMOK") || line->starts_with("PL3D") ||
        line->starts_with("BND") || line->starts_with("PRT5") || line->starts_with("EVA5") ||
        line->starts_with("CSVF") || line->starts_with("ISOG") || line->starts_with("TISOG") ||
        line->starts_with("SHOW_") || line->starts_with("HIDE_") || line->starts_with("OPEN_") ||
        line->starts_with("CLOSE_") || line->starts_with("DEVICE");  // DEVICE_ACT too
    if (status.error().code != ErrorCode::kTruncated || !later)
      return tl::unexpected<Error>(status.error());
    break;
  }
  if (meshCount_ && static_cast<int>(index_.meshes.size()) < *meshCount_) {
    return fail(ErrorCode::kTruncated, "{}: ends at line {} with {} of {} meshes",
                lines_.path().string(), lines_.lineNumber(), index_.meshes.size(), *meshCount_);
  }
  const auto cut = std::ranges::find_if(blocks_, [](int blocks) { return blocks != 3; });
  if (cut != blocks_.end()) {
    return fail(ErrorCode::kTruncated,
                "{}: mesh {} has no OBST or no VENT block: the file ends at line {} or is damaged",
                lines_.path().string(), cut - blocks_.begin() + 1, lines_.lineNumber());
  }
  VOLUTE_TRY(finish());
  return std::move(index_);
}

bool isShown(std::span<const FdsEvent> events, double time) {
  if (events.empty())
    return true;
  const auto next = std::ranges::upper_bound(events, time, {}, &FdsEvent::time);
  return next == events.begin() ? !next->shown : std::prev(next)->shown;
}

std::uint64_t FdsMesh::nodeCount() const {
  return static_cast<std::uint64_t>(planes[0].size()) * planes[1].size() * planes[2].size();
}

std::uint64_t FdsMesh::cellCount() const {
  return static_cast<std::uint64_t>(cells(0)) * cells(1) * cells(2);
}

Box3 FdsMesh::bounds() const {
  return {Vec3(planes[0].front(), planes[1].front(), planes[2].front()),
          Vec3(planes[0].back(), planes[1].back(), planes[2].back())};
}

Result<SmvIndex> SmvIndex::read(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(auto lines, TextLines::open(path));
  return SmvReader(std::move(lines), maxMemory).read();
}

const FdsInput& inputOf(const SmvIndex& index) {
  static const FdsInput kNone;
  return index.input ? *index.input : kNone;
}

bool isSmvPath(const std::string& path) {
  return extensionOf(path) == ".smv";
}

}  // namespace volute
