// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>
#include <map>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/fds_report.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/cli/gl_pictures.hpp"
#include "volute/cli/mesh_report.hpp"
#include "volute/cli/scene_report.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/smoke/scene_smoke.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/cli/values.hpp"
#include "volute/scene/scene.hpp"

namespace volute::cli {
namespace {

struct Extremes {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  std::uint64_t notFinite = 0;
  std::uint64_t zeros = 0;

  void add(std::span<const float> values) {
    for (const float value : values) {
      if (!std::isfinite(value)) {
        ++notFinite;
        continue;
      }
      zeros += value == 0;
      least = std::min<double>(least, value);
      most = std::max<double>(most, value);
    }
  }
};

void addExtremes(Report& report, const Extremes& extremes, std::uint64_t values) {
  const double zeros = static_cast<double>(extremes.zeros) / static_cast<double>(values);
  report.add("minimum", extremes.least)
      .add("maximum", extremes.most)
      .add("zero_share", jsonNumber(zeros), fmt::format("{:.1f} %", 100 * zeros))
      .add("not_finite", extremes.notFinite,
           extremes.notFinite ? fmt::format("{} values", extremes.notFinite) : "");
}

std::string firstToLast(auto first, auto last) {
  return first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last);
}

/// [first, last] of each gap.
nlohmann::ordered_json missingFrames(const VolumeInfo& info) {
  auto gaps = nlohmann::ordered_json::array();
  for (const FrameGap& gap : gapsOf(info.frameNumbers)) gaps.push_back({gap.first, gap.last});
  return gaps;
}

void addVolume(Report& report, const VolumeInfo& info) {
  const Box3& b = info.bounds;
  report.add("grid", info.name)
      .add("unit", info.unit, info.unit)
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z))
      .add("channels", info.channels,
           info.channels == 1 ? "1" : fmt::format("{} (linear RGB)", info.channels))
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("frame_numbers", {info.frameNumbers.front(), info.frameNumbers.back()},
           firstToLast(info.frameNumbers.front(), info.frameNumbers.back()))
      .add("missing_frames", missingFrames(info), missingNumbers(info.frameNumbers))
      .add("times", {info.times.front(), info.times.back()},
           firstToLast(info.times.front(), info.times.back()) + " s")
      .add("bounds", {b.min.x(), b.min.y(), b.min.z(), b.max.x(), b.max.y(), b.max.z()},
           fmt::format("{}  to  {} m", vectorText(b.min), vectorText(b.max)))
      .add("basis", info.basis == Basis::kBox ? "box" : "trilinear")
      .add("raw_bytes", info.rawBytes(), bytesText(info.rawBytes()));
}

void addHeader(Report& report, const VoluteReader& reader, std::uint64_t bytes) {
  const VoluteHeader& header = reader.header();
  const double ratio = static_cast<double>(reader.info().rawBytes()) / static_cast<double>(bytes);
  report.add("ratio", jsonNumber(ratio), fmt::format("{:.4g}", ratio))
      .add("minimum", header.valueMin)
      .add("maximum", header.valueMax)
      .add("asked", {{"kind", header.targetKind}, {"value", jsonNumber(header.targetValue)}},
           fmt::format("{} {:.6g}", header.targetKind, header.targetValue))
      .add("relative_rms", header.reachedRms)
      .add("max_error", header.reachedMaxError)
      .add("codec", header.codec, fmt::format("{}", header.codec))
      .add("format", fmt::format("{}.{}", header.versionMajor, header.versionMinor))
      .add("written_by", header.writtenBy)
      .add("provenance", header.provenance)
      .add("blocks", reader.blocks().count(), fmt::format("{}", reader.blocks().count()));
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
  nlohmann::ordered_json blocks = nlohmann::ordered_json::array();
  std::map<std::string, int> modes;
  std::string text;
  for (std::size_t i = 0; i < grid.count(); ++i) {
    const auto origin = grid.origin(i);
    const auto extents = grid.extents(i);
    const auto described = reader.describeBlock(i);
    const std::string mode = described ? *described : "damaged";
    ++modes[mode];
    blocks.push_back({{"block", i},
                      {"origin", {origin[3], origin[2], origin[1]}},
                      {"size", {extents[3], extents[2], extents[1]}},
                      {"frames",
                       {reader.info().frameNumbers[origin[0]],
                        reader.info().frameNumbers[origin[0] + extents[0] - 1]}},
                      {"bytes", reader.storedBytes(i)},
                      {"mode", mode}});
    text += fmt::format("\n  {:>6}  frames {} to {}, voxels from {}, {}, {}: {} bytes, {}", i,
                        reader.info().frameNumbers[origin[0]],
                        reader.info().frameNumbers[origin[0] + extents[0] - 1], origin[3],
                        origin[2], origin[1], reader.storedBytes(i), mode);
  }
  nlohmann::ordered_json counts;
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
    const Vec3 voxel = grid.empty ? Vec3(own.voxelSize[0], own.voxelSize[1], own.voxelSize[2])
                                  : info.voxelSize();
    const std::uint64_t memory =
        own.memory > 0 ? own.memory : 4 * static_cast<std::uint64_t>(info.frameValues());
    const double ratio = static_cast<double>(info.rawBytes()) /
                         static_cast<double>(std::max<std::uint64_t>(grid.bytes, 1));
    list.push_back({{"name", info.name},
                    {"type", own.type},
                    {"class", own.gridClass},
                    {"half", own.half},
                    {"empty", grid.empty},
                    {"size", {info.x, info.y, info.z}},
                    {"voxel_size", {voxel.x(), voxel.y(), voxel.z()}},
                    {"active_voxels", grid.description ? Json(own.voxels) : Json()},
                    {"minimum", header.valueMin},
                    {"maximum", header.valueMax},
                    {"memory_bytes", memory},
                    {"bytes", grid.bytes},
                    {"raw_bytes", info.rawBytes()},
                    {"asked",
                     {{"kind", header.targetKind}, {"value", jsonNumber(header.targetValue)}}},
                    {"relative_rms", header.reachedRms},
                    {"max_error", header.reachedMaxError}});
    text += fmt::format("\n  {:<16} {}{}{}, ", info.name, own.type, own.half ? " (half)" : "",
                        own.gridClass.empty() ? "" : ", " + own.gridClass);
    if (grid.empty) {
      text += "empty";
      continue;
    }
    text += fmt::format("{} x {} x {}, {:.4g} to {:.4g}, ", info.x, info.y, info.z,
                        header.valueMin, header.valueMax);
    if (grid.description)
      text += fmt::format("{} voxels not empty, ", own.voxels);
    text += fmt::format("{} in memory, {} in the file ({:.4g} of dense floats), relative rms {:.3g}, "
                        "max error {:.3g}",
                        bytesText(memory), bytesText(grid.bytes), ratio, header.reachedRms,
                        header.reachedMaxError);
  }
  report.add("grids", list, text);
}

Result<VoluteReader> openForInfo(const std::string& path, const std::string& grid,
                                 Context& context) {
  VoluteReader::Options options;
  options.partial = true;
  options.maxMemory = context.maxMemory;
  options.grid = grid;
  return VoluteReader::open(path, options);
}

/// All segments of all grids.
Result<Integrity> verifyGrids(const std::string& path, const VoluteReader& main, Context& context) {
  Integrity all = main.verify();
  for (const VoluteGrid& grid : main.grids()) {
    if (grid.empty || grid.info.name == main.info().name)
      continue;
    VOLUTE_ASSIGN(const auto reader, openForInfo(path, grid.info.name, context));
    const Integrity one = reader.verify();
    all.segments += one.segments;
    all.intactSegments += one.intactSegments;
    all.intactLevels = std::min(all.intactLevels, one.intactLevels);
    if (all.firstFault.empty() && !one.firstFault.empty())
      all.firstFault = fmt::format("grid '{}': {}", grid.info.name, one.firstFault);
  }
  return all;
}

Result<Report> describeVolute(const std::string& path, const std::string& field, bool blocks,
                              Context& context, bool& damaged) {
  VOLUTE_ASSIGN(const auto reader, openForInfo(path, field, context));
  VOLUTE_ASSIGN(const Integrity integrity, field.empty() ? verifyGrids(path, reader, context)
                                                         : Result<Integrity>(reader.verify()));
  const std::uint64_t bytes = bytesOnDisk(path).value_or(integrity.presentBytes);
  const bool several = reader.grids().size() > 1;
  Report report;
  report.add("file", path).add("kind", "volute").add("bytes", bytes, bytesText(bytes));
  addIntegrity(report, integrity, reader);
  addVolume(report, reader.info());
  addHeader(report, reader, several ? reader.grid().bytes : std::max(bytes, integrity.expectedBytes));
  if (several || reader.grid().description)
    addVoluteGrids(report, reader);
  if (blocks)
    addBlocks(report, reader);
  damaged = damaged || !integrity.complete();
  return report;
}

Result<Report> describePicture(const std::string& path) {
  VOLUTE_ASSIGN(const auto image, readImage(path));
  Report report;
  report.add("file", path).add("kind", "picture");
  if (const auto bytes = bytesOnDisk(path))
    report.add("bytes", *bytes, bytesText(*bytes));
  report
      .add("size", {image.width, image.height},
           fmt::format("{} x {} pixels", image.width, image.height))
      .add("channels", image.channels, fmt::format("{}", image.channels));
  Extremes extremes;
  extremes.add(image.pixels);
  addExtremes(report, extremes, image.pixels.size());
  return report;
}

/// The first file of what is one or more OpenVDB files; nothing for other formats.
std::optional<std::filesystem::path> firstVdb(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    const auto files = listNumberedFiles(path, ".vdb");
    return files ? std::optional(files->front().path) : std::nullopt;
  }
  if (extensionOf(path) != ".vdb")
    return std::nullopt;
  if (FramePattern::isPattern(path) && !std::filesystem::exists(path, error)) {
    const auto pattern = FramePattern::parse(path);
    if (!pattern)
      return std::nullopt;
    const auto files = pattern->list();
    return files ? std::optional(files->front().path) : std::nullopt;
  }
  return path;
}

/// A line for each grid of a file: size, range, voxels that are not empty, memory.
Status addGrids(Report& report, const std::filesystem::path& file, Context& context) {
  VOLUTE_ASSIGN(const auto grids, listGrids(file, context.maxMemory));
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
                    {"usable", grid.readable}});
    text += fmt::format("\n  {:<16} {}{}{}, ", grid.name, grid.type, grid.half ? " (half)" : "",
                        grid.gridClass[0] != '\0' ? fmt::format(", {}", grid.gridClass) : "");
    text += empty ? std::string("empty")
                  : fmt::format("{} x {} x {}, {:.4g} to {:.4g}, {} voxels not empty, {}", size(0),
                                size(1), size(2), grid.least, grid.most, grid.voxels,
                                bytesText(grid.memory));
  }
  report.add("grids", list, text);
  return {};
}

Result<Report> describeVolume(const std::string& path, const Arguments& arguments,
                              Context& context) {
  InputOptions options;
  options.grid = arguments.find<std::string>("field").value_or("");
  auto opened = openVolume(path, options, context);
  const auto vdb = firstVdb(path);
  Report report;
  report.add("file", path).add("kind", "volume");
  if (const auto bytes = bytesOnDisk(path))
    report.add("bytes", *bytes, bytesText(*bytes));
  // Of several grids none may be the usual one, or that one is empty; the list says what there is.
  const bool listed = !opened && vdb && options.grid.empty() &&
                      (opened.error().code == ErrorCode::kInvalidArgument ||
                       opened.error().code == ErrorCode::kInvalidData);
  if (listed) {
    auto grids = addGrids(report, *vdb, context);
    if (grids)
      return report;
  }
  if (!opened)
    return tl::unexpected(std::move(opened.error()));
  VolumeInput input = std::move(*opened);
  const VolumeInfo& info = input.source->info();
  addVolume(report, info);
  if (vdb)
    VOLUTE_TRY(addGrids(report, *vdb, context));
  if (!arguments.flag("values"))
    return report;
  Extremes extremes;
  std::vector<float> frame(info.frameValues());
  for (int i = 0; i < info.frames; ++i) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading frame {}", info.frameNumbers[i]);
    VOLUTE_TRY(input.source->readFrame(i, frame));
    extremes.add(frame);
    context.progress.report("reading", i + 1, info.frames);
  }
  addExtremes(report, extremes, info.values());
  return report;
}

/// The graphics device, before the files if there are any.
Status showGl(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto report, describeGl());
  if (context.json && arguments.positionals().empty())
    context.print(dumpJson(report.json()));
  else if (context.json)
    return fail(ErrorCode::kInvalidArgument, "--gl with --json takes no FILE");
  else
    context.print(report.text());
  return {};
}

Status runInfo(const Arguments& arguments, Context& context) {
  if (arguments.positionals().empty() && !arguments.flag("gl"))
    return fail(ErrorCode::kInvalidArgument, "FILE is missing; give a file, or --gl");
  if (arguments.flag("gl")) {
    VOLUTE_TRY(showGl(arguments, context));
    if (arguments.positionals().empty())
      return {};
  }
  std::vector<FileKind> kinds;
  for (const auto& path : arguments.positionals()) kinds.push_back(readKind(path));
  VOLUTE_TRY(refuseIdle(arguments, kinds));
  bool damaged = false;
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  const auto& paths = arguments.positionals();
  for (const auto& path : paths) {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    auto report =
        capture               ? describeCapture(path, context, damaged)
        : isScenePath(path)   ? describeScene(path, context)
        : isVolutePath(path)  ? describeVolute(path, arguments.find<std::string>("field").value_or(""),
                                                 arguments.flag("blocks"), context, damaged)
        : isPicturePath(path) ? describePicture(path)
        : isSmvPath(path) ? describeFdsCase(path, arguments.find<std::string>("field").value_or(""),
                                            arguments.flag("values"), context)
        : isSmokeCase(path) ? describeMeshCase(path, arguments.flag("values"), context, damaged)
                            : describeVolume(path, arguments, context);
    VOLUTE_TRY(report);
    files.push_back(report->json());
    if (!context.json)
      context.print(fmt::format("{}{}", files.size() > 1 ? "\n" : "", report->text()));
  }
  if (context.json)
    context.print(
        dumpJson(paths.size() == 1 ? files[0] : nlohmann::ordered_json{{"files", files}}));
  if (damaged)
    return fail(ErrorCode::kInvalidData,
                "not everything is intact or can be used; what is was shown");
  return {};
}

}  // namespace

Command infoCommand() {
  using enum ValueKind;
  return {
      .name = "info",
      .summary = "Says what is in a file and whether it is whole",
      .examples = {"volute info fire.volute", "volute info smoke.npy --values --json",
                   "volute info case.smv", "volute info hall.pvd", "volute info --gl"},
      .description =
          "Sizes, frames, times and bounds of a volume, and all grids of a file with several; of a "
          ".volute also what error was asked "
          "for and reached, and whether every "
          "byte is intact. Pictures (.png, .exr) show their size and range. A damaged .volute "
          "is described as far as it is intact, "
          "and the exit code is 1. An FDS case (.smv) shows its meshes, obstructions and files, "
          "which of them says how thick the smoke is, at which times, and what is cut off. Smoke "
          "on "
          "a mesh (.vtu, .pvtu, .vtk, .pvd, .case, .e, .foam) shows its times, cells, the "
          "tetrahedra that they are split into, and its fields with their ranges. A scene lists its "
          "media, a capture its cameras and which of their pictures are missing.",
      .positionals = {{.name = "FILE",
                       .help = "a volume, a picture, smoke on a mesh, an FDS case, a scene or a capture",
                       .several = true,
                       .optional = true}},
      .options = {fieldOption("which one of a file with several; which source of an FDS case",
                              {"volume", kVoluteKind, "fds"}),
                  {.name = "blocks",
                   .help = "of a .volute, each block's place, transform and size",
                   .kinds = {kVoluteKind}},
                  {.name = "values",
                   .help = "read all frames for their minimum, maximum, zeros and values that "
                           "are not finite",
                   .kinds = {"volume", "smoke", "fds"}},
                  {.name = "gl",
                   .help = "the graphics device that --renderer gl draws with, and its limits"}},
      .run = runInfo};
}

}  // namespace volute::cli
