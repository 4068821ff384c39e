// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_underlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/program.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/confinement.hpp"
#include "volute/io/dxf.hpp"
#include "volute/io/image_file.hpp"
#include "volute/visibility/svg_layer.hpp"

namespace volute {
namespace {

struct Unit {
  const char* name;
  double meters;
};

/// That in which a drawing of `size` is nearest to the case's size.
Unit unitBySize(const Vec2& size, const Vec2& ofCase) {
  static constexpr Unit kUnits[] = {
      {"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"inches", 0.0254}, {"feet", 0.3048}};
  const auto apart = [&](const Unit& unit) {
    return std::abs(std::log(unit.meters * size.norm() / ofCase.norm()));
  };
  return *std::ranges::min_element(kUnits, {}, apart);
}

std::string sizeText(const Vec2& size) {
  return fmt::format("{:.4g} x {:.4g}", size.x(), size.y());
}

/// Remarks of lines of a layer that are no areas.
void remarkOfLines(int lines, std::string_view what, const UnderlayOptions& options,
                   const std::string& name, std::vector<Remark>& remarks) {
  if (lines > 0) {
    remarks.push_back(Remark(RemarkCode::kLeftOut,
                             fmt::format("{}: {} lines of the layer '{}' {}: they are no areas",
                                         name, lines, options.areaLayer, what))
                          .in(name));
  }
}

Result<PlanUnderlay> readDrawing(const std::filesystem::path& file, const UnderlayOptions& options,
                                 std::vector<Remark>& remarks) {
  const std::string name = file.string();
  VOLUTE_ASSIGN(const DxfDrawing drawing, readDxf(file, options.maxMemory, options.areaLayer));
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Vec2 low(kFar, kFar), high(-kFar, -kFar);
  const auto reach = [&](const Vec2& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  };
  for (const DrawnLine& line : drawing.lines) {
    reach(line.from);
    reach(line.to);
  }
  if (drawing.lines.empty()) {
    for (const DrawnOutline& outline : drawing.outlines)
      std::ranges::for_each(outline.points, reach);
  }
  const Vec2 size = high - low;
  if (!(size.maxCoeff() > 0))
    return fail(ErrorCode::kInvalidData, "{}: all of its lines are one point", name);
  std::string left;
  for (const auto& [kind, count] : drawing.left)
    left += fmt::format("{}{} {}", left.empty() ? "" : ", ", count, kind);
  if (!left.empty())
    remarks.push_back(
        Remark(RemarkCode::kLeftOut, fmt::format("{}: not drawn: {}", name, left)).in(name));
  PlanUnderlay underlay;
  Vec2 scale(1, 1), origin(0, 0);
  if (options.place) {
    if (!(size.minCoeff() > 0))
      return fail(ErrorCode::kInvalidData, "{}: a drawing of {} cannot fill a rectangle", name,
                  sizeText(size));
    scale = (options.place->second - options.place->first).cwiseQuotient(size);
    origin = options.place->first - scale.cwiseProduct(low);
  } else {
    const Vec2 ofCase = options.max - options.min;
    if (drawing.unit) {
      scale *= *drawing.unit;
    } else {
      const Unit unit = unitBySize(size, ofCase);
      scale *= unit.meters;
      remarks.push_back(Remark(RemarkCode::kAssumed,
                               fmt::format("{}: states no unit; taken as {}, by its size of {}",
                                           name, unit.name, sizeText(size)))
                            .in(name));
    }
    const Vec2 begin = scale.cwiseProduct(low), end = scale.cwiseProduct(high);
    if ((begin.array() > options.max.array()).any() || (end.array() < options.min.array()).any()) {
      origin = options.min - begin;
      remarks.push_back(
          Remark(RemarkCode::kAssumed,
                 fmt::format("{}: lies apart from the case, from ({}, {}) to ({}, {}) m; "
                             "its lower left corner is moved to the case's",
                             name, plainNumber(begin.x(), 4), plainNumber(begin.y(), 4),
                             plainNumber(end.x(), 4), plainNumber(end.y(), 4)),
                 {Hint::set("underlay_bounds").so("places it")})
              .in(name));
    }
  }
  const auto place = [&](const Vec2& p) -> Vec2 { return origin + scale.cwiseProduct(p); };
  underlay.min = place(low);
  underlay.max = place(high);
  for (const DrawnLine& line : drawing.lines)
    underlay.lines.emplace_back(place(line.from), place(line.to));
  if (!options.areaLayer.empty()) {
    std::vector<PlanOutline> outlines;
    for (const DrawnOutline& outline : drawing.outlines) {
      auto& made = outlines.emplace_back(PlanOutline{"", fmt::format("line {}", outline.line), {}});
      for (const Vec2& point : outline.points) made.points.push_back(place(point));
    }
    std::vector<std::pair<Vec2, std::string>> texts;
    for (const DrawnText& text : drawing.texts) texts.emplace_back(place(text.at), text.text);
    VOLUTE_ASSIGN(underlay.areas,
                  areasOfOutlines(std::move(outlines), texts, options.areaLayer, name));
    remarkOfLines(drawing.open, "are not closed", options, name, remarks);
  }
  return underlay;
}

/// A picture over the whole case, or where its place is stated.
Result<PlanUnderlay> readPicture(const std::filesystem::path& file,
                                 const UnderlayOptions& options) {
  PlanUnderlay underlay;
  const ImageReadOptions reading{.maxMemory = options.maxMemory};
  VOLUTE_ASSIGN(underlay.picture, readImage(file, reading));
  VOLUTE_ASSIGN(const auto alpha, readAlpha(file, reading));
  if (alpha)
    layOnWhite(underlay.picture, *alpha);
  std::tie(underlay.min, underlay.max) =
      options.place.value_or(std::pair(options.min, options.max));
  return underlay;
}

/// As a picture, by librsvg's program, which is given no more memory than this one, a minute, and
/// no file but this one: what the drawing names beside it is not drawn.
Result<PlanUnderlay> readSvg(const std::filesystem::path& file, const UnderlayOptions& options,
                             std::vector<Remark>& remarks) {
  VOLUTE_TRY(InputFile::open(file));
  const std::string converter = findProgram({"rsvg-convert"});
  if (converter.empty()) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: a drawing in SVG needs rsvg-convert (Debian's librsvg2-bin), which is not in the "
        "PATH; a .png or .dxf file needs nothing",
        file.string());
  }
  const ScratchFolder folder;
  const auto picture = folder.path() / "drawing.png";
  if (folder.path().empty() || !writeFile(picture, std::string_view()))
    return fail(ErrorCode::kIo, "{}: no folder for temporary files", file.string());
  constexpr const char* kPixels = "2400";  // of its longer side: some more than maps have
  constexpr std::uint64_t kLibraries = std::uint64_t{512} << 20;
  const std::vector<std::filesystem::path> programs{std::filesystem::path(converter).parent_path(),
                                                    "/usr",
                                                    "/lib",
                                                    "/lib64",
                                                    "/etc/fonts",
                                                    "/etc/ld.so.cache",
                                                    "/var/cache/fontconfig"};
  runProgram(
      {converter, "--width", kPixels, "--height", kPixels, "--keep-aspect-ratio"},
      {.memory = options.maxMemory + kLibraries, .input = file, .output = picture, .confine = [&] {
         return detail::confineProgram(programs);
       }});
  auto read = readPicture(picture, options);
  if (!read) {  // there is none, or a part of one: it met a limit
    return fail(ErrorCode::kInvalidData,
                "{}: not a drawing that {} can read within a minute and {} MiB of memory",
                file.string(), converter, options.maxMemory >> 20);
  }
  if (options.areaLayer.empty())
    return read;
  VOLUTE_ASSIGN(auto layer, readSvgLayer(file, options.areaLayer));
  const auto place = [&](const Vec2& share) -> Vec2 {
    return read->min + share.cwiseProduct(read->max - read->min);
  };
  for (PlanOutline& outline : layer.outlines)
    std::ranges::transform(outline.points, outline.points.begin(), place);
  for (auto& [at, text] : layer.texts) at = place(at);
  VOLUTE_ASSIGN(read->areas, areasOfOutlines(std::move(layer.outlines), layer.texts,
                                             options.areaLayer, file.string()));
  remarkOfLines(layer.open, "are not closed", options, file.string(), remarks);
  remarkOfLines(layer.curved, "are curves", options, file.string(), remarks);
  return read;
}

}  // namespace

Result<PlanUnderlay> readUnderlay(const std::filesystem::path& file, const UnderlayOptions& options,
                                  std::vector<Remark>& remarks) {
  const std::string extension = extensionOf(file);
  if (extension == ".dxf")
    return readDrawing(file, options, remarks);
  if (extension == ".svg")
    return readSvg(file, options, remarks);
  if (!options.areaLayer.empty()) {
    return fail(ErrorCode::kUnsupported,
                "{}: areas are read from layers of .dxf and .svg drawings, of which it is none",
                file.string());
  }
  if (extension == ".pdf" || extension == ".dwg") {
    return fail(ErrorCode::kUnsupported,
                "{}: a drawing is a .png, .svg or .dxf file; save it as one of these",
                file.string());
  }
  return readPicture(file, options);
}

void layOnWhite(Image& picture, const Image& alpha) {
  VOLUTE_ASSERT(alpha.width == picture.width && alpha.height == picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float opaque = std::clamp(alpha.at(x, y, 0), 0.0F, 1.0F);
      for (int c = 0; c < picture.channels; ++c)
        picture.at(x, y, c) = opaque * picture.at(x, y, c) + (1 - opaque);
    }
  }
}

std::optional<std::pair<Vec2, Vec2>> lineWithin(Vec2 from, Vec2 to, const Vec2& min,
                                                const Vec2& max) {
  const Vec2 along = to - from;
  double begin = 0, end = 1;
  for (int axis = 0; axis < 2; ++axis) {
    if (along[axis] == 0) {
      if (from[axis] < min[axis] || from[axis] > max[axis])
        return std::nullopt;
      continue;
    }
    const double a = (min[axis] - from[axis]) / along[axis];
    const double b = (max[axis] - from[axis]) / along[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (!(begin <= end))
    return std::nullopt;
  return std::pair<Vec2, Vec2>(from + begin * along, from + end * along);
}

}  // namespace volute
