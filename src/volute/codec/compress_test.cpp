// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <bit>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/base/team_testing.hpp"
#include "volute/codec/codec_testing.hpp"
#include "volute/grid/array_source.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;
using namespace testing;

// Compresses, reads back and checks that the report tells the truth.
CompressReport checkedRoundTrip(const Sequence& sequence, ErrorTarget target,
                                const CompressOptions& options = {}) {
  const ScratchFile file;
  const auto report = compressTo(file.path(), sequence, target, options);
  EXPECT_TRUE(report) << report.error().message;
  if (!report)
    return {};
  const auto decoded = readBack(file.path());
  EXPECT_TRUE(decoded) << decoded.error().message;
  if (!decoded)
    return {};
  const auto difference = differenceOf(sequence, *decoded);
  EXPECT_NEAR(difference.relativeRms, report->relativeRms, 1e-9 * difference.relativeRms);
  EXPECT_EQ(difference.maxError, report->maxError);
  EXPECT_EQ(report->fileBytes, std::filesystem::file_size(file.path()));
  return *report;
}

TEST(Compress, EveryKindOfTargetIsMetAndNotWasted) {
  const Sequence sequence = plumes(18, 16, 20, 33);
  const double raw = static_cast<double>(sequence.info.rawBytes());
  for (const double rms : {2e-2, 3e-3, 3e-4}) {
    const auto report = checkedRoundTrip(sequence, {Kind::kRms, rms});
    EXPECT_LE(report.support.rms, rms);
    EXPECT_GT(report.support.rms, 0.75 * rms);
    const auto look = checkedRoundTrip(sequence, {Kind::kLook, rms});
    EXPECT_LE(look.support.rms, rms);
    EXPECT_GT(look.support.rms, 0.75 * rms);
    const auto overAll = checkedRoundTrip(sequence, {Kind::kRmsOverAll, rms});
    EXPECT_LE(overAll.relativeRms, rms);
    EXPECT_GT(overAll.relativeRms, 0.75 * rms);
  }
  EXPECT_LE(checkedRoundTrip(sequence, {Kind::kPsnr, 50}).relativeRms, std::pow(10, -2.5));
  for (const double ratio : {20.0, 40.0}) {
    const auto report = checkedRoundTrip(sequence, {Kind::kRatio, ratio});
    EXPECT_LE(static_cast<double>(report.fileBytes), raw / ratio);
    EXPECT_GT(static_cast<double>(report.fileBytes), 0.9 * raw / ratio);
  }
  const auto sized = checkedRoundTrip(sequence, {Kind::kSize, 30000});
  EXPECT_LE(sized.fileBytes, 30000u);
  EXPECT_GT(sized.fileBytes, 27000u);
  for (const double error : {0.1, 0.003}) {
    const auto report = checkedRoundTrip(sequence, {Kind::kMaxError, error});
    EXPECT_LE(report.maxError, error);
    EXPECT_GT(report.maxError, 0.5 * error);
  }
}

// The nearest 16-bit float.
float asHalf(float value) {
  if (value == 0)
    return 0;
  const int bits = 10 - std::max(std::ilogb(value), -14);
  return std::ldexp(std::nearbyint(std::ldexp(value, bits)), -bits);
}

TEST(Compress, HalvesMeetTheTargetAndWasteNothing) {
  Sequence sequence = plumes(18, 16, 20, 33);
  std::ranges::transform(sequence.values, sequence.values.begin(), asHalf);
  for (const Kind kind : {Kind::kRms, Kind::kLook, Kind::kRmsOverAll}) {
    for (const double rms : {3e-3, 7e-4, 3e-4, 1e-4}) {
      const ScratchFile file;
      CompressOptions options;
      options.halves = true;
      const auto report = compressTo(file.path(), sequence, {kind, rms}, options);
      ASSERT_TRUE(report) << report.error().message;
      const bool overAll = kind == Kind::kRmsOverAll;
      EXPECT_GT(overAll ? report->relativeRms : report->support.rms,
                (rms > 5e-4 ? 0.9 : 0.45) * rms);
      Sequence decoded = readBack(file.path()).value();
      std::ranges::transform(decoded.values, decoded.values.begin(), asHalf);
      const double share = overAll ? 1 : report->support.share;
      const double range = overAll ? report->valueMax - report->valueMin
                                   : report->support.high - report->support.low;
      const double whole = differenceOf(sequence, decoded).relativeRms *
                           (report->valueMax - report->valueMin) / range / std::sqrt(share);
      EXPECT_LE(whole, rms) << rms;
    }
  }
}

/// A strong ball and a faint one of the same shape: the faint one's own error, against that of an
/// error that is the same for all values. Values of both signs.
TEST(Compress, LookKeepsWhatIsFaint) {
  for (const float sign : {1.0F, -1.0F}) {
    Sequence sequence = plumes(4, 24, 24, 24);
    const std::size_t half = 12;
    auto view = sequence.view();
    const auto isFaint = [&](std::size_t i) { return i % 24 >= half; };
    for (int t = 0; t < 4; ++t)
      for (int k = 0; k < 24; ++k)
        for (int j = 0; j < 24; ++j)
          for (int i = 0; i < 12; ++i)
            view(t, k, j, i + 12, 0) = sign * 1e-3F * view(t, k, j, i, 0);
    const auto faintError = [&](ErrorTarget target) {
      const ScratchFile file;
      EXPECT_TRUE(compressTo(file.path(), sequence, target));
      const Sequence decoded = readBack(file.path()).value();
      double squared = 0, all = 0;
      for (std::size_t i = 0; i < decoded.values.size(); ++i) {
        EXPECT_TRUE(sequence.values[i] != 0 || decoded.values[i] == 0);
        if (!isFaint(i))
          continue;
        squared += std::pow(decoded.values[i] - sequence.values[i], 2);
        all += std::pow(sequence.values[i], 2);
      }
      return std::sqrt(squared / all);
    };
    const double look = faintError({Kind::kLook, 3e-3}), even = faintError({Kind::kRms, 3e-3});
    EXPECT_LT(look, 0.35);
    EXPECT_LT(look, 0.5 * even);
  }
}

TEST(Compress, QualityWordsAreTargets) {
  EXPECT_EQ(kQualityWords[1].word, "look");
  EXPECT_EQ(kQualityWords[1].target.value, CompressOptions().target.value);
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), plumes(3, 8, 8, 20), kQualityWords[1].target));
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->header().targetKind, "look");
}

RC_GTEST_PROP(Compress, AnySizeOfVolumeComesBackWithinItsError, ()) {
  const auto side = [](int most) { return *rc::gen::inRange(1, most); };
  const int channels = *rc::gen::element(1, 3);
  const Sequence sequence =
      plumes(side(20), side(20), side(20), side(36), channels, *rc::gen::element(0.0f, 100.0f));
  const ScratchFile file;
  const auto report = compressTo(file.path(), sequence, {Kind::kRms, 5e-3});
  RC_ASSERT(report.has_value());
  const auto decoded = readBack(file.path());
  RC_ASSERT(decoded.has_value());
  RC_ASSERT(differenceOf(sequence, *decoded).relativeRms <= 5e-3);
  RC_ASSERT(decoded->info.x == sequence.info.x && decoded->info.frames == sequence.info.frames);
}

/// Doubles, rounded as they are read.
class Doubles final : public RoundingSource {
 public:
  Doubles(VolumeInfo info, std::vector<double> numbers)
      : info_(std::move(info)), numbers_(std::move(numbers)) {}

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    const double* from = &numbers_[static_cast<std::size_t>(index) * values.size()];
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(from[i] - offset_);
      const double shown = offset_ + static_cast<double>(values[i]);
      rounding_ = std::max(rounding_, std::abs(from[i] - shown));
    }
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return true; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset, rounding_ = 0; }

 private:
  VolumeInfo info_;
  std::vector<double> numbers_;
  double rounding_ = 0, offset_ = 0;
};

RC_GTEST_PROP(Compress, ErrorsAreThoseOfTheDoublesOrTheTargetIsRefused, ()) {
  Sequence sequence = plumes(3, 8, 8, 20);
  const double offset = std::pow(10, *rc::gen::inRange(0, 8));
  std::vector<double> numbers;
  for (const float value : sequence.values) numbers.push_back(offset + 0.1 + value);
  Doubles source(sequence.info, numbers);
  CompressOptions options;
  const ErrorTarget& target = options.target;
  options.target = *rc::gen::element(ErrorTarget{Kind::kMaxError, 3e-3},
                                     ErrorTarget{Kind::kRms, 3e-3}, ErrorTarget{Kind::kRatio, 4},
                                     ErrorTarget{Kind::kPsnr, 50}, ErrorTarget{Kind::kLook, 3e-3});
  const ScratchFile file;
  Progress quiet;
  const auto report = compress(source, file.path(), options, quiet);
  if (!report) {
    RC_ASSERT(target.kind != Kind::kRatio && offset >= 1e4);
    RC_ASSERT(report.error().code == ErrorCode::kUnsupported);
    return;
  }
  const auto decoded = readBack(file.path());
  RC_ASSERT(decoded.has_value());
  double most = 0, squared = 0;
  const auto [low, high] = std::ranges::minmax(numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double error = std::abs(decoded->values[i] - numbers[i]);
    most = std::max(most, error), squared += error * error;
  }
  const double rms = std::sqrt(squared / static_cast<double>(numbers.size())) / (high - low);
  RC_ASSERT(most <= report->maxError);
  RC_ASSERT(rms <= report->relativeRms * (1 + 1e-6));
  if (target.kind == Kind::kMaxError)
    RC_ASSERT(report->maxError <= 3e-3);
  if (target.isOverSupport())
    RC_ASSERT(report->relativeRms <= 3e-3);
  if (target.kind == Kind::kPsnr)
    RC_ASSERT(report->relativeRms <= std::pow(10, -2.5));
}

TEST(Compress, DoublesThatAllBecomeZeroAreRefused) {
  const Sequence sequence = plumes(2, 8, 8, 20);
  const auto scaled = [&](double by, float first) {
    std::vector<double> numbers;
    for (const float value : sequence.values) numbers.push_back(by * value);
    numbers.front() = first;
    Doubles source(sequence.info, numbers);
    const ScratchFile file;
    Progress quiet;
    const auto report = compress(source, file.path(), {}, quiet);
    return report ? "" : report.error().message;
  };
  EXPECT_THAT(scaled(1e-300, 0), ::testing::HasSubstr("and would become 0: they go up to"));
  EXPECT_EQ(scaled(1e-300, 1), "") << "faint beside others";
  EXPECT_EQ(scaled(0, 0), "");
}

RC_GTEST_PROP(Compress, NumbersFarFromZeroKeepAnErrorThatFloatsDoNotHold, ()) {
  Sequence sequence = plumes(3, 8, 8, 20);
  const double far = std::pow(10, *rc::gen::inRange(3, 9)) * *rc::gen::element(1.0, -1.0);
  const bool partly = *rc::gen::arbitrary<bool>();  // beside a background of 0
  std::vector<double> numbers;
  for (const float value : sequence.values)
    numbers.push_back(partly && !(value > 0.05F) ? 0 : far + 0.1 + value);
  Doubles source(sequence.info, numbers);
  RC_ASSERT(settleOffset(source).has_value());
  CompressOptions options;
  options.target = *rc::gen::element(ErrorTarget{Kind::kMaxError, 1e-3},
                                     ErrorTarget{Kind::kRms, 3e-4}, ErrorTarget{Kind::kLook, 3e-4});
  const ScratchFile file;
  Progress quiet;
  const auto report = compress(source, file.path(), options, quiet);
  RC_ASSERT(report.has_value());
  const auto reader = VoluteReader::open(file.path(), {.differences = Offsets::kAll});
  RC_ASSERT(reader.has_value());
  const auto rounded = readBack(file.path());
  RC_ASSERT(rounded.has_value());
  std::vector<float> frame(sequence.info.frameValues());
  double most = 0;
  for (int t = 0; t < sequence.info.frames; ++t) {
    RC_ASSERT(reader->readRegion(t, {0, 0, 0}, {8, 8, 20}, frame).has_value());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(t) * frame.size() + i;
      const double shown = reader->offset() + frame[i];
      most = std::max(most, std::abs(shown - numbers[at]));
      RC_ASSERT(rounded->values[at] == static_cast<float>(shown));
    }
  }
  RC_ASSERT(most <= report->maxError && report->maxError < 0.1);
  if (options.target.kind == Kind::kMaxError)
    RC_ASSERT(most <= 1e-3);
  const auto [low, high] = std::ranges::minmax(numbers);
  RC_ASSERT(std::abs(reader->header().valueMin - low) < 1e-3);
  RC_ASSERT(std::abs(reader->header().valueMax - high) < 1e-3);
}

RC_GTEST_PROP(Compress, FloatsFarFromZeroKeepTheirErrorAsFloatsAndAsDoubles, ()) {
  Sequence sequence = plumes(3, 8, 8, 20, *rc::gen::element(1, 3));
  const double far = std::pow(10, *rc::gen::inRange(2, 7)) * *rc::gen::element(1.0, -1.0);
  const double scale = *rc::gen::element(0.03, 1.0, 20.0);
  const bool partly = *rc::gen::arbitrary<bool>();  // beside a background of 0
  for (float& value : sequence.values)
    value = partly && !(value > 0.05F) ? 0 : static_cast<float>(far + scale * value);
  constexpr NumberType kFloats{NumberKind::kFloat32, std::endian::native == std::endian::big};
  ArraySource source(sequence.info, {std::as_bytes(std::span(sequence.values)).data(), kFloats,
                                     denseStrides(sequence.info, kFloats)});
  RC_ASSERT(settleOffset(source).has_value());
  CompressOptions options;
  options.target = *rc::gen::element(
      ErrorTarget{Kind::kMaxError, 1e-3}, ErrorTarget{Kind::kMaxError, 0.011},
      ErrorTarget{Kind::kMaxError, 0.1}, ErrorTarget{Kind::kRms, 1e-4}, ErrorTarget{});
  const ScratchFile file;
  Progress quiet;
  const auto report = compress(source, file.path(), options, quiet);
  RC_ASSERT(report.has_value());
  const auto reader = VoluteReader::open(file.path(), {.differences = Offsets::kAll});
  RC_ASSERT(reader.has_value());
  const auto rounded = readBack(file.path());
  RC_ASSERT(rounded.has_value());
  std::vector<float> frame(sequence.info.frameValues());
  double most = 0, squares = 0, roundedSquares = 0;
  for (int t = 0; t < sequence.info.frames; ++t) {
    RC_ASSERT(reader->readRegion(t, {0, 0, 0}, {8, 8, 20}, frame).has_value());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(t) * frame.size() + i;
      const double number = sequence.values[at];
      const double error = std::abs(reader->offset() + frame[i] - number);
      const double ofFloats = std::abs(rounded->values[at] - number);
      most = std::max({most, error, ofFloats});
      squares += error * error, roundedSquares += ofFloats * ofFloats;
    }
  }
  RC_ASSERT(most <= report->maxError);
  if (options.target.kind == Kind::kMaxError)
    RC_ASSERT(report->maxError <= options.target.value);
  else
    RC_ASSERT(report->support.rms <= options.target.value);
  const double support = report->support.share * static_cast<double>(sequence.values.size());
  const double rms = std::sqrt(std::max(squares, roundedSquares) / std::max(support, 1.0));
  const double range = report->support.high - report->support.low;
  RC_ASSERT(rms <= report->support.rms * (range > 0 ? range : std::abs(far)) * (1 + 1e-6));
}

TEST(Compress, OffsetsAreOfWhatIsFarFromZeroAlone) {
  class Counted final : public LayerwiseSource {
   public:
    explicit Counted(Sequence sequence) : sequence_(std::move(sequence)) {}

    const VolumeInfo& info() const override { return sequence_.info; }

    Status readLayers(int index, int first, int end, std::span<float> values) override {
      ++reads;
      const std::size_t layer = info().frameValues() / static_cast<std::size_t>(info().z);
      const std::size_t begin = info().frameValues() * static_cast<std::size_t>(index) +
                                layer * static_cast<std::size_t>(first);
      std::copy_n(sequence_.values.begin() + static_cast<std::ptrdiff_t>(begin),
                  layer * static_cast<std::size_t>(end - first), values.begin());
      return {};
    }

    double rounding() const override { return 0; }

    double offset() const override { return offset_; }

    bool takesOffset() const override { return true; }

    void takeOffset(double offset) override { offset_ = offset; }

    int reads = 0;

   private:
    Sequence sequence_;
    double offset_ = 0;
  };

  const auto offsetOfPlumes = [](float base, float scale, Offsets which, int& reads) {
    Sequence sequence = plumes(9, 8, 8, 20);
    for (float& value : sequence.values) value = base + scale * value;
    Counted source(std::move(sequence));
    EXPECT_TRUE(settleOffset(source, which));
    reads = source.reads;
    return source.offset();
  };
  int reads = 0;
  EXPECT_EQ(offsetOfPlumes(0, 1, Offsets::kAll, reads), 0);
  EXPECT_EQ(reads, 1) << "one frame tells it";
  EXPECT_EQ(offsetOfPlumes(300, 100, Offsets::kAll, reads), 0);
  EXPECT_EQ(offsetOfPlumes(300, 0, Offsets::kAll, reads), 0) << "constant";
  EXPECT_EQ(offsetOfPlumes(300, 1, Offsets::kOfRounded, reads), 0);
  EXPECT_EQ(reads, 0) << "floats are never rounded";
  const double offset = offsetOfPlumes(300, 1, Offsets::kAll, reads);
  EXPECT_NEAR(offset, 300, 64);
  EXPECT_EQ(reads, 9);
  EXPECT_EQ(offsetOfPlumes(301, 1.1F, Offsets::kAll, reads), offset) << "another part of it";
}

TEST(Compress, ASmallMaximumErrorIsMetWhereASmallerOneIs) {
  Sequence sequence = plumes(3, 8, 8, 20);
  for (float& value : sequence.values) value = 0.3F + 1.7F * value;
  for (const double most : {3e-5, 2e-5, 1.2e-5, 1e-5, 9e-6, 5e-6, 2e-6}) {
    const ScratchFile file;
    const auto report = compressTo(file.path(), sequence, {Kind::kMaxError, most});
    ASSERT_TRUE(report.has_value()) << report.error().message;
    EXPECT_LE(report->maxError, most);
  }
}

// Found by the property above it: with few values the error goes up and down with the step just
// above the target, and the finest step is asked for, at which CDF 9/7's scaling coefficient has 30
// bits. The values that are even around the plumes do not count for the target.
TEST(Compress, FewValuesFarFromZeroKeepTheirError) {
  for (const auto& [t, z, y, x] : {std::array{10, 7, 13, 2}, std::array{16, 15, 5, 2}}) {
    const Sequence sequence = plumes(t, z, y, x, 1, 100);
    const auto report = checkedRoundTrip(sequence, {Kind::kRms, 5e-3});
    EXPECT_LE(report.relativeRms, 5e-3);
    EXPECT_LE(report.fileBytes, 1500u);
  }
}

TEST(Compress, TheFinestStepHoldsTheGreatestCoefficients) {
  for (const char* mode : {"plain:cdf97:4", "plain:cdf53:4", "plain:haar:4"}) {
    CompressOptions options;
    options.mode = blockModeByName(mode);
    const ScratchFile file;
    const auto refused =
        compressTo(file.path(), plumes(16, 16, 16, 16, 1, 100), {Kind::kRms, 1e-9}, options);
    ASSERT_FALSE(refused.has_value());
    const std::string& message = refused.error().message;
    const std::string_view before = "leaves a relative RMS of ";
    const auto at = message.find(before);
    ASSERT_NE(at, std::string::npos) << message;
    EXPECT_LE(std::stod(message.substr(at + before.size())), 5e-4) << mode;
  }
}

// Blocks without an exact zero whose last row of frames leaves few halvings: every choice of modes
// has one for them.
TEST(Compress, EveryChoiceOfModesKeepsBlocksOfFewFrames) {
  for (const int effort : {1, 3, 5, 9}) {
    for (const char* wavelet : {"auto", "haar", "cdf53", "cdf97"}) {
      CompressOptions options;
      options.effort = effort;
      options.wavelet = wavelet;
      for (const int frames : {1, 2, 3, 4, 5, 8, 17, 18, 19, 20, 33}) {
        const Sequence sequence = plumes(frames, 8, 8, 8, 1, 1);
        const auto report = checkedRoundTrip(sequence, {Kind::kRms, 1e-3}, options);
        EXPECT_LE(report.relativeRms, 1e-3) << effort << wavelet << frames;
        EXPECT_GT(report.relativeRms, 1e-5) << effort << wavelet << frames;
      }
    }
  }
}

TEST(Compress, FastAtASizeLosesNoFrame) {
  const Sequence sequence = plumes(17, 16, 16, 16, 1, 1);
  CompressOptions fast;
  fast.effort = kFastEffort;
  const auto all = checkedRoundTrip(sequence, {Kind::kRatio, 60});
  const auto report = checkedRoundTrip(sequence, {Kind::kRatio, 60}, fast);
  EXPECT_LE(report.relativeRms, 1.2 * all.relativeRms);
  EXPECT_LE(report.maxError, 1.5 * all.maxError);
}

// The step of the first choice is far too coarse for the target: a faint block that was left out
// then is written after all.
TEST(Compress, BlocksLeftOutAtACoarseStepAreWrittenAtAFineOne) {
  Sequence sequence = plumes(16, 16, 16, 48);
  auto view = sequence.view();
  for (int t = 0; t < 16; ++t)
    for (int z = 0; z < 16; ++z)
      for (int y = 0; y < 16; ++y)
        for (int x = 32; x < 48; ++x)
          view(t, z, y, x, 0) = 1e-4f * static_cast<float>((x * 7 + y * 13 + z * 29 + t * 31) % 17);
  for (const double rms : {1e-4, 1e-5, 2e-6})
    EXPECT_LE(checkedRoundTrip(sequence, {Kind::kRms, rms}).relativeRms, rms);
}

TEST(Compress, ADenseFieldOverAllVoxelsPaysForNoTopology) {
  const Sequence sequence = plumes(17, 20, 21, 22);
  const ScratchFile file;
  for (const Kind kind : {Kind::kRmsOverAll, Kind::kPsnr, Kind::kRms}) {
    const auto report =
        testing::compressTo(file.path(), sequence, {kind, kind == Kind::kPsnr ? 50 : 3e-3});
    ASSERT_TRUE(report) << report.error().message;
    const auto reader = VoluteReader::open(file.path());
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_EQ(reader->header().codec, 3);
    EXPECT_EQ(reader->hasTopology(), kind == Kind::kRms);
    EXPECT_GE(report->support.rms, report->relativeRms);
    const auto back = testing::readBack(file.path());
    ASSERT_TRUE(back);
    EXPECT_NEAR(differenceOf(sequence, *back).relativeRms, report->relativeRms, 1e-9);
  }
}

TEST(Compress, OddSizesOfManyBlocks) {
  const auto report = checkedRoundTrip(plumes(34, 21, 35, 19), {Kind::kRms, 3e-3});
  EXPECT_LE(report.relativeRms, 3e-3);
  EXPECT_GT(report.blocks, 0u);
  EXPECT_LT(report.blocks, 3u * 2 * 3 * 2);  // those of empty space are not there
}

TEST(Compress, TheSmallestVolumes) {
  for (const auto& [t, z, y, x] :
       {std::array{1, 1, 1, 1}, {1, 1, 1, 5}, {1, 5, 1, 1}, {5, 1, 1, 1}, {1, 17, 17, 17}}) {
    const auto report = checkedRoundTrip(plumes(t, z, y, x, 1, -3), {Kind::kRms, 1e-3});
    EXPECT_LE(report.relativeRms, 1e-3) << t << z << y << x;
  }
}

TEST(Compress, ConstantFieldsAreExact) {
  for (const float value : {0.0f, -2.5f, 1e-30f, 3e38f}) {
    Sequence sequence = makeSequence(17, 5, 18, 3, 3);
    std::ranges::fill(sequence.values, value);
    const auto report = checkedRoundTrip(sequence, {Kind::kRms, 1e-3});
    EXPECT_EQ(report.relativeRms, 0);
    EXPECT_LT(report.fileBytes, 800u);
  }
}

TEST(Compress, EmptySpaceStaysExactlyZero) {
  Sequence sequence = plumes(32, 32, 32, 32);
  auto view = sequence.view();
  for (int t = 16; t < 32; ++t)
    for (int z = 0; z < 32; ++z)
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) view(t, z, y, x, 0) = 0;
  const ScratchFile file;
  ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 1e-2}));
  const auto decoded = readBack(file.path());
  ASSERT_TRUE(decoded);
  for (std::size_t i = sequence.values.size() / 2; i < sequence.values.size(); ++i)
    ASSERT_EQ(decoded->values[i], 0);
}

TEST(Compress, ExtremeValuesDoNotOverflow) {
  Sequence sequence = makeSequence(3, 4, 5, 6);
  for (std::size_t i = 0; i < sequence.values.size(); ++i)
    sequence.values[i] = i % 3 == 0 ? 3.4e38f : i % 3 == 1 ? -3.4e38f : 1e-44f;
  EXPECT_LE(checkedRoundTrip(sequence, {Kind::kRms, 1e-3}).relativeRms, 1e-3);
}

TEST(Compress, ReachesWhatFloatsAllowAndSaysWhenNot) {
  const Sequence sequence = plumes(4, 8, 8, 8);
  EXPECT_LE(checkedRoundTrip(sequence, {Kind::kMaxError, 2e-6}).maxError, 2e-6);
  const ScratchFile file;
  const auto refused = compressTo(file.path(), sequence, {Kind::kMaxError, 1e-12});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(refused.error().message.find("cannot be reached"), std::string::npos);
  const auto tooSmall = compressTo(file.path(), sequence, {Kind::kSize, 100});
  ASSERT_FALSE(tooSmall);
  EXPECT_NE(tooSmall.error().message.find("the smallest is"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file.path()));
  EXPECT_TRUE(std::filesystem::is_empty(file.folder()));
}

TEST(Compress, ErrorsNameTheFileAsTheCallerDoes) {
  const Sequence sequence = plumes(1, 8, 8, 8);
  const ScratchFile file;
  CompressOptions options;
  for (const std::string name : {"", "result.volute"}) {
    options.name = name;
    const auto refused = compressTo(file.path(), sequence, {Kind::kMaxError, 1e-12}, options);
    ASSERT_FALSE(refused);
    const std::string shown = name.empty() ? file.path().string() : name;
    EXPECT_TRUE(refused.error().message.starts_with(shown + ": ")) << refused.error().message;
  }
  const auto nowhere =
      compressTo(file.folder() / "none" / "a.volute", sequence, {Kind::kRms, 1e-3}, options);
  ASSERT_FALSE(nowhere);
  EXPECT_TRUE(nowhere.error().message.starts_with("result.volute: ")) << nowhere.error().message;
}

TEST(Compress, NonsenseTargetsAndWaveletsAreRefused) {
  const Sequence sequence = plumes(1, 4, 4, 4);
  const ScratchFile file;
  for (const ErrorTarget target : {ErrorTarget{Kind::kMaxError, 0},
                                   {Kind::kRms, 0},
                                   {Kind::kRms, -1},
                                   {Kind::kRatio, NAN},
                                   {Kind::kPsnr, INFINITY}}) {
    const auto refused = compressTo(file.path(), sequence, target);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  }
  SequenceSource source(sequence);
  Progress progress;
  CompressOptions options;
  options.wavelet = "db4";
  EXPECT_EQ(compress(source, file.path(), options, progress).error().code,
            ErrorCode::kInvalidArgument);
}

TEST(Compress, ValuesThatAreNotFiniteAreNamed) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    Sequence sequence = plumes(20, 4, 5, 6, 3);
    sequence.info.name = "flame";
    sequence.info.frameNumbers[18] = 77;
    sequence.info.frameNumbers[19] = 78;
    sequence.view()(18, 1, 2, 3, 2) = bad;
    sequence.view()(19, 0, 0, 0, 0) = bad;
    const ScratchFile file;
    const auto refused = compressTo(file.path(), sequence, {});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(
                  "grid 'flame', frame 77, voxel (3, 2, 1) in x, y, z, channel 2"),
              std::string::npos)
        << refused.error().message;
  }
}

TEST(Compress, TheSameBytesForAnyNumberOfThreads) {
  const Sequence sequence = plumes(18, 20, 33, 35);  // 36 blocks
  std::string first;
  for (const int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    const ScratchFile file;
    ASSERT_TRUE(compressTo(file.path(), sequence, {Kind::kRms, 2e-3}));
    const auto bytes = readBytes(file.path());
    if (first.empty())
      first = bytes;
    EXPECT_EQ(bytes, first) << threads;
  }
}

// As a file whose layers can be read apart; `broken`: a frame that cannot be read.
class LayeredSource final : public FrameSource {
 public:
  explicit LayeredSource(const Sequence& sequence, int broken = -1)
      : source_(sequence), broken_(broken) {}

  const VolumeInfo& info() const override { return source_.info(); }

  Status readFrame(int index, std::span<float> values) override {
    if (index == broken_)
      return fail(ErrorCode::kIo, "frame {} cannot be read", index);
    return source_.readFrame(index, values);
  }

  bool readsLayers() const override { return true; }

 private:
  SequenceSource source_;
  int broken_;
};

TEST(Compress, TheSameBytesForAnyNumberOfRanks) {
  struct Case {
    ErrorTarget target;
    int channels;
  };

  for (const Case& one : {Case{{Kind::kRms, 2e-3}, 3}, Case{{Kind::kSize, 9000}, 1},
                          Case{{Kind::kMaxError, 0.05}, 1}}) {
    const Sequence sequence = plumes(33, 20, 18, 20, one.channels);  // 3 rows of 2 layers
    std::string alone;
    for (const int ranks : {1, 2, 3, 4, 8}) {
      const ScratchFile file;
      onRanks(ranks, [&](Team& team) {
        SequenceSource whole(sequence);
        LayeredSource layered(sequence);
        CompressOptions options;
        options.target = one.target;
        Progress progress;
        FrameSource& source = ranks == 3 ? static_cast<FrameSource&>(whole) : layered;
        const auto report = compress(source, file.path(), options, progress, team);
        ASSERT_TRUE(report) << report.error().message;
        EXPECT_EQ(report->fileBytes, std::filesystem::file_size(file.path()));
      });
      const auto bytes = readBytes(file.path());
      if (alone.empty())
        alone = bytes;
      EXPECT_EQ(bytes, alone) << ranks << " ranks, " << one.channels << " channels";
      EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.folder()), {}), 1);
    }
  }
}

/// Stops after it was asked so often.
class StopsAfter final : public Progress {
 public:
  explicit StopsAfter(int left) : left_(left) {}

  bool cancelled() const override { return left_-- <= 0; }

 private:
  mutable std::atomic<int> left_;
};

TEST(Compress, GoesOnFromFinishedUnits) {
  const Sequence sequence = plumes(50, 20, 18, 20);
  const ScratchFile file;
  CompressOptions options;
  options.target = {Kind::kRms, 2e-3};
  SequenceSource alone(sequence);
  Progress calm;
  ASSERT_TRUE(compress(alone, file.path(), options, calm));
  const auto expected = readBytes(file.path());
  options.work = file.folder() / "work";
  // Later and later, each time with other ranks, on what the runs before have left.
  int ranks = 1;
  bool finished = false;
  for (int left = 5; !finished && left < 400; left += 25) {
    std::filesystem::remove(file.path());
    ranks = ranks % 4 + 1;
    std::atomic<bool> whole{true};
    onRanks(ranks, [&](Team& team) {
      LayeredSource source(sequence);
      StopsAfter progress(left);
      const auto report = compress(source, file.path(), options, progress, team);
      if (!report) {
        EXPECT_EQ(report.error().code, ErrorCode::kCancelled) << report.error().message;
        whole = false;
      }
    });
    finished = whole;
    EXPECT_EQ(std::filesystem::exists(file.path()), finished);
  }
  ASSERT_TRUE(finished);
  EXPECT_EQ(readBytes(file.path()), expected);
  EXPECT_FALSE(std::filesystem::exists(options.work));
}

// Units of other values, and units that a disk has lost or spoilt, are done again.
TEST(Compress, DoesNotTrustWhatItFinds) {
  const Sequence sequence = plumes(40, 12, 12, 12);
  Sequence other = sequence;
  other.values[1000] += 1e-6f;
  const ScratchFile file;
  CompressOptions options;
  options.target = {Kind::kRms, 2e-3};
  Progress calm;
  SequenceSource source(sequence);
  ASSERT_TRUE(compress(source, file.path(), options, calm));
  const auto expected = readBytes(file.path());
  options.work = file.folder() / "work";
  const auto interrupt = [&](const Sequence& values, int after) {
    SequenceSource interrupted(values);
    StopsAfter progress(after);
    EXPECT_FALSE(compress(interrupted, file.path(), options, progress));
  };
  interrupt(other, 25);
  interrupt(sequence, 25);
  int damaged = 0;
  for (const auto& entry : std::filesystem::directory_iterator(options.work)) {
    auto bytes = readBytes(entry.path());
    if (++damaged % 3 == 0)
      std::filesystem::remove(entry.path());
    if (damaged % 3 == 1)
      bytes[bytes.size() / 2] ^= 1;
    if (damaged % 3 == 1)
      testing::writeBytes(entry.path(), bytes);
  }
  EXPECT_GT(damaged, 6);
  ASSERT_TRUE(compress(source, file.path(), options, calm));
  EXPECT_EQ(readBytes(file.path()), expected);
  EXPECT_FALSE(std::filesystem::exists(options.work));
}

// All frames of a row need 18 MiB, 16 layers of them half of that.
TEST(Compress, LayersThatFitInMemoryGiveTheSameBytes) {
  const Sequence sequence = plumes(16, 32, 32, 32);
  CompressOptions options;
  std::vector<std::string> files;
  for (const std::uint64_t memory : {std::uint64_t{10} << 20, std::uint64_t{64} << 20}) {
    LayeredSource source(sequence);
    options.maxMemory = memory;
    Progress progress;
    const ScratchFile file;
    ASSERT_TRUE(compress(source, file.path(), options, progress));
    files.push_back(readBytes(file.path()));
  }
  EXPECT_EQ(files[0], files[1]);
}

// Whichever rank comes to the frame that nobody can read.
TEST(Compress, AFrameThatCannotBeReadEndsAllRanks) {
  const Sequence sequence = plumes(64, 16, 16, 16);
  const ScratchFile file;
  onRanks(3, [&](Team& team) {
    LayeredSource source(sequence, 40);
    Progress progress;
    const auto report = compress(source, file.path(), {}, progress, team);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find("frame 40 cannot be read"), std::string::npos)
        << report.error().message;
  });
  EXPECT_TRUE(std::filesystem::is_empty(file.folder()));
}

TEST(Compress, RanksWithDifferentSequencesAreRefused) {
  const Sequence one = plumes(20, 8, 8, 8), other = plumes(21, 8, 8, 8);
  const ScratchFile file;
  onRanks(3, [&](Team& team) {
    SequenceSource source(team.rank() == 2 ? other : one);
    Progress progress;
    const auto report = compress(source, file.path(), {}, progress, team);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find("rank 2 reads another sequence"), std::string::npos);
  });
  EXPECT_TRUE(std::filesystem::is_empty(file.folder()));
}

// Blocks of few frames where single frames are read, of many where all are.
TEST(Compress, AccessSaysHowManyFramesABlockHas) {
  for (const int frames : {3, 16, 37}) {
    const Sequence sequence = plumes(frames, 16, 20, 33);
    for (const Kind kind : {Kind::kRmsOverAll, Kind::kLook, Kind::kMaxError, Kind::kSize}) {
      const double value = kind == Kind::kMaxError ? 0.01 : kind == Kind::kSize ? 30000 : 3e-3;
      CompressOptions options;
      options.access = Access::kFrame;
      const auto shorter = checkedRoundTrip(sequence, {kind, value}, options);
      EXPECT_EQ(shorter.blockFrames, frames > 4 ? 4 : 16);
      options.access = Access::kFilm;
      EXPECT_EQ(checkedRoundTrip(sequence, {kind, value}, options).blockFrames, 16);
    }
  }
}

// What moves fast gains nothing from long blocks.
TEST(Compress, BlocksAreShortWhereThatCostsNothing) {
  Sequence noise = makeSequence(32, 32, 32, 32);
  std::uint32_t seed = 7;
  for (float& value : noise.values) {
    seed = seed * 1664525u + 1013904223u;
    value = static_cast<float>(seed >> 8) * 0x1p-24f;
  }
  EXPECT_EQ(checkedRoundTrip(noise, {Kind::kRmsOverAll, 1e-2}).blockFrames, 4);
  Sequence still = plumes(32, 32, 32, 32);
  for (int t = 1; t < 32; ++t)
    std::ranges::copy(still.frame(0), still.values.begin() +
                                          static_cast<std::ptrdiff_t>(t * still.frame(0).size()));
  EXPECT_EQ(checkedRoundTrip(still, {Kind::kRmsOverAll, 3e-3}).blockFrames, 16);
}

TEST(Compress, MetadataComesBackBitForBit) {
  Sequence sequence = plumes(5, 3, 4, 5, 3);
  sequence.info.name = "Größe";
  sequence.info.unit = "g/m3";
  sequence.info.bounds = {Vec3(-1, 0.1, 1.0 / 3), Vec3(2, 5, 7)};
  sequence.info.frameNumbers = {-3, 5, 6, 7, 2000000000};
  for (const bool regular : {true, false}) {
    sequence.info.basis = regular ? Basis::kTrilinear : Basis::kCubic;
    sequence.info.times.clear();
    for (const int n : sequence.info.frameNumbers)
      sequence.info.times.push_back(0.7 + (n + 3.0) / 24);
    if (!regular)
      sequence.info.times[2] += 1e-9;
    SequenceSource source(sequence);
    CompressOptions options;
    options.target = {Kind::kPsnr, 43};
    options.provenance = "made by a test";
    Progress progress;
    const ScratchFile file;
    ASSERT_TRUE(compress(source, file.path(), options, progress));
    const auto reader = VoluteReader::open(file.path());
    ASSERT_TRUE(reader) << reader.error().message;
    const VolumeInfo& info = reader->info();
    EXPECT_EQ(info.name, sequence.info.name);
    EXPECT_EQ(info.unit, "g/m3");
    EXPECT_EQ(info.basis, sequence.info.basis);
    EXPECT_EQ(info.bounds.min, sequence.info.bounds.min);
    EXPECT_EQ(info.bounds.max, sequence.info.bounds.max);
    EXPECT_EQ(info.frameNumbers, sequence.info.frameNumbers);
    EXPECT_EQ(info.times, sequence.info.times);
    EXPECT_EQ(reader->header().provenance, "made by a test");
    EXPECT_EQ(reader->header().targetKind, "psnr");
    EXPECT_EQ(reader->header().targetValue, 43);
  }
}

class Stopper final : public Progress {
 public:
  bool cancelled() const override { return true; }
};

TEST(Compress, StopsWhenAsked) {
  const Sequence sequence = plumes(20, 8, 8, 8);
  SequenceSource source(sequence);
  Stopper stopper;
  const ScratchFile file;
  EXPECT_EQ(compress(source, file.path(), {}, stopper).error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(std::filesystem::is_empty(file.folder()));
}

TEST(Compress, RowsThatDoNotFitAreRefusedWithTheirNeed) {
  const Sequence sequence = plumes(16, 32, 32, 32);
  SequenceSource source(sequence);
  Progress progress;
  CompressOptions options;
  options.maxMemory = 1 << 20;
  const ScratchFile file;
  const auto refused = compress(source, file.path(), options, progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(refused.error().message.find("need 18 MiB"), std::string::npos)
      << refused.error().message;
}

// Frames out of nothing, as many as one likes.
class EndlessSource final : public FrameSource {
 public:
  EndlessSource(int frames, int side) : frame_(plumes(1, side, side, side)) {
    info_ = frame_.info;
    info_.frames = frames;
    info_.frameNumbers.clear();
    info_.times.clear();
    info_.fillDefaults();
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    const float scale = 1 + 0.001f * static_cast<float>(index);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = frame_.values[i] * scale;
    return {};
  }

 private:
  Sequence frame_;
  VolumeInfo info_;
};

long peakKilobytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// In a process of its own: a peak of other cases would hide it.
TEST(Compress, MemoryDoesNotGrowWithTheFrames) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer keeps freed memory";
#endif
  const auto peakOf = [](int frames) {
    EndlessSource source(frames, 32);
    CompressOptions options;
    options.target = {Kind::kRms, 1e-2};
    options.mode = BlockMode{};  // the same for all: quicker
    Progress progress;
    const ScratchFile file;
    EXPECT_TRUE(compress(source, file.path(), options, progress));
    return peakKilobytes();
  };
  const long before = peakOf(32);
  const long growth = peakOf(192) - before;  // 25 MB of frames
  EXPECT_LT(growth, 8 << 10);
}

TEST(Compress, TheIndexOfManyFramesIsSmall) {
  EndlessSource source(2000, 8);
  CompressOptions options;
  options.target = {Kind::kRms, 1e-2};
  Progress progress;
  const ScratchFile file;
  ASSERT_TRUE(compress(source, file.path(), options, progress));
  const auto bytes = readBytes(file.path());
  const auto headBytes = static_cast<unsigned char>(bytes[16]) |
                         static_cast<unsigned char>(bytes[17]) << 8 |
                         static_cast<unsigned char>(bytes[18]) << 16;
  EXPECT_LT(headBytes, 125 * 3 * 6 + 3000);  // 125 blocks of 3 tiers, contexts, frames and times
}

}  // namespace
}  // namespace volute
