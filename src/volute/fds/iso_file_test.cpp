// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/iso_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/fds/particle_file.hpp"
#include "volute/fds/people_file.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

FdsMesh meshOfFirst() {
  FdsMesh mesh;
  mesh.planes = kFirst;
  return mesh;
}

/// Nothing, then two triangles on levels 1 and 2, then one.
std::vector<fdswriter::Triangles> isoFrames() {
  return {{0, {}, {}, {}},
          {2, {0, 0, 0.1F, 1, 0, 0.1F, 0, 0.8F, 0.1F, 1, 0.8F, 0.5F}, {1, 2, 3, 2, 4, 3}, {1, 2}},
          {4, {0, 0, 0.2F, 1, 0, 0.2F, 0, 0.8F, 0.2F}, {1, 2, 3}, {2}}};
}

Result<FdsIsoFile> isoOf(const fdswriter::Records& file, const ScratchFolder& folder) {
  file.save(folder / "a.iso");
  return FdsIsoFile::open({0, folder / "a.iso", {"TEMPERATURE", "temp", "C"}}, meshOfFirst());
}

const std::vector<std::vector<std::array<std::string, 2>>> kQuantities = {
    {}, {{"PARTICLE TEMPERATURE", "C"}, {"PARTICLE DIAMETER", "mu-m"}}};

std::vector<fdswriter::Particles> particleFrames() {
  return {{0, {{{}, {}}, {{}, {}}}},
          {1, {{{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F}, {}}, {{}, {}}}},
          {2, {{{0.1F, 0.3F, 0.5F}, {}}, {{0.7F, 0.1F, 0.2F}, {55, 900}}}}};
}

Result<FdsParticleFile> particlesOf(const fdswriter::Records& file, const ScratchFolder& folder) {
  file.save(folder / "a.prt5");
  return FdsParticleFile::open({0, {0, 1}, folder / "a.prt5"});
}

TEST(FdsIsoFile, GivesTrianglesAndTheirLevels) {
  const ScratchFolder folder;
  for (const std::size_t split : {0, 5}) {
    const auto iso = isoOf(fdswriter::isoFile({30, 100}, isoFrames(), split), folder);
    ASSERT_TRUE(iso) << iso.error().message;
    EXPECT_THAT(iso->frames().times, ElementsAre(0, 2, 4));
    EXPECT_THAT(iso->levels(), ElementsAre(30, 100));
    EXPECT_TRUE(iso->readFrame(0)->triangles.empty());
    const auto frame = iso->readFrame(1);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(iso->bytesOf(1), 4 * (3 * 4 + 4 * 2U));
    EXPECT_THAT(frame->vertices.back(), ElementsAre(1, 0.8F, 0.5F));
    ASSERT_EQ(frame->triangles.size(), 2U);
    EXPECT_THAT(frame->triangles[1], ElementsAre(1, 3, 2));
    EXPECT_THAT(frame->levels, ElementsAre(0, 1));
  }
}

TEST(FdsIsoFile, SaysWhatIsWrong) {
  const ScratchFolder folder;
  const auto refused = [&](std::vector<fdswriter::Triangles> frames, const std::string& says) {
    const auto iso = isoOf(fdswriter::isoFile({30, 100}, frames), folder);
    ASSERT_TRUE(iso) << iso.error().message;
    const auto frame = iso->readFrame(1);
    ASSERT_FALSE(frame) << says;
    EXPECT_EQ(frame.error().code, ErrorCode::kInvalidData);
    EXPECT_THAT(frame.error().message, HasSubstr(says));
  };
  auto frames = isoFrames();
  frames[1].corners[3] = 5;
  refused(frames, "a triangle of vertex 5, where there are 4");
  frames[1].corners[3] = 0;
  refused(frames, "a triangle of vertex 0");
  frames = isoFrames();
  frames[1].levels[1] = 3;
  refused(frames, "a triangle of level 3, where there are 2");
  for (const float wrong : {9.0F, std::numeric_limits<float>::quiet_NaN()}) {
    frames = isoFrames();
    frames[1].vertices[4] = wrong;
    refused(frames, "outside of the mesh");
  }
  const auto nan = isoOf(fdswriter::isoFile({std::numeric_limits<float>::infinity()}, {}), folder);
  EXPECT_THAT(nan.error().message, HasSubstr("a level of its surfaces is inf"));
}

TEST(FdsParticleFile, GivesPlacesAndValues) {
  const ScratchFolder folder;
  for (const std::size_t split : {0, 5}) {
    const auto file =
        particlesOf(fdswriter::particleFile(kQuantities, particleFrames(), split), folder);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_THAT(file->frames().times, ElementsAre(0, 1, 2));
    EXPECT_EQ(file->classes(), 2U);
    EXPECT_EQ(file->quantitiesOf(1)[1].quantity, "PARTICLE DIAMETER");
    EXPECT_EQ(file->quantitiesOf(1)[0].unit, "C");
    EXPECT_EQ(file->count(0), 0U);
    EXPECT_EQ(file->count(1), 2U);
    EXPECT_EQ(file->count(2), 2U);
    const auto frame = file->readFrame(1);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_THAT((*frame)[0].places[1], ElementsAre(0.2F, 0.4F, 0.6F));
    const auto last = file->readFrame(2);
    EXPECT_THAT((*last)[1].places[0], ElementsAre(0.7F, 0.1F, 0.2F));
    EXPECT_THAT((*last)[1].values[1], ElementsAre(900));
  }
}

TEST(FdsPeople, AreATableOfWalksAboveTheFloorsOfTheirMeshes) {
  const ScratchFolder folder;
  const auto people = [](float x, std::vector<std::int32_t> numbers) {
    const std::size_t n = numbers.size();
    fdswriter::Particles::OfAClass one;
    for (const float value : {x, 2.0F, 4.0F}) one.places.insert(one.places.end(), n, value);
    one.bodies.assign(4 * n, 0.5F);
    one.values.assign(n, 0.1F);
    one.numbers = std::move(numbers);
    return one;
  };
  fdswriter::particleFile(
      {{{"HUMAN_SPEED", "m/s"}}},
      {{0, {people(1, {7, 9})}}, {0.5F, {people(2, {9})}}, {1, {people(0, {})}}})
      .save(folder / "a.prt5");
  fdswriter::Index index;
  index.meshes = {{{{{0, 1, 2}, {0, 1, 2}, {0, 1, 2}}}, {}, {}},
                  {{{{0, 1, 2}, {0, 1, 2}, {3, 5}}}, {}, {}, true}};
  index.files = "EVA5     2\n a.prt5\n 1\n 1\n";
  index.save(folder / "made.smv");
  const std::string above = "id,time,x,y,floor\n7,0,1,2,3\n9,0,1,2,3\n9,0.5,2,2,3\n";
  EXPECT_EQ(fdsPeopleTable(folder / "a.prt5", 1000).value(), above);
  EXPECT_EQ(fdsPeopleTable(folder / "made.smv", 1000).value(), above);
  EXPECT_TRUE(mayHoldPeople(folder / "a.prt5"));
  EXPECT_THAT(fdsPeopleTable(folder / "a.prt5", 10).error().message, HasSubstr("0 MiB"));

  index.input = "made.fds";
  index.save(folder / "made.smv");
  fdswriter::saveText(folder / "made.fds",
                      "&HEAD CHID='made' /\n&MESH ID='mesh', EVACUATION=T, EVAC_Z_OFFSET=0.5 /\n");
  EXPECT_THAT(fdsPeopleTable(folder / "made.smv", 1000).value(), HasSubstr("7,0,1,2,3.5\n"));

  fdswriter::particleFile({{}}, {{0, {{{1, 2, 3}, {}}}}}).save(folder / "drops.prt5");
  EXPECT_THAT(fdsPeopleTable(folder / "drops.prt5", 1000).error().message,
              HasSubstr("expected people of FDS+Evac"));
  index.files.clear();
  index.save(folder / "nobody.smv");
  EXPECT_THAT(fdsPeopleTable(folder / "nobody.smv", 1000).error().message,
              HasSubstr("names no people"));
}

TEST(FdsParticleFile, WorksWithoutEmptyRecordsAndSaysWhatIsWrong) {
  const ScratchFolder folder;
  // As a writer that leaves them out.
  using Words = std::vector<std::int32_t>;
  fdswriter::Records bare;
  for (const int word : {1, 600, 1}) bare.values(Words{word});
  bare.values(Words{0, 0});
  for (const float time : {0.0F, 1.0F}) {
    bare.time(time);
    bare.values(Words{0});
  }
  bare.save(folder / "a.prt5");
  const auto file = FdsParticleFile::open({0, {0}, folder / "a.prt5"});
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_THAT(file->frames().times, ElementsAre(0, 1));
  const auto other = FdsParticleFile::open({0, {0, 1}, folder / "a.prt5"});
  EXPECT_THAT(other.error().message, HasSubstr("the number of classes is 1, expected 2"));
  auto frames = particleFrames();
  frames[1].classes[0].places[2] = std::numeric_limits<float>::infinity();
  const auto wrong = particlesOf(fdswriter::particleFile(kQuantities, frames), folder);
  ASSERT_TRUE(wrong);
  EXPECT_THAT(wrong->readFrame(1).error().message, HasSubstr("a particle is at inf m"));
}

/// Every prefix is refused or has its whole frames, and every flipped bit of what is guarded is
/// refused.
template <class Open>
void damage(const fdswriter::Records& whole, const Open& open) {
  std::size_t frames = 0;
  for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
    fdswriter::Records cut;
    cut.bytes.assign(whole.bytes.begin(), whole.bytes.begin() + static_cast<std::ptrdiff_t>(size));
    const auto file = open(cut);
    if (!file) {
      EXPECT_EQ(file.error().code, ErrorCode::kTruncated) << file.error().message;
      EXPECT_EQ(frames, 0U);
      continue;
    }
    // What may be left out after a class without particles makes a frame whole before its end.
    EXPECT_GE(file->frames().times.size() + 1, frames);
    frames = std::max(frames, file->frames().times.size());
    for (std::size_t i = 0; i < file->frames().times.size(); ++i) EXPECT_TRUE(file->readFrame(i));
  }
  for (const auto& [begin, end] : whole.guarded) {
    for (std::size_t bit = 8 * begin; bit < 8 * end; ++bit) {
      fdswriter::Records flipped;
      flipped.bytes = whole.bytes;
      flipped.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      const auto file = open(flipped);
      // A longer file may end within what a larger count announces.
      if (file) {
        EXPECT_LT(file->frames().times.size(), 3U) << "byte " << bit / 8 << " bit " << bit % 8;
        EXPECT_FALSE(file->frames().remarks.empty());
      }
    }
  }
}

TEST(FdsIsoFile, IsReadToItsLastWholeFrameAndDamageIsRefused) {
  const ScratchFolder folder;
  damage(fdswriter::isoFile({30, 100}, isoFrames()),
         [&](const fdswriter::Records& file) { return isoOf(file, folder); });
}

TEST(FdsParticleFile, IsReadToItsLastWholeFrameAndDamageIsRefused) {
  const ScratchFolder folder;
  damage(fdswriter::particleFile(kQuantities, particleFrames()),
         [&](const fdswriter::Records& file) { return particlesOf(file, folder); });
}

TEST(FrameTimes, TheNearestOne) {
  const std::vector<double> times = {0, 10, 30};
  for (const auto& [time, place] :
       {std::pair(-5.0, 0U), {4.9, 0U}, {5.0, 0U}, {5.1, 1U}, {20.1, 2U}, {99.0, 2U}})
    EXPECT_EQ(nearestFrame(times, time), place) << time;
}

}  // namespace
}  // namespace volute
