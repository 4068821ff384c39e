// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/recompress.hpp"

#include <utility>

#include "volute/base/output_file.hpp"
#include "volute/codec/bundle.hpp"
#include "volute/grid/wrapped_source.hpp"

namespace volute {
namespace {

class RestatedSource final : public WrappedSource {
 public:
  RestatedSource(std::unique_ptr<FrameSource> source, VolumeInfo info)
      : WrappedSource(std::move(source)), info_(std::move(info)) {}

  const VolumeInfo& info() const override { return info_; }

 private:
  VolumeInfo info_;
};

/// The same voxels between other bounds, along the axes.
void moveTo(const VolumeInfo& info, GridDescription& grid) {
  const Vec3 voxel = info.voxelSize();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    grid.voxelSize[a] = voxel[axis];
    grid.origin[a] =
        info.bounds.min[axis] + (0.5 - static_cast<double>(grid.begin[a])) * voxel[axis];
  }
  grid.matrices.clear();
  grid.map = voxel[0] == voxel[1] && voxel[0] == voxel[2] ? "UniformScaleTranslateMap"
                                                          : "ScaleTranslateMap";
}

}  // namespace

void addOwnError(const VoluteReader& reader, CompressOptions& options) {
  const VoluteHeader& header = reader.header();
  const double range = header.valueMax - header.valueMin;
  options.sourceRms = header.reachedRms * (range > 0 ? range : 1);
  options.sourceMaxError = header.reachedMaxError;
}

Result<CompressReport> recompress(const std::shared_ptr<const VoluteReader>& reader,
                                  const VolumeInfo& info, const std::filesystem::path& target,
                                  CompressOptions options, Progress& progress) {
  std::optional<GridDescription> description = reader->grid().description;
  const Box3& bounds = reader->info().bounds;
  if (description && (info.bounds.min != bounds.min || info.bounds.max != bounds.max))
    moveTo(info, *description);
  addOwnError(*reader, options);
  options.name = target.string();
  RestatedSource source(frameSource(reader), info);
  CompressReport report;
  if (description && (wantsDescription(*description) || reader->offset() != 0 ||
                      !reader->fileMetadata().lists.empty())) {
    options.halves = description->half;
    options.floats = description->isOfFloats();
    VOLUTE_ASSIGN(const auto values, PendingFile::create(target));
    VOLUTE_ASSIGN(report, compress(source, values.path(), options, progress));
    VOLUTE_ASSIGN(auto file, PendingFile::create(target));
    VOLUTE_ASSIGN(report.fileBytes, bundle({{info.name, description, values.path()}},
                                           reader->fileMetadata(), file.path(), progress));
    VOLUTE_TRY(file.commit());
  } else {
    VOLUTE_ASSIGN(report, compress(source, target, options, progress));
  }
  VOLUTE_ASSIGN(const auto written, VoluteReader::open(target));
  const VoluteHeader& header = written.header();
  report.relativeRms = header.reachedRms;
  report.maxError = header.reachedMaxError;
  if (header.support)
    report.support.rms = header.support->rms;
  return report;
}

}  // namespace volute
