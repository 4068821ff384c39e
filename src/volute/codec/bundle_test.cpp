// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/bundle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "volute/base/parallel.hpp"
#include "volute/codec/codec_testing.hpp"
#include "volute/codec/grid_table.hpp"
#include "volute/codec/join.hpp"
#include "volute/codec/recompress.hpp"

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;
using namespace testing;

constexpr std::uint64_t kMemory = std::uint64_t{64} << 20;

GridDescription staggered(int frames) {
  GridDescription grid;
  grid.type = "vec3s";
  grid.gridClass = "staggered";
  grid.half = true;
  grid.background = {1, 2, 3};
  grid.map = "UniformScaleTranslateMap";
  grid.voxelSize = {.5, .5, .5};
  grid.origin = {.1, -2, 7};
  grid.begin = {-3, 0, 1 << 20};
  grid.voxels = 12345, grid.memory = 1 << 30;
  const MetadataList list{{"creator", "string", "somebody"}, {"frame", "int32", {"\1\0\0\0", 4}}};
  for (int i = 0; i < frames; ++i) {
    grid.metadata.add(i == 1 ? nullptr : &list);
    grid.shifts.push_back({i, -i, 0});
  }
  return grid;
}

/// Three grids with values of other sizes, and an empty one.
struct Cache {
  explicit Cache(int frames = 3)
      : density(plumes(frames, 5, 6, 19)),
        heat(plumes(frames, 7, 4, 4, 1, 300)),
        velocity(plumes(frames, 3, 6, 5, 3)) {
    Sequence* const all[] = {&heat, &density, &velocity};
    const char* const names[] = {"temperature", "density", "velocity"};
    for (std::size_t i = 0; i < 3; ++i) {
      all[i]->info.name = names[i];
      EXPECT_TRUE(compressTo(files[i].path(), *all[i], {Kind::kRms, 2e-2 / (1 + double(i))}));
      grids.push_back({names[i], {}, files[i].path()});
    }
    grids[2].description = staggered(frames);
    grids.insert(grids.begin() + 1, {"flame", GridDescription(), {}});
    const MetadataList list{{"made by", "string", "a test"}};
    for (int i = 0; i < frames; ++i) fileMetadata.add(&list);
    Progress quiet;
    const auto bytes = bundle(grids, fileMetadata, file.path(), quiet);
    EXPECT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(*bytes, std::filesystem::file_size(file.path()));
    for (auto& grid : grids) {
      if (!grid.file.empty())
        alone.push_back(*testing::readBack(grid.file));
    }
  }

  Sequence density, heat, velocity;
  std::vector<BundledGrid> grids;
  std::vector<Sequence> alone;  ///< what each file of its own says: temperature, density, velocity
  FrameMetadata fileMetadata;
  std::vector<ScratchFile> files = std::vector<ScratchFile>(3);
  ScratchFile file;
};

VoluteReader::Options options(std::string grid, bool partial = false) {
  return {partial, kMemory, std::move(grid)};
}

TEST(Bundle, EachGridIsWhatItIsAlone) {
  const Cache cache;
  const char* const names[] = {"temperature", "density", "velocity"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto back = testing::readBack(cache.file.path(), options(names[i]));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->values, cache.alone[i].values);
    EXPECT_EQ(back->info.name, names[i]);
    EXPECT_EQ(back->info.bounds.max, cache.alone[i].info.bounds.max);
  }
  const auto reader = VoluteReader::open(cache.file.path(), options(""));
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->info().name, "density");
  EXPECT_TRUE(reader->verify().complete());
  ASSERT_EQ(reader->grids().size(), 4u);
  EXPECT_TRUE(reader->grids()[1].empty);
  EXPECT_EQ(reader->grids()[1].info.frames, 3);
  EXPECT_EQ(reader->grids()[3].description, staggered(3));
  EXPECT_NEAR(reader->grids()[3].header.targetValue, 2e-2 / 3, 1e-12);
  EXPECT_EQ(reader->fileMetadata(), cache.fileMetadata);
  EXPECT_FALSE(reader->grid().description);
  const auto source = frameSource(
      std::make_shared<VoluteReader>(*VoluteReader::open(cache.file.path(), options("velocity"))));
  EXPECT_EQ(source->otherGrids(), (std::vector<std::string>{"temperature", "flame", "density"}));
}

TEST(Recompress, HandsOnWhatTheFileSaysOfTheGrid) {
  const Cache cache;
  const auto open = [](const std::filesystem::path& path, const char* grid) {
    return std::make_shared<const VoluteReader>(VoluteReader::open(path, options(grid)).value());
  };
  const auto old = open(cache.file.path(), "velocity");
  const ScratchFile file;
  Progress quiet;
  CompressOptions how;
  how.target = {Kind::kMaxError, 1e-2};
  const auto report = recompress(old, old->info(), file.path(), how, quiet);
  ASSERT_TRUE(report) << report.error().message;
  const auto again = open(file.path(), "velocity");
  EXPECT_EQ(again->grids().size(), 1u);
  EXPECT_EQ(again->grid().description, staggered(3));
  EXPECT_EQ(again->fileMetadata(), cache.fileMetadata);
  EXPECT_EQ(report->fileBytes, std::filesystem::file_size(file.path()));
  EXPECT_EQ(report->maxError, again->header().reachedMaxError);
  EXPECT_GE(report->maxError, old->header().reachedMaxError);
  EXPECT_LE(report->maxError, old->header().reachedMaxError + 1e-2);
  const auto back = testing::readBack(file.path());
  ASSERT_TRUE(back);
  EXPECT_LE(differenceOf(cache.velocity, *back).maxError, report->maxError);

  VolumeInfo moved = old->info();
  moved.name = "wind";
  moved.times = {1, 2, 5};
  moved.bounds = {Vec3(1, 2, 3), Vec3(11, 22, 33)};
  ASSERT_TRUE(recompress(old, moved, file.path(), how, quiet));
  const auto placed = open(file.path(), "wind");
  EXPECT_EQ(placed->info().times, moved.times);
  EXPECT_LT((placed->info().bounds.max - moved.bounds.max).norm(), 1e-9);
  EXPECT_EQ(placed->grid().description->background, staggered(3).background);
}

/// So many bytes that follow from a seed, in parts.
class MadeBytes final : public KeptBytes {
 public:
  MadeBytes(std::size_t size, unsigned seed) : bytes_(size) {
    for (std::size_t i = 0; i < size; ++i)
      bytes_[i] = static_cast<std::byte>((i * i + seed) >> (i % 7));
  }

  std::uint64_t size() const override { return bytes_.size(); }

  Result<std::span<const std::byte>> next() override {
    const std::size_t count = std::min(kPart, bytes_.size() - done_);
    done_ += count;
    return std::span<const std::byte>(bytes_).subspan(done_ - count, count);
  }

  const std::vector<std::byte>& all() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t done_ = 0;
};

/// The cache with two grids that are kept as bytes: one the same in two frames, one of two parts.
void keepTwo(const Cache& cache, const std::filesystem::path& target) {
  Progress quiet;
  auto store = KeptStore::create(target);
  ASSERT_TRUE(store);
  store->begin({"id", "int32", 1});
  for (const unsigned seed : {1u, 1u, 2u}) {
    MadeBytes bytes(1000, seed);
    ASSERT_TRUE(store->add(&bytes));
  }
  store->begin({"points", "ptdataidx32", 4});
  MadeBytes large(KeptBytes::kPart + 77, 3);
  ASSERT_TRUE(store->add(nullptr));
  ASSERT_TRUE(store->add(&large));
  ASSERT_TRUE(store->add(nullptr));
  EXPECT_EQ(store->table().pieceBytes.size(), 3u);
  ASSERT_TRUE(bundle(cache.grids, cache.fileMetadata, target, quiet, &*store));
}

std::vector<std::byte> allOf(KeptBytes& bytes) {
  std::vector<std::byte> all;
  for (;;) {
    const auto part = bytes.next();
    EXPECT_TRUE(part);
    if (!part || part->empty())
      return all;
    all.insert(all.end(), part->begin(), part->end());
  }
}

TEST(Bundle, GridsAreKeptAsBytes) {
  const Cache cache;
  const ScratchFile file;
  keepTwo(cache, file.path());
  const auto reader = VoluteReader::open(file.path(), options("velocity"));
  ASSERT_TRUE(reader) << reader.error().message;
  const auto& kept = reader->kept();
  ASSERT_EQ(kept.grids.size(), 2u);
  EXPECT_EQ(kept.grids[0], (KeptGrid{"id", "int32", 1, {0, 0, 1}}));
  EXPECT_EQ(kept.grids[1], (KeptGrid{"points", "ptdataidx32", 4, {-1, 2, -1}}));
  EXPECT_EQ(kept.parts.size(), 4u);
  EXPECT_EQ(allOf(*reader->keptBytes(0, 1)), MadeBytes(1000, 1).all());
  EXPECT_EQ(allOf(*reader->keptBytes(0, 2)), MadeBytes(1000, 2).all());
  EXPECT_EQ(allOf(*reader->keptBytes(1, 1)), MadeBytes(KeptBytes::kPart + 77, 3).all());
  EXPECT_EQ(reader->keptBytes(1, 0), nullptr);
  Integrity integrity = reader->verify();
  reader->verifyKept(integrity);
  EXPECT_TRUE(integrity.complete()) << integrity.firstFault;
  EXPECT_EQ(testing::readBack(file.path(), options("velocity"))->values, cache.alone[2].values);
  // A bit of a kept grid.
  auto bytes = readBytes(file.path());
  bytes[bytes.size() - 40] ^= 1;
  writeBytes(file.path(), bytes);
  const auto damaged = VoluteReader::open(file.path(), options("velocity"));
  ASSERT_TRUE(damaged);
  EXPECT_TRUE(damaged->verify().complete());
  damaged->verifyKept(integrity);
  EXPECT_FALSE(integrity.complete());
  const auto piece = damaged->keptBytes(1, 1);
  EXPECT_TRUE(piece->next());
  EXPECT_FALSE(piece->next());
}

TEST(Bundle, TablesOfKeptGridsAreCheckedWhateverTheySay) {
  KeptTable table;
  table.grids = {{"id", "int32", 1, {0, 0, 1}}, {"points", "", 4, {-1, 1, -1}}};
  table.pieceBytes = {1000, KeptBytes::kPart + 1};
  table.parts = {{0, 10, 1}, {0, 20, 2}, {0, 30, 3}};
  const auto content = writeKeptTable(table);
  const auto back = readKeptTable(content);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->grids, table.grids);
  EXPECT_EQ(back->storedBytes(), 60u);
  EXPECT_EQ(back->storedBytes(0), 60u);
  EXPECT_EQ(back->storedBytes(1), 50u);
  for (std::size_t size = 0; size < content.size(); ++size)
    EXPECT_FALSE(readKeptTable(std::span(content).first(size))) << size;
  for (std::size_t bit = 0; bit < 8 * content.size(); ++bit) {
    auto other = content;
    other[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    const auto read = readKeptTable(other);
    for (std::size_t i = 0; read && i < read->grids.size(); ++i) {
      for (const int piece : read->grids[i].pieces) {
        EXPECT_LT(piece, static_cast<int>(read->pieceBytes.size()));
        EXPECT_TRUE(piece < 0 || read->partsOf(piece).second <= read->parts.size());
      }
    }
  }
}

TEST(Bundle, MatricesOfFramesComeBack) {
  const Cache cache;
  const ScratchFile file;
  Progress quiet;
  auto grids = cache.grids;
  GridDescription& grid = *grids[3].description;
  grid.shifts.clear();
  for (int i = 0; i < 3; ++i)
    grid.matrices.push_back({0, -.5, .1, i + .2, .5, 0, 0, 1, 0, 0, .25, -3});
  ASSERT_TRUE(bundle(grids, {}, file.path(), quiet));
  const auto reader = VoluteReader::open(file.path(), options("velocity"));
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->grid().description, grid);
  EXPECT_EQ(reader->grid().description->places().size(), 3u);
  EXPECT_EQ(grid.of({2}).matrices, std::vector{grid.matrices[2]});
  grid.matrices[1][0] = NAN;
  EXPECT_FALSE(bundle(grids, {}, file.path(), quiet)) << "it is read back";
}

TEST(Bundle, WhatIsNotThereOrEmptyIsSaid) {
  const Cache cache;
  const auto missing = VoluteReader::open(cache.file.path(), options("heat"));
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("'temperature', 'flame' (empty), 'density', 'velocity'"),
            std::string::npos);
  const auto empty = VoluteReader::open(cache.file.path(), options("flame"));
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::kInvalidData);
}

TEST(Bundle, OneGridAloneIsTheFileAsItWas) {
  const Cache cache;
  const ScratchFile other;
  Progress quiet;
  ASSERT_TRUE(bundle({{"density", {}, cache.grids[2].file}}, {}, other.path(), quiet));
  EXPECT_EQ(readBytes(other.path()), readBytes(cache.grids[2].file));
  // Described: the same values behind a chunk that older readers skip.
  ASSERT_TRUE(bundle({{"density", staggered(3), cache.grids[2].file}}, {}, other.path(), quiet));
  const auto bytes = readBytes(other.path());
  EXPECT_EQ(std::string(&bytes[36], 4), "GRDS");
  EXPECT_EQ(bytes[40], 1);
  EXPECT_EQ(testing::readBack(other.path())->values, cache.alone[1].values);
}

TEST(Bundle, GridsOfOtherFramesOrOfOneNameAreRefused) {
  const Cache three, two(2);
  Progress quiet;
  const ScratchFile target;
  auto grids = three.grids;
  grids[3].file = two.grids[3].file;
  const auto mixed = bundle(grids, {}, target.path(), quiet);
  ASSERT_FALSE(mixed);
  EXPECT_NE(mixed.error().message.find("'velocity' has other frames than 'temperature'"),
            std::string::npos);
  grids[3] = grids[2];
  EXPECT_FALSE(bundle(grids, {}, target.path(), quiet));
  EXPECT_FALSE(bundle({grids[1]}, {}, target.path(), quiet));
}

TEST(Bundle, WithoutValuesTheFileHasItsFramesAllTheSame) {
  VolumeInfo frames;
  frames.frames = 3;
  frames.x = frames.y = frames.z = 1;
  frames.frameNumbers = {4, 5, 7};
  frames.times = {1, 1.5, 4};
  frames.up = 'y';
  const auto nothing = emptyFrames(frames);
  const ScratchFile file;
  Progress quiet;
  ASSERT_TRUE(bundle({{"a", staggered(3)}, {"b"}}, {}, file.path(), quiet, nullptr, nothing.get()));
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->grids().size(), 2u);
  EXPECT_EQ(reader->grids()[0].description, staggered(3));
  EXPECT_TRUE(reader->grid().empty);
  EXPECT_EQ(reader->info().frameNumbers, frames.frameNumbers);
  EXPECT_EQ(reader->grids()[1].info.times, frames.times);
  EXPECT_EQ(reader->info().up, 'y');
  EXPECT_TRUE(reader->verify().complete());
  std::vector<Bricks> bricks(3);
  ASSERT_TRUE(reader->readBricks(0, 3, bricks));
  EXPECT_TRUE(bricks[2].leaves().empty());
  const auto one = VoluteReader::open(file.path(), options("b"));
  ASSERT_FALSE(one);
  EXPECT_NE(one.error().message.find("grid 'b' is empty"), std::string::npos);
  // Neither grids nor what is kept.
  EXPECT_FALSE(bundle({}, {}, file.path(), quiet, nullptr, nothing.get()));
}

/// Whether no grid can be read as if the file were whole; in part only finite values.
::testing::AssertionResult damageOfGridsIsFound(const std::filesystem::path& path) {
  bool found = false;
  for (const char* name : {"temperature", "density", "velocity"}) {
    found = found || !testing::readBack(path, options(name));
    const auto part = VoluteReader::open(path, options(name, true));
    if (!part)
      continue;
    const auto values = testing::readBack(path, options(name, true));
    if (!values)
      return ::testing::AssertionFailure() << "not readable in part: " << values.error().message;
    for (const float value : values->values) {
      if (!std::isfinite(value))
        return ::testing::AssertionFailure() << "a value that is not finite";
    }
  }
  return found ? ::testing::AssertionSuccess()
               : ::testing::AssertionFailure() << "all grids read as if whole";
}

TEST(Bundle, EveryTruncationAndAFlippedBitInAnyByteIsFound) {
  const ThreadLimit limit(1);
  const Cache cache(1);
  const auto bytes = readBytes(cache.file.path());
  ASSERT_LT(bytes.size(), 4000u);
  const ScratchFile copy;
  writeBytes(copy.path(), bytes);
  {
    std::fstream file(copy.path(), std::ios::in | std::ios::out | std::ios::binary);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      const auto bit = static_cast<int>(at % 8);
      file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(bytes[at] ^ 1 << bit));
      file.flush();
      ASSERT_TRUE(damageOfGridsIsFound(copy.path())) << "bit " << bit << " of byte " << at;
      file.seekp(static_cast<std::streamoff>(at)).put(bytes[at]);
    }
  }
  for (std::size_t size = bytes.size(); size-- > 0;) {
    std::filesystem::resize_file(copy.path(), size);
    ASSERT_TRUE(damageOfGridsIsFound(copy.path())) << size << " of " << bytes.size() << " bytes";
  }
}

TEST(Bundle, APrefixPlaysAllGridsCoarsely) {
  const Cache cache(20);
  auto bytes = readBytes(cache.file.path());
  bytes.resize(bytes.size() - bytes.size() / 10);
  const ScratchFile cut;
  writeBytes(cut.path(), bytes);
  for (const char* name : {"temperature", "density", "velocity"}) {
    const auto reader = VoluteReader::open(cut.path(), options(name, true));
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_GE(reader->verify().intactLevels, 3) << name;
  }
}

// Tables that nobody writes: none crashes, and each is refused with a reason.
TEST(GridTable, AnyBytesAreReadOrRefused) {
  for (const bool paged : {false, true}) {
    GridTable table;
    table.paged = paged;
    table.rows.push_back({"a", false, staggered(3), {10, 20, 30}, paged ? 40u : 0u});
    table.rows.push_back({"b", true, {}, {}});
    const auto bytes = writeGridTable(table);
    const auto back = readGridTable(bytes, paged);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->rows[0].description, table.rows[0].description);
    EXPECT_EQ(back->rows[0].tierBytes, table.rows[0].tierBytes);
    EXPECT_EQ(back->rows[0].pageBytes, table.rows[0].pageBytes);
    EXPECT_TRUE(back->rows[1].empty);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      EXPECT_FALSE(readGridTable(std::span(bytes).first(size), paged)) << size;
    auto broken = bytes;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      for (int value = 0; value < 256; ++value) {
        broken[at] = static_cast<std::byte>(value);
        (void)readGridTable(broken, paged);
      }
      broken[at] = bytes[at];
    }
    table.rows[1].name = "a";
    EXPECT_FALSE(readGridTable(writeGridTable(table), paged));
    table.rows.erase(table.rows.begin());
    EXPECT_EQ(readGridTable(writeGridTable(table), paged).has_value(), paged);  // all empty
    table.rows.clear();
    EXPECT_EQ(readGridTable(writeGridTable(table), paged).has_value(), paged);
  }
}

}  // namespace
}  // namespace volute
