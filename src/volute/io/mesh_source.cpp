// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/mesh_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <span>

#include "volute/base/assert.hpp"
#include "volute/base/file_as_written.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/io/collection.hpp"
#include "volute/io/ensight_files.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/mesh.hpp"
#include "volute/io/netcdf_length.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"

namespace volute {
namespace {

/// Goes through an array of bytes, writing to it or reading from it.
struct Bytes {
  std::byte* at;

  template <class T>
  void put(const std::vector<T>& from) {
    at = std::ranges::copy(std::as_bytes(std::span(from)), at).out;
  }

  template <class T>
  void get(std::vector<T>& to, std::uint64_t count) {
    to.resize(count);
    const auto bytes = std::as_writable_bytes(std::span(to));
    std::copy_n(at, bytes.size(), bytes.begin());
    at += bytes.size();
  }
};

std::size_t floatsFor(const MeshSize& size) {
  const std::uint64_t bytes = size.points * sizeof(Vec3) + size.cells * sizeof(CellShape) +
                              (size.cells + 1 + size.indices) * sizeof(std::int64_t) +
                              size.walls * sizeof(WallCorners) + size.values() * sizeof(float);
  return (bytes + sizeof(float) - 1) / sizeof(float);
}

// Requests; others are frames, to be described where they begin with kDescribe.
constexpr std::string_view kTimes = "times", kTake = "take", kDescribe = "describe", kHead = "head";

/// What netCDF's libraries fill variables with before they are written (NC_FILL_DOUBLE and
/// NC_FILL_FLOAT, which are the same number).
constexpr double kNetcdfFill = 9.9692099683868690e+36;

bool isNetcdfFill(double value) {
  return static_cast<float>(value) == static_cast<float>(kNetcdfFill);
}

/// As many of them as a reply has room for, behind what it begins with.
std::string withFields(std::string reply, std::span<const MeshFieldSummary> fields) {
  for (const MeshFieldSummary& summary : fields) {
    if (reply.size() + sizeof summary < ReaderProcess::kMaxMessage)
      reply += toMessage(summary);
  }
  return reply;
}

/// The same the other way.
Result<std::vector<MeshFieldSummary>> fieldsIn(std::string_view reply) {
  std::vector<MeshFieldSummary> fields;
  for (; !reply.empty(); reply.remove_prefix(sizeof(MeshFieldSummary))) {
    VOLUTE_ASSIGN(auto summary,
                  fromMessage<MeshFieldSummary>(reply.substr(0, sizeof(MeshFieldSummary))));
    summary.name[MeshSize::kMaxName] = '\0';
    settleFlag(summary.ofCells);
    fields.push_back(summary);
  }
  return fields;
}

/// The child's side: it is asked for the frames, or for one of them: how much it is or what it
/// has, then the thing itself.
/// The parameters are the file, the field, and the share, a zero byte after each but the last.
Result<ReaderProcess::Serve> serveMesh(std::string_view parameters) {
  const std::size_t cut = parameters.find('\0');
  const std::filesystem::path file(parameters.substr(0, cut));
  parameters.remove_prefix(cut + 1);
  const std::size_t end = parameters.find('\0');
  const std::string field(parameters.substr(0, end));
  VOLUTE_ASSIGN(const auto share, fromMessage<MeshShare>(parameters.substr(end + 1)));
  VOLUTE_ASSIGN(const MeshPlugin* plugin, loadVtkMeshPlugin());
  return [file, field, share, reader = std::shared_ptr<MeshReader>(plugin->makeReader())](
             std::string_view request, std::span<float> values) -> Result<std::string> {
    if (request == kTimes) {
      VOLUTE_ASSIGN(const std::vector<double> times, reader->times(file));
      return std::string(reinterpret_cast<const char*>(times.data()),
                         times.size() * sizeof(double));
    }
    if (request == kHead) {
      VOLUTE_ASSIGN(const MeshHead head, reader->head(file));
      return withFields(toMessage(head.time), head.fields);
    }
    if (request.starts_with(kDescribe)) {
      request.remove_prefix(kDescribe.size());
      std::size_t frame = 0;
      std::from_chars(request.data(), request.data() + request.size(), frame);
      VOLUTE_ASSIGN(const auto described, reader->describe(file, frame));
      return withFields(toMessage(described.first), described.second);
    }
    if (request != kTake) {
      std::size_t frame = 0;
      std::from_chars(request.data(), request.data() + request.size(), frame);
      VOLUTE_ASSIGN(const MeshSize size, reader->load(file, frame, field, share));
      return toMessage(size);
    }
    VOLUTE_ASSIGN(const MeshData data, reader->take());
    Bytes bytes{reinterpret_cast<std::byte*>(values.data())};
    bytes.put(data.soup.vertices);
    bytes.put(data.soup.offsets);
    bytes.put(data.soup.connectivity);
    bytes.put(data.walls);
    bytes.put(data.values);
    bytes.put(data.soup.shapes);
    return std::string();
  };
}

/// Whether what belongs to a file lies in others below its folder, which only its reader knows.
bool isSpread(const std::filesystem::path& path) {
  static constexpr std::string_view kSpread[] = {".case", ".foam", ".pvtu"};
  return std::ranges::find(kSpread, extensionOf(path)) != std::end(kSpread);
}

std::filesystem::path folderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

ReaderJob meshReader(const std::filesystem::path& path, const std::string& field,
                     const MeshShare& share = {}) {
  return {serveMesh,
          path.string() + '\0' + field + '\0' + toMessage(share),
          {isSpread(path) ? folderOf(path) : path},
          [] { (void)loadVtkMeshPlugin(); }};
}

/// Bytes of the files below a folder: of the first so many, where a folder has very many.
std::uint64_t bytesBelow(const std::filesystem::path& folder) {
  constexpr int kEnough = 20000;
  std::uint64_t bytes = 0;
  std::error_code error;
  int seen = 0;
  using Walk = std::filesystem::recursive_directory_iterator;
  constexpr auto kSkip = std::filesystem::directory_options::skip_permission_denied;
  for (Walk at(folder, kSkip, error); !error && at != Walk() && seen < kEnough;
       at.increment(error), ++seen) {
    std::error_code noSize;
    if (const auto size = at->file_size(noSize); !noSize)
      bytes += size;
  }
  return bytes;
}

double secondsFor(const std::filesystem::path& path, std::uint64_t fileSize) {
  const std::uint64_t bytes = isSpread(path) ? bytesBelow(folderOf(path)) : fileSize;
  return 3 + 1e-6 * static_cast<double>(bytes);
}

Result<std::uint64_t> readableSize(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  return file.size();
}

bool isExodus(const std::filesystem::path& path) {
  static constexpr std::string_view kExodus[] = {".e", ".ex2", ".exo", ".exii"};
  return std::ranges::find(kExodus, extensionOf(path)) != std::end(kExodus);
}

/// What VTK's reader of Exodus does not see.
Status checkLength(const std::filesystem::path& path) {
  return isExodus(path) ? checkNetcdfLength(path) : Status();
}

/// What reading a file that looks whole may take.
Result<ReaderProcess::Limits> limitsFor(const std::filesystem::path& path,
                                        std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const std::uint64_t fileSize, readableSize(path));
  VOLUTE_TRY(checkLength(path));
  return ReaderProcess::Limits{maxMemory, secondsFor(path, fileSize)};
}

Result<std::vector<double>> readTimes(const std::filesystem::path& path,
                                      const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const ReaderProcess::Limits limits, limitsFor(path, options.maxMemory));
  ReaderProcess process(meshReader(path, options.field));
  VOLUTE_ASSIGN(const std::string reply, process.call(file, kTimes, 0, limits));
  if (reply.size() >= ReaderProcess::kMaxMessage) {
    return fail(ErrorCode::kTooLarge, "{}: has {} instants or more; expected fewer: split the case",
                file, reply.size() / sizeof(double));
  }
  std::vector<double> times(reply.size() / sizeof(double));
  if (!times.empty())
    std::memcpy(times.data(), reply.data(), times.size() * sizeof(double));
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i > 0 && isNetcdfFill(times[i]))
      continue;  // left out later, and told
    if (i > 1 && isNetcdfFill(times[i - 1])) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the time of instant {} was never written (netCDF's fill value); expected "
                  "ascending times",
                  file, i - 1);
    }
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1])) {
      return fail(ErrorCode::kInvalidData, "{}: instant {} is at {} s; expected ascending times",
                  file, i, times[i]);
    }
  }
  if (times.empty())
    return fail(ErrorCode::kInvalidData, "{}: has no instants", file);
  return times;
}

/// Counts that can be and names that end.
bool settle(MeshSize& size) {
  settleFlag(size.ofCells);
  settleFlag(size.bare);
  settleFlag(size.hasDimensions);
  return size.sound();
}

tl::unexpected<Error> notSound(const std::string& file) {
  return fail(ErrorCode::kInvalidData, "{}: its reader describes a mesh that cannot be", file);
}

/// Before anything of a mesh is made: the cells as they come and as they are copied, then their
/// tets with faces, order and places.
Status checkMemory(const MeshSize& size, const std::string& file, const MeshOptions& options) {
  constexpr double kPerTet = 110;  // bytes, measured on 1.5 million tets
  // One of a tet's 4 indices, 2 of a pyramid's 5, 3 of a wedge's 6, 5 or 6 of a hexahedron's 8.
  const double indices = static_cast<double>(size.indices), cells = static_cast<double>(size.cells);
  const double tets = std::max(indices - 3 * cells, cells);
  const double need = 2.0 * sizeof(float) * static_cast<double>(floatsFor(size)) +
                      (kPerTet + static_cast<double>(options.perTet)) * tets;
  if (need <= static_cast<double>(options.maxMemory))
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{}: a mesh of {} points and {} cells needs about {:.0f} MiB, more than the {} MiB "
              "allowed",
              file, size.points, size.cells, need / (1 << 20), options.maxMemory >> 20);
}

/// What the child has loaded.
Result<MeshData> takeMesh(ReaderProcess& process, const MeshSize& size, const std::string& file,
                          const ReaderProcess::Limits& limits) {
  VOLUTE_TRY(process.call(file, kTake, floatsFor(size), limits));
  MeshData data;
  data.ofCells = size.ofCells;
  data.field = size.field;
  data.others.assign(size.others, ::strnlen(size.others, MeshSize::kMaxName));
  if (size.hasDimensions)
    data.dimensions = size.dimensions;
  data.ghosts = size.ghosts;
  // Copied out of memory that is shared read-write; nothing is written through it here.
  Bytes bytes{reinterpret_cast<std::byte*>(const_cast<float*>(process.values().data()))};
  bytes.get(data.soup.vertices, size.points);
  bytes.get(data.soup.offsets, size.cells + 1);
  bytes.get(data.soup.connectivity, size.indices);
  bytes.get(data.walls, size.walls);
  bytes.get(data.values, size.values());
  bytes.get(data.soup.shapes, size.cells);
  for (const CellShape shape : data.soup.shapes) {
    if (shape > CellShape::kPolyhedron)
      return fail(ErrorCode::kInvalidData, "{}: its reader made cells of an unknown shape", file);
  }
  return data;
}

Result<MeshData> readMesh(const std::filesystem::path& path, std::size_t frame,
                          const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const ReaderProcess::Limits limits, limitsFor(path, options.maxMemory));
  ReaderProcess process(meshReader(path, options.field, options.share));
  VOLUTE_ASSIGN(const std::string reply, process.call(file, fmt::format("{}", frame), 0, limits));
  VOLUTE_ASSIGN(auto size, fromMessage<MeshSize>(reply));
  if (!settle(size))
    return notSound(file);
  VOLUTE_TRY(checkMemory(size, file, options));
  return takeMesh(process, size, file, limits);
}

Result<MeshHead> readHead(const std::filesystem::path& path, const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const ReaderProcess::Limits limits, limitsFor(path, options.maxMemory));
  ReaderProcess process(meshReader(path, ""));
  VOLUTE_ASSIGN(const std::string reply, process.call(file, kHead, 0, limits));
  const std::string_view text = reply;
  MeshHead head;
  VOLUTE_ASSIGN(head.time, fromMessage<double>(text.substr(0, sizeof(double))));
  VOLUTE_ASSIGN(head.fields, fieldsIn(text.substr(sizeof(double))));
  return head;
}

/// What a frame has, without values.
struct Description {
  MeshContents contents;
  std::vector<MeshFieldSummary> fields;
  CellSoup soup;
};

Result<Description> describeMesh(const std::filesystem::path& path, std::size_t frame,
                                 const MeshOptions& options) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const ReaderProcess::Limits limits, limitsFor(path, options.maxMemory));
  ReaderProcess process(meshReader(path, ""));
  VOLUTE_ASSIGN(const std::string reply,
                process.call(file, fmt::format("{}{}", kDescribe, frame), 0, limits));
  const std::string_view text = reply;
  Description described;
  VOLUTE_ASSIGN(described.contents,
                fromMessage<MeshContents>(text.substr(0, sizeof(MeshContents))));
  if (!settle(described.contents.size))
    return notSound(file);
  described.contents.partial[MeshSize::kMaxName] = '\0';
  VOLUTE_TRY(checkMemory(described.contents.size, file, options));
  VOLUTE_ASSIGN(described.fields, fieldsIn(text.substr(sizeof(MeshContents))));
  VOLUTE_ASSIGN(MeshData data, takeMesh(process, described.contents.size, file, limits));
  described.soup = std::move(data.soup);
  return described;
}

MeshSize sizeOf(const MemoryMesh& mesh) {
  MeshSize size;
  size.points = mesh.cells.vertices.size();
  size.cells = mesh.cells.shapes.size();
  size.indices = mesh.cells.connectivity.size();
  size.ghosts = mesh.ghosts;
  return size;
}

/// The field that is asked for, or the only one, or the density.
Result<const MemoryMesh::Field*> fieldIn(const MemoryMesh& mesh, const std::string& name,
                                         const std::string& file) {
  std::vector<std::string> names;
  for (const MemoryMesh::Field& field : mesh.fields) names.push_back(field.name);
  const std::string wanted = !name.empty() ? name : names.size() == 1 ? names[0] : "density";
  const auto found = std::ranges::find(names, wanted);
  if (found != names.end())
    return &mesh.fields[static_cast<std::size_t>(found - names.begin())];
  return fail(ErrorCode::kNotFound, Hint::choose("field"), "{}: has {}; expected {}", file,
              fmt::join(names, ", "),
              name.empty() ? "one field, or one that is named" : fmt::format("'{}'", name));
}

/// readMesh() of a mesh in memory.
Result<MeshData> dataIn(const MemoryMesh& mesh, std::size_t frame, const std::string& name,
                        const std::string& file, const MeshOptions& options) {
  VOLUTE_TRY(checkMemory(sizeOf(mesh), file, options));
  VOLUTE_ASSIGN(const MemoryMesh::Field* const field, fieldIn(mesh, name, file));
  std::vector<std::string> others;
  for (const MemoryMesh::Field& other : mesh.fields) {
    if (&other != field)
      others.push_back(other.name);
  }
  return MeshData{.soup = {},  // the same at all times
                  .values = field->values[frame],
                  .ofCells = field->ofCells,
                  .field = field->name,
                  .others = fmt::format("{}", fmt::join(others, ", ")),
                  .dimensions = {},
                  .ghosts = mesh.ghosts};
}

MeshContents contentsOf(const MemoryMesh& mesh) {
  MeshContents contents;
  contents.size = sizeOf(mesh);
  for (const CellShape shape : mesh.cells.shapes)
    ++contents.shapes[static_cast<std::size_t>(shape)];
  return contents;
}

MeshFieldSummary summaryOf(const MemoryMesh::Field& field, std::size_t frame) {
  MeshFieldSummary summary;
  field.name.copy(summary.name, MeshSize::kMaxName);
  summary.ofCells = field.ofCells;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const float value : field.values[frame]) {
    if (std::isfinite(value))
      least = std::min<double>(least, value), most = std::max<double>(most, value);
    else
      ++summary.notFinite;
  }
  if (least <= most)
    summary.least = least, summary.most = most;
  return summary;
}

std::string dimensionsText(const std::optional<std::array<double, 7>>& dimensions) {
  return dimensions ? fmt::format("[{}]", fmt::join(*dimensions, " ")) : "none";
}

/// Of `count`, in ascending order, those that no tet has: a filter that cuts a mesh leaves them.
std::vector<std::int32_t> unusedBy(std::span<const Tet> tets, std::size_t count) {
  std::vector<char> used(count, 0);
  for (const Tet& tet : tets) {
    for (const std::int32_t v : tet) used[static_cast<std::size_t>(v)] = 1;
  }
  std::vector<std::int32_t> unused;
  for (std::size_t i = 0; i < count; ++i) {
    if (used[i] == 0)
      unused.push_back(static_cast<std::int32_t>(i));
  }
  return unused;
}

/// Takes vertices away; returns which are left.
std::vector<std::int32_t> leaveOutVertices(std::span<const std::int32_t> unused,
                                           std::vector<Vec3>& vertices, std::vector<Tet>& tets) {
  std::vector<std::int32_t> left, to(vertices.size(), -1);
  left.reserve(vertices.size() - unused.size());
  auto next = unused.begin();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (next != unused.end() && static_cast<std::size_t>(*next) == i) {
      ++next;
      continue;
    }
    to[i] = static_cast<std::int32_t>(left.size());
    vertices[left.size()] = vertices[i];
    left.push_back(static_cast<std::int32_t>(i));
  }
  vertices.resize(left.size());
  for (Tet& tet : tets) {
    for (std::int32_t& v : tet) v = to[static_cast<std::size_t>(v)];
  }
  return left;
}

/// Without vertices that no tet has. Errors count vertices and tets as they come out of the file.
Result<std::shared_ptr<const TetMesh>> buildInSpace(const CellSoup& soup, const SplitCells& split,
                                                    MeshOrder& order, const std::string& file) {
  std::vector<Vec3> vertices = split.vertices(soup);
  std::vector<Tet> tets = split.tets;
  const auto unused = unusedBy(tets, vertices.size());
  const bool all = unused.empty() || tets.empty();
  const auto left = all ? std::vector<std::int32_t>() : leaveOutVertices(unused, vertices, tets);
  order = reorderInSpace(vertices, tets);
  for (std::int32_t& from : order.vertexFrom) {
    if (!all)
      from = left[static_cast<std::size_t>(from)];
  }
  auto mesh = TetMesh::build(std::move(vertices), std::move(tets), file);
  return mesh || !all ? mesh : TetMesh::build(split.vertices(soup), split.tets, file);
}

}  // namespace

Status MemoryMesh::validate(const std::string& name) const {
  const auto wrong = [&](const std::string& what) -> Status {
    return fail(ErrorCode::kInvalidArgument, "{}: {}", name, what);
  };
  if (times.empty() || fields.empty())
    return wrong("a mesh in memory has at least a time and a field");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1]))
      return wrong(fmt::format("time {} is {} s; expected ascending times", i, times[i]));
  }
  std::set<std::string> names;
  for (const Field& field : fields) {
    if (field.name.empty() || field.name.size() > MeshSize::kMaxName ||
        !names.insert(field.name).second) {
      return wrong(fmt::format("a field is called '{}'; expected different names of 1 to {} bytes",
                               field.name, MeshSize::kMaxName));
    }
    if (field.values.size() != times.size()) {
      return wrong(fmt::format("field '{}' has values at {} times, and there are {}", field.name,
                               field.values.size(), times.size()));
    }
    const std::size_t count = field.ofCells ? cells.shapes.size() : cells.vertices.size();
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (field.values[i].size() != count) {
        return wrong(fmt::format("field '{}' has {} values at {} s, and there are {} {}",
                                 field.name, field.values[i].size(), times[i], count,
                                 field.ofCells ? "cells" : "points"));
      }
    }
  }
  return {};
}

bool isMeshCase(const std::filesystem::path& path) {
  static constexpr std::string_view kExtensions[] = {".case", ".e",    ".ex2", ".exo",
                                                     ".exii", ".foam", ".vtk", ".pvtu"};
  return std::ranges::find(kExtensions, extensionOf(path)) != std::end(kExtensions);
}

Result<MeshSource> MeshSource::open(const std::filesystem::path& path, const MeshOptions& options) {
  VOLUTE_ASSIGN(MeshSource source, list(path, options));
  if (extensionOf(path) == ".pvd")
    source.readHeads();
  if (extensionOf(path) == ".foam")
    source.remarks_ = foamRemarks(path);
  VOLUTE_TRY(source.leaveOutAbsent(path));
  bool ascending = extensionOf(path) == ".pvd";
  for (const FrameLocation& location : source.locations_) {
    const auto number = frameNumberOf(location.file);
    ascending =
        ascending && number && (source.numbers_.empty() || *number > source.numbers_.back());
    source.numbers_.push_back(number.value_or(0));
  }
  for (std::size_t i = 0; !ascending && i < source.numbers_.size(); ++i)
    source.numbers_[i] = static_cast<int>(i);
  return source;
}

MeshSource MeshSource::of(std::shared_ptr<const MemoryMesh> mesh, const std::filesystem::path& name,
                          const MeshOptions& options) {
  MeshSource source;
  source.options_ = options;
  source.path_ = name;
  source.times_ = mesh->times;
  for (std::size_t i = 0; i < mesh->times.size(); ++i) {
    source.locations_.push_back({name, i});
    source.numbers_.push_back(static_cast<int>(i));
  }
  source.memory_ = std::move(mesh);
  return source;
}

Result<MeshSource> MeshSource::withField(const std::string& field, Negatives negatives) const {
  MeshOptions options{field, negatives, options_.maxMemory};
  if (field == (options_.field.empty() ? settledField_ : options_.field))
    options.mean = options_.mean;
  if (!memory_)
    return open(path_, options);
  MeshSource source = of(memory_, path_, options);
  source.mesh_ = mesh_, source.added_ = added_;
  source.vertexFrom_ = vertexFrom_, source.cellOf_ = cellOf_;
  source.unused_ = unused_;
  return source;
}

Result<MeshSource> MeshSource::list(const std::filesystem::path& path, const MeshOptions& options) {
  MeshSource source;
  source.path_ = path;
  source.options_ = options;
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return fail(ErrorCode::kNotFound, "{}: no such file", path.string());
  if (std::filesystem::is_directory(path, error)) {
    return fail(ErrorCode::kInvalidArgument, "{}: is a folder; expected the file of a mesh in it",
                path.string());
  }
  if (extensionOf(path) == ".vtu") {
    source.locations_ = {{path, 0}};
    source.times_ = {0};
    return source;
  }
  if (isMeshCase(path)) {
    VOLUTE_ASSIGN(source.times_, readTimes(path, options));
    for (std::size_t i = 0; i < source.times_.size(); ++i) source.locations_.push_back({path, i});
    return source;
  }
  if (extensionOf(path) != ".pvd") {
    return fail(
        ErrorCode::kUnsupported,
        "{}: not a mesh; expected a .vtu, .pvtu or .vtk file, a .pvd series, or a case of EnSight "
        "(.case), Exodus (.e, .ex2, .exo, .exii) or OpenFOAM (.foam)",
        path.string());
  }
  VOLUTE_ASSIGN(auto files, readCollection(path, loadVtkPlugin));
  for (const TimedFile& file : files) {
    const std::string kind = extensionOf(file.path);
    if (kind != ".vtu" && kind != ".pvtu") {
      return fail(ErrorCode::kUnsupported, "{}: names {}; expected a series of .vtu or .pvtu files",
                  path.string(), file.path.string());
    }
    if (!std::isfinite(file.time)) {
      return fail(ErrorCode::kInvalidData, "{}: {} is at {} s; expected a time", path.string(),
                  file.path.string(), file.time);
    }
  }
  std::ranges::stable_sort(files, {}, &TimedFile::time);
  FilesAsWritten written;
  for (const TimedFile& file : files) {
    if (!source.times_.empty() && source.times_.back() == file.time) {
      return fail(ErrorCode::kInvalidData,
                  "{}: {} and {} are both at {} s; expected one file for each time (a .pvtu names "
                  "several pieces)",
                  path.string(), source.locations_.back().file.filename().string(),
                  file.path.string(), file.time);
    }
    source.locations_.push_back({written.find(path.parent_path(), file.path.string()), 0});
    source.times_.push_back(file.time);
  }
  if (source.locations_.empty())
    return fail(ErrorCode::kInvalidData, "{}: names no files", path.string());
  return source;
}

template <class Absent>
void MeshSource::leaveOut(const Absent& isAbsent) {
  std::vector<FrameLocation> locations;
  std::vector<double> times;
  for (std::size_t i = 0; i < locations_.size(); ++i) {
    if (isAbsent(i)) {
      absent_.push_back(times_[i]);
      continue;
    }
    locations.push_back(locations_[i]);
    times.push_back(times_[i]);
  }
  locations_ = std::move(locations);
  times_ = std::move(times);
}

void MeshSource::readHeads() {
  std::vector<CollectedFile> files;
  for (std::size_t i = 0; i < locations_.size(); ++i)
    files.push_back({locations_[i].file, times_[i]});
  for (CollectedFile& file : files) {
    auto head = readHead(file.path, options_);
    if (!head) {
      fieldLists_.clear();
      break;  // reading the frame says what is wrong with the file
    }
    file.stated = head->time;
    fieldLists_.push_back(std::move(head->fields));
  }
  if (std::string said = contradictionOf(files); !said.empty())
    remarks_.push_back(Remark(RemarkCode::kDoubtful, std::move(said)).in(path_.string()));
}

std::vector<std::vector<std::string>> MeshSource::fieldNames() const {
  std::vector<std::vector<std::string>> names;
  for (const auto& fields : fieldLists_) {
    names.emplace_back();
    for (const MeshFieldSummary& field : fields) names.back().emplace_back(field.name);
  }
  if (!locations_.empty() && extensionOf(locations_.front().file) == ".foam") {
    for (const double time : times_) names.push_back(foamFields(locations_.front().file, time));
  }
  return names;
}

Status MeshSource::leaveOutAbsent(const std::filesystem::path& path) {
  if (locations_.size() < 2)
    return {};
  if (isExodus(path))
    return leaveOutUnwritten();
  if (const auto unwritten = std::ranges::find_if(times_, isNetcdfFill);
      unwritten != times_.end()) {
    return fail(ErrorCode::kInvalidData,
                "{}: the time {} s was never written (netCDF's fill value); expected a time",
                path.string(), plainNumber(*unwritten));
  }
  std::string field = options_.field;
  const std::string& also = options_.alsoField;
  const auto has = [&](std::size_t i, const std::string& name) {
    return name.empty() ||
           std::ranges::any_of(fieldLists_[i], [&](const MeshFieldSummary& summary) {
             return name == summary.name;
           });
  };
  if (extensionOf(path) == ".case") {
    keepTimesOf(path);
    return {};
  }
  std::vector<bool> there(locations_.size(), true);
  if (extensionOf(path) == ".pvd") {
    if (fieldLists_.empty())
      return {};
    if (field.empty()) {
      std::vector<GridEntry> entries;
      for (const MeshFieldSummary& summary : fieldLists_.front())
        entries.push_back({summary.name, "", summary.components == 1});
      const auto chosen = chooseGrid(entries, "", path.string(), {.noun = "field"});
      if (!chosen)
        return {};  // reading the first frame says it better
      field = entries[*chosen].name;
    }
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = has(i, field) && has(i, also);
  } else if (extensionOf(path) == ".foam" && !field.empty()) {
    for (std::size_t i = 0; i < there.size(); ++i)
      there[i] = hasFoamField(path, field, times_[i]) &&
                 (also.empty() || hasFoamField(path, also, times_[i]));
  } else {
    return {};
  }
  if (std::ranges::none_of(there, std::identity()))
    return {};  // reading the first frame lists what there is
  options_.field = field;
  absentWhat_ = also.empty() ? fmt::format("there is no field '{}'", field)
                             : fmt::format("there is no field '{}', or no '{}',", field, also);
  leaveOut([&](std::size_t i) { return !there[i]; });
  return {};
}

/// Of an EnSight case: those of the field's own time set. At others VTK holds its values.
void MeshSource::keepTimesOf(const std::filesystem::path& path) {
  const auto own = ensightTimes(path, options_.field);
  if (!own)
    return;
  std::vector<FrameLocation> locations;
  std::vector<double> times;
  auto from = times_.begin();
  for (const double time : *own) {  // VTK rounds them to float
    const auto found = std::find_if(from, times_.end(), [time](double one) {
      return static_cast<float>(one) == static_cast<float>(time);
    });
    if (found == times_.end())
      return;
    from = std::next(found);
    locations.push_back(locations_[static_cast<std::size_t>(found - times_.begin())]);
    times.push_back(*found);
  }
  locations_ = std::move(locations);
  times_ = std::move(times);
}

/// Records at the end of an Exodus file that its writer made and did not write, and at its begin.
Status MeshSource::leaveOutUnwritten() {
  absentWhat_ = "the record was never written (netCDF's fill value)";
  std::size_t whole = times_.size();
  while (whole > 1 && isNetcdfFill(times_[whole - 1])) --whole;
  for (std::size_t i = 0; i < whole; ++i) {
    if (isNetcdfFill(times_[i])) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the time of instant {} was never written (netCDF's fill value); expected "
                  "ascending times",
                  locations_[i].file.string(), i);
    }
  }
  const auto isUnwritten = [&](std::size_t i) {
    const auto holdsNothing = [&](const std::string& field) {
      MeshOptions options = options_;
      options.field = field;
      const auto data = readMesh(locations_[i].file, locations_[i].index, options);
      return data && !data->values.empty() && std::ranges::all_of(data->values, isNetcdfFill);
    };
    return (!options_.alsoField.empty() && holdsNothing(options_.alsoField)) ||
           holdsNothing(options_.field);
  };
  while (whole > 1 && isUnwritten(whole - 1)) --whole;
  std::size_t first = 0;
  while (first < whole && isUnwritten(first)) ++first;
  if (first == whole)
    return {};  // reading the first frame says it
  leaveOut([&](std::size_t i) { return i < first || i >= whole; });
  return {};
}

std::string MeshSource::absentText() const {
  if (absent_.empty())
    return "";
  constexpr std::size_t kShown = 5;
  std::string times;
  for (std::size_t i = 0; i < std::min(kShown, absent_.size()); ++i)
    times += fmt::format("{}{}", i == 0 ? "" : ", ",
                         isNetcdfFill(absent_[i]) ? std::string("unknown")
                                                  : fmt::format("{} s", plainNumber(absent_[i])));
  return fmt::format("{} at {} of {} times, which are left out: {}{}", absentWhat_, absent_.size(),
                     absent_.size() + times_.size(), times, absent_.size() > kShown ? " ..." : "");
}

/// The first frame that is read says what the field is in all.
Status MeshSource::settleSeries(const MeshData& data, std::size_t frame) {
  const std::string file = locations_[frame].file.string();
  if (settledField_.empty()) {
    settledField_ = data.field;
    settledOfCells_ = data.ofCells;
    settledDimensions_ = data.dimensions;
    return {};
  }
  if (settledOfCells_ != data.ofCells) {
    return fail(ErrorCode::kInvalidData,
                "{}: at {} s the field '{}' is of {}, before of {}; expected the same at all times",
                file, times_[frame], data.field, data.ofCells ? "cells" : "points",
                settledOfCells_ ? "cells" : "points");
  }
  if (settledDimensions_ != data.dimensions) {
    return fail(ErrorCode::kInvalidData,
                "{}: at {} s the field '{}' states the dimensions {}, before {}; expected the same "
                "at all times",
                file, times_[frame], data.field, dimensionsText(data.dimensions),
                dimensionsText(settledDimensions_));
  }
  return {};
}

/// Not checked: that a mesh moves or grows, as many do, but that all of it is scaled about the
/// origin as another unit of length would.
Status MeshSource::checkScale(const CellSoup& soup, std::size_t frame) const {
  constexpr double kUnits[] = {10, 12, 39.3701, 3.28084, 100, 1000};
  constexpr double kRounding = 1e-4;
  const auto boundsOf = [](const CellSoup& one) {
    Box3 box;
    for (const Vec3& vertex : one.vertices) box.extend(vertex);
    return box;
  };
  const Box3 before = boundsOf(soup_), now = boundsOf(soup);
  const double sizeBefore = before.size().maxCoeff(), sizeNow = now.size().maxCoeff();
  for (const double unit : kUnits) {
    for (const double scale : {unit, 1 / unit}) {
      const double near = kRounding * sizeNow;
      if (std::abs(scale * sizeBefore - sizeNow) > near ||
          (scale * before.min - now.min).cwiseAbs().maxCoeff() > near ||
          (scale * before.max - now.max).cwiseAbs().maxCoeff() > near)
        continue;
      return fail(ErrorCode::kInvalidData,
                  "{}: at {} s the mesh is {:.4g} times as large as at a time before, in all "
                  "directions; expected one unit of length, metres, at all times",
                  locations_[frame].file.string(), times_[frame], scale);
    }
  }
  return {};
}

Result<MeshData> MeshSource::dataOf(std::size_t frame, const std::string& field) const {
  const FrameLocation& location = locations_[frame];
  if (memory_)
    return dataIn(*memory_, frame, field, location.file.string(), options_);
  MeshOptions options = options_;
  options.field = field;
  return readMesh(location.file, location.index, options);
}

Status MeshSource::takeCells(const CellSoup& soup, const std::string& file) {
  VOLUTE_ASSIGN(SplitCells split, splitCells(soup, file));
  MeshOrder order;
  VOLUTE_ASSIGN(mesh_, buildInSpace(soup, split, order, file));
  unused_ = unusedBy(split.tets, soup.vertices.size());
  added_ = std::move(split.added);
  vertexFrom_ = std::move(order.vertexFrom);
  cellOf_.clear();
  cellOf_.reserve(order.tetFrom.size());
  for (const std::int32_t from : order.tetFrom)
    cellOf_.push_back(split.cellOf[static_cast<std::size_t>(from)]);
  return {};
}

/// Of the soup.
Status MeshSource::takeWalls(std::span<const WallCorners> corners, const std::string& file) {
  walls_ = nullptr;
  if (corners.empty())
    return {};
  auto walls = std::make_shared<std::vector<ThinWall>>();
  walls->reserve(corners.size());
  for (const WallCorners& three : corners) {
    ThinWall& wall = walls->emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      if (three[k] < 0 || three[k] >= std::ssize(soup_.vertices))
        return notSound(file);
      wall[k] = soup_.vertices[static_cast<std::size_t>(three[k])];
    }
  }
  walls_ = std::move(walls);
  return {};
}

/// Values where no cell is need not make sense. The largest of them, 0 or more.
double MeshSource::clearUnused(std::span<float> values) const {
  double most = 0;
  for (const std::int32_t i : unused_) {
    float& value = values[static_cast<std::size_t>(i)];
    if (std::isfinite(value))
      most = std::max<double>(most, value);
    value = 0;
  }
  return most;
}

Result<MeshFrame> MeshSource::read(std::size_t frame, std::span<const float> weights) {
  VOLUTE_ASSERT(frame < locations_.size());
  const std::string file = locations_[frame].file.string();
  auto read = dataOf(frame, options_.field.empty() ? settledField_ : options_.field);
  if (!read && read.error().code == ErrorCode::kNotFound && !settledField_.empty()) {
    return fail(ErrorCode::kInvalidData, "{} (at {} s; the first time has '{}')",
                read.error().message, times_[frame], settledField_);
  }
  VOLUTE_TRY(read);
  MeshData& data = *read;
  VOLUTE_TRY(settleSeries(data, frame));
  if (memory_ && !mesh_) {
    VOLUTE_TRY(takeCells(memory_->cells, file));
  } else if (!memory_ && (!mesh_ || soup_ != data.soup || wallCorners_ != data.walls)) {
    if (mesh_)
      VOLUTE_TRY(checkScale(data.soup, frame));
    VOLUTE_TRY(takeCells(data.soup, file));
    soup_ = std::move(data.soup);
    VOLUTE_TRY(takeWalls(data.walls, file));
    wallCorners_ = std::move(data.walls);
  }
  MeshFrame out;
  out.dimensions = data.dimensions;
  out.field = data.field;
  out.others = data.others;
  out.ofCells = data.ofCells;
  out.ghosts = data.ghosts;
  if (!data.ofCells)
    out.unusedMost = clearUnused(data.values);
  out.unused = unused_.size();
  const auto unwritten = std::ranges::count_if(data.values, isNetcdfFill);
  if (unwritten > 0) {
    return fail(ErrorCode::kInvalidData,
                "{}: at {} s {} of {} values of the field '{}' were never written (netCDF's fill "
                "value); leave that time out, or run the simulation to its end",
                file, times_[frame], unwritten, data.values.size(), data.field);
  }
  VOLUTE_ASSIGN(out.clamped, checkField(data.values, options_.negatives,
                                        fmt::format("{}: field '{}'", file, data.field)));
  out.mesh = mesh_;
  out.walls = walls_;
  if (data.ofCells) {
    VOLUTE_ASSERT(weights.empty() || weights.size() == data.values.size());
    out.values = cellToPoint(*mesh_, data.values, cellOf_, options_.mean, weights);
    if (options_.keepsCells)
      out.cells = std::move(data.values);
  } else {
    const std::vector<float> values = added_.follow(std::move(data.values));
    out.values.reserve(vertexFrom_.size());
    for (const std::int32_t from : vertexFrom_)
      out.values.push_back(values[static_cast<std::size_t>(from)]);
  }
  return out;
}

Result<MeshDescription> MeshSource::describe(std::size_t frame) const {
  VOLUTE_ASSERT(frame < locations_.size());
  const std::string file = locations_[frame].file.string();
  Description described;
  if (memory_) {
    described = {contentsOf(*memory_), {}, memory_->cells};
    VOLUTE_TRY(checkMemory(described.contents.size, file, options_));
    for (const MemoryMesh::Field& field : memory_->fields)
      described.fields.push_back(summaryOf(field, frame));
  } else {
    VOLUTE_ASSIGN(described,
                  describeMesh(locations_[frame].file, locations_[frame].index, options_));
  }
  MeshDescription description{described.contents, std::move(described.fields), nullptr};
  if (const auto split = splitCells(described.soup, file)) {
    MeshOrder order;
    description.mesh = buildInSpace(described.soup, *split, order, file);
  } else {
    description.mesh = tl::unexpected<Error>(split.error());
  }
  return description;
}

}  // namespace volute
