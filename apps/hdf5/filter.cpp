// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// A filter of HDF5, loaded from HDF5_PLUGIN_PATH: each chunk of a dataset is a .volute file.

#include <H5PLextern.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/array_source.hpp"

namespace volute {
namespace {

constexpr H5Z_filter_t kNumber = 473;  ///< of those that HDF5 leaves to everybody: not registered
constexpr unsigned kVersion = 1;
constexpr std::size_t kMaxAxes = 16;

/// What a dataset keeps for its chunks: version, maximum error (a double, low half first; 0: as
/// pictures need it), type of numbers, and the sides of a chunk.
struct Settings {
  double maxError = 0;
  NumberType type{};
  std::vector<unsigned> sides{};

  /// Axes before the last three are put in a row.
  VolumeInfo info() const {
    VolumeInfo info;
    const std::size_t axes = sides.size();
    const auto side = [&](std::size_t fromLast) {
      return fromLast <= axes ? static_cast<int>(sides[axes - fromLast]) : 1;
    };
    info.x = side(1), info.y = side(2), info.z = side(3);
    info.frames = 1;
    for (std::size_t i = 0; i + 3 < axes; ++i) info.frames *= static_cast<int>(sides[i]);
    info.fillDefaults();
    return info;
  }
};

double doubleOf(const unsigned* halves) {
  return std::bit_cast<double>(std::uint64_t{halves[1]} << 32 | halves[0]);
}

Result<Settings> settingsOf(std::size_t count, const unsigned* values) {
  if (count < 6 || values[0] != kVersion || values[4] == 0 || values[4] > kMaxAxes ||
      count != 5 + values[4])
    return fail(ErrorCode::kUnsupported, "a dataset of another version of Volute's filter");
  Settings settings;
  settings.maxError = doubleOf(values + 1);
  settings.type.kind = static_cast<NumberKind>(values[3] & 0xFF);
  settings.type.bigEndian = (values[3] & 0x100) != 0;
  settings.sides.assign(values + 5, values + count);
  std::uint64_t all = 1;
  for (const unsigned side : settings.sides) {
    all *= side;  // HDF5's chunks are below 4 GB
    if (side == 0 || all > std::numeric_limits<int>::max())
      return fail(ErrorCode::kInvalidData, "a chunk of no or too many numbers");
  }
  return settings;
}

/// A folder for the file that a chunk becomes.
class ChunkFolder {
 public:
  ChunkFolder() {
    std::error_code error;
    name_ = (std::filesystem::temp_directory_path(error) / "volute-hdf5-XXXXXX").string();
    if (!::mkdtemp(name_.data()))
      name_.clear();
  }

  ~ChunkFolder() {
    std::error_code error;
    if (!name_.empty())
      std::filesystem::remove_all(name_, error);
  }

  ChunkFolder(const ChunkFolder&) = delete;
  ChunkFolder& operator=(const ChunkFolder&) = delete;

  Result<std::filesystem::path> file() const {
    if (name_.empty())
      return fail(ErrorCode::kIo, "cannot make a folder for temporary files");
    return std::filesystem::path(name_) / "chunk.volute";
  }

 private:
  std::string name_;
};

/// The maximum error before integers are rounded to such again, which adds up to half of one.
double withinWhole(const Settings& settings) {
  using enum NumberKind;
  constexpr double kHalf = 0.499;
  const bool whole = settings.type.kind != kFloat32 && settings.type.kind != kFloat64;
  const double most = settings.maxError;
  return whole ? std::min(most, std::floor(most) + kHalf) : most;
}

Result<std::vector<char>> encoded(const Settings& settings, const void* numbers,
                                  std::size_t bytes) {
  const VolumeInfo info = settings.info();
  if (bytes != info.values() * settings.type.size())
    return fail(ErrorCode::kInvalidData, "a chunk of {} bytes; expected {}", bytes,
                info.values() * settings.type.size());
  ArraySource source(info, {static_cast<const std::byte*>(numbers), settings.type,
                            denseStrides(info, settings.type)});
  VOLUTE_TRY(settleOffset(source));
  CompressOptions options;
  if (settings.maxError > 0)
    options.target = {ErrorTarget::Kind::kMaxError, withinWhole(settings)};
  const ChunkFolder folder;
  VOLUTE_ASSIGN(const auto file, folder.file());
  Progress quiet;
  VOLUTE_TRY(compress(source, file, options, quiet));
  std::ifstream in(file, std::ios::binary);
  return std::vector<char>(std::istreambuf_iterator<char>(in), {});
}

template <class Number>
void put(double value, bool swapped, char* to) {
  if constexpr (std::is_integral_v<Number>) {
    const double low = static_cast<double>(std::numeric_limits<Number>::min());
    const double high = static_cast<double>(std::numeric_limits<Number>::max());
    const double whole = std::round(value);
    const Number number = whole <= low    ? std::numeric_limits<Number>::min()
                          : whole >= high ? std::numeric_limits<Number>::max()
                                          : static_cast<Number>(whole);
    std::memcpy(to, &number, sizeof number);
  } else {
    const auto number = static_cast<Number>(value);
    std::memcpy(to, &number, sizeof number);
  }
  if (swapped)
    std::reverse(to, to + sizeof(Number));
}

using Put = void (*)(double, bool, char*);

Put putterOf(NumberKind kind) {
  switch (kind) {
    case NumberKind::kUint8:
      return put<std::uint8_t>;
    case NumberKind::kInt8:
      return put<std::int8_t>;
    case NumberKind::kUint16:
      return put<std::uint16_t>;
    case NumberKind::kInt16:
      return put<std::int16_t>;
    case NumberKind::kUint32:
      return put<std::uint32_t>;
    case NumberKind::kInt32:
      return put<std::int32_t>;
    case NumberKind::kFloat32:
      return put<float>;
    case NumberKind::kFloat64:
      return put<double>;
    default:
      return nullptr;
  }
}

Status decodeTo(char* to, const Settings& settings, const void* chunk, std::size_t bytes) {
  const VolumeInfo expected = settings.info();
  const Put putter = putterOf(settings.type.kind);
  auto file = InputFile::ofBytes({static_cast<const std::byte*>(chunk), bytes}, "a chunk");
  VOLUTE_ASSIGN(auto opened, VoluteReader::open(std::move(file), {.differences = Offsets::kAll}));
  const auto reader = std::make_shared<const VoluteReader>(std::move(opened));
  const VolumeInfo& info = reader->info();
  if (!putter || info.frames != expected.frames || info.z != expected.z || info.y != expected.y ||
      info.x != expected.x || info.channels != 1)
    return fail(ErrorCode::kInvalidData, "a chunk that is not what its dataset says");
  const auto source = frameSource(reader);
  std::vector<float> values(info.frameValues());
  const std::size_t size = settings.type.size();
  for (int frame = 0; frame < info.frames; ++frame) {
    VOLUTE_TRY(source->readFrame(frame, values));
    for (const float value : values) {
      putter(reader->offset() + value, settings.type.bigEndian, to);
      to += size;
    }
  }
  return {};
}

void report(const Error& error) {
  H5Epush2(H5E_DEFAULT, __FILE__, "volute", 0, H5E_ERR_CLS, H5E_PLINE, H5E_CANTFILTER, "volute: %s",
           error.message.c_str());
}

/// NumPy's way to write a type of HDF5.
std::optional<NumberType> numberTypeOfHdf5(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  if (kind != H5T_INTEGER && kind != H5T_FLOAT)
    return std::nullopt;
  const char letter = kind == H5T_FLOAT ? 'f' : H5Tget_sign(type) == H5T_SGN_NONE ? 'u' : 'i';
  const auto found = numberTypeOf(fmt::format(
      "{}{}{}", H5Tget_order(type) == H5T_ORDER_BE ? '>' : '<', letter, H5Tget_size(type)));
  return found && putterOf(found->kind) ? found : std::nullopt;
}

/// Settings for the chunks of a dataset that is created.
herr_t setLocal(hid_t properties, hid_t type, hid_t /*space*/) {
  unsigned flags = 0;
  std::size_t count = 2;
  std::array<unsigned, 2> given{};
  std::array<hsize_t, kMaxAxes> sides{};
  if (H5Pget_filter_by_id2(properties, kNumber, &flags, &count, given.data(), 0, nullptr, nullptr) <
      0)
    return -1;
  const int axes = H5Pget_chunk(properties, kMaxAxes, sides.data());
  const auto number = numberTypeOfHdf5(type);
  const double maxError = count == 2 ? doubleOf(given.data()) : 0;
  const bool makesSense = count == 0 || (count == 2 && maxError > 0 && std::isfinite(maxError));
  if (axes < 1 || !number || !makesSense) {
    report({ErrorCode::kInvalidArgument,
            "the filter takes integers of up to 32 bits and floats of 32 or 64, in chunks of up to "
            "16 axes, and a maximum error above 0 as two numbers, or none"});
    return -1;
  }
  std::vector<unsigned> values{
      kVersion, count == 2 ? given[0] : 0, count == 2 ? given[1] : 0,
      static_cast<unsigned>(number->kind) | (number->bigEndian ? 0x100U : 0U),
      static_cast<unsigned>(axes)};
  for (int i = 0; i < axes; ++i) values.push_back(static_cast<unsigned>(sides[i]));
  return H5Pmodify_filter(properties, kNumber, flags, values.size(), values.data());
}

/// Replaces *buffer. Returns the bytes in it, 0 on an error.
std::size_t filtered(unsigned flags, std::size_t count, const unsigned* values, std::size_t bytes,
                     std::size_t* room, void** buffer) {
  const auto settings = settingsOf(count, values);
  if (!settings)
    return report(settings.error()), 0;
  std::size_t made = 0;
  void* result = nullptr;
  if ((flags & H5Z_FLAG_REVERSE) != 0) {
    made = settings->info().values() * settings->type.size();
    result = H5allocate_memory(made, false);
    const Status done = result ? decodeTo(static_cast<char*>(result), *settings, *buffer, bytes)
                               : Status(fail(ErrorCode::kTooLarge, "out of memory"));
    if (!done) {
      if (result)
        H5free_memory(result);
      return report(done.error()), 0;
    }
  } else {
    const auto file = encoded(*settings, *buffer, bytes);
    if (!file)
      return report(file.error()), 0;
    made = file->size();
    result = H5allocate_memory(made, false);
    if (!result)
      return 0;
    std::ranges::copy(*file, static_cast<char*>(result));
  }
  H5free_memory(*buffer);
  *buffer = result, *room = made;
  return made;
}

/// The same; nothing is thrown through HDF5.
std::size_t filter(unsigned flags, std::size_t count, const unsigned* values, std::size_t bytes,
                   std::size_t* room, void** buffer) {
  try {
    return filtered(flags, count, values, bytes, room, buffer);
  } catch (const std::exception& fault) {
    report({ErrorCode::kTooLarge, fault.what()});
    return 0;
  }
}

const H5Z_class2_t kFilter = {H5Z_CLASS_T_VERS, kNumber, 1, 1, "volute", nullptr, setLocal, filter};

}  // namespace
}  // namespace volute

extern "C" {

H5PL_type_t H5PLget_plugin_type() {
  return H5PL_TYPE_FILTER;
}

const void* H5PLget_plugin_info() {
  return &volute::kFilter;
}
}
