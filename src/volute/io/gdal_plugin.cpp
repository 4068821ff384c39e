// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "volute/base/lower_case.hpp"
#include "volute/base/number_type.hpp"
#include "volute/base/number_word.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/hdf5_facts.hpp"
#include "volute/io/hdf5_filters.hpp"
#include "volute/io/unit.hpp"

namespace volute {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int kAxes = 5;  // t, z, y, x, c
constexpr std::string_view kAxisNames[kAxes] = {"t", "z", "y", "x", "c"};

/// The axis that a dimension's name says; -1: none.
int axisNamed(const std::string& name) {
  static constexpr std::pair<std::string_view, int> kNames[] = {
      {"t", 0}, {"time", 0}, {"z", 1},       {"height", 1}, {"altitude", 1}, {"y", 2},
      {"x", 3}, {"c", 4},    {"channel", 4}, {"rgb", 4},    {"component", 4}};
  const std::string small = lowerCase(name);
  const auto* known = std::ranges::find(kNames, small, &std::pair<std::string_view, int>::first);
  return known == std::end(kNames) ? -1 : known->second;
}

/// What GDAL said of the last failure.
std::string gdalSaid(std::string_view otherwise) {
  const char* last = CPLGetLastErrorMsg();
  std::string said = last ? last : "";
  said.resize(std::min(said.find("\nat ("), said.size()));  // where in its sources
  return said.empty() ? std::string(otherwise) : said;
}

/// Why a file grows no further, which HDF5 knows and does not hand on; empty: it does.
std::string whyFull(const std::string& file) {
  constexpr off_t kSome = 1 << 20;
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0)
    return {};
  const off_t end = ::lseek(descriptor, 0, SEEK_END);
  const int error = end < 0 ? 0 : ::posix_fallocate(descriptor, end, kSome);
  ::close(descriptor);
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO;
  return full ? std::strerror(error) : "";
}

/// HDF5 closes its files where a process ends, and falls over one that could not be written: what
/// it does there is left out.
void endBeforeHdf5() {
  static const int kOnce = ::on_exit(
      [](int status, void*) {
        std::cout.flush();
        std::fflush(nullptr);
        ::_exit(status);
      },
      nullptr);
  (void)kOnce;
}

using ArrayPtr = std::shared_ptr<GDALMDArray>;

/// All arrays below a group that may be volumes.
void listArrays(const GDALGroup& group, const std::string& path, int depth,
                std::vector<GridEntry>& entries, std::vector<ArrayPtr>& arrays) {
  constexpr int kDeepest = 16;
  constexpr std::size_t kMax = 10'000;
  for (const std::string& name : group.GetMDArrayNames()) {
    if (entries.size() >= kMax)
      return;
    const ArrayPtr array = group.OpenMDArray(name);
    if (!array)
      continue;
    const std::size_t count = array->GetDimensionCount();
    const GDALExtendedDataType& type = array->GetDataType();
    const bool number =
        type.GetClass() == GEDTC_NUMERIC && !GDALDataTypeIsComplex(type.GetNumericDataType());
    if (count < 2)
      continue;
    entries.push_back({path + name, number ? std::to_string(count) + " axes" : "no numbers",
                       number && count >= 3 && count <= kAxes});
    arrays.push_back(array);
  }
  for (const std::string& name : group.GetGroupNames()) {
    const auto inner = depth < kDeepest ? group.OpenGroup(name) : nullptr;
    if (inner)
      listArrays(*inner, path + name + "/", depth + 1, entries, arrays);
  }
}

/// GDAL leaves out what a link to another file stands for.
void listLinks(const std::string& file, std::vector<GridEntry>& entries,
               std::vector<ArrayPtr>& arrays) {
#if VOLUTE_HAS_HDF5
  for (const Hdf5Link& link : hdf5Links(file)) {
    if (std::ranges::find(entries, link.name, &GridEntry::name) != entries.end())
      continue;
    entries.push_back({link.name, "a link to " + link.target, false});
    arrays.push_back(nullptr);
  }
#else
  (void)file, (void)entries, (void)arrays;
#endif
}

/// Programs write "Units" and "SCALE_FACTOR", too; GDAL knows the names as netCDF has them.
std::shared_ptr<GDALAttribute> attributeOf(const GDALMDArray& array, std::string_view name) {
  if (auto attribute = array.GetAttribute(std::string(name)))
    return attribute;
  constexpr const char* kAll[] = {"SHOW_ALL=YES", nullptr};
  for (const auto& attribute : array.GetAttributes(kAll)) {
    if (lowerCase(attribute->GetName()) == lowerCase(name))
      return attribute;
  }
  return nullptr;
}

std::string unitOf(const GDALMDArray& array) {
  std::string unit = array.GetUnit();
  for (const char* name : {"units", "unit"}) {
    const auto attribute = unit.empty() ? attributeOf(array, name) : nullptr;
    const char* said = attribute ? attribute->ReadAsString() : nullptr;
    unit = said ? said : unit;
  }
  return unit;
}

/// A coordinate's numbers in a unit, or as they are where it is empty; none where the dimension has
/// none. Depths, of which netCDF's CF conventions say that they are positive down, become heights.
/// @param beside    an array of the dimension's name beside the one that is read; may be null
/// @param unitless  gets its name and the unit where it states none
/// @param faces     gets the two ends of a lone coordinate, as netCDF's CF conventions state them;
///                  may be null
Result<std::vector<double>> coordinateOf(const GDALDimension& dimension, const ArrayPtr& beside,
                                         const std::string& file, std::string_view unit,
                                         bool& since, std::vector<std::string>& unitless,
                                         const GDALGroup* root = nullptr,
                                         std::vector<double>* faces = nullptr) {
  constexpr std::uint64_t kMax = 100'000'000;
  ArrayPtr array = dimension.GetIndexingVariable();
  if (!array && beside && beside->GetDimensionCount() == 1 &&
      beside->GetDimensions()[0]->GetSize() == dimension.GetSize())
    array = beside;
  if (!array || array->GetDimensionCount() != 1 || dimension.GetSize() > kMax ||
      array->GetDataType().GetClass() != GEDTC_NUMERIC)
    return std::vector<double>();
  const ArrayPtr numbers = array->GetUnscaled();
  std::vector<double> values(static_cast<std::size_t>(dimension.GetSize()));
  const GUInt64 start = 0;
  const std::size_t count = values.size();
  if (!numbers || !numbers->Read(&start, &count, nullptr, nullptr,
                                 GDALExtendedDataType::Create(GDT_Float64), values.data())) {
    return fail(ErrorCode::kInvalidData, "{}: the coordinate '{}' cannot be read: {}", file,
                array->GetName(), gdalSaid("the file is damaged"));
  }
  if (faces && count == 1) {
    const auto attribute = array->GetAttribute("bounds");
    const char* name = attribute ? attribute->ReadAsString() : nullptr;
    const std::string path = array->GetFullName();
    const ArrayPtr ends =
        name ? root->OpenMDArrayFromFullname(path.substr(0, path.rfind('/') + 1) + name) : nullptr;
    const ArrayPtr plain = ends && ends->GetDimensionCount() == 2 &&
                                   ends->GetDimensions()[0]->GetSize() == 1 &&
                                   ends->GetDimensions()[1]->GetSize() == 2
                               ? ends->GetUnscaled()
                               : nullptr;
    constexpr GUInt64 kStarts[] = {0, 0};
    constexpr std::size_t kCounts[] = {1, 2};
    values.resize(3);
    if (!plain || !plain->Read(kStarts, kCounts, nullptr, nullptr,
                               GDALExtendedDataType::Create(GDT_Float64), values.data() + 1))
      values.resize(1);
  }
  const auto split = [&]() -> std::vector<double> {
    if (values.size() > count) {
      faces->assign(values.begin() + 1, values.end());
      values.resize(1);
    }
    return values;
  };
  std::string stated = unitOf(*array);
  const std::size_t from = stated.find(" since ");
  since = from != stated.npos;
  if (since)
    stated.resize(from);
  if (const auto positive = array->GetAttribute("positive")) {
    const char* said = positive->ReadAsString();
    if (said && lowerCase(said) == "down") {
      for (double& value : values) value = -value;
    }
  } else if (unitChange(stated, "Pa")) {
    for (double& value : values) value = -value;  // pressure grows downwards
  }
  if (stated.empty() && !unit.empty())
    unitless.push_back(fmt::format("{} is taken in {}", array->GetName(), unit));
  if (stated.empty() || unit.empty())
    return split();
  const auto change = unitChange(stated, unit);
  if (!change) {
    const bool ofPlaces = unit == "m";
    return fail(ErrorCode::kUnsupported, ofPlaces ? Hints{Hint::set("bounds")} : Hints{},
                "{}: the coordinate '{}' is in '{}'; expected one in {}", file, array->GetName(),
                stated, ofPlaces ? "metres, or bounds of your own" : "seconds");
  }
  for (double& value : values) value = (*change)(value);
  return split();
}

class GdalReader final : public ArrayReader {
 public:
  Result<ArrayFacts> describe(const std::filesystem::path& path, const std::string& wanted,
                              const std::string& usual, bool place) override {
    file_ = path.string();
    std::fill(std::begin(at_), std::end(at_), -1);
    array_ = nullptr, root_ = nullptr;
    unitless_.clear();
    CPLErrorReset();
    static constexpr const char* kDrivers[] = {"netCDF", "HDF5", "Zarr", nullptr};
    // GDAL's driver reads CDF-5, and does not know it by its first bytes.
    std::array<char, 4> magic{};
    std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
    const std::string name = std::string_view(magic.data(), magic.size()) == "CDF\5"
                                 ? "NETCDF:\"" + file_ + "\""
                                 : file_;
    dataset_.reset(GDALDataset::Open(name.c_str(), GDAL_OF_MULTIDIM_RASTER, kDrivers));
    const auto root = dataset_ ? dataset_->GetRootGroup() : nullptr;
    if (!root) {
      return fail(ErrorCode::kInvalidData, "{}: no netCDF, HDF5 or Zarr file that can be read: {}",
                  file_, gdalSaid("it is damaged or of another kind"));
    }
    std::vector<GridEntry> entries;
    std::vector<ArrayPtr> arrays;
    listArrays(*root, "", 0, entries, arrays);
    listLinks(file_, entries, arrays);
    const std::string bare = wanted.starts_with('/') ? wanted.substr(1) : wanted;
    VOLUTE_ASSIGN(const std::size_t index,
                  chooseGrid(entries, bare, file_,
                             {"array", usual,
                              "an array of numbers with three to five axes: z, y, x, with "
                              "time before them or components after"}));
    array_ = arrays[index];
    root_ = root;
    VOLUTE_TRY(findChunks());
    VOLUTE_ASSIGN(const Hdf5Chunks pieces, piecesOfHdf5());
    ArrayFacts facts;
    entries[index].name.copy(facts.name, ArrayFacts::kMaxText);
    unitOf(*array_).copy(facts.unit, ArrayFacts::kMaxText);
    otherGrids(entries, index, ArrayFacts::kMaxText).copy(facts.others, ArrayFacts::kMaxText);
    VOLUTE_TRY(settleAxes(facts));
    const GDALDataType type = array_->GetDataType().GetNumericDataType();
    VOLUTE_TRY(settleNumbers(type));
    VOLUTE_TRY(countChunks(pieces));
    lacks_ = pieces.lacks;
    asFloats_ = type == GDT_Float32 && scale_ == 1 && offset_ == 0;
    facts.rounded =
        !asFloats_ && (GDALGetDataTypeSizeBytes(type) >= 4 || scale_ != 1 || offset_ != 0);
    VOLUTE_TRY(placeBy(facts, place));
    VOLUTE_ASSIGN(const auto all, times());
    facts.timed = !all.empty();
    fmt::format("{}", fmt::join(unitless_, ", ")).copy(facts.unitless, ArrayFacts::kMaxText);
    range_.copy(facts.range, ArrayFacts::kMaxText);
    absent_.copy(facts.absent, ArrayFacts::kMaxText);
    return facts;
  }

  Result<std::vector<double>> times() override {
    if (at_[0] < 0)
      return std::vector<double>();
    const auto dimension = dimensionOf(0);
    bool since = false;
    VOLUTE_ASSIGN(auto times,
                  coordinateOf(*dimension, besideOf(*dimension), file_, "s", since, unitless_));
    backwards_[0] = times.size() > 1 && times.back() < times.front();
    if (backwards_[0])
      std::ranges::reverse(times);
    if (since && !times.empty()) {
      const double first = times.front();
      for (double& time : times) time -= first;
    }
    constexpr double kUnwritten = 1e30;  // netCDF's fill value is 9.97e36
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (std::abs(times[i]) > kUnwritten) {
        return fail(ErrorCode::kInvalidData,
                    "{}: '{}' was never written at {} of {} (netCDF's fill value); leave that "
                    "frame out, or run the simulation to its end",
                    file_, dimension->GetName(), i, times.size());
      }
      if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
        return fail(
            ErrorCode::kInvalidData,
            "{}: the coordinate '{}' says {} s at {} of {}; expected times that ascend or descend",
            file_, dimension->GetName(), times[i], i, times.size());
      }
    }
    return times;
  }

  Status read(int frame, int firstLayer, int layers, std::span<float> values, double offset,
              ArrayReadFacts& facts) override {
    if (!array_)
      return fail(ErrorCode::kInvalidData, "{}: was not opened before", file_);
    const std::size_t row = static_cast<std::size_t>(size_[2]) * size_[3] * size_[4];
    if (layers < 1 || values.size() != row * static_cast<std::size_t>(layers))
      return fail(ErrorCode::kInvalidData, "{}: {} layers were asked for", file_, layers);
    // Doubles of some layers at once, in pieces that the file is packed in.
    const std::size_t most = std::max<std::size_t>(1, (std::size_t{8} << 20) / row);
    const auto blocks = array_->GetBlockSize();
    const std::size_t packed = at_[1] >= 0 && static_cast<std::size_t>(at_[1]) < blocks.size()
                                   ? std::max<std::size_t>(blocks[at_[1]], 1)
                                   : 1;
    const auto step = static_cast<int>(
        asFloats_ ? layers
                  : std::min<std::size_t>(std::max(most / packed * packed, std::min(packed, most)),
                                          layers));
    std::vector<double> doubles;
    for (int done = 0; done < layers; done += step) {
      const int some = std::min(step, layers - done);
      const auto part = values.subspan(row * done, row * some);
      if (asFloats_) {
        VOLUTE_TRY(readPart(frame, firstLayer + done, some, GDT_Float32, part.data()));
        for (float& number : part) {
          if (isMissing(number)) {
            note(number, facts);
            number = std::numeric_limits<float>::quiet_NaN();
          } else if (offset != 0) {
            number = static_cast<float>(number - offset);
          }
        }
        continue;
      }
      doubles.resize(part.size());
      VOLUTE_TRY(readPart(frame, firstLayer + done, some, GDT_Float64, doubles.data()));
      for (double& number : doubles) {
        if (number < 0)
          number += wrap_;
        if (isMissing(number)) {
          note(number, facts);
          number = std::numeric_limits<double>::quiet_NaN();
        } else {
          number = scale_ * number + offset_;
        }
      }
      constexpr bool kBig = std::endian::native == std::endian::big;
      const auto beyond =
          toFloats({NumberKind::kFloat64, kBig}, std::as_bytes(std::span(doubles)).data(),
                   sizeof(double), part, facts.rounding, offset);
      if (beyond) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the value {:g} is beyond float32, in which values are kept; expected at "
                    "most 3.4e38: scale them",
                    file_, *beyond);
      }
    }
    return {};
  }

 private:
  std::shared_ptr<GDALDimension> dimensionOf(int axis) const {
    return array_->GetDimensions()[static_cast<std::size_t>(at_[axis])];
  }

  ArrayPtr besideOf(const GDALDimension& dimension) const {
    const std::string path = array_->GetFullName();
    return root_->OpenMDArrayFromFullname(path.substr(0, path.rfind('/') + 1) +
                                          dimension.GetName());
  }

  /// The numbers of an attribute; none where it is not there.
  Result<std::vector<double>> numbersOf(std::string_view name) const {
    const auto attribute = attributeOf(*array_, name);
    if (!attribute)
      return std::vector<double>();
    if (attribute->GetDataType().GetClass() != GEDTC_NUMERIC) {
      return fail(ErrorCode::kInvalidData, "{}: '{}' of '{}' is text; expected numbers", file_,
                  name, array_->GetName());
    }
    return attribute->ReadAsDoubleArray();
  }

  /// What a stored number means, and which mean that nothing is there: GDAL's drivers for HDF5 and
  /// Zarr leave that to whoever asks, and none knows of valid ranges and of what netCDF fills with.
  Status settleNumbers(GDALDataType type) {
    bool known = false;
    scale_ = array_->GetScale(&known);
    VOLUTE_ASSIGN(const auto scale, numbersOf("scale_factor"));
    if (!known && !scale.empty())
      scale_ = scale.front();
    offset_ = array_->GetOffset(&known);
    VOLUTE_ASSIGN(const auto offset, numbersOf("add_offset"));
    if (!known && !offset.empty())
      offset_ = offset.front();
    if (scale.size() > 1 || offset.size() > 1) {
      return fail(ErrorCode::kInvalidData,
                  "{}: '{}' has {} numbers to scale with and {} to move by; expected one of each",
                  file_, array_->GetName(), scale.size(), offset.size());
    }
    if (scale_ == 0 || !std::isfinite(scale_) || !std::isfinite(offset_)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the numbers of '{}' are scaled by {} and moved by {}; expected finite "
                  "numbers, the first of them not 0",
                  file_, array_->GetName(), scale_, offset_);
    }
    VOLUTE_ASSIGN(missing_, numbersOf("missing_value"));
    VOLUTE_ASSIGN(const auto fill, numbersOf("_FillValue"));
    missing_.insert(missing_.end(), fill.begin(), fill.end());
    const double none = array_->GetNoDataValueAsDouble(&known);
    if (known && (fillIsNone_ || isUsualMarker(none)))
      missing_.push_back(none);
    std::erase(missing_, 0.0);  // what arrays begin with unless it is said
    isFloat_ = type == GDT_Float32 || type == GDT_Float64;
    constexpr double kFloat = 9.9692099683868690e+36, kInt16 = -32767, kInt32 = -2147483647;
    if (isFloat_)
      missing_.push_back(kFloat);
    const bool netcdf = std::string_view(dataset_->GetDriver()->GetDescription()) == "netCDF";
    if (netcdf && fill.empty() && !known && (type == GDT_Int16 || type == GDT_Int32))
      missing_.push_back(type == GDT_Int16 ? kInt16 : kInt32);
    VOLUTE_ASSIGN(const auto range, numbersOf("valid_range"));
    VOLUTE_ASSIGN(const auto least, numbersOf("valid_min"));
    VOLUTE_ASSIGN(const auto most, numbersOf("valid_max"));
    if ((!range.empty() && range.size() != 2) || least.size() > 1 || most.size() > 1) {
      return fail(ErrorCode::kInvalidData,
                  "{}: '{}' has {} numbers as its valid_range, {} as its valid_min and {} as its "
                  "valid_max; expected two, one and one",
                  file_, array_->GetName(), range.size(), least.size(), most.size());
    }
    low_ = -kInfinite, high_ = kInfinite, range_.clear();
    if (!least.empty() || !range.empty())
      limit(least.empty() ? "valid_range" : "valid_min", least.empty() ? range[0] : least[0], true);
    if (!most.empty() || !range.empty())
      limit(most.empty() ? "valid_range" : "valid_max", most.empty() ? range[1] : most[0], false);
    const auto isUnsigned = attributeOf(*array_, "_Unsigned");
    const char* said = isUnsigned ? isUnsigned->ReadAsString() : nullptr;
    wrap_ = !isFloat_ && said && lowerCase(said) == "true"
                ? std::exp2(8.0 * GDALGetDataTypeSizeBytes(type))
                : 0;
    for (double& number : missing_) number += number < 0 ? wrap_ : 0;
    return {};
  }

  /// Numbers that nobody has as values. The fill value of a plain array of Zarr is what it begins
  /// with, as zarr.ones() does; xarray's means that nothing is there.
  static bool isUsualMarker(double fill) { return fill <= -999 || std::abs(fill) >= 1e20; }

  /// An end of the valid range. A float about stored integers that are scaled, or of a wider type
  /// than the stored numbers, is about scaled values, as netCDF's conventions say; any other is
  /// about stored numbers.
  void limit(const char* attribute, double end, bool lower) {
    if (!std::isfinite(end))
      return;
    const GDALDataType its = attributeOf(*array_, attribute)->GetDataType().GetNumericDataType();
    const GDALDataType stored = array_->GetDataType().GetNumericDataType();
    const bool scaled =
        (scale_ != 1 || offset_ != 0) && (its == GDT_Float32 || its == GDT_Float64) &&
        (!isFloat_ || GDALGetDataTypeSizeBytes(its) > GDALGetDataTypeSizeBytes(stored));
    range_ += fmt::format("{}{} {} {:g} ({})", range_.empty() ? "" : ", ",
                          scaled ? "values" : "stored numbers", lower ? "below" : "above", end,
                          attribute);
    // An integer may stand for a value that is half a step away.
    const double slack = scaled && !isFloat_ ? 0.5 : 0;
    const double number = scaled ? (end - offset_) / scale_ : end;
    if (lower != (scaled && scale_ < 0))
      low_ = std::max(low_, number - slack);
    else
      high_ = std::min(high_, number + slack);
  }

  /// Where the chunks of a Zarr array are. GDAL reads the fill value where there is none, 0 where
  /// that is null, and whatever length a chunk has.
  Status findChunks() {
    chunks_.clear(), absent_.clear(), fillIsNone_ = true;
    if (std::string_view(dataset_->GetDriver()->GetDescription()) != "Zarr")
      return {};
    std::filesystem::path folder = std::filesystem::path(file_) / array_->GetFullName().substr(1);
    if (!std::filesystem::exists(folder / ".zarray"))
      folder = file_;  // the array alone
    std::ifstream text(folder / ".zarray");
    const auto said = nlohmann::json::parse(text, nullptr, false);
    if (!said.is_object())
      return {};
    std::ifstream about(folder / ".zattrs");
    fillIsNone_ = nlohmann::json::parse(about, nullptr, false).contains("_ARRAY_DIMENSIONS");
    const auto isStated = [&](const char* name) {
      const auto found = said.find(name);
      return found != said.end() && !found->is_null() && *found != nlohmann::json::array();
    };
    separator_ = said.value("dimension_separator", nlohmann::json(".")) == "/" ? "/" : ".";
    allChunks_ = !array_->GetRawNoDataValue();
    chunkBytes_ = 0;
    if (!isStated("compressor") && !isStated("filters")) {
      const auto type = said.value("dtype", nlohmann::json());  // GDAL has wider ones for some
      const auto numbers = type.is_string() ? numberTypeOf(type.get<std::string>()) : std::nullopt;
      chunkBytes_ = numbers ? numbers->size() : 0;
      for (const GUInt64 side : array_->GetBlockSize()) chunkBytes_ *= std::max<GUInt64>(side, 1);
    }
    bool any = false, others = false;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (!std::isdigit(static_cast<unsigned char>(name.front())))
        continue;
      const bool dots = name.find('.') != name.npos;
      (dots == (separator_ == ".") ? any : others) = true;
    }
    if (others && !any) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the chunks of '{}' are named by another dimension_separator than its "
                  ".zarray says, '{}'",
                  file_, array_->GetName(), separator_);
    }
    chunks_ = folder;
    fill_ = said.value("fill_value", nlohmann::json()).dump();
    return {};
  }

  Result<Hdf5Chunks> piecesOfHdf5() const {
#if VOLUTE_HAS_HDF5
    return hdf5Chunks(file_, array_->GetFullName());
#else
    return Hdf5Chunks();
#endif
  }

  /// Files without a chunk that holds nothing but the fill value are usual; so are copies that
  /// broke off, and runs that were stopped.
  /// @param pieces  of a dataset of HDF5
  Status countChunks(const Hdf5Chunks& pieces) {
    if (pieces.absent > 0 && pieces.fill.empty()) {
      return fail(ErrorCode::kInvalidData,
                  "{}: {} of {} chunks of '{}' were never written, and it has no fill value, which "
                  "leaves open what is there; expected all of them",
                  file_, pieces.absent, pieces.expected, array_->GetName());
    }
    if (pieces.absent > 0 && pieces.expected == 1)
      absent_ = "was never written; its " + valuesAre(pieces.fill);
    else if (pieces.absent > 0)
      absent_ = fmt::format("{} of {} chunks were never written; their {}", pieces.absent,
                            pieces.expected, valuesAre(pieces.fill));
    if (chunks_.empty() || allChunks_)
      return {};
    const auto blocks = array_->GetBlockSize();
    std::uint64_t expected = 1, there = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const GUInt64 block = std::max<GUInt64>(blocks[i], 1);
      expected *= (array_->GetDimensions()[i]->GetSize() + block - 1) / block;
    }
    std::error_code error;
    for (std::filesystem::recursive_directory_iterator at(chunks_, error), end; at != end;
         at.increment(error)) {
      const std::string name = at->path().filename().string();
      there += std::isdigit(static_cast<unsigned char>(name.front())) && at->is_regular_file(error);
    }
    if (there < expected) {
      absent_ = fmt::format("{} of {} chunks are not there; their {}", expected - there, expected,
                            valuesAre(fill_));
    }
    return {};
  }

  /// Of what is read where no chunk is.
  std::string valuesAre(const std::string& fill) const {
    double number = 0;
    return !readNumber(fill, number) || std::isnan(number) || isMissing(number)
               ? fmt::format("values are not known (the fill value is {})", fill)
               : fmt::format("values are the fill value {}", fill);
  }

  Status checkChunks(const GUInt64* starts, const std::size_t* counts, const GInt64* steps) const {
    if (chunks_.empty() || (!allChunks_ && chunkBytes_ == 0))
      return {};
    const auto blocks = array_->GetBlockSize();
    std::vector<GUInt64> first, last;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const GUInt64 low = steps[i] < 0 ? starts[i] + 1 - counts[i] : starts[i];
      const GUInt64 block = std::max<GUInt64>(blocks[i], 1);
      first.push_back(low / block), last.push_back((low + counts[i] - 1) / block);
    }
    for (std::vector<GUInt64> at = first;;) {
      const std::string name = fmt::format("{}", fmt::join(at, separator_));
      std::error_code error;
      const auto size = std::filesystem::file_size(chunks_ / name, error);
      if (error && allChunks_) {
        return fail(ErrorCode::kInvalidData,
                    "{}: '{}' has no chunk {}, and its fill_value is null, which leaves open what "
                    "is there; expected the chunk, or a fill_value",
                    file_, array_->GetName(), name);
      }
      if (!error && chunkBytes_ > 0 && size != chunkBytes_) {
        return fail(ErrorCode::kInvalidData,
                    "{}: chunk {} of '{}' has {} bytes; expected {}, as it is not compressed",
                    file_, name, array_->GetName(), size, chunkBytes_);
      }
      std::size_t axis = at.size();
      while (axis > 0 && ++at[axis - 1] > last[axis - 1]) {
        at[axis - 1] = first[axis - 1];
        --axis;
      }
      if (axis == 0)
        return {};
    }
  }

  bool isMissing(double number) const {
    const double its = asStored(number);
    return isBeyondRange(number) ||
           std::ranges::any_of(missing_, [&](double one) { return its == asStored(one); });
  }

  bool isBeyondRange(double number) const {
    const double its = asStored(number);
    return its < asStored(low_) || its > asStored(high_);
  }

  /// A file may state doubles about floats.
  double asStored(double number) const {
    return isFloat_ ? static_cast<double>(static_cast<float>(number)) : number;
  }

  /// What stands for nothing; whatever is beyond the valid range was told before.
  void note(double number, ArrayReadFacts& facts) const {
    facts.hasMarker = facts.hasMarker || !isBeyondRange(number);
    if (!isBeyondRange(number))
      facts.marker = number;
  }

  /// What all dimensions but that of channels are called behind the axis, as volute.xarray writes
  /// those of a grid that lies elsewhere: "_flow" of t_flow, z_flow, .. Empty: nothing.
  std::string commonEnding() const {
    std::string ending;
    for (const auto& dimension : array_->GetDimensions()) {
      const std::string& name = dimension->GetName();
      if (axisNamed(name) == kAxes - 1)
        continue;
      const std::string own = name.empty() ? "" : name.substr(1);
      if (!own.starts_with('_') || (!ending.empty() && own != ending))
        return {};
      ending = own;
    }
    return ending;
  }

  /// By its name, or by what CF calls the axis of its coordinate; -1: unknown.
  int axisOf(const GDALDimension& dimension, const std::string& ending) const {
    const std::string& name = dimension.GetName();
    int axis = axisNamed(name);
    if (axis < 0 && !ending.empty())
      axis = axisNamed(name.substr(0, name.size() - ending.size()));
    ArrayPtr coordinate = axis < 0 ? dimension.GetIndexingVariable() : nullptr;
    if (axis < 0 && !coordinate)
      coordinate = besideOf(dimension);
    const auto attribute = coordinate ? attributeOf(*coordinate, "axis") : nullptr;
    const char* said = attribute ? attribute->ReadAsString() : nullptr;
    return said && std::strlen(said) == 1 ? axisNamed(said) : axis;
  }

  /// Which dimension is which axis.
  Status settleAxes(ArrayFacts& facts) {
    const auto& dimensions = array_->GetDimensions();
    const std::string ending = commonEnding();
    std::vector<std::size_t> rest;
    std::string names, order;
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      const std::string& name = dimensions[i]->GetName();
      names += (i > 0 ? ", " : "") + name;
      const int axis = axisOf(*dimensions[i], ending);
      if (axis < 0) {
        rest.push_back(i);
      } else if (at_[axis] >= 0) {
        return fail(ErrorCode::kInvalidData,
                    "{}: '{}' has the dimensions {}, of which two are {}; expected z, y and x once",
                    file_, facts.name, names, kAxisNames[axis]);
      } else {
        at_[axis] = static_cast<int>(i);
      }
    }
    // Those whose names say nothing, by their places.
    std::vector<int> open;
    for (const int axis : {1, 2, 3}) {
      if (at_[axis] < 0)
        open.push_back(axis);
    }
    const bool nameless = rest.size() == dimensions.size();
    if (nameless && rest.size() >= 4)
      open.insert(open.begin(), 0);
    if (nameless && rest.size() == 5)
      open.push_back(4);
    if (open.size() != rest.size()) {
      return fail(ErrorCode::kInvalidData,
                  "{}: '{}' has the dimensions {}; expected z, y and x, with t (or time) and c (or "
                  "channel) where there are any",
                  file_, facts.name, names);
    }
    for (std::size_t i = 0; i < rest.size(); ++i) {
      at_[open[i]] = static_cast<int>(rest[i]);
      const std::string& name = dimensions[rest[i]]->GetName();
      const bool numbered =
          nameless && !name.empty() && std::isdigit(static_cast<unsigned char>(name.back()));
      if (!numbered)  // those that a library made up
        order += (order.empty() ? "" : ", ") + name + " is " + std::string(kAxisNames[open[i]]);
    }
    order.copy(facts.order, ArrayFacts::kMaxText);
    for (int axis = 0; axis < kAxes; ++axis) {
      const std::uint64_t size = at_[axis] < 0 ? 1 : dimensionOf(axis)->GetSize();
      if (size > std::numeric_limits<std::int32_t>::max()) {
        return fail(ErrorCode::kTooLarge, "{}: '{}' has {} elements along {}", file_, facts.name,
                    size, kAxisNames[axis]);
      }
      size_[axis] = facts.size[axis] = static_cast<std::int32_t>(size);
      backwards_[axis] = false;
    }
    return {};
  }

  /// Bounds by coordinates: voxels lie around them. Where they descend, the axis is read backwards.
  /// @param place  whether they are to give bounds; else directions alone
  Status placeBy(ArrayFacts& facts, bool place) {
    constexpr double kRelative = 1e-3, kRounding = 1e-6;
    std::array<double, 3> low{}, high{}, step{};
    std::array<bool, 3> has{};
    std::array<std::vector<double>, 3> faces;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const auto dimension = dimensionOf(3 - i);
      bool since = false;
      VOLUTE_ASSIGN(const auto places,
                    coordinateOf(*dimension, besideOf(*dimension), file_, place ? "m" : "", since,
                                 unitless_, root_.get(), &faces[i]));
      if (places.empty())
        continue;
      has[i] = true;
      const auto count = static_cast<double>(places.size());
      const double mean = places.size() > 1 ? (places.back() - places.front()) / (count - 1) : 0;
      const double far = std::max(std::abs(places.front()), std::abs(places.back()));
      for (std::size_t k = 0; k < places.size(); ++k) {
        const double expected = places.front() + mean * static_cast<double>(k);
        if (!std::isfinite(places[k]) || (places.size() > 1 && mean == 0) ||
            std::abs(places[k] - expected) > kRelative * std::abs(mean) + kRounding * far) {
          const std::string uneven = fmt::format(
              "the coordinate '{}' is not evenly spaced: {:.9g} at {} of {}, where even steps say "
              "{:.9g}",
              dimension->GetName(), places[k], k, places.size(), expected);
          if (place) {
            return fail(ErrorCode::kUnsupported, "{}: {}; interpolate the array to even voxels",
                        file_, uneven);
          }
          if (facts.doubt[0] == 0)
            uneven.copy(facts.doubt, ArrayFacts::kMaxText);
          break;
        }
      }
      backwards_[3 - i] = mean < 0;
      low[i] = std::min(places.front(), places.back()),
      high[i] = std::max(places.front(), places.back());
      step[i] = std::abs(mean);
      if (step[i] > 0)
        least = std::min(least, step[i]);
    }
    if (!place || (!has[0] && !has[1] && !has[2]))
      return {};
    std::vector<std::string> thin;
    for (int i = 0; i < 3; ++i) {
      if (!has[i]) {
        return fail(ErrorCode::kUnsupported, Hint::set("bounds"),
                    "{}: '{}' has coordinates, but none of {}; give bounds", file_, facts.name,
                    dimensionOf(3 - i)->GetName());
      }
      const auto& ends = faces[i];
      if (ends.size() == 2 && std::isfinite(ends[0]) && std::isfinite(ends[1]) &&
          ends[0] != ends[1]) {
        facts.bounds[i] = std::min(ends[0], ends[1]);
        facts.bounds[3 + i] = std::max(ends[0], ends[1]);
        continue;
      }
      const double side = step[i] > 0 ? step[i] : std::isfinite(least) ? least : 1.0;
      facts.bounds[i] = low[i] - 0.5 * side, facts.bounds[3 + i] = high[i] + 0.5 * side;
      if (step[i] == 0)
        thin.push_back(fmt::format("{:.6g} m along {}", side, dimensionOf(3 - i)->GetName()));
    }
    facts.placed = true;
    fmt::format("{}", fmt::join(thin, ", ")).copy(facts.thin, ArrayFacts::kMaxText);
    return {};
  }

  /// Layers of a frame in the order z, y, x, c.
  Status readPart(int frame, int first, int layers, GDALDataType type, void* values) const {
    const int begin[kAxes] = {frame, first, 0, 0, 0};
    const int count[kAxes] = {1, layers, size_[2], size_[3], size_[4]};
    const std::ptrdiff_t stride[kAxes] = {0, std::ptrdiff_t{size_[2]} * size_[3] * size_[4],
                                          std::ptrdiff_t{size_[3]} * size_[4], size_[4], 1};
    GUInt64 starts[kAxes];
    std::size_t counts[kAxes];
    GInt64 steps[kAxes];
    GPtrDiff_t strides[kAxes];
    for (int axis = 0; axis < kAxes; ++axis) {
      if (at_[axis] < 0)
        continue;
      const auto i = static_cast<std::size_t>(at_[axis]);
      starts[i] =
          static_cast<GUInt64>(backwards_[axis] ? size_[axis] - 1 - begin[axis] : begin[axis]);
      counts[i] = static_cast<std::size_t>(count[axis]);
      steps[i] = backwards_[axis] ? -1 : 1;
      strides[i] = static_cast<GPtrDiff_t>(stride[axis]);
    }
    VOLUTE_TRY(checkChunks(starts, counts, steps));
    CPLErrorReset();
    if (array_->Read(starts, counts, steps, strides, GDALExtendedDataType::Create(type), values))
      return {};
    if (!lacks_.empty())
      return fail(ErrorCode::kUnsupported, "{}: {}", file_, lacks_);
    return fail(ErrorCode::kInvalidData, "{}: frame {} cannot be read: {}", file_, frame,
                gdalSaid("the file is damaged"));
  }

  std::string file_;
  std::unique_ptr<GDALDataset> dataset_;
  std::shared_ptr<GDALGroup> root_;
  ArrayPtr array_;
  std::filesystem::path chunks_;   // the folder of a Zarr array's chunks
  std::string separator_;          // in their names
  bool allChunks_ = false;         // must be there
  std::uintmax_t chunkBytes_ = 0;  // of each; 0: it is not known
  std::string fill_;               // read in the place of those that are not there
  bool asFloats_ = false;
  double scale_ = 1, offset_ = 0;      // of the stored numbers
  std::vector<double> missing_;        // stored in the place of what is not there
  bool fillIsNone_ = true;             // the file's fill value is one of them
  bool isFloat_ = false;               // what is stored
  double low_ = 0, high_ = 0;          // beyond them nothing is there
  std::string range_;                  // the same as text, by the attributes that say it
  std::string lacks_;                  // what reading its chunks wants; empty: nothing
  std::string absent_;                 // which of its chunks are not there
  double wrap_ = 0;                    // added to negative numbers, which mean unsigned ones
  std::vector<std::string> unitless_;  // coordinates
  int at_[kAxes] = {};                 // the dimension of each axis; -1: it has none
  std::int32_t size_[kAxes] = {};
  bool backwards_[kAxes] = {};
};

class GdalWriter final : public ArrayWriter {
 public:
  Status begin(const std::filesystem::path& file, const std::filesystem::path& target,
               const VolumeInfo& info, double offset) override {
    file_ = file.string();
    target_ = target.string();
    offset_ = offset;
    CPLErrorReset();
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("netCDF");
    if (!driver) {
      return fail(ErrorCode::kUnsupported,
                  "{}: this GDAL has no driver for netCDF, which writes it", target_);
    }
    dataset_.reset(driver->CreateMultiDimensional(file.c_str(), nullptr, nullptr));
    const auto root = dataset_ ? dataset_->GetRootGroup() : nullptr;
    if (!root)
      return failed();
    std::vector<std::shared_ptr<GDALDimension>> dimensions;
    std::shared_ptr<GDALDimension> two;  // of the two faces of a lone voxel
    const auto faces = [&](const std::string& name, GDALMDArray& array, int i) -> Status {
      const auto doubles = GDALExtendedDataType::Create(GDT_Float64);
      const auto attribute =
          array.CreateAttribute("bounds", {}, GDALExtendedDataType::CreateString(), nullptr);
      if (!two)
        two = root->CreateDimension("nv", "", "", 2);
      const ArrayPtr ends =
          two ? root->CreateMDArray(name + "_bnds", {dimensions.back(), two}, doubles) : nullptr;
      const double numbers[] = {info.bounds.min[i], info.bounds.max[i]};
      constexpr GUInt64 kStarts[] = {0, 0};
      constexpr std::size_t kCounts[] = {1, 2};
      const bool good = attribute && attribute->Write((name + "_bnds").c_str()) && ends &&
                        ends->Write(kStarts, kCounts, nullptr, nullptr, doubles, numbers);
      return good ? Status() : failed();
    };
    const auto axis = [&](const char* name, const char* unit, auto size, auto place,
                          int along = -1) -> Status {
      const auto count = static_cast<std::size_t>(size);
      const auto dimension = root->CreateDimension(name, "", "", count);
      const auto doubles = GDALExtendedDataType::Create(GDT_Float64);
      const ArrayPtr array =
          dimension && unit ? root->CreateMDArray(name, {dimension}, doubles) : nullptr;
      if (!dimension || (unit && (!array || !array->SetUnit(unit))))
        return failed();
      dimensions.push_back(dimension);
      size_.push_back(count);
      if (!unit)
        return {};
      std::vector<double> places;
      for (std::size_t i = 0; i < count; ++i) places.push_back(place(static_cast<double>(i)));
      const GUInt64 start = 0;
      if (!array->Write(&start, &count, nullptr, nullptr, doubles, places.data()))
        return failed();
      return along >= 0 && count == 1 ? faces(name, *array, along) : Status();
    };
    const auto centres = [&](int i, int count) {
      const double low = info.bounds.min[i], high = info.bounds.max[i];
      return [=](double at) { return low + (at + 0.5) / count * (high - low); };
    };
    const auto time = [&](double at) { return info.times[static_cast<std::size_t>(at)]; };
    VOLUTE_TRY(axis("time", "s", info.frames, time));
    VOLUTE_TRY(axis("z", "m", info.z, centres(2, info.z), 2));
    VOLUTE_TRY(axis("y", "m", info.y, centres(1, info.y), 1));
    VOLUTE_TRY(axis("x", "m", info.x, centres(0, info.x), 0));
    if (info.channels > 1)
      VOLUTE_TRY(axis("c", nullptr, info.channels, time));
    // Packed by layers, so that a slice reads little, with checksums.
    std::vector<std::size_t> pieces = size_;
    pieces[0] = 1;
    pieces[1] = std::min<std::size_t>(pieces[1], 16);
    std::string blocks = fmt::format("{}", fmt::join(pieces, ","));
    CPLStringList options;
    options.SetNameValue("BLOCKSIZE", blocks.c_str());
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("ZLEVEL", "1");
    options.SetNameValue("CHECKSUM", "YES");
    array_ = root->CreateMDArray(
        info.name.empty() ? "values" : info.name, dimensions,
        GDALExtendedDataType::Create(offset == 0 ? GDT_Float32 : GDT_Float64), options.List());
    if (!array_ || (!info.unit.empty() && !array_->SetUnit(info.unit)))
      return failed();
    return {};
  }

  Status write(std::span<const float> values) override {
    std::vector<GUInt64> start(size_.size(), 0);
    std::vector<std::size_t> count = size_;
    start[0] = frame_++, count[0] = 1;
    std::vector<double> numbers;
    const void* from = values.data();
    if (offset_ != 0) {
      numbers.reserve(values.size());
      for (const float value : values) numbers.push_back(offset_ + value);
      from = numbers.data();
    }
    CPLErrorReset();
    const auto type = GDALExtendedDataType::Create(offset_ == 0 ? GDT_Float32 : GDT_Float64);
    if (!array_->Write(start.data(), count.data(), nullptr, nullptr, type, from))
      return failed();
    return {};
  }

  Status finish() override {
    CPLErrorReset();
    array_ = nullptr;
    dataset_ = nullptr;
    return CPLGetLastErrorType() >= CE_Failure ? failed() : Status();
  }

 private:
  Status failed() const {
    endBeforeHdf5();
    const std::string full = whyFull(file_);
    return fail(ErrorCode::kIo, "{}: cannot be written: {}", target_,
                full.empty() ? gdalSaid("the disk may be full") : full);
  }

  std::string file_, target_;
  std::unique_ptr<GDALDataset> dataset_;
  ArrayPtr array_;
  std::vector<std::size_t> size_;  // of the dimensions
  GUInt64 frame_ = 0;
  double offset_ = 0;
};

}  // namespace
}  // namespace volute

extern "C" const volute::ArrayPlugin* voluteArrayPlugin() {
  using namespace volute;
  // One thread, no files beside the one that is read, and no locks on that.
  CPLSetConfigOption("GDAL_NUM_THREADS", "1");
  CPLSetConfigOption("GDAL_DRIVER_PATH", "disable");
  CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
  ::setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
  CPLSetErrorHandler(CPLQuietErrorHandler);
  GDALAllRegister();
  static constexpr ArrayPlugin kPlugin{
      []() -> std::unique_ptr<ArrayReader> {
#if VOLUTE_HAS_HDF5
        loadHdf5Filters();
#endif
        return std::make_unique<GdalReader>();
      },
      []() -> std::unique_ptr<ArrayWriter> { return std::make_unique<GdalWriter>(); }};
  return &kPlugin;
}
