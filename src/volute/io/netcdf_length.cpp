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
  return a != 0 && b > kHuge / a ? kHuge : std::min(kHuge, a * b);
}

Count plus(Count a, Count b) {
  return std::min(kHuge, std::min(kHuge, a) + std::min(kHuge, b));
}

Count padded(Count bytes) {
  return plus(bytes, 3) / 4 * 4;
}

struct Variable {
  bool ofRecords = false;
  Count bytes = 0;  ///< of one record, or of all
  Count begin = 0;
};

/// The header of a classic file, read from its start, in big-endian order. What lies beyond the
/// file's end is 0, and ends every list.
class Header {
 public:
  Header(const InputFile& file, int version) : file_(file), version_(version) {
    records_ = count();
    (void)number(4);  // the list's tag
    std::vector<Count> dimensions;
    for (Count left = count(); left > 0 && isWhole(); --left) {
      skipName();
      dimensions.push_back(count());
    }
    skipAttributes();
    (void)number(4);
    for (Count left = count(); left > 0 && isWhole(); --left) {
      Variable& variable = variables_.emplace_back();
      skipName();
      Count values = 1;
      const Count rank = count();
      for (Count k = 0; k < rank && isWhole(); ++k) {
        const Count index = count();
        const Count length = index < dimensions.size() ? dimensions[index] : 0;
        if (k == 0 && length == 0)
          variable.ofRecords = true;
        else
          values = times(values, length);
      }
      skipAttributes();
      variable.bytes = times(values, valueSize());
      (void)count();  // the same as bytes, where that is small enough
      variable.begin = number(version_ == 1 ? 4 : 8);
    }
  }

  /// Of a file whose writer was stopped.
  bool isOpen() const { return records_ == (version_ == 5 ? ~Count{0} : Count{0xFFFFFFFF}); }

  /// Where the values end that it announces.
  Count end() const {
    // A lone variable of records is not padded between them.
    const bool lone = std::ranges::count(variables_, true, &Variable::ofRecords) == 1;
    Count record = 0, end = at_;
    for (const Variable& v : variables_) {
      if (v.ofRecords)
        record = plus(record, lone ? v.bytes : padded(v.bytes));
    }
    for (const Variable& v : variables_) {
      if (v.bytes > 0 && (!v.ofRecords || records_ > 0))
        end = std::max(end,
                       plus(plus(v.begin, v.ofRecords ? times(records_ - 1, record) : 0), v.bytes));
    }
    return end;
  }

 private:
  bool isWhole() const { return at_ <= file_.size(); }

  /// Of `bytes` bytes, at most 8.
  Count number(std::size_t bytes) {
    std::array<std::byte, 8> raw{};
    const Count from = at_;
    at_ = plus(at_, bytes);
    if (!isWhole() || !file_.read(from, std::span(raw).first(bytes)))
      return 0;
    Count value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | std::to_integer<Count>(raw[i]);
    return value;
  }

  /// Of 8 bytes in CDF-5.
  Count count() { return number(version_ == 5 ? 8 : 4); }

  void skipName() {
    const Count length = count();
    at_ = plus(at_, padded(length));
  }

  Count valueSize() {
    static constexpr Count kSizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    const Count type = number(4);
    return type < std::size(kSizes) ? kSizes[type] : 0;
  }

  void skipAttributes() {
    (void)number(4);
    for (Count left = count(); left > 0 && isWhole(); --left) {
      skipName();
      const Count size = valueSize(), length = count();
      at_ = plus(at_, padded(times(length, size)));
    }
  }

  const InputFile& file_;
  int version_;
  Count at_ = 4;
  Count records_ = 0;
  std::vector<Variable> variables_;
};

}  // namespace

Status checkNetcdfLength(const std::filesystem::path& path, bool others) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::array<char, 4> magic{};
  if (file.size() >= magic.size())
    VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(magic))));
  const std::string_view text(magic.data(), magic.size());
  if (text == "\x89HDF" || (others && !text.starts_with("CDF")))
    return {};  // the library finds what is missing
  const auto version = static_cast<unsigned char>(text[3]);
  if (!text.starts_with("CDF") || (version != 1 && version != 2 && version != 5)) {
    return fail(file.size() < magic.size() ? ErrorCode::kTruncated : ErrorCode::kInvalidData,
                "{}: begins with neither CDF (netCDF classic) nor the signature of HDF5; expected "
                "a netCDF, Exodus or HDF5 file",
                path.string());
  }
  const Header header(file, version);
  if (header.isOpen()) {
    return fail(ErrorCode::kInvalidData,
                "{}: does not say how many instants it has: its writer was stopped; expected a "
                "file that was closed",
                path.string());
  }
  if (file.size() >= header.end())
    return {};
  return fail(ErrorCode::kTruncated,
              "{}: has {} bytes; its header says at least {}: the end is missing; copy the file "
              "again or write it anew",
              path.string(), file.size(), header.end());
}

}  // namespace volute
