// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_iso_sheets.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr std::size_t kMostLevels = 8;
constexpr double kOpacity = 0.4;

Result<std::vector<double>> levelsIn(const std::string& text, const std::string& numbers) {
  std::vector<double> levels;
  for (std::size_t begin = 0; begin <= numbers.size();) {
    const std::size_t end = std::min(numbers.find(',', begin), numbers.size());
    double level = 0;
    const auto [rest, error] =
        std::from_chars(numbers.data() + begin, numbers.data() + end, level);
    if (error != std::errc() || rest != numbers.data() + end || !std::isfinite(level) ||
        levels.size() == kMostLevels) {
      return fail(ErrorCode::kInvalidArgument,
                  "'{}' is no isosurface; expected a quantity and up to {} values of it, as "
                  "TEMPERATURE 60 or TEMPERATURE 60,200",
                  text, kMostLevels);
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
  const std::size_t space = text.rfind(' ');
  const bool both = space != text.npos && space > 0;
  sheets.quantity_ = both ? text.substr(0, space) : text;
  VOLUTE_ASSIGN(sheets.levels_, levelsIn(text, both ? text.substr(space + 1) : ""));
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
    return fail(ErrorCode::kNotFound,
                "{}; an isosurface needs 3D slices (&SLCF with XB) or PLOT3D of the quantity",
                opened.error().message);
  }
  VOLUTE_TRY(opened);
  const FdsSource& source = opened->source();
  if (source.kind == FdsFileKind::kSlice)
    sheets.unit_ = index.slices[source.parts.front().entry].labels.unit;
  if (source.kind == FdsFileKind::kPlot) {
    sheets.unit_ = index.plots[source.parts.front().entry]
                       .labels[static_cast<std::size_t>(source.plotVariable)]
                       .unit;
  }
  for (const std::string& remark : opened->remarks()) {
    if (std::ranges::find(index.remarks, remark) == index.remarks.end())
      reading.progress.remark(remark);
  }
  sheets.case_ = std::make_shared<FdsCase>(std::move(*opened));
  return sheets;
}

Result<std::vector<FdsIso>> FdsIsoSheets::at(double time) const {
  VOLUTE_ASSIGN(const FdsField field, case_->field(time));
  std::vector<FdsIso> sheets;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const double share =
        levels_.size() < 2 ? 0.45 : static_cast<double>(i) / static_cast<double>(levels_.size() - 1);
    const Rgb colour = displayColor(ColorMap::kViridis, share).unaryExpr(&srgbDecode);
    sheets.emplace_back(field, IsoLook{levels_[i], colour, kOpacity});
  }
  return sheets;
}

std::string FdsIsoSheets::words() const {
  return fmt::format("{} = {:g} {}", quantity_, fmt::join(levels_, ", "), unit_);
}

}  // namespace volute
