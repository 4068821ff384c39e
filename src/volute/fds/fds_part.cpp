// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_part.hpp"

#include <algorithm>

#include "volute/fds/fds_input.hpp"
#include "volute/fds/particle_file.hpp"

namespace volute {
namespace {

/// The cells that values stand for, on one axis.
struct AxisCells {
  std::vector<double> planes;
  std::vector<int> places;
  std::vector<std::array<int, 2>> cells;  // of the mesh, first and last, for each lattice cell
};

/// Values of cells with indices begin..end; index 0 is a ghost, i stands for the cell that ends at
/// node i.
AxisCells cellAxis(const std::vector<double>& nodes, int begin, int end) {
  AxisCells axis;
  for (int i = std::max(begin, 1); i <= end; ++i) {
    if (axis.planes.empty())
      axis.planes.push_back(nodes[static_cast<std::size_t>(i) - 1]);
    axis.planes.push_back(nodes[static_cast<std::size_t>(i)]);
    axis.places.push_back(i - begin);
    axis.cells.push_back({i - 1, i - 1});
  }
  return axis;
}

/// Values at nodes begin..end; one node alone is a layer that reaches to the middles of the cells
/// on both sides.
AxisCells nodeAxis(const std::vector<double>& nodes, int begin, int end) {
  AxisCells axis;
  if (begin < end) {
    for (int i = begin; i <= end; ++i) {
      axis.planes.push_back(nodes[static_cast<std::size_t>(i)]);
      axis.places.push_back(i - begin);
      if (i < end)
        axis.cells.push_back({i, i});
    }
    return axis;
  }
  const int last = static_cast<int>(nodes.size()) - 1;
  const auto middle = [&](int cell) {
    return 0.5 *
           (nodes[static_cast<std::size_t>(cell)] + nodes[static_cast<std::size_t>(cell) + 1]);
  };
  axis.planes = {begin > 0 ? middle(begin - 1) : nodes.front(),
                 begin < last ? middle(begin) : nodes.back()};
  axis.places = {0, 0};
  axis.cells = {{std::max(begin - 1, 0), std::min(begin, last - 1)}};
  return axis;
}

/// Clear air at all times at which something else is stored.
class ClearFrames final : public FdsFrameFile {
 public:
  /// Of all values with indices as FDS counts cells, ghosts included.
  ClearFrames(std::vector<double> times, const FdsMesh& mesh) : FdsFrameFile(mesh.nodeCount()) {
    frames_.times = std::move(times);
    frames_.offsets.resize(frames_.times.size());
  }

  Status readFrame(std::size_t, std::span<float> out) const override {
    std::ranges::fill(out, 0.0F);
    return {};
  }
};

/// Of the first file that has any: slices, fire, particles, PLOT3D.
std::vector<double> timesOfOthers(const SmvIndex& index) {
  const auto meshOf = [&](int mesh) -> const FdsMesh& {
    return index.meshes[static_cast<std::size_t>(mesh)];
  };
  const auto timesOf = [](const auto& file) {
    return file ? file->frames().times : std::vector<double>();
  };
  std::vector<double> times;
  for (const FdsSliceEntry& slice : index.slices) {
    if (times.empty())
      times = timesOf(FdsSliceFile::open(slice, meshOf(slice.mesh)));
  }
  for (const FdsSmokeEntry& smoke : index.smoke) {
    if (times.empty())
      times = timesOf(FdsSmokeFile::open(smoke.file, meshOf(smoke.mesh)));
  }
  for (const FdsParticleEntry& particles : index.particles) {
    if (times.empty())
      times = timesOf(FdsParticleFile::open(particles));
  }
  for (const FdsPlotEntry& plot : index.plots) {
    if (times.empty() || plot.time > times.back())
      times.push_back(plot.time);
  }
  return times.empty() ? std::vector<double>{0} : times;
}

}  // namespace

/// In the unit of the mesh's first file.
std::optional<std::size_t> FdsCase::plotVariableOf(const FdsPlotEntry& plot,
                                                   const FdsSourcePart& part) const {
  const auto variable = plotVariable(plot, source().plotted);
  return variable && plot.labels[*variable].unit == labelsOf(index_, source(), part).unit
             ? variable
             : std::nullopt;
}

Result<std::shared_ptr<FdsCase::Part>> FdsCase::openPart(const FdsSourcePart& what) const {
  auto part = std::make_shared<Part>();
  part->what = what;
  const FdsMesh& mesh = index_.meshes[static_cast<std::size_t>(what.mesh)];
  FdsNodeBox nodes{{0, 0, 0}, {mesh.cells(0), mesh.cells(1), mesh.cells(2)}};
  const auto hold = [&](auto opened) -> Status {
    if (!opened)
      return tl::unexpected<Error>(opened.error());
    using File = typename decltype(opened)::value_type;
    part->file = std::make_unique<File>(std::move(*opened));
    return {};
  };
  if (source().kind == FdsFileKind::kSlice) {
    const FdsSliceEntry& entry = index_.slices[what.entry];
    part->path = entry.file;
    VOLUTE_ASSIGN(auto slice, FdsSliceFile::open(entry, mesh));
    nodes = slice.nodes();
    part->file = std::make_unique<FdsSliceFile>(std::move(slice));
  } else if (source().kind == FdsFileKind::kPlot) {
    std::vector<FdsPlotEntry> entries;
    std::vector<std::size_t> variables;
    for (const FdsPlotEntry& plot : index_.plots) {
      const auto variable = plotVariableOf(plot, what);
      if (plot.mesh != what.mesh || !variable)
        continue;
      entries.push_back(plot);
      variables.push_back(*variable);
    }
    part->path = index_.plots[what.entry].file;
    VOLUTE_TRY(hold(FdsPlotFiles::open(entries, variables, mesh)));
  } else if (source().kind == FdsFileKind::kClear) {
    part->path = index_.path;
    part->file = std::make_unique<ClearFrames>(timesOfOthers(index_), mesh);
  } else {
    const FdsSmokeEntry& entry = index_.smoke[what.entry];
    part->path = entry.file;
    part->massExtinction = entry.massExtinction.value_or(part->massExtinction);
    part->assumesExtinction = !entry.massExtinction;
    if (source().kind == FdsFileKind::kSmoke16) {
      VOLUTE_TRY(hold(FdsSmoke16File::open(part->path.replace_extension(".s16"), mesh)));
    } else {
      part->sizeRows = readSizeFile(entry.file.string() + ".sz");
      if (source().kind == FdsFileKind::kSmokeDensity)
        part->path.replace_extension(".s3dd");
      VOLUTE_TRY(hold(FdsSmokeFile::open(part->path, mesh)));
    }
  }
  if (source().kind == FdsFileKind::kSlice || source().kind == FdsFileKind::kPlot) {
    const auto stated = inputOf(index_).massExtinction;
    part->massExtinction = stated.value_or(part->massExtinction);
    part->assumesExtinction = !stated;
  }
  if (options_.massExtinction > 0) {
    part->massExtinction = options_.massExtinction;
    part->assumesExtinction = false;
  }
  part->cellLength = mesh.planes[0][1] - mesh.planes[0][0];
  part->lattice.mesh = what.mesh;
  part->lattice.nodal = !source().cellCentred;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = source().cellCentred
                           ? cellAxis(mesh.planes[axis], nodes.begin[axis], nodes.end[axis])
                           : nodeAxis(mesh.planes[axis], nodes.begin[axis], nodes.end[axis]);
    part->lattice.planes[axis] = cells.planes;
    part->axes.place[axis] = cells.places;
    part->axes.size[axis] = nodes.end[axis] - nodes.begin[axis] + 1;
    part->meshCells[axis] = cells.cells;
    if (nodes.begin[axis] != nodes.end[axis] || part->lattice.cells(axis) < 1)
      continue;
    part->lattice.thinAxis = axis;
    part->lattice.place = source().cellCentred
                              ? 0.5 * (cells.planes[0] + cells.planes[1])
                              : mesh.planes[axis][static_cast<std::size_t>(nodes.begin[axis])];
  }
  return part;
}

}  // namespace volute
