// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/mesh_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "volute/base/assert.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/mesh.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"

namespace volute {
namespace {

/// Goes through an array of bytes, writing to it or reading from it.
struct Bytes {
  std::byte* at;

  template <class T>
  void put(const std::vector<T>& from) {
    std::memcpy(at, from.data(), from.size() * sizeof(T));
    at += from.size() * sizeof(T);
  }

  template <class T>
  void get(std::vector<T>& to, std::uint64_t count) {
    to.resize(count);
    std::memcpy(static_cast<void*>(to.data()), at, count * sizeof(T));
    at += count * sizeof(T);
  }
};

std::size_t floatsFor(const MeshSize& size) {
  const std::uint64_t bytes = size.points * sizeof(Vec3) + size.cells * sizeof(CellShape) +
                              (size.cells + 1 + size.indices) * sizeof(std::int64_t) +
                              size.values() * sizeof(float);
  return (bytes + sizeof(float) - 1) / sizeof(float);
}

constexpr std::string_view kTimes = "times", kTake = "take";  // requests; others are instants

/// The child's side: it is asked for the instants, or for one of them: how much it is, then the
/// thing itself.
ReaderProcess::Serve makeServe(const std::filesystem::path& file, const std::string& field) {
  return [file, field, reader = std::shared_ptr<MeshReader>()](
             std::string_view request, std::span<float> values) mutable -> Result<std::string> {
    if (!reader) {
      VOLUTE_ASSIGN(const MeshPlugin* plugin, loadVtkMeshPlugin());
      reader = plugin->makeReader();
    }
    if (request == kTimes) {
      VOLUTE_ASSIGN(const std::vector<double> times, reader->times(file));
      return std::string(reinterpret_cast<const char*>(times.data()),
                         times.size() * sizeof(double));
    }
    if (request != kTake) {
      std::size_t instant = 0;
      std::from_chars(request.data(), request.data() + request.size(), instant);
      VOLUTE_ASSIGN(const MeshSize size, reader->load(file, instant, field));
      return toMessage(size);
    }
    VOLUTE_ASSIGN(const MeshData data, reader->take());
    Bytes bytes{reinterpret_cast<std::byte*>(values.data())};
    bytes.put(data.soup.vertices);
    bytes.put(data.soup.offsets);
    bytes.put(data.soup.connectivity);
    bytes.put(data.values);
    bytes.put(data.soup.shapes);
    return std::string();
  };
}

/// A case may be spread over files that only its reader knows.
double secondsFor(const std::filesystem::path& path, std::uint64_t fileSize) {
  return (isMeshCase(path) ? 60 : 10) + 1e-6 * static_cast<double>(fileSize);
}

Result<std::uint64_t> sizeOf(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) {
    return fail(ErrorCode::kNotFound, "{}: cannot be read: {}", path.string(), error.message());
  }
  return size;
}

Result<std::vector<double>> readTimes(const std::filesystem::path& path,
                                      const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const std::uint64_t fileSize, sizeOf(path));
  ReaderProcess process(makeServe(path, options.field));
  const ReaderProcess::Limits limits{options.maxMemory, secondsFor(path, fileSize)};
  VOLUTE_ASSIGN(const std::string reply, process.call(file, kTimes, 0, limits));
  if (reply.size() >= ReaderProcess::kMaxMessage) {
    return fail(ErrorCode::kTooLarge, "{}: has {} instants or more; expected fewer: split the case",
                file, reply.size() / sizeof(double));
  }
  std::vector<double> times(reply.size() / sizeof(double));
  std::memcpy(times.data(), reply.data(), times.size() * sizeof(double));
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1])) {
      return fail(ErrorCode::kInvalidData, "{}: instant {} is at {} s; expected ascending times",
                  file, i, times[i]);
    }
  }
  if (times.empty())
    return fail(ErrorCode::kInvalidData, "{}: has no instants", file);
  return times;
}

Result<MeshData> readMesh(const std::filesystem::path& path, std::size_t instant,
                          const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const std::uint64_t fileSize, sizeOf(path));
  ReaderProcess process(makeServe(path, options.field));
  const ReaderProcess::Limits limits{options.maxMemory, secondsFor(path, fileSize)};
  VOLUTE_ASSIGN(const std::string reply, process.call(file, fmt::format("{}", instant), 0, limits));
  VOLUTE_ASSIGN(const auto size, fromMessage<MeshSize>(reply));
  VOLUTE_TRY(process.call(file, kTake, floatsFor(size), limits));
  MeshData data;
  data.ofCells = size.ofCells;
  data.field = size.field;
  // Copied out of memory that is shared read-write; nothing is written through it here.
  Bytes bytes{reinterpret_cast<std::byte*>(const_cast<float*>(process.values().data()))};
  bytes.get(data.soup.vertices, size.points);
  bytes.get(data.soup.offsets, size.cells + 1);
  bytes.get(data.soup.connectivity, size.indices);
  bytes.get(data.values, size.values());
  bytes.get(data.soup.shapes, size.cells);
  return data;
}

}  // namespace

bool isMeshCase(const std::filesystem::path& path) {
  static constexpr std::string_view kExtensions[] = {".case", ".e",    ".ex2", ".exo",
                                                     ".exii", ".foam", ".vtk"};
  return std::ranges::find(kExtensions, path.extension().string()) != std::end(kExtensions);
}

Result<MeshSource> MeshSource::open(const std::filesystem::path& path, const MeshOptions& options) {
  MeshSource source;
  source.options_ = options;
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return fail(ErrorCode::kNotFound, "{}: no such file", path.string());
  if (path.extension() == ".vtu") {
    source.instants_ = {{path, 0}};
    source.times_ = {0};
    return source;
  }
  if (isMeshCase(path)) {
    VOLUTE_ASSIGN(source.times_, readTimes(path, options));
    for (std::size_t i = 0; i < source.times_.size(); ++i) source.instants_.push_back({path, i});
    return source;
  }
  if (path.extension() != ".pvd") {
    return fail(ErrorCode::kUnsupported,
                "{}: not a mesh; expected a .vtu or .vtk file, a .pvd series, or a case of EnSight "
                "(.case), Exodus (.e, .ex2, .exo, .exii) or OpenFOAM (.foam)",
                path.string());
  }
  VOLUTE_ASSIGN(auto files, readCollection(path, loadVtkPlugin));
  std::ranges::stable_sort(files, {}, &TimedFile::time);
  for (const TimedFile& file : files) {
    source.instants_.push_back({path.parent_path() / file.path, 0});
    source.times_.push_back(file.time);
  }
  if (source.instants_.empty())
    return fail(ErrorCode::kInvalidData, "{}: names no files", path.string());
  return source;
}

Result<MeshFrame> MeshSource::read(std::size_t frame) {
  VOLUTE_ASSERT(frame < instants_.size());
  const Instant& instant = instants_[frame];
  const std::string file = instant.file.string();
  VOLUTE_ASSIGN(MeshData data, readMesh(instant.file, instant.index, options_));
  MeshFrame out;
  out.field = data.field;
  VOLUTE_ASSIGN(out.clamped, checkField(data.values, options_.negatives,
                                        fmt::format("{}: field '{}'", file, data.field)));
  VOLUTE_ASSIGN(const SplitCells split, splitCells(data.soup, file));
  if (!mesh_ || vertices_ != data.soup.vertices || tets_ != split.tets) {
    std::vector<Vec3> vertices = data.soup.vertices;
    std::vector<Tet> tets = split.tets;
    order_ = reorderInSpace(vertices, tets);
    VOLUTE_ASSIGN(mesh_, TetMesh::build(std::move(vertices), std::move(tets), file));
    vertices_ = std::move(data.soup.vertices);
    tets_ = split.tets;
  }
  out.mesh = mesh_;
  if (data.ofCells) {
    std::vector<std::int32_t> cellOf;
    for (const std::int32_t from : order_.tetFrom)
      cellOf.push_back(split.cellOf[static_cast<std::size_t>(from)]);
    out.values = cellToPoint(*mesh_, data.values, cellOf);
  } else {
    for (const std::int32_t from : order_.vertexFrom)
      out.values.push_back(data.values[static_cast<std::size_t>(from)]);
  }
  return out;
}

}  // namespace volute
