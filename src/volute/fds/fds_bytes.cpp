// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/fds_part.hpp"

// What the bytes and words of a case stand for.

namespace volute {
/// What bytes of .s3d stand for.
Status FdsCase::findBytes() {
  if (source().kind != FdsFileKind::kSmoke)
    return {};
  if (options_.quantity.empty())
    return findGeneration();
  return options_.quantity == kFdsHeatRelease ? findHeatScale() : findTemperatureScale();
}

/// FDS 6.11 writes it into the index; without it bytes have FDS's defaults, as far as the largest
/// temperature in .s3d.sz does not contradict.
Status FdsCase::findTemperatureScale() {
  if (index_.temperatureRange) {
    temperatureRange_ = *index_.temperatureRange;
    return {};
  }
  const auto [least, most] = temperatureRange_;
  const auto said = largestSaid();
  if (said && *said > most * (1 + 1e-5)) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: its .sz files have {} up to {:g} degrees C, and no TEMP_MINMAX says what bytes "
        "stand for",
        index_.path.string(), options_.quantity, *said);
  }
  remarks_.push_back(
      {RemarkCode::kAssumed,
       fmt::format(
           "{}: bytes of {} are taken for {:g} to {:g} degrees C, as FDS writes them unless "
           "it is told otherwise: no TEMP_MINMAX says it",
           index_.path.string(), options_.quantity, least, most)});
  return {};
}

std::optional<double> FdsCase::largestSaid() const {
  std::optional<double> largest;
  if (source().kind != FdsFileKind::kSmoke || options_.quantity.empty())
    return largest;
  for (const auto& part : parts_) {
    for (const FdsSizeRow& row : part->sizeRows) {
      if (row.columns.size() > 2 && std::isfinite(row.columns[2]))
        largest = std::max(largest.value_or(row.columns[2]), row.columns[2]);
    }
  }
  return largest;
}

/// The heat of the last byte is an input of FDS that no file names. The fourth number of a frame in
/// .s3d.sz is the largest heat q, and its byte is 254 q / it, cut off: FDS's default if that fits,
/// else what does.
Status FdsCase::findHeatScale() {
  if (index_.largestHeat) {
    largestHeat_ = *index_.largestHeat;
    return {};
  }
  constexpr int kFramesToRead = 4;  // of each file
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  for (const auto& part : parts_) {
    int read = 0;
    std::vector<float> bytes(part->file->values());
    std::vector<FdsSizeRow> rows = part->sizeRows;
    std::ranges::sort(rows, std::greater{}, [](const FdsSizeRow& row) {
      return row.columns.size() > 2 ? row.columns[2] : 0;
    });
    const auto& times = part->file->frames().times;
    for (const FdsSizeRow& row : rows) {
      const auto place = std::ranges::find_if(
          times, [&](double time) { return std::abs(time - row.time) <= 1e-5 * (1 + time); });
      if (row.columns.size() < 3 || !(row.columns[2] > 0) || place == times.end())
        continue;
      if (read++ == kFramesToRead)
        break;
      VOLUTE_TRY(part->file->readFrame(static_cast<std::size_t>(place - times.begin()), bytes));
      const double byte = *std::ranges::max_element(bytes);
      if (byte <= 0)
        continue;
      least = std::max(least, 254 * row.columns[2] / (byte + 1));
      most = std::min(most, 254 * row.columns[2] / byte);
    }
  }
  if (most == std::numeric_limits<double>::infinity() ||
      (least <= largestHeat_ * (1 + 1e-5) && largestHeat_ <= most * (1 + 1e-5)))
    return {};
  if (least > most * (1 + 1e-5)) {
    return fail(ErrorCode::kInvalidData,
                "{}: bytes of {} and the largest values in their .sz files do not fit together",
                index_.path.string(), kFdsHeatRelease);
  }
  largestHeat_ = 0.5 * (least + most);
  remarks_.push_back(
      {RemarkCode::kAssumed, fmt::format("{}: the last byte of {} stands for {:.4g} to {:.4g} "
                                         "kW/m3 by its .sz files; the middle is "
                                         "taken",
                                         index_.path.string(), kFdsHeatRelease, least, most)});
  return {};
}

/// Whether bytes of .s3d are opacity or density: the fourth number of a frame in .s3d.sz is the
/// largest byte (before it was rounded) of the former, the largest density of the latter. Nothing
/// else tells them apart.
Status FdsCase::findGeneration() {
  const Part* best = nullptr;
  std::size_t bestFrame = 0;
  double most = 0;
  bool any = false;
  for (const auto& part : parts_) {
    const auto& times = part->file->frames().times;
    for (const FdsSizeRow& row : part->sizeRows) {
      const auto place = std::ranges::find_if(
          times, [&](double time) { return std::abs(time - row.time) <= 1e-5 * (1 + time); });
      if (row.columns.size() < 3 || place == times.end())
        continue;
      any = true;
      if (row.columns[2] > most) {
        most = row.columns[2];
        best = part.get();
        bestFrame = static_cast<std::size_t>(place - times.begin());
      }
    }
  }
  if (best == nullptr) {
    if (!any) {
      remarks_.push_back(
          {RemarkCode::kAssumed, fmt::format("{}: without a fourth column in .s3d.sz its bytes are "
                                             "taken for opacity, as FDS wrote "
                                             "them until 2025",
                                             index_.path.string())});
    }
    return {};
  }
  std::vector<float> bytes(best->file->values());
  VOLUTE_TRY(best->file->readFrame(bestFrame, bytes));
  const double largest = *std::ranges::max_element(bytes);
  bytesAreDensity_ = largest > 0 && std::abs(largest - most) > 1;
  if (bytesAreDensity_ && most > 1) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: frame {} has bytes up to {}, its .sz file says {}: neither opacity nor density",
        best->path.string(), bestFrame, largest, most);
  }
  return bytesAreDensity_ ? Status() : findRounding(*best);
}

/// Whether opacity was cut off to a byte or rounded. The fourth column of .s3d.sz has the largest
/// value c of a frame: FDS 6.5 writes e and cuts it off; 6.7 writes e + 1/2 and cuts that off, so
/// that even a clear frame says 1/2; others write e and round it.
Status FdsCase::findRounding(const Part& part) {
  constexpr int kFramesToRead = 12;
  double least = std::numeric_limits<double>::infinity();
  int cut = 0;
  int rounded = 0;
  int read = 0;
  const auto& times = part.file->frames().times;
  std::vector<float> bytes(part.file->values());
  for (const FdsSizeRow& row : part.sizeRows) {
    if (row.columns.size() < 3)
      continue;
    const double most = row.columns[2];
    least = std::min(least, most);
    const double fraction = most - std::floor(most);
    const auto place = std::ranges::find_if(
        times, [&](double time) { return std::abs(time - row.time) <= 1e-5 * (1 + time); });
    if (fraction <= 0.51 || fraction >= 0.99 || place == times.end() || read == kFramesToRead)
      continue;
    ++read;
    VOLUTE_TRY(part.file->readFrame(static_cast<std::size_t>(place - times.begin()), bytes));
    const double largest = *std::ranges::max_element(bytes);
    cut += largest == std::floor(most);
    rounded += largest == std::ceil(most);
  }
  if (rounded > 0 && cut == 0)
    rounding_ = SmokeScale::Rounding::kNearest;
  if (cut > 0 && rounded == 0)
    rounding_ = least >= 0.499 ? SmokeScale::Rounding::kNearest : SmokeScale::Rounding::kDown;
  return {};
}

/// The mass extinction of soot, where densities become extinction.
void FdsCase::tellExtinction() {
  const Part& part = *parts_.front();
  const FdsInput& input = inputOf(index_);
  const std::string inputName = input.path.filename().string();
  const bool ofInput = source().kind == FdsFileKind::kSlice || source().kind == FdsFileKind::kPlot;
  RemarkCode code = RemarkCode::kNote;
  std::string from;
  if (part.assumesExtinction) {
    const bool unknown = !ofInput || input.path.empty();
    code = unknown ? RemarkCode::kAssumed : RemarkCode::kNote;
    from = fmt::format("FDS's default{}", !unknown  ? ""
                                          : ofInput ? ": no input file is read that says another "
                                                      "MASS_EXTINCTION_COEFFICIENT"
                                                    : ": its .smv says none");
  } else if (!ofInput || !input.massExtinction) {
    return;  // that of the smoke's own entry, or of the caller
  } else if (part.massExtinction != *input.massExtinction) {
    from = fmt::format("as stated, although {} says {:g}", inputName, *input.massExtinction);
  } else {
    from = fmt::format("MASS_EXTINCTION_COEFFICIENT of {}", inputName);
    if (input.otherExtinction) {
      code = RemarkCode::kDoubtful;
      from += fmt::format(", which says {:g} in another line", *input.otherExtinction);
    }
  }
  remarks_.push_back({code, fmt::format("{}: the extinction of soot is {:g} m2/kg ({})",
                                        index_.path.string(), part.massExtinction, from)});
}

namespace {

/// C of visibility by what other slices say of the same places at the same times.
struct FactorBesides {
  std::string source;
  bool isDensity = false;                 // whose mass extinction may be another
  double least = 0, usual = 0, most = 0;  // of nine tenths of the values

  bool contradicts(double factor) const { return least > 1.1 * factor || most < 0.9 * factor; }
};

/// The slice of another source that has the same places.
const FdsSliceEntry* sameSlice(const SmvIndex& index, const FdsSliceEntry& slice,
                               const FdsSource& source) {
  for (const FdsSourcePart& part : source.parts) {
    const FdsSliceEntry& other = index.slices[part.entry];
    if (other.mesh == slice.mesh && other.cellCentred == slice.cellCentred && slice.nodes &&
        other.nodes == slice.nodes)
      return &other;
  }
  return nullptr;
}

/// Whether a value of a slice is of a cell outside of it: the first on each axis, where they are of
/// cells.
bool isGhost(const FdsSliceEntry& slice, std::size_t value) {
  for (int axis = 0; slice.cellCentred && axis < 3; ++axis) {
    const auto count =
        static_cast<std::size_t>(slice.nodes->end[axis] - slice.nodes->begin[axis] + 1);
    if (count > 1 && value % count == 0)
      return true;
    value /= count;
  }
  return false;
}

/// Adds the products of a slice of visibility and the extinction that another one says.
void addProducts(const FdsMesh& mesh, const FdsSliceEntry& seen, const FdsSliceEntry& other,
                 const SmokeScale& scale, double cap, std::vector<double>& products) {
  constexpr std::size_t kFrames = 4, kMax = 100'000;
  const auto a = FdsSliceFile::open(seen, mesh), b = FdsSliceFile::open(other, mesh);
  if (!a || !b || a->values() != b->values())
    return;
  std::vector<float> visibility(a->values()), smoke(b->values());
  std::size_t read = 0;
  for (std::size_t i = a->frames().times.size(); i-- > 0 && read < kFrames;) {
    const double time = a->frames().times[i];
    const auto place = std::ranges::find_if(b->frames().times, [&](double one) {
      return std::abs(time - one) <= 1e-5 * (1 + std::abs(time));
    });
    if (place == b->frames().times.end())
      continue;
    ++read;
    if (!a->readFrame(i, visibility) ||
        !b->readFrame(static_cast<std::size_t>(place - b->frames().times.begin()), smoke))
      return;
    for (std::size_t v = 0; v < smoke.size() && products.size() < kMax; ++v) {
      if (visibility[v] > 0 && visibility[v] < 0.98 * cap && smoke[v] > 0 &&
          std::isfinite(smoke[v]) && !isGhost(seen, v))
        products.push_back(visibility[v] * static_cast<double>(scale.band(smoke[v]).value));
    }
  }
}

std::optional<FactorBesides> factorBesides(const SmvIndex& index, const FdsSource& seen,
                                           std::span<const FdsSource> sources, double cap,
                                           double massExtinction) {
  constexpr std::size_t kFewest = 20;
  for (const FdsSource& source : sources) {
    if (seen.kind != FdsFileKind::kSlice || source.kind != FdsFileKind::kSlice ||
        source.quantity == SmokeQuantity::kVisibility)
      continue;
    SmokeScale scale;
    scale.quantity = source.quantity;
    scale.massExtinction = massExtinction;
    std::vector<double> products;
    for (const FdsSourcePart& part : seen.parts) {
      const FdsSliceEntry& slice = index.slices[part.entry];
      if (const FdsSliceEntry* other = sameSlice(index, slice, source))
        addProducts(index.meshes[static_cast<std::size_t>(part.mesh)], slice, *other, scale, cap,
                    products);
    }
    if (products.size() < kFewest)
      continue;
    std::ranges::sort(products);
    const std::size_t n = products.size();
    return FactorBesides{source.name, source.quantity == SmokeQuantity::kSootDensity,
                         products[n / 20], products[n / 2], products[n - 1 - n / 20]};
  }
  return std::nullopt;
}

}  // namespace

/// C and the cap of visibility, the mass extinction of soot: as the caller or the input file says,
/// else as FDS has them by default, unless the files have other values than these leave possible.
Status FdsCase::findVisibility() {
  const FdsInput& input = inputOf(index_);
  const std::string inputName = input.path.filename().string();
  if (!options_.quantity.empty() || source().kind == FdsFileKind::kClear)
    return {};
  if (source().quantity == SmokeQuantity::kSootDensity && source().kind != FdsFileKind::kSmoke)
    tellExtinction();
  if (source().quantity != SmokeQuantity::kVisibility)
    return {};
  visibilityFactor_ =
      options_.visibilityFactor.value_or(input.visibilityFactor.value_or(visibilityFactor_));
  std::string factor =
      options_.visibilityFactor ? "as stated"
      : input.visibilityFactor
          ? fmt::format("VISIBILITY_FACTOR of {}", inputName)
          : fmt::format("FDS's default{}", input.path.empty() ? ": no input file is read that says "
                                                                "another VISIBILITY_FACTOR"
                                                              : "");
  if (options_.visibilityFactor && input.visibilityFactor &&
      *options_.visibilityFactor != *input.visibilityFactor)
    factor += fmt::format(", although {} says {:g}", inputName, *input.visibilityFactor);
  visibilityCap_ = input.maximumVisibility.value_or(visibilityCap_);
  std::string cap = input.maximumVisibility ? fmt::format("MAXIMUM_VISIBILITY of {}", inputName)
                                            : "FDS's default";
  // Air that is clear at first has the cap everywhere.
  float largest = 0;
  std::size_t often = 0;
  for (const auto& part : parts_) {
    std::vector<float> values(part->file->values());
    VOLUTE_TRY(part->file->readFrame(part->frameAt.front(), values));
    for (const float value : values) {
      if (!std::isfinite(value) || value < largest)
        continue;
      often = value == largest ? often + 1 : 1;
      largest = value;
    }
  }
  constexpr float kRounding = 1e-5F;
  const bool plateau = often > 1 && input.path.empty();
  if (largest > static_cast<float>(visibilityCap_) * (1 + kRounding) ||
      (plateau && largest < static_cast<float>(visibilityCap_) * (1 - kRounding))) {
    visibilityCap_ = largest;
    cap = "the largest value at the first stored time";
  }
  const bool assumed = input.path.empty();
  const double massExtinction = options_.massExtinction > 0
                                    ? options_.massExtinction
                                    : input.massExtinction.value_or(kFdsMassExtinction);
  const auto besides = factorBesides(index_, source(), sources_, visibilityCap_, massExtinction);
  if (besides && besides->contradicts(visibilityFactor_)) {
    const bool sure = besides->most <= 1.02 * besides->least && !besides->isDensity;
    if (assumed && !options_.visibilityFactor && sure) {
      visibilityFactor_ = 1e-3 * std::round(1e3 * besides->usual);
      factor = fmt::format("by {}, at the same times; FDS's default is 3", besides->source);
    } else {
      remarks_.push_back(
          {RemarkCode::kDoubtful,
           fmt::format("{}: visibility by C = {:g} ({}) contradicts {}, by which it is {:.3g} to "
                       "{:.3g} at the same times{}",
                       index_.path.string(), visibilityFactor_, factor, besides->source,
                       besides->least, besides->most,
                       besides->isDensity ? ", or the mass extinction of soot is another" : "")});
    }
  }
  remarks_.push_back(
      {assumed ? RemarkCode::kAssumed : RemarkCode::kNote,
       fmt::format("{}: K = C / visibility with C = {:g} ({}); visibility is cut at {:g} m ({}): "
                   "where it is, "
                   "extinction is anything from 0 to {:.4g} 1/m, and {:.4g} is taken",
                   index_.path.string(), visibilityFactor_, factor, visibilityCap_, cap,
                   visibilityFactor_ / visibilityCap_, visibilityFactor_ / visibilityCap_)});
  return {};
}

/// How the stored values of a frame become extinction.
Result<SmokeScale> FdsCase::scaleOf(const Part& part, std::size_t frame) const {
  SmokeScale scale;
  scale.quantity = source().quantity;
  scale.massExtinction = part.massExtinction;
  scale.visibilityFactor = visibilityFactor_;
  scale.visibilityCap = visibilityCap_;
  scale.asStored = !options_.quantity.empty();
  const FdsFileKind kind = source().kind;
  if (kind == FdsFileKind::kSmoke && scale.asStored) {
    const bool heat = options_.quantity == kFdsHeatRelease;
    scale.bytes = heat ? SmokeScale::Bytes::kHeat : SmokeScale::Bytes::kTemperature;
    scale.largestHeat = largestHeat_;
    scale.temperature = temperatureRange_;
  } else if (kind == FdsFileKind::kSmoke && !bytesAreDensity_) {
    scale.bytes = SmokeScale::Bytes::kOpacity;
    scale.rounding = rounding_;
    scale.cellLength = part.cellLength;
  } else if (kind == FdsFileKind::kSmoke || kind == FdsFileKind::kSmokeDensity) {
    scale.bytes = SmokeScale::Bytes::kDensity;
    if (kind == FdsFileKind::kSmokeDensity)
      scale.rounding = SmokeScale::Rounding::kNearest;
    const double time = part.file->frames().times[frame];
    const std::size_t column = kind == FdsFileKind::kSmokeDensity ? 4 : 2;
    const auto row = std::ranges::find_if(part.sizeRows, [&](const FdsSizeRow& one) {
      return std::abs(one.time - time) <= 1e-5 * (1 + std::abs(time)) &&
             one.columns.size() > column;
    });
    if (row == part.sizeRows.end() || !(row->columns[column] >= 0)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: frame {} (t = {} s): its .sz file does not say the largest density, without "
                  "which bytes mean nothing",
                  part.path.string(), frame, time);
    }
    scale.largestDensity = row->columns[column];
  } else if (kind == FdsFileKind::kSmoke16) {
    VOLUTE_ASSIGN(scale.step, static_cast<const FdsSmoke16File&>(*part.file).step(frame));
  }
  return scale;
}

}  // namespace volute
