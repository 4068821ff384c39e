// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/lattice_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "volute/io/reader_process.hpp"

namespace volute::detail {
namespace {

/// Texts of any length in a message, each after its length.
std::string texts(std::initializer_list<std::string_view> parts) {
  std::string message;
  for (const std::string_view part : parts) {
    message += toMessage(static_cast<std::uint32_t>(part.size()));
    message += part;
  }
  return message;
}

/// Takes the next text off a message; none where it is cut short.
std::optional<std::string_view> nextText(std::string_view& message) {
  std::uint32_t size = 0;
  if (message.size() < sizeof size)
    return std::nullopt;
  std::memcpy(&size, message.data(), sizeof size);
  message.remove_prefix(sizeof size);
  if (size > message.size())
    return std::nullopt;
  const auto part = message.substr(0, size);
  message.remove_prefix(size);
  return part;
}

std::string encodeMetadata(const MetadataList& list) {
  std::string message;
  for (const GridMetadata& entry : list) message += texts({entry.name, entry.type, entry.value});
  return message;
}

bool decodeMetadata(std::string_view message, MetadataList& list) {
  while (!message.empty()) {
    GridMetadata& entry = list.emplace_back();
    for (std::string* text : {&entry.name, &entry.type, &entry.value}) {
      const auto part = nextText(message);
      if (!part)
        return false;
      *text = *part;
    }
  }
  return true;
}

/// What came from the process that reads the file, before anything is made of it.
Status checkFrame(LatticeFrame& frame, const std::string& file) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  frame.grid[LatticeFrame::kMaxName] = '\0';
  frame.others[LatticeFrame::kMaxName] = '\0';
  frame.leftOut[LatticeFrame::kMaxName] = '\0';
  frame.writer[LatticeFrame::kMaxWriter] = frame.gridClass[LatticeFrame::kMaxWriter] = '\0';
  frame.unit[LatticeFrame::kMaxUnit] = '\0';
  settleFlag(frame.bricks);
  settleFlag(frame.turned);
  settleFlag(frame.vectors.local);
  bool sound = frame.channels == 1 || frame.channels == 3;
  for (int axis = 0; axis < 3; ++axis) {
    sound = sound && std::isfinite(frame.origin[axis]) && std::isfinite(frame.voxelSize[axis]) &&
            frame.voxelSize[axis] > 0;
    for (const std::int64_t index : {frame.box.begin[axis], frame.box.end[axis]})
      sound = sound && index > -kFarthest && index < kFarthest;
  }
  sound = sound && frame.vectors.type <= VectorKind::Type::kContravariantAbsolute &&
          frame.vectors.type >= VectorKind::Type::kUnstated;
  if (sound && (!frame.turned || isSound(frame.matrix)))
    return {};
  return fail(ErrorCode::kInvalidData, "{}: its reader describes a grid that cannot be", file);
}

}  // namespace

std::string encodeCache(const LatticeCache& cache) {
  std::string message = texts({encodeMetadata(cache.metadata)});
  for (const LatticeGrid& grid : cache.grids)
    message +=
        texts({toMessage(grid.frame), toMessage(grid.traits), encodeMetadata(grid.metadata)});
  return message;
}

Result<LatticeCache> decodeCache(std::string_view message, const std::string& file) {
  const auto cut = [&] {
    return fail(ErrorCode::kInvalidData, "{}: the description of its grids is cut short", file);
  };
  LatticeCache cache;
  const auto ofFile = nextText(message);
  if (!ofFile || !decodeMetadata(*ofFile, cache.metadata))
    return cut();
  while (!message.empty()) {
    const auto frame = nextText(message);
    const auto traits = frame ? nextText(message) : std::nullopt;
    const auto metadata = traits ? nextText(message) : std::nullopt;
    LatticeGrid& grid = cache.grids.emplace_back();
    if (!metadata || !decodeMetadata(*metadata, grid.metadata))
      return cut();
    VOLUTE_ASSIGN(grid.frame, fromMessage<LatticeFrame>(*frame));
    VOLUTE_ASSIGN(grid.traits, fromMessage<GridTraits>(*traits));
    for (char* end :
         {&grid.frame.grid[LatticeFrame::kMaxName], &grid.frame.others[LatticeFrame::kMaxName],
          &grid.frame.leftOut[LatticeFrame::kMaxName], &grid.traits.type[GridTraits::kMaxText],
          &grid.traits.gridClass[GridTraits::kMaxText], &grid.traits.map[GridTraits::kMaxText],
          &grid.traits.problem[GridTraits::kMaxProblem]})
      *end = '\0';
    settleFlag(grid.traits.half);
    if (grid.traits.problem[0] == '\0')
      VOLUTE_TRY(checkFrame(grid.frame, file));
  }
  return cache;
}

Result<LatticeFrame> decodeFrame(std::string_view message, const std::string& file) {
  VOLUTE_ASSIGN(auto frame, fromMessage<LatticeFrame>(message));
  VOLUTE_TRY(checkFrame(frame, file));
  return frame;
}

std::string encodeGridFacts(const std::vector<GridFacts>& grids) {
  std::string message;
  for (const GridFacts& grid : grids) {
    if (message.size() + sizeof(GridFacts) <= ReaderProcess::kMaxMessage)
      message += toMessage(grid);
  }
  return message;
}

Result<std::vector<GridFacts>> decodeGridFacts(std::string_view message) {
  std::vector<GridFacts> grids;
  for (; !message.empty(); message.remove_prefix(sizeof(GridFacts))) {
    VOLUTE_ASSIGN(auto grid, fromMessage<GridFacts>(message.substr(0, sizeof(GridFacts))));
    grid.name[GridFacts::kMaxName] = '\0';
    grid.type[GridFacts::kMaxType] = grid.gridClass[GridFacts::kMaxType] = '\0';
    settleFlag(grid.half);
    settleFlag(grid.frustum);
    settleFlag(grid.readable);
    grids.push_back(grid);
  }
  return grids;
}

std::string encodeFiles(const std::vector<TimedFile>& files) {
  std::string message;
  for (const TimedFile& file : files) message += toMessage(file.time) + file.path.string() + '\0';
  return message;
}

Result<std::vector<TimedFile>> decodeFiles(std::string_view message,
                                           const std::string& collection) {
  std::vector<TimedFile> files;
  for (std::size_t at = 0; at < message.size();) {
    const auto end = message.find('\0', at + sizeof(double));
    const std::string_view entry = message.substr(at, end - at);
    VOLUTE_ASSIGN(const auto time, fromMessage<double>(entry.substr(0, sizeof(double))));
    if (end == std::string_view::npos || entry.size() == sizeof(double)) {
      return fail(ErrorCode::kInvalidData, "{}: the list of its files is cut short", collection);
    }
    files.push_back({time, std::string(entry.substr(sizeof(double)))});
    at = end + 1;
  }
  return files;
}

}  // namespace volute::detail
