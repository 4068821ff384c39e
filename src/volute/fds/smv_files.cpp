// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <filesystem>

#include "volute/fds/smv_reader.hpp"

namespace volute {
namespace {

/// "% " and what follows, "!" and what follows: comments of the index.
std::string_view beforeMark(std::string_view text, char mark) {
  return text.substr(0, text.find(mark));
}

}  // namespace

Status SmvReader::readTable(std::string_view) {
  std::string kind, name;
  VOLUTE_TRY(text(kind, "what a table holds"));
  VOLUTE_TRY(text(name, "the name of a table"));
  index_.others.push_back({"table of " + kind, -1, files_.find(index_.path.parent_path(), name)});
  return {};
}

/// Values of one mesh alone are in a file.
Status SmvReader::claim(const std::filesystem::path& file, int mesh) {
  const auto [owner, first] = owners_.emplace(file.string(), mesh);
  if (first || owner->second == mesh)
    return {};
  return wrong(fmt::format("a file of mesh {} alone; {} is that of mesh {} already", mesh + 1,
                           file.filename().string(), owner->second + 1));
}

/// A line with the name of a file beside the index.
Result<std::filesystem::path> SmvReader::file(std::string_view what) {
  std::string name;
  VOLUTE_TRY(text(name, what));
  return files_.find(index_.path.parent_path(), name);
}

Status SmvReader::readBoundary(std::string_view rest) {
  VOLUTE_ASSIGN(const int mesh, meshNumber(rest));
  VOLUTE_ASSIGN(const auto path, file("the name of a boundary file"));
  FdsLabels labels;
  VOLUTE_TRY(readLabels(labels));
  index_.others.push_back({"boundary values of " + labels.quantity, mesh, path});
  return {};
}

Status SmvReader::readParticleClass(std::string_view) {
  FdsParticleClass one;
  std::string line;
  VOLUTE_TRY(text(line, "the name of a class of particles"));
  one.name = trimmed(beforeMark(line, '%'));
  VOLUTE_ASSIGN(const auto colour, numbers("the colour of a class of particles", 3));
  for (int c = 0; c < 3; ++c) one.colour[c] = static_cast<float>(std::clamp(colour[c], 0.0, 1.0));
  VOLUTE_ASSIGN(const int quantities, count("the number of a class's quantities"));
  FdsLabels labels;  // the files say them again
  for (int i = 0; i < quantities; ++i) VOLUTE_TRY(readLabels(labels));
  index_.particleClasses.push_back(std::move(one));
  return {};
}

Status SmvReader::readParticles(std::string_view rest) {
  FdsParticleEntry particles;
  VOLUTE_ASSIGN(particles.mesh, meshNumber(rest));
  VOLUTE_ASSIGN(particles.file, file("the name of a particle file"));
  VOLUTE_TRY(claim(particles.file, particles.mesh));
  VOLUTE_ASSIGN(const int number, count("the number of classes of particles"));
  bool known = true;
  for (int i = 0; i < number; ++i) {
    VOLUTE_ASSIGN(const int one, count("the number of a class of particles"));
    known = known && one >= 1 && one <= static_cast<int>(index_.particleClasses.size());
    particles.classes.push_back(one - 1);
  }
  if (known)
    index_.particles.push_back(std::move(particles));
  else  // people of FDS+Evac
    index_.others.push_back({kUnknownParticles, particles.mesh, particles.file});
  return {};
}

/// With `coloured` there is a second file, of another quantity on the surfaces.
Status SmvReader::readSurfaces(std::string_view rest, bool coloured) {
  FdsIsoEntry surfaces;
  VOLUTE_ASSIGN(surfaces.mesh, meshNumber(rest));
  VOLUTE_ASSIGN(surfaces.file, file("the name of an isosurface file"));
  VOLUTE_TRY(claim(surfaces.file, surfaces.mesh));
  std::filesystem::path colours;
  if (coloured) {
    VOLUTE_ASSIGN(colours, file("the name of a file of values on isosurfaces"));
  }
  VOLUTE_TRY(readLabels(surfaces.labels));
  if (coloured) {
    FdsLabels labels;
    VOLUTE_TRY(readLabels(labels));
    index_.others.push_back(
        {"values of " + labels.quantity + " on isosurfaces", surfaces.mesh, colours});
  }
  index_.isosurfaces.push_back(std::move(surfaces));
  return {};
}

Status SmvReader::readLabels(FdsLabels& labels) {
  VOLUTE_TRY(text(labels.quantity, "a quantity"));
  VOLUTE_TRY(text(labels.shortName, "a quantity's short name"));
  return text(labels.unit, "a quantity's unit");
}

Status SmvReader::readSliceNodes(std::string_view rest) {
  return readSlice(rest, false);
}

Status SmvReader::readSliceCells(std::string_view rest) {
  return readSlice(rest, true);
}

Status SmvReader::readSlice(std::string_view rest, bool cellCentred) {
  FdsSliceEntry slice;
  slice.cellCentred = cellCentred;
  VOLUTE_ASSIGN(slice.mesh, meshNumber(rest));
  const auto mark = rest.find('&');
  if (mark != std::string_view::npos) {
    std::vector<double> indices;
    for (const auto word : words(beforeMark(rest.substr(mark + 1), '!'))) {
      const auto value = numberOf(word);
      if (value)
        indices.push_back(*value);
    }
    if (indices.size() < 6)
      return wrong("six node indices after '&'");
    const FdsMesh& mesh = index_.meshes[slice.mesh];
    cells_ = {mesh.cells(0), mesh.cells(1), mesh.cells(2)};
    VOLUTE_ASSIGN(slice.nodes, nodeBox(indices));
  }
  VOLUTE_ASSIGN(slice.file, file("the name of a slice file"));
  VOLUTE_TRY(readLabels(slice.labels));
  VOLUTE_TRY(claim(slice.file, slice.mesh));
  const auto kind = rest.find('#');
  if (kind != std::string_view::npos && rest.find("STRUCTURED", kind) == std::string_view::npos) {
    ++skippedSlices_[slice.labels.quantity];
    return {};
  }
  index_.slices.push_back(std::move(slice));
  return {};
}

Status SmvReader::readSmoke(std::string_view rest) {
  FdsSmokeEntry smoke;
  VOLUTE_ASSIGN(smoke.mesh, meshNumber(rest));
  const auto found = words(rest);
  if (found.size() > 1) {
    smoke.massExtinction = numberOf(found[1]);
    if (smoke.massExtinction && !(*smoke.massExtinction > 0))
      smoke.massExtinction.reset();
  }
  VOLUTE_ASSIGN(smoke.file, file("the name of a smoke file"));
  VOLUTE_TRY(readLabels(smoke.labels));
  VOLUTE_TRY(claim(smoke.file, smoke.mesh));
  index_.smoke.push_back(std::move(smoke));
  return {};
}

Status SmvReader::readPlot(std::string_view rest) {
  FdsPlotEntry plot;
  const auto found = words(rest);
  const auto time = found.empty() ? std::nullopt : numberOf(found[0]);
  if (!time || found.size() < 2)
    return wrong("PL3D, a time and a mesh");
  plot.time = *time;
  // Fortran may leave a space within the time: "PL3D       10.06     1" or "PL3D  10 .06  1".
  VOLUTE_ASSIGN(plot.mesh, meshNumber(found.back()));
  if (found.size() == 3 && found[1].starts_with('.')) {
    if (const auto joined = numberOf(std::string(found[0]) + std::string(found[1])))
      plot.time = *joined;
  }
  VOLUTE_ASSIGN(plot.file, file("the name of a PLOT3D file"));
  VOLUTE_TRY(claim(plot.file, plot.mesh));
  for (FdsLabels& labels : plot.labels) VOLUTE_TRY(readLabels(labels));
  index_.plots.push_back(std::move(plot));
  return {};
}

}  // namespace volute
