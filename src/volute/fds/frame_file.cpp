// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/frame_file.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "volute/fds/frame_scan.hpp"
#include "volute/fds/text_lines.hpp"

namespace volute {
namespace {

Status checkFdsLabel(const FortranFile& file, std::uint64_t offset, std::span<const char> found,
                     std::string_view expected, std::string_view what) {
  const std::string_view text(found.data(), found.size());
  const std::string_view stated = text.substr(0, text.find_last_not_of(' ') + 1);
  if (stated == trimmed(expected.substr(0, kFdsLabel)))
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}: byte {}: the {} is '{}', the .smv file says '{}': damaged, or of another run",
              file.path().string(), offset + 4, what, stated, expected);
}

std::array<std::int32_t, 3> nodesOf(const FdsMesh& mesh) {
  return {mesh.cells(0) + 1, mesh.cells(1) + 1, mesh.cells(2) + 1};
}

/// Each header word must be what the mesh and the format say.
template <std::size_t N>
Status checkHeader(const FortranFile& file, const std::array<std::int32_t, N>& found,
                   const std::array<std::int32_t, N>& expected) {
  for (std::size_t i = 0; i < N; ++i) {
    if (found[i] != expected[i]) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: word {} of the header is {}, expected {}: damaged, or not of this "
                  "mesh",
                  file.path().string(), 4 + 4 * i, i + 1, found[i], expected[i]);
    }
  }
  return {};
}

}  // namespace

Result<FdsSliceFile> FdsSliceFile::open(const FdsSliceEntry& entry, const FdsMesh& mesh) {
  VOLUTE_ASSIGN(auto file, FortranFile::open(entry.file));
  const std::array<std::pair<const std::string*, const char*>, 3> labels = {
      {{&entry.labels.quantity, "quantity"},
       {&entry.labels.shortName, "short name"},
       {&entry.labels.unit, "unit"}}};
  std::uint64_t offset = 0;
  for (const auto& [expected, what] : labels) {
    std::array<char, kFdsLabel> text{};
    const std::uint64_t begin = offset;
    VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(text), what));
    VOLUTE_TRY(checkFdsLabel(file, begin, text, *expected, what));
  }
  std::array<std::int32_t, 6> words{};
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(words), "the slice's indices"));
  FdsNodeBox nodes;
  std::size_t values = 1;
  for (int axis = 0; axis < 3; ++axis) {
    nodes.begin[axis] = words[2 * axis];
    nodes.end[axis] = words[2 * axis + 1];
    if (nodes.begin[axis] < 0 || nodes.begin[axis] > nodes.end[axis] ||
        nodes.end[axis] > mesh.cells(axis)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: indices {} to {} on axis {} of a mesh with {} cells: the file is "
                  "damaged",
                  file.path().string(), begin + 4 + 8 * axis, nodes.begin[axis], nodes.end[axis],
                  "xyz"[axis], mesh.cells(axis));
    }
    values *= static_cast<std::size_t>(nodes.end[axis] - nodes.begin[axis]) + 1;
  }
  if (entry.nodes && *entry.nodes != nodes) {
    return fail(ErrorCode::kInvalidData,
                "{}: byte {}: the indices are not those of the .smv file: damaged, or of another "
                "run",
                file.path().string(), begin + 4);
  }
  FdsSliceFile slice(std::move(file), nodes, values);
  VOLUTE_TRY(slice.findFrames(offset));
  return slice;
}

Status FdsSliceFile::findFrames(std::uint64_t offset) {
  return scanFrames(
      file_, offset, frames_, [&](std::uint64_t& place, std::size_t frame) -> Result<double> {
        VOLUTE_ASSIGN(const double time, readTime(file_, place, frame));
        VOLUTE_ASSIGN(place, file_.skip(place, 4 * values_, frameName("values", frame)));
        return time;
      });
}

Status FdsSliceFile::readFrame(std::size_t frame, std::span<float> out) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_TRY(readTime(file_, offset, frame));
  VOLUTE_TRY(file_.readInto(offset, out, frameName("values", frame)));
  return {};
}

Result<FdsSmokeFile> FdsSmokeFile::open(const std::filesystem::path& path, const FdsMesh& mesh) {
  VOLUTE_ASSIGN(auto file, FortranFile::open(path));
  std::array<std::int32_t, 8> words{};
  VOLUTE_ASSIGN(const std::uint64_t offset, file.readInto(0, std::span(words), "the header"));
  // FDS calls the same layout 0 or 1; in version 2 frames have their own largest values.
  constexpr int kLikely = 9;
  if (words[0] == 1 && words[1] > 1 && words[1] <= kLikely) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: byte 8: version {} of 3D smoke; expected 0 or 1: let FDS write SMOKE3D_VERSION=1, or "
        "slices of EXTINCTION COEFFICIENT",
        path.string(), words[1]);
  }
  VOLUTE_TRY(checkHeader<8>(
      file, words,
      {1, words[1] == 1 ? 1 : 0, 0, mesh.cells(0), 0, mesh.cells(1), 0, mesh.cells(2)}));
  FdsSmokeFile smoke(std::move(file), mesh.nodeCount());
  VOLUTE_TRY(smoke.findFrames(offset));
  return smoke;
}

Status FdsSmokeFile::findFrames(std::uint64_t offset) {
  return scanFrames(
      file_, offset, frames_, [&](std::uint64_t& place, std::size_t frame) -> Result<double> {
        VOLUTE_ASSIGN(const double time, readTime(file_, place, frame));
        std::array<std::int32_t, 2> sizes{};
        const std::uint64_t begin = place;
        VOLUTE_ASSIGN(place, file_.readInto(place, std::span(sizes), frameName("sizes", frame)));
        // A run of 3 bytes stands for 254 values at most; no code is longer than its values by
        // much.
        const auto coded = static_cast<std::uint64_t>(sizes[1]);
        if (static_cast<std::uint64_t>(sizes[0]) != values_ || sizes[1] < 0 ||
            values_ > 85 * coded) {
          return fail(ErrorCode::kInvalidData,
                      "{}: byte {}: frame {} has {} values in {} bytes, expected {} values: the "
                      "file is damaged",
                      file_.path().string(), begin + 4, frame, sizes[0], sizes[1], values_);
        }
        VOLUTE_ASSIGN(place, file_.skip(place, coded, frameName("code", frame)));
        return time;
      });
}

tl::expected<void, std::size_t> decodeRuns(std::span<const std::uint8_t> code,
                                           std::span<std::uint8_t> out) {
  constexpr std::uint8_t kRun = 255;
  std::size_t filled = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] != kRun) {
      if (filled == out.size())
        return tl::unexpected(i);
      out[filled++] = code[i];
      continue;
    }
    if (i + 2 >= code.size())
      return tl::unexpected(i);
    const std::uint8_t value = code[i + 1];
    const std::size_t count = code[i + 2];
    if (value == kRun || count == 0 || count == kRun || count > out.size() - filled)
      return tl::unexpected(i);
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(filled), count, value);
    filled += count;
    i += 2;
  }
  if (filled != out.size())
    return tl::unexpected(code.size());
  return {};
}

Status FdsSmokeFile::readBytes(std::size_t frame, std::span<std::uint8_t> out) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_TRY(readTime(file_, offset, frame));
  std::array<std::int32_t, 2> sizes{};
  VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(sizes), frameName("sizes", frame)));
  std::vector<std::uint8_t> code(static_cast<std::size_t>(std::max(sizes[1], 0)));
  VOLUTE_TRY(file_.readInto(offset, std::span(code), frameName("code", frame)));
  if (const auto decoded = decodeRuns(code, out); !decoded) {
    return fail(ErrorCode::kInvalidData,
                "{}: byte {}: the run-length code of frame {} (t = {} s) does not give {} values: "
                "the file is damaged",
                file_.path().string(), offset + 4 + decoded.error(), frame, frames_.times[frame],
                values_);
  }
  return {};
}

Status FdsSmokeFile::readFrame(std::size_t frame, std::span<float> out) const {
  std::vector<std::uint8_t> bytes(values_);
  VOLUTE_TRY(readBytes(frame, bytes));
  std::copy(bytes.begin(), bytes.end(), out.begin());
  return {};
}

namespace {

/// Of words, which FDS cuts off. Where all values of a frame are one, it writes a range of 1 and
/// words of 0, which are exact.
double stepOf(float least, float most) {
  return most == least + 1.0F ? 0 : (static_cast<double>(most) - least) / 65535;
}

}  // namespace

Result<FdsSmoke16File> FdsSmoke16File::open(const std::filesystem::path& path,
                                            const FdsMesh& mesh) {
  VOLUTE_ASSIGN(auto file, FortranFile::open(path));
  std::array<std::int32_t, 6> words{};
  VOLUTE_ASSIGN(const std::uint64_t offset, file.readInto(0, std::span(words), "the header"));
  const auto nodes = nodesOf(mesh);
  VOLUTE_TRY(checkHeader<6>(file, words, {1, 1, 0, nodes[0], nodes[1], nodes[2]}));
  FdsSmoke16File smoke(std::move(file), mesh.nodeCount());
  VOLUTE_TRY(smoke.findFrames(offset));
  return smoke;
}

Result<FdsSmoke16File::FrameHead> FdsSmoke16File::readHead(std::uint64_t& offset,
                                                           const std::string& what) const {
  FrameHead head;
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(&head, 1), what));
  const auto number = static_cast<std::uint64_t>(head.values);
  if (number != values_ || head.stored != head.values || !std::isfinite(head.least) ||
      !std::isfinite(head.most) || head.least > head.most) {
    return fail(ErrorCode::kInvalidData,
                "{}: byte {}: {}: {} values from {} to {}, expected {}: the file is damaged",
                file_.path().string(), begin + 4, what, head.values, head.least, head.most,
                values_);
  }
  return head;
}

Status FdsSmoke16File::findFrames(std::uint64_t offset) {
  return scanFrames(
      file_, offset, frames_, [&](std::uint64_t& place, std::size_t frame) -> Result<double> {
        VOLUTE_ASSIGN(const double time, readTime(file_, place, frame));
        VOLUTE_TRY(readHead(place, frameName("range", frame)));
        VOLUTE_ASSIGN(place, file_.skip(place, 2 * values_, frameName("values", frame)));
        return time;
      });
}

Status FdsSmoke16File::readFrame(std::size_t frame, std::span<float> out) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_TRY(readTime(file_, offset, frame));
  VOLUTE_ASSIGN(const FrameHead head, readHead(offset, frameName("range", frame)));
  std::vector<std::uint8_t> bytes(2 * values_);
  VOLUTE_TRY(file_.readInto(offset, std::span(bytes), frameName("values", frame)));
  const double step = stepOf(head.least, head.most);
  for (std::size_t i = 0; i < values_; ++i) {
    const int stored = 256 * bytes[2 * i] + bytes[2 * i + 1];
    out[i] = static_cast<float>(head.least + step * stored);
  }
  return {};
}

Result<double> FdsSmoke16File::step(std::size_t frame) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_TRY(readTime(file_, offset, frame));
  VOLUTE_ASSIGN(const FrameHead head, readHead(offset, frameName("range", frame)));
  return stepOf(head.least, head.most);
}

Result<FdsPlotFiles> FdsPlotFiles::open(std::span<const FdsPlotEntry> entries,
                                        std::span<const std::size_t> variables,
                                        const FdsMesh& mesh) {
  FdsPlotFiles plots(mesh);
  plots.nodes_ = nodesOf(mesh);
  std::optional<Error> missing;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const FdsPlotEntry& entry = entries[i];
    auto opened = FortranFile::open(entry.file);
    if (!opened && opened.error().code == ErrorCode::kNotFound) {
      plots.frames_.remarks.push_back(
          {RemarkCode::kDamaged, opened.error().message + ": its time is left out"});
      missing = opened.error();
      continue;
    }
    VOLUTE_ASSIGN(const auto file, std::move(opened));
    const auto check = [&]() -> Status {
      std::array<std::int32_t, 3> words{};
      VOLUTE_ASSIGN(std::uint64_t offset, file.readInto(0, std::span(words), "the header"));
      VOLUTE_TRY(checkHeader<3>(file, words, plots.nodes_));
      std::array<std::int32_t, 4> zeros{};
      const std::uint64_t begin = offset;
      VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(zeros), "the second header"));
      if (zeros != std::array<std::int32_t, 4>{}) {
        return fail(ErrorCode::kInvalidData,
                    "{}: byte {}: the second header is not all zero: the file is damaged",
                    file.path().string(), begin + 4);
      }
      VOLUTE_ASSIGN(offset, file.skip(offset, 20 * plots.values_, "the values"));
      if (offset != file.size()) {
        return fail(ErrorCode::kInvalidData, "{}: byte {}: {} bytes too many: the file is damaged",
                    file.path().string(), offset, file.size() - offset);
      }
      return {};
    };
    const Status status = check();
    if (!status && status.error().code == ErrorCode::kTruncated) {
      plots.frames_.remarks.push_back(
          {RemarkCode::kDamaged, status.error().message + ": its time is left out"});
      continue;
    }
    VOLUTE_TRY(status);
    plots.frames_.add(entry.time, plots.files_.size(), entry.file.string());
    plots.files_.emplace_back(entry.file, variables[i]);
  }
  if (plots.files_.empty() && missing)
    return tl::unexpected<Error>(*missing);
  return plots;
}

Status FdsPlotFiles::readFrame(std::size_t frame, std::span<float> out) const {
  const auto& [path, variable] = files_[frames_.offsets[frame]];
  VOLUTE_ASSIGN(const auto file, FortranFile::open(path));
  std::uint64_t offset = 0;
  VOLUTE_ASSIGN(offset, file.skip(offset, sizeof(nodes_), "the header"));
  VOLUTE_ASSIGN(offset, file.skip(offset, 16, "the second header"));
  std::vector<float> all(5 * values_);
  VOLUTE_TRY(file.readInto(offset, std::span(all), "the values"));
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(variable * values_);
  std::copy_n(begin, values_, out.begin());
  return {};
}

std::vector<FdsSizeRow> readSizeFile(const std::filesystem::path& path) {
  std::vector<FdsSizeRow> rows;
  auto lines = TextLines::open(path);
  if (!lines)
    return rows;
  for (bool first = true;; first = false) {
    const auto line = lines->next();
    if (!line || !*line)
      return rows;
    FdsSizeRow row;
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
    for (const auto word : words(**line)) {
      const auto number = numberOf(word);
      if (!number)
        break;
      row.columns.push_back(*number);
    }
    if (first && row.columns.size() == 1)
      continue;
    if (row.columns.size() < 3)
      continue;
    row.time = row.columns.front();
    row.columns.erase(row.columns.begin());
    rows.push_back(std::move(row));
  }
}

}  // namespace volute
