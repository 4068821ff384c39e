// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_iso_sheets.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "volute/base/number_word.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/fds/fds_iso.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"
#include "volute/media/fds/fds_triangle_sheets.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxLevels = 8;

/// Whether two levels are one: files have them as floats.
bool isLevel(double a, double b) {
  return std::abs(a - b) <= 1e-5 * std::max(std::abs(a), std::abs(b));
}

/// What isosurface files there are, for people; nothing where there are none.
std::string storedIn(const SmvIndex& index) {
  std::set<std::string> names;
  for (const FdsIsoEntry& iso : index.isosurfaces) names.insert(iso.labels.quantity);
  return names.empty()
             ? ""
             : fmt::format("; the case has isosurface files of {}", fmt::join(names, ", "));
}

Result<std::vector<double>> levelsIn(const std::string& text, const std::string& numbers,
                                     const SmvIndex& index) {
  std::vector<double> levels;
  for (std::size_t begin = 0; begin <= numbers.size();) {
    const std::size_t end = std::min(numbers.find(',', begin), numbers.size());
    double level = 0;
    if (!readNumber(std::string_view(numbers).substr(begin, end - begin), level) ||
        !std::isfinite(level) || levels.size() == kMaxLevels) {
      return fail(ErrorCode::kInvalidArgument,
                  "'{}' is no isosurface; expected a quantity and up to {} values of it, as "
                  "TEMPERATURE 60 or TEMPERATURE 60,200, or a quantity of isosurface files alone{}",
                  text, kMaxLevels, storedIn(index));
    }
    levels.push_back(level);
    begin = end + 1;
  }
  std::ranges::sort(levels);
  return levels;
}

}  // namespace

Result<FdsIsoSheets> FdsIsoSheets::open(const SmvIndex& index, const std::string& text,
                                        Reading& reading) {
  FdsIsoSheets sheets;
  sheets.maxMemory_ = reading.maxMemory;
  const auto ofThis = [&](const FdsIsoEntry& iso) { return iso.labels.quantity == text; };
  if (std::ranges::any_of(index.isosurfaces, ofThis)) {
    sheets.quantity_ = text;
    VOLUTE_TRY(sheets.openFiles(index, true, reading));
    return sheets;
  }
  const std::size_t space = text.rfind(' ');
  const bool both = space != text.npos && space > 0;
  sheets.quantity_ = both ? text.substr(0, space) : text;
  VOLUTE_ASSIGN(sheets.levels_, levelsIn(text, both ? text.substr(space + 1) : "", index));
  FdsOptions options{.quantity = sheets.quantity_, .volume = true};
  options.maxMemory = reading.maxMemory;
  // Of cells that have one value each a surface would be stairs.
  const auto sources = findSources(index, sheets.quantity_);
  const auto smooth = std::ranges::find_if(
      sources, [](const FdsSource& one) { return one.volume && !one.cellCentred; });
  if (smooth != sources.end())
    options.source = smooth->name;
  auto opened = FdsCase::open(index, options);
  if (!opened && opened.error().code == ErrorCode::kNotFound) {
    const Status files = sheets.openFiles(index, false, reading);
    if (files)
      return sheets;
    if (files.error().code != ErrorCode::kNotFound)
      return tl::unexpected<Error>(files.error());
    return fail(ErrorCode::kNotFound,
                "{}; an isosurface needs 3D slices (&SLCF with XB) or PLOT3D of the quantity, or "
                "an isosurface file (&ISOF) with that value{}",
                opened.error().message, storedIn(index));
  }
  VOLUTE_TRY(opened);
  const FdsSource& source = opened->source();
  if (source.kind == FdsFileKind::kSlice || source.kind == FdsFileKind::kPlot)
    sheets.unit_ = labelsOf(index, source, source.parts.front()).unit;
  for (const Remark& remark : opened->remarks()) {
    if (std::ranges::find(index.remarks, remark) == index.remarks.end())
      reading.progress.remark(remark);
  }
  sheets.case_ = std::make_shared<FdsCase>(std::move(*opened));
  return sheets;
}

/// With `all` the levels are those of the files, else the files must have levels_.
Status FdsIsoSheets::openFiles(const SmvIndex& index, bool all, Reading& reading) {
  std::vector<std::shared_ptr<const FdsIsoFile>> files;
  std::vector<double> found;
  for (const FdsIsoEntry& iso : index.isosurfaces) {
    if (iso.labels.quantity != quantity_)
      continue;
    VOLUTE_ASSIGN(auto file,
                  FdsIsoFile::open(iso, index.meshes[static_cast<std::size_t>(iso.mesh)]));
    for (const Remark& remark : file.frames().remarks) reading.progress.remark(remark);
    for (const float level : file.levels()) {
      if (std::ranges::none_of(found, [&](double other) { return isLevel(level, other); }))
        found.push_back(level);
    }
    unit_ = iso.labels.unit;
    if (!file.frames().times.empty())
      files.push_back(std::make_shared<const FdsIsoFile>(std::move(file)));
  }
  const auto stored = [&](double level) {
    return std::ranges::any_of(found, [&](double other) { return isLevel(level, other); });
  };
  if (files.empty() || (!all && !std::ranges::all_of(levels_, stored)))
    return fail(ErrorCode::kNotFound, "{}: no isosurface file has these surfaces of {}",
                index.path.string(), quantity_);
  std::ranges::sort(found);
  if (all)
    levels_ = found;
  files_ = std::move(files);
  return {};
}

std::vector<Rgb> FdsIsoSheets::colours() const {
  std::vector<Rgb> colours;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const double share = levels_.size() < 2
                             ? 0.45
                             : static_cast<double>(i) / static_cast<double>(levels_.size() - 1);
    colours.push_back(displayColor(ColorMap::kViridis, share).unaryExpr(&srgbDecode));
  }
  return colours;
}

Result<std::vector<AnyMedium>> FdsIsoSheets::at(double time) const {
  if (!case_)
    return stored(time);
  VOLUTE_ASSIGN(const FdsField field, case_->field(time));
  std::vector<AnyMedium> sheets;
  const std::vector<Rgb> colours = this->colours();
  for (std::size_t i = 0; i < levels_.size(); ++i)
    sheets.emplace_back(
        FdsIso(field, IsoLook{levels_[i], colours[i], FdsTriangleSheets::kOpacity}));
  return sheets;
}

Result<std::vector<AnyMedium>> FdsIsoSheets::stored(double time) const {
  std::vector<FdsIsoFrame> frames;
  std::uint64_t bytes = 0;
  for (const auto& file : files_) {
    const std::size_t frame = nearestFrame(file->frames().times, time);
    constexpr std::uint64_t kInMemory = 12;  // times as large as in the file, with a tree of boxes
    bytes += kInMemory * file->bytesOf(frame);
    if (maxMemory_ > 0 && bytes > maxMemory_) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "isosurfaces of {} at {} s need {} MiB or more, more than the {} MiB allowed",
                  quantity_, plainNumber(file->frames().times[frame]), bytes >> 20,
                  maxMemory_ >> 20);
    }
    VOLUTE_ASSIGN(FdsIsoFrame read, file->readFrame(frame));
    // Levels as they are numbered here; surfaces that nobody asks for are left out.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < read.triangles.size(); ++i) {
      const double level = file->levels()[static_cast<std::size_t>(read.levels[i])];
      const auto place =
          std::ranges::find_if(levels_, [&](double other) { return isLevel(level, other); });
      if (place == levels_.end())
        continue;
      read.levels[kept] = static_cast<std::int32_t>(place - levels_.begin());
      read.triangles[kept++] = read.triangles[i];
    }
    read.levels.resize(kept);
    read.triangles.resize(kept);
    frames.push_back(std::move(read));
  }
  std::vector<AnyMedium> media;
  const auto isEmpty = [](const FdsIsoFrame& frame) { return frame.triangles.empty(); };
  if (std::ranges::all_of(frames, isEmpty))
    return media;
  VOLUTE_ASSIGN(auto sheets, FdsTriangleSheets::build(frames, colours()));
  media.emplace_back(std::move(sheets));
  return media;
}

std::string FdsIsoSheets::words() const {
  const std::string text = fmt::format("{} = {:g} {}", quantity_, fmt::join(levels_, ", "), unit_);
  if (case_)
    return text;
  std::set<double> times;
  for (const auto& file : files_)
    times.insert(file->frames().times.begin(), file->frames().times.end());
  return text + fmt::format(", the nearest of {} stored times", times.size());
}

}  // namespace volute
