// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/netcdf_length.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "volute/base/input_file.hpp"

namespace volute {
namespace {

using Count = std::uint64_t;

/// Beyond any file; sums and products of counts that are at most this do not overflow.
constexpr Count kHuge = Count{1} << 62;

Count times(Count a, Count b) {
  return a != 0 && b > kHuge / a ? kHuge : a * b;
}

Count plus(Count a, Count b) {
  return std::min(kHuge, std::min(kHuge, a) + std::min(kHuge, b));
}

Count padded(Count bytes) {
  return plus(bytes, 3) / 4 * 4;
}

tl::unexpected<Error> truncated(const InputFile& file, Count expected) {
  return fail(ErrorCode::kTruncated,
              "{}: has {} bytes; its header says at least {}: the end is missing; copy the file "
              "again or write it anew",
              file.path().string(), file.size(), expected);
}

/// The header of a classic file, read from its start. In big-endian order.
class HeaderReader {
 public:
  HeaderReader(const InputFile& file, bool wide) : file_(file), wide_(wide) {}

  /// Of `bytes` bytes, at most 8.
  Result<Count> number(int bytes) {
    std::array<std::byte, 8> raw{};
    const auto part = std::span(raw).first(static_cast<std::size_t>(bytes));
    VOLUTE_TRY(need(part.size()));
    VOLUTE_TRY(file_.read(at_, part));
    at_ += part.size();
    Count value = 0;
    for (const std::byte byte : part) value = value << 8 | std::to_integer<Count>(byte);
    return value;
  }

  Count place() const { return at_; }

  /// A count: of 8 bytes in CDF-5.
  Result<Count> count() { return number(wide_ ? 8 : 4); }

  Status skip(Count bytes) {
    VOLUTE_TRY(need(bytes));
    at_ += bytes;
    return {};
  }

  /// What is printed of it.
  Result<std::string> name() {
    constexpr Count kMax = 64;
    VOLUTE_ASSIGN(const Count length, count());
    VOLUTE_TRY(need(padded(length)));
    std::string text(std::min(length, kMax), ' ');
    VOLUTE_TRY(file_.read(at_, std::as_writable_bytes(std::span(text))));
    at_ += padded(length);
    std::ranges::replace_if(text, [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
    return text;
  }

  Status skipName() {
    VOLUTE_ASSIGN(const Count length, count());
    return skip(padded(length));
  }

  /// The number of entries of a list; each takes some bytes of the file.
  Result<Count> listLength(Count tag, const char* what) {
    VOLUTE_ASSIGN(const Count found, number(4));
    VOLUTE_ASSIGN(const Count length, count());
    if (found == tag || (found == 0 && length == 0)) {
      VOLUTE_TRY(need(length));
      return length;
    }
    return fail(ErrorCode::kInvalidData,
                "{}: damaged header at byte {}: expected the list of {} (tag {}), found {} of "
                "tag {}",
                file_.path().string(), at_, what, tag, length, found);
  }

  Result<Count> sizeOfType() {
    VOLUTE_ASSIGN(const Count type, number(4));
    static constexpr Count kSizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    if (type >= 1 && type < std::size(kSizes))
      return kSizes[type];
    return fail(ErrorCode::kInvalidData,
                "{}: damaged header at byte {}: values of type {}; expected 1 to 11",
                file_.path().string(), at_, type);
  }

  Status skipAttributes() {
    constexpr Count kTag = 12;
    VOLUTE_ASSIGN(const Count attributes, listLength(kTag, "attributes"));
    for (Count i = 0; i < attributes; ++i) {
      VOLUTE_TRY(skipName());
      VOLUTE_ASSIGN(const Count size, sizeOfType());
      VOLUTE_ASSIGN(const Count length, count());
      VOLUTE_TRY(skip(padded(times(length, size))));
    }
    return {};
  }

 private:
  Status need(Count bytes) const {
    if (plus(at_, bytes) > file_.size())
      return truncated(file_, plus(at_, bytes));
    return {};
  }

  const InputFile& file_;
  bool wide_;
  Count at_ = 4;
};

struct Variable {
  std::string name;
  bool ofRecords = false;
  Count bytes = 0;  ///< of one record, or of all
  Count begin = 0;
};

/// Values lie behind the header, no two variables' at one place: first those that are there once,
/// then a record of all the others after another.
Status checkPlaces(std::vector<Variable> variables, Count headerEnd, const std::string& name) {
  std::erase_if(variables, [](const Variable& variable) { return variable.bytes == 0; });
  std::ranges::sort(variables, {}, &Variable::begin);
  Count end = headerEnd;
  bool records = false;
  const Variable* before = nullptr;
  for (const Variable& variable : variables) {
    if (variable.begin < end) {
      return fail(ErrorCode::kInvalidData,
                  "{}: damaged header: the values of '{}' begin at byte {}, within {} that ends at "
                  "byte {}; copy the file again",
                  name, variable.name, variable.begin,
                  before ? fmt::format("those of '{}'", before->name) : "the header", end);
    }
    if (records && !variable.ofRecords) {
      return fail(ErrorCode::kInvalidData,
                  "{}: damaged header: the values of '{}' begin at byte {}, behind '{}', which "
                  "changes with time; copy the file again",
                  name, variable.name, variable.begin, before->name);
    }
    records = variable.ofRecords;
    end = plus(variable.begin, variable.bytes);
    before = &variable;
  }
  return {};
}

Status checkClassic(const InputFile& file, int version) {
  constexpr Count kDimensions = 10, kVariables = 11;
  const std::string name = file.path().string();
  HeaderReader header(file, version == 5);
  VOLUTE_ASSIGN(const Count records, header.count());
  if (records == (version == 5 ? ~Count{0} : Count{0xFFFFFFFF})) {
    return fail(ErrorCode::kInvalidData,
                "{}: does not say how many instants it has: its writer was stopped; expected a "
                "file that was closed",
                name);
  }
  VOLUTE_ASSIGN(const Count dimensionCount, header.listLength(kDimensions, "dimensions"));
  std::vector<Count> dimensions;
  for (Count i = 0; i < dimensionCount; ++i) {
    VOLUTE_TRY(header.skipName());
    VOLUTE_ASSIGN(const Count length, header.count());
    dimensions.push_back(length);
  }
  VOLUTE_TRY(header.skipAttributes());
  VOLUTE_ASSIGN(const Count variableCount, header.listLength(kVariables, "variables"));
  std::vector<Variable> variables;
  for (Count i = 0; i < variableCount; ++i) {
    Variable& variable = variables.emplace_back();
    VOLUTE_ASSIGN(variable.name, header.name());
    VOLUTE_ASSIGN(const Count rank, header.count());
    Count values = 1;
    for (Count k = 0; k < rank; ++k) {
      VOLUTE_ASSIGN(const Count dimension, header.count());
      if (dimension >= dimensions.size()) {
        return fail(ErrorCode::kInvalidData,
                    "{}: damaged header: variable {} has dimension {}; there are {}", name, i,
                    dimension, dimensions.size());
      }
      if (k == 0 && dimensions[dimension] == 0)
        variable.ofRecords = true;
      else
        values = times(values, dimensions[dimension]);
    }
    VOLUTE_TRY(header.skipAttributes());
    VOLUTE_ASSIGN(const Count size, header.sizeOfType());
    VOLUTE_TRY(header.count());  // the same as bytes, where that is small enough
    VOLUTE_ASSIGN(variable.begin, header.number(version == 1 ? 4 : 8));
    variable.bytes = times(values, size);
  }
  VOLUTE_TRY(checkPlaces(variables, header.place(), name));
  // A lone variable of records is not padded between them.
  const bool lone = std::ranges::count(variables, true, &Variable::ofRecords) == 1;
  Count record = 0;
  for (const Variable& variable : variables) {
    if (variable.ofRecords)
      record = plus(record, lone ? variable.bytes : padded(variable.bytes));
  }
  Count expected = 0;
  for (const Variable& variable : variables) {
    if (variable.bytes == 0 || (variable.ofRecords && records == 0))
      continue;
    const Count before = variable.ofRecords ? times(records - 1, record) : 0;
    expected = std::max(expected, plus(plus(variable.begin, before), variable.bytes));
  }
  if (file.size() < expected)
    return truncated(file, expected);
  return {};
}

/// The address of the end in the superblock at the file's start.
Status checkHdf5(const InputFile& file) {
  std::array<std::byte, 64> head{};
  const auto present = std::min<std::size_t>(head.size(), file.size());
  VOLUTE_TRY(file.read(0, std::span(head).first(present)));
  constexpr std::size_t kWidths = 16;  // up to here they are all alike
  if (present < kWidths)
    return truncated(file, kWidths);
  const auto number = [&](std::size_t at, std::size_t bytes) {
    Count value = 0;
    for (std::size_t i = bytes; i-- > 0;) value = value << 8 | std::to_integer<Count>(head[at + i]);
    return value;
  };
  const Count version = number(8, 1);
  const Count width = number(version < 2 ? 13 : 9, 1);  // of an address
  if (version > 3 || width < 2 || width > 8)
    return {};  // the library says that it does not know it
  const std::size_t base = version == 0 ? 24 : version == 1 ? 28 : 12;
  if (present < base + 3 * width)
    return truncated(file, base + 3 * width);
  const Count end = number(base + 2 * width, width);
  if (file.size() < end)
    return truncated(file, end);
  return {};
}

}  // namespace

Status checkNetcdfLength(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::array<std::byte, 4> magic{};
  if (file.size() < magic.size()) {
    return fail(ErrorCode::kTruncated, "{}: has {} bytes; expected an Exodus (netCDF) file",
                path.string(), file.size());
  }
  VOLUTE_TRY(file.read(0, magic));
  const std::string text(reinterpret_cast<const char*>(magic.data()), magic.size());
  const int version = text[3];
  if (text.starts_with("CDF") && (version == 1 || version == 2 || version == 5))
    return checkClassic(file, version);
  if (text == "\x89HDF")
    return checkHdf5(file);
  return fail(ErrorCode::kInvalidData,
              "{}: is no Exodus file: it begins with neither CDF (netCDF classic) nor the "
              "signature of HDF5 (netCDF-4)",
              path.string());
}

}  // namespace volute
