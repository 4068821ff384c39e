// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_report.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <nlohmann/json.hpp>

#include "volute/codec/kept_grids.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/volume_files/compression_report.hpp"
#include "volute/volume_files/volume_grids.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

std::string firstToLast(auto first, auto last) {
  return first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last);
}

/// [first, last] of each gap.
nlohmann::ordered_json missingFrames(const VolumeInfo& info) {
  auto gaps = nlohmann::ordered_json::array();
  for (const FrameGap& gap : gapsOf(info.frameNumbers)) {
    gaps.push_back({jsonFrame(gap.first, info.frameScale), jsonFrame(gap.last, info.frameScale)});
  }
  return gaps;
}

/// Rows of the first frame's.
nlohmann::ordered_json matrixJson(const std::vector<GridMatrix>& places) {
  return places.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(places.front());
}

std::string matrixText(const std::vector<GridMatrix>& places) {
  if (places.empty())
    return "";
  const Mat3 m = linearOf(places.front());
  const bool moves =
      std::ranges::any_of(places, [&](const GridMatrix& place) { return place != places.front(); });
  return fmt::format(
      "turned or moved by ({:.4g}, {:.4g}, {:.4g}; {:.4g}, {:.4g}, {:.4g}; {:.4g}, "
      "{:.4g}, {:.4g}){}",
      m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2),
      moves ? ", and otherwise in other frames" : "");
}

/// @param places  VolumeInput::places
void addFrames(Report& report, const VolumeInfo& info) {
  report.add("frames", info.frames, fmt::format("{}", info.frames))
      .add("frame_numbers",
           {jsonFrame(info.frameNumbers.front(), info.frameScale),
            jsonFrame(info.frameNumbers.back(), info.frameScale)},
           firstToLast(info.frameText(0), info.frameText(info.frameNumbers.size() - 1)))
      .add("missing_frames", missingFrames(info),
           missingNumbers(info.frameNumbers, info.frameScale))
      .add("times", {info.times.front(), info.times.back()},
           firstToLast(info.times.front(), info.times.back()) + " s");
}

void addVolume(Report& report, const VolumeInfo& info, const std::vector<GridMatrix>& places) {
  const Box3 b = aroundPlaces(info.bounds, places);
  report.add("grid", info.name)
      .add("unit", info.unit, info.unit)
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z))
      .add("channels", info.channels,
           info.channels == 1 ? "1" : fmt::format("{} (linear RGB)", info.channels));
  addFrames(report, info);
  report
      .add("bounds", {b.min.x(), b.min.y(), b.min.z(), b.max.x(), b.max.y(), b.max.z()}, boxText(b))
      .add("matrix", matrixJson(places), matrixText(places))
      .add("up", info.up == 0 ? "" : std::string(1, info.up))
      .add("basis", basisName(info.basis))
      .add("raw_bytes", info.rawBytes(), bytesText(info.rawBytes()));
}

void addHeader(Report& report, const VoluteReader& reader, std::uint64_t bytes) {
  const VoluteHeader& header = reader.header();
  const double ratio = static_cast<double>(reader.info().rawBytes()) / static_cast<double>(bytes);
  report.add("ratio", jsonNumber(ratio), fmt::format("{:.4g}", ratio))
      .add("minimum", header.valueMin)
      .add("maximum", header.valueMax)
      .add("offset", header.offset,
           header.offset == 0 ? "" : fmt::format("{} is added to what is stored", header.offset))
      .add("asked", {{"kind", header.targetKind}, {"value", jsonNumber(header.targetValue)}},
           fmt::format("{} {:.6g}", header.targetKind, header.targetValue))
      .add("relative_rms", header.reachedRms);
  if (const auto& support = header.support) {
    report
        .add("support_rms", support->rms, fmt::format("{:.6g} (over what is in use)", support->rms))
        .add("support_share", support->share,
             fmt::format("{:.4g} % of all voxels", 100 * support->share))
        .add("support_range", {support->low, support->high},
             fmt::format("{:.4g} to {:.4g}{}", support->low, support->high,
                         support->robust ? " (.0001 and .9999 quantiles)" : ""))
        .add("max_error_at",
             {{"frame",
               jsonFrame(reader.info().frameNumbers[static_cast<std::size_t>(support->worstFrame)],
                         reader.info().frameScale)},
              {"voxel", support->worstVoxel}},
             fmt::format("frame {}, voxel ({}, {}, {})",
                         reader.info().frameText(static_cast<std::size_t>(support->worstFrame)),
                         support->worstVoxel[0], support->worstVoxel[1], support->worstVoxel[2]));
  }
  const std::uint64_t occupied = reader.occupiedCount();
  report.add("max_error", header.reachedMaxError)
      .add("codec", header.codec, fmt::format("{}", header.codec))
      .add("format", fmt::format("{}.{}", header.versionMajor, header.versionMinor))
      .add("written_by", header.writtenBy)
      .add("provenance", header.provenance)
      .add("blocks", occupied, fmt::format("{} of {}", occupied, reader.blocks().count()))
      .add("block_frames", reader.blocks().frames(),
           fmt::format("{} decoded together", reader.blocks().frames()));
}

void addIntegrity(Report& report, const Integrity& integrity, const VoluteReader& reader) {
  report.add("complete", integrity.complete(), "")
      .add("integrity",
           {{"expected_bytes", integrity.expectedBytes},
            {"present_bytes", integrity.presentBytes},
            {"segments", integrity.segments},
            {"intact_segments", integrity.intactSegments},
            {"intact_levels", integrity.intactLevels},
            {"first_fault", integrity.firstFault}},
           integrityText(integrity, reader));
}

// A line for each block: where it is, how it is coded, what it takes.
void addBlocks(Report& report, const VoluteReader& reader) {
  const BlockGrid& grid = reader.blocks();
  const VolumeInfo& info = reader.info();
  nlohmann::ordered_json blocks = nlohmann::ordered_json::array();
  std::map<std::string, int> modes;
  std::string text;
  // Pages of the index that are damaged are what the integrity says.
  const auto occupied = reader.occupied();
  if (!occupied)
    return;
  for (const std::uint64_t number : *occupied) {
    const auto i = static_cast<std::size_t>(number);
    const auto origin = grid.origin(i);
    const auto extents = grid.extents(i);
    const auto described = reader.describeBlock(i);
    const std::string mode = described ? *described : "damaged";
    const std::uint64_t bytes = reader.storedBytes(i).value_or(0);
    ++modes[mode];
    blocks.push_back({{"block", i},
                      {"origin", {origin[3], origin[2], origin[1]}},
                      {"size", {extents[3], extents[2], extents[1]}},
                      {"frames",
                       {jsonFrame(info.frameNumbers[origin[0]], info.frameScale),
                        jsonFrame(info.frameNumbers[origin[0] + extents[0] - 1], info.frameScale)}},
                      {"bytes", bytes},
                      {"mode", mode}});
    text += fmt::format("\n  {:>6}  frames {} to {}, voxels from {}, {}, {}: {} bytes, {}", i,
                        info.frameText(origin[0]), info.frameText(origin[0] + extents[0] - 1),
                        origin[3], origin[2], origin[1], bytes, mode);
  }
  auto counts = nlohmann::ordered_json::object();
  std::string countsText;
  for (const auto& [mode, count] : modes) {
    counts[mode] = count;
    countsText += fmt::format("{}{} {}", countsText.empty() ? "" : "; ", count, mode);
  }
  report.add("modes", counts, countsText).add("block_list", blocks, text);
}

/// A line for each grid of a .volute: size, range, voxels that are not empty, memory, bytes.
void addVoluteGrids(Report& report, const VoluteReader& reader) {
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const VoluteGrid& grid : reader.grids()) {
    const GridDescription own = grid.description.value_or(
        GridDescription{.type = grid.info.channels == 3 ? "vec3s" : "float"});
    const VoluteHeader& header = grid.header;
    const VolumeInfo& info = grid.info;
    const Vec3 voxel =
        grid.empty ? Vec3(own.voxelSize[0], own.voxelSize[1], own.voxelSize[2]) : info.voxelSize();
    const std::uint64_t memory =
        own.memory > 0 ? own.memory : 4 * static_cast<std::uint64_t>(info.frameValues());
    const double ratio = static_cast<double>(info.rawBytes()) /
                         static_cast<double>(std::max<std::uint64_t>(grid.bytes, 1));
    list.push_back(
        {{"name", info.name},
         {"type", own.type},
         {"class", own.gridClass},
         {"half", own.half},
         {"empty", grid.empty},
         {"size", {info.x, info.y, info.z}},
         {"voxel_size", {voxel.x(), voxel.y(), voxel.z()}},
         {"active_voxels",
          grid.description ? nlohmann::ordered_json(own.voxels) : nlohmann::ordered_json()},
         {"minimum", header.valueMin},
         {"maximum", header.valueMax},
         {"memory_bytes", memory},
         {"bytes", grid.bytes},
         {"raw_bytes", info.rawBytes()},
         {"asked", {{"kind", header.targetKind}, {"value", jsonNumber(header.targetValue)}}},
         {"relative_rms", header.reachedRms},
         {"support_rms",
          header.support ? nlohmann::ordered_json(header.support->rms) : nlohmann::ordered_json()},
         {"support_share", header.support ? nlohmann::ordered_json(header.support->share)
                                          : nlohmann::ordered_json()},
         {"max_error", header.reachedMaxError}});
    text += fmt::format("\n  {:<16} {}{}{}, ", info.name, own.type, own.half ? " (half)" : "",
                        own.gridClass.empty() ? "" : ", " + own.gridClass);
    if (grid.empty) {
      text += "empty";
      continue;
    }
    text += fmt::format("{} x {} x {}, {:.4g} to {:.4g}, ", info.x, info.y, info.z, header.valueMin,
                        header.valueMax);
    if (grid.description)
      text += fmt::format("{} voxels not empty, ", own.voxels);
    text += fmt::format(
        "{} in memory, {} in the file{}, relative rms {:.3g}, max error {:.3g}", bytesText(memory),
        bytesText(grid.bytes),
        grid.bytes > 0 ? fmt::format(" ({:.4g} of dense floats)", ratio) : std::string(),
        header.reachedRms, header.reachedMaxError);
  }
  report.add("grids", list, text);
}

Result<VoluteReader> openForInfo(const std::string& path, const std::string& grid,
                                 Reading& reading) {
  VoluteReader::Options options;
  options.partial = true;
  options.maxMemory = reading.maxMemory;
  options.grid = grid;
  return VoluteReader::open(path, options);
}

/// All segments of all grids.
Result<Integrity> verifyGrids(const std::string& path, const VoluteReader& main, Reading& reading) {
  Integrity all = main.verify();
  for (const VoluteGrid& grid : main.grids()) {
    if (grid.empty || grid.info.name == main.info().name)
      continue;
    VOLUTE_ASSIGN(const auto reader, openForInfo(path, grid.info.name, reading));
    const Integrity one = reader.verify();
    all.segments += one.segments;
    all.intactSegments += one.intactSegments;
    all.intactLevels = std::min(all.intactLevels, one.intactLevels);
    if (all.firstFault.empty() && !one.firstFault.empty())
      all.firstFault = fmt::format("grid '{}': {}", grid.info.name, one.firstFault);
  }
  main.verifyKept(all);
  return all;
}

Result<FileDescription> describeVolute(const std::string& path, const DescribeRequest& request,
                                       Reading& reading) {
  VOLUTE_ASSIGN(const auto reader, openForInfo(path, request.field, reading));
  VOLUTE_ASSIGN(const Integrity integrity, request.field.empty()
                                               ? verifyGrids(path, reader, reading)
                                               : Result<Integrity>(reader.verify()));
  const std::uint64_t bytes = bytesOnDisk(path).value_or(integrity.presentBytes);
  const bool several = reader.grids().size() > 1;
  Report report;
  report.add("file", path).add("kind", "volute").add("bytes", bytes, bytesText(bytes));
  addIntegrity(report, integrity, reader);
  VoluteGrid own = reader.grid();
  if (request.framesPerSecond)
    own.info.setRate(*request.framesPerSecond);
  if (own.empty) {  // no grid has values
    addFrames(report, own.info);
    report.add("up", own.info.up == 0 ? "" : std::string(1, own.info.up))
        .add("written_by", own.header.writtenBy)
        .add("provenance", own.header.provenance);
  } else {
    addVolume(report, own.info,
              own.description ? own.description->places() : std::vector<GridMatrix>());
    addHeader(report, reader, several ? own.bytes : std::max(bytes, integrity.expectedBytes));
  }
  if (several || own.empty || own.description)
    addVoluteGrids(report, reader);
  std::vector<KeptResult> kept;
  for (std::size_t i = 0; i < reader.kept().grids.size(); ++i) {
    const KeptGrid& grid = reader.kept().grids[i];
    kept.push_back({grid.name, grid.type, reader.kept().storedBytes(i)});
  }
  if (!kept.empty())
    addKept(report, kept);
  if (request.blocks)
    addBlocks(report, reader);
  return FileDescription{std::move(report), !integrity.complete()};
}

/// The first file of what is one or more OpenVDB files; nothing for other formats.
std::optional<std::filesystem::path> firstVdb(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    const auto files = listNumberedFiles(path, ".vdb");
    return files && volumesIn(path) ? std::optional(files->front().path) : std::nullopt;
  }
  if (!isVdbPath(path))
    return std::nullopt;
  if (namesSeriesOfFiles(path)) {
    const auto pattern = FramePattern::parse(path);
    if (!pattern)
      return std::nullopt;
    const auto files = pattern->list(SubFrames::kAllowed);
    return files ? std::optional(files->front().path) : std::nullopt;
  }
  return path;
}

/// So many voxels with the same value.
void addEqual(ValueRange& range, std::span<const float> value, std::uint64_t voxels) {
  if (voxels == 0)
    return;
  range.add(value);
  range.count += (voxels - 1) * value.size();
  range.zeros += (voxels - 1) * static_cast<std::uint64_t>(std::ranges::count(value, 0.0f));
}

/// All voxels of a frame.
void addValues(ValueRange& range, const Bricks& frame, const VolumeInfo& info) {
  const auto channels = static_cast<std::size_t>(frame.channels());
  const IndexBox box{{0, 0, 0}, {info.x, info.y, info.z}};
  std::uint64_t filled = 0;
  std::vector<float> values;
  for (std::size_t i = 0; i < frame.leaves().size(); ++i) {
    const Bricks::Leaf& leaf = frame.leaves()[i];
    const BrickMask inside = maskInside(leaf.origin, box);
    values.clear();
    for (std::size_t z = 0; z < inside.size(); ++z) {
      for (std::uint64_t left = leaf.valued[z] & inside[z]; left != 0; left &= left - 1) {
        for (std::size_t c = 0; c < channels; ++c)
          values.push_back(frame.values(
              i)[c * Bricks::kVoxels + 64 * z + static_cast<std::size_t>(std::countr_zero(left))]);
      }
    }
    range.add(values);
    filled += values.size() / channels;
  }
  for (const Bricks::Tile& tile : frame.tiles()) {
    const std::uint64_t voxels = voxelsIn(tile.box().intersection(box));
    addEqual(range, std::span(tile.value).first(channels), voxels);
    filled += voxels;
  }
  addEqual(range, std::span(frame.background()).first(channels), info.voxels() - filled);
}

/// Names the grids of a sequence that its first file, whose grids are listed, lacks.
void tellLaterGrids(const std::string& path, const std::filesystem::path& first,
                    std::span<const GridFacts> listed, const InputOptions& options,
                    Reading& reading) {
  Progress quiet;
  Reading silent = reading.with(quiet);
  const auto all = VolumeGrids::open(path, options, silent);
  if (!all || (*all)->frames().frames < 2)
    return;
  std::string later;
  for (const VolumeGrid& grid : (*all)->grids()) {
    const bool there =
        std::ranges::any_of(listed, [&](const GridFacts& one) { return grid.name == one.name; });
    if (!there)
      later += fmt::format("{}'{}'", later.empty() ? "" : ", ", grid.name);
  }
  if (!later.empty())
    reading.progress.remark(
        Remark(RemarkCode::kNote, fmt::format("{}: {}, whose grids are listed, lacks {}", path,
                                              first.filename().string(), later))
            .in(path));
}

/// A line for each grid of a file: size, range, voxels that are not empty, memory.
Status addGrids(Report& report, const std::string& path, const std::filesystem::path& file,
                const InputOptions& options, Reading& reading) {
  VOLUTE_ASSIGN(const auto grids, listGrids(file, reading.maxMemory));
  tellLaterGrids(path, file, grids, options, reading);
  auto list = nlohmann::ordered_json::array();
  std::string text = fmt::format("in {}", file.filename().string());
  for (const GridFacts& grid : grids) {
    const bool empty = grid.voxels == 0 || grid.box.empty();
    const auto size = [&](int axis) { return empty ? 0 : grid.box.size(axis); };
    list.push_back({{"name", grid.name},
                    {"type", grid.type},
                    {"class", grid.gridClass},
                    {"half", grid.half},
                    {"size", {size(0), size(1), size(2)}},
                    {"voxel_size", grid.voxelSize},
                    {"active_voxels", grid.voxels},
                    {"minimum", jsonNumber(grid.least)},
                    {"maximum", jsonNumber(grid.most)},
                    {"memory_bytes", grid.memory},
                    {"frustum", grid.frustum},
                    {"usable", grid.readable},
                    {"problem", grid.problem}});
    text += fmt::format("\n  {:<16} {}{}{}{}, ", grid.name, grid.type, grid.half ? " (half)" : "",
                        grid.gridClass[0] != '\0' ? fmt::format(", {}", grid.gridClass) : "",
                        grid.frustum ? ", a frustum" : "");
    text += grid.problem[0] != '\0' ? fmt::format("not readable: {}", grid.problem)
            : empty
                ? std::string("empty")
                : fmt::format("{} x {} x {}, {}{} voxels not empty, {}", size(0), size(1), size(2),
                              std::isfinite(grid.least)
                                  ? fmt::format("{:.4g} to {:.4g}, ", grid.least, grid.most)
                                  : "",
                              grid.voxels, bytesText(grid.memory));
  }
  report.add("grids", list, text);
  return {};
}

}  // namespace

Result<FileDescription> describeVolume(const std::string& path, const DescribeRequest& request,
                                       Reading& reading) {
  if (isVolutePath(path))
    return describeVolute(path, request, reading);
  InputOptions options;
  options.grid = request.field;
  options.stated.framesPerSecond = request.framesPerSecond;
  options.byLayers = true;  // nothing is read that is as large as a frame's box
  auto opened = openVolume(path, options, reading);
  const auto vdb = firstVdb(path);
  Report report;
  report.add("file", path).add("kind", "volume");
  if (const auto bytes = bytesOnDisk(path))
    report.add("bytes", *bytes, bytesText(*bytes));
  // Of several grids none may be the usual one, or that one is empty; the list says what there is.
  const bool damaged = !opened && opened.error().code == ErrorCode::kTruncated;
  const bool listed = !opened && vdb && options.grid.empty() &&
                      (damaged || opened.error().code == ErrorCode::kInvalidArgument ||
                       opened.error().code == ErrorCode::kInvalidData ||
                       opened.error().code == ErrorCode::kUnsupported);
  if (listed) {
    if (const auto all = VolumeGrids::open(path, options, reading)) {
      VolumeInfo frames = (*all)->frames();
      if (request.framesPerSecond)
        frames.setRate(*request.framesPerSecond);
      addFrames(report, frames);
    }
    if (addGrids(report, path, *vdb, options, reading)) {
      // All but that a grid has to be chosen is what other commands end with.
      if (opened.error().code != ErrorCode::kInvalidArgument)
        reading.progress.remark(Remark(damaged ? RemarkCode::kDamaged : RemarkCode::kNote,
                                       opened.error().message, opened.error().hints)
                                    .in(path));
      return FileDescription{std::move(report), damaged};
    }
  }
  if (!opened)
    return tl::unexpected(std::move(opened.error()));
  VolumeInput input = std::move(*opened);
  const VolumeInfo& info = input.source->info();
  addVolume(report, info, input.places);
  if (vdb)
    VOLUTE_TRY(addGrids(report, path, *vdb, options, reading));
  if (!request.values)
    return FileDescription{std::move(report)};
  ValueRange range;
  Bricks frame;
  for (int i = 0; i < info.frames; ++i) {
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading frame {}", info.frameText(i));
    VOLUTE_TRY(input.source->readBricks(i, frame));
    addValues(range, frame, info);
    reading.progress.report("reading", i + 1, info.frames);
  }
  range.addTo(report);
  return FileDescription{std::move(report)};
}

}  // namespace volute
