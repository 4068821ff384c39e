// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/film.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "volute/image/srgb.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

#if VOLUTE_HAS_VIDEO

constexpr int kFrames = 12;

/// Soft colours; the first row of the picture is red, and a bright square moves.
Image makeFrame(int width, int height, int number) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = y < height / 4 ? 0.8f : 0.1f;
      image.at(x, y, 1) = 0.5f * static_cast<float>(x) / static_cast<float>(width);
      image.at(x, y, 2) = 0.3f;
      const bool square =
          x >= 2 * number && x < 2 * number + 8 && y >= height / 2 && y < height / 2 + 8;
      if (square)
        image.at(x, y, 0) = image.at(x, y, 1) = image.at(x, y, 2) = 1;
    }
  }
  return image;
}

Status writeFilm(const std::filesystem::path& path, int width, int height) {
  VOLUTE_ASSIGN(auto film, FilmWriter::create(path, width, height, 25));
  for (int i = 0; i < kFrames; ++i) VOLUTE_TRY(film->addFrame(makeFrame(width, height, i)));
  return film->finish();
}

/// Root of the mean squared difference of the sRGB bytes.
double difference(const Image& a, const Image& b) {
  double sum = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < 3; ++c)
        sum += std::pow(255 * (srgbEncode(a.at(x, y, c)) - srgbEncode(b.at(x, y, c))), 2);
    }
  }
  return std::sqrt(sum / (3.0 * a.width * a.height));
}

TEST(Film, InterlacedOnesAreKnown) {
  const TempFolder folder;
  for (const auto& [order, interlaced] : {std::pair('p', false), std::pair('t', true)}) {
    const std::string head = fmt::format("YUV4MPEG2 W16 H16 F25:1 I{} C420jpeg\n", order);
    writeBytes(folder / "a.y4m", head + "FRAME\n" + std::string(16 * 16 * 3 / 2, 'x'));
    ASSERT_VALUE(const auto film, FilmReader::open(folder / "a.y4m"));
    EXPECT_EQ(film.info().interlaced, interlaced);
    EXPECT_EQ(film.info().otherStreams, 0);
  }
}

TEST(Film, PixelsThatAreNotSquareAreKnown) {
  const TempFolder folder;
  writeBytes(folder / "a.y4m",
             "YUV4MPEG2 W16 H16 F25:1 A2:1 C420jpeg\nFRAME\n" + std::string(16 * 16 * 3 / 2, 'x'));
  ASSERT_VALUE(const auto film, FilmReader::open(folder / "a.y4m"));
  EXPECT_EQ(film.info().pixelAspect, 2);
}

/// Levels of 8 bits that a film of grey pictures shows, whose stored values are those of 8 bits by
/// column, times what its bits are more.
std::vector<double> greyLevels(const std::filesystem::path& path, int bits,
                               const std::string& range, const std::vector<int>& stored) {
  std::string row;
  for (const int level : stored) {
    const int value = bits == 8 ? level : level << (bits - 8);
    row += static_cast<char>(value & 255);
    if (bits > 8)
      row += static_cast<char>(value >> 8);
  }
  std::string text = fmt::format("YUV4MPEG2 W{} H2 F25:1 Cmono{}{}\nFRAME\n", stored.size(),
                                 bits > 8 ? fmt::format("{}", bits) : "", range);
  writeBytes(path, text + row + row);
  auto film = FilmReader::open(path);
  EXPECT_TRUE(film);
  const auto frame = film ? film->next() : Result<std::optional<Image>>();
  EXPECT_TRUE(frame && *frame);
  std::vector<double> levels;
  for (int x = 0; frame && *frame && x < (*frame)->width; ++x)
    levels.push_back(255 * srgbEncode((*frame)->at(x, 1, 1)));
  return levels;
}

TEST(Film, GreyIsOfTheFullRangeUnlessItSaysOtherwise) {
  const TempFolder folder;
  const std::vector<int> stored{0, 8, 16, 60, 128, 200, 235, 250};
  for (const int bits : {8, 10, 12, 16}) {
    const double step = std::exp2(bits - 8) * 255 / (std::exp2(bits) - 1);
    for (const char* range : {"", " XCOLORRANGE=FULL", " XCOLORRANGE=LIMITED"}) {
      const auto levels = greyLevels(folder / "a.y4m", bits, range, stored);
      ASSERT_EQ(levels.size(), stored.size());
      for (std::size_t i = 0; i < stored.size(); ++i) {
        const double limited = std::clamp((stored[i] - 16) / 219.0, 0.0, 1.0) * 255;
        EXPECT_NEAR(levels[i], std::string(range).ends_with("LIMITED") ? limited : step * stored[i],
                    0.01)
            << bits << range << " " << stored[i];
      }
    }
  }
}

/// The same of a film in colour whose pictures are grey.
std::vector<double> neutralLevels(const std::filesystem::path& path, int bits,
                                  const std::string& range, const std::vector<int>& stored) {
  const auto plane = [&](const std::vector<int>& levels) {
    std::string row;
    for (const int level : levels) {
      row += static_cast<char>((level << (bits - 8)) & 255);
      if (bits > 8)
        row += static_cast<char>(level << (bits - 8) >> 8);
    }
    return row + row;
  };
  const std::string none = plane(std::vector<int>(stored.size(), 128));
  writeBytes(path, fmt::format("YUV4MPEG2 W{} H2 F25:1 C444{}{}\nFRAME\n", stored.size(),
                               bits > 8 ? fmt::format("p{}", bits) : "", range) +
                       plane(stored) + none + none);
  auto film = FilmReader::open(path);
  EXPECT_TRUE(film) << (film ? "" : film.error().message);
  const auto frame = film ? film->next() : Result<std::optional<Image>>();
  EXPECT_TRUE(frame && *frame);
  std::vector<double> levels;
  for (int x = 0; frame && *frame && x < (*frame)->width; ++x)
    levels.push_back(255 * srgbEncode((*frame)->at(x, 1, 1)));
  return levels;
}

TEST(Film, ColoursOfTheFullRangeReachWhite) {
  const TempFolder folder;
  const std::vector<int> stored{0, 8, 16, 60, 128, 200, 235, 250};
  for (const int bits : {8, 10, 12}) {
    const double step = std::exp2(bits - 8) * 255 / (std::exp2(bits) - 1);
    for (const char* range : {" XCOLORRANGE=FULL", " XCOLORRANGE=LIMITED"}) {
      const auto levels = neutralLevels(folder / "a.y4m", bits, range, stored);
      ASSERT_EQ(levels.size(), stored.size());
      for (std::size_t i = 0; i < stored.size(); ++i) {
        const double limited = std::clamp((stored[i] - 16) / 219.0, 0.0, 1.0) * 255;
        EXPECT_NEAR(levels[i], std::string(range).ends_with("LIMITED") ? limited : step * stored[i],
                    bits == 8 ? 0.5 : 0.02)
            << bits << range << " " << stored[i];
      }
    }
  }
}

/// The matrix of the track, by which its pictures are to be shown (ISO/IEC 14496-12, 8.3.2).
void setMatrix(const std::filesystem::path& film, const std::array<int, 4>& abcd) {
  std::string bytes = readBytes(film);
  const std::size_t matrix = bytes.find("tkhd") + 44;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t at = matrix + 4 * (i < 2 ? i : i + 1);
    bytes.replace(
        at, 4, {static_cast<char>(abcd[i] < 0 ? -1 : 0), static_cast<char>(abcd[i]), '\0', '\0'});
  }
  writeBytes(film, bytes);
}

TEST(Film, PicturesAreTurnedAsTheyAreToBeShown) {
  const TempFolder folder;
  const auto path = folder / "a.mp4";
  if (const auto written = writeFilm(path, 48, 32); !written)
    GTEST_SKIP() << written.error().message;
  const Image upright = makeFrame(48, 32, 0);
  for (const auto& [abcd, turned] :
       {std::pair(std::array{1, 0, 0, 1}, 0), std::pair(std::array{0, 1, -1, 0}, 90),
        std::pair(std::array{-1, 0, 0, -1}, 180), std::pair(std::array{0, -1, 1, 0}, 270)}) {
    setMatrix(path, abcd);
    ASSERT_VALUE(auto film, FilmReader::open(path));
    EXPECT_EQ(film.info().turned, turned);
    EXPECT_EQ(film.info().width, turned % 180 == 0 ? 48 : 32);
    ASSERT_VALUE(const auto shown, film.next());
    Image back(48, 32);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 48; ++x) {
        for (int c = 0; c < 3; ++c)
          back.at(x, y, c) = turned == 0     ? shown->at(x, y, c)
                             : turned == 90  ? shown->at(31 - y, x, c)
                             : turned == 180 ? shown->at(47 - x, 31 - y, c)
                                             : shown->at(y, 47 - x, c);
      }
    }
    EXPECT_LT(difference(back, upright), 12) << turned;
  }
  setMatrix(path, {-1, 0, 0, 1});
  const auto mirrored = FilmReader::open(path);
  ASSERT_FALSE(mirrored);
  EXPECT_THAT(mirrored.error().message, HasSubstr("are to be shown mirrored"));
}

class Films : public ::testing::TestWithParam<const char*> {};

/// Eight levels of 8 bits over 960 pixels: bands of 120 pixels where nothing dithers, and more
/// where a codec drops the dithering.
TEST_P(Films, DarkGradientsHaveNoWideBands) {
  constexpr int kWidth = 960, kHeight = 64;
  Image ramp(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c)
        ramp.at(x, y, c) = static_cast<float>(srgbDecode((14 + 7 * (x + 0.5) / kWidth) / 255));
    }
  }
  const TempFolder folder;
  ASSERT_VALUE(auto writer, FilmWriter::create(folder / GetParam(), kWidth, kHeight, 25));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(ok(writer->addFrame(ramp)));
  ASSERT_TRUE(ok(writer->finish()));
  ASSERT_VALUE(auto film, FilmReader::open(folder / GetParam()));
  ASSERT_VALUE(const auto frame, film.next());
  ASSERT_TRUE(frame.has_value());
  int longest = 1, run = 1;
  double sum = 0, wanted = 0;
  for (int x = 1; x < kWidth; ++x) {
    const auto level = [&](int at) {
      return std::lround(255 * srgbEncode(frame->at(at, kHeight / 2, 1)));
    };
    run = level(x) == level(x - 1) ? run + 1 : 1;
    longest = std::max(longest, run);
    sum += srgbEncode(frame->at(x, kHeight / 2, 1));
    wanted += srgbEncode(ramp.at(x, kHeight / 2, 1));
  }
  EXPECT_LT(longest, 56);  // a dithered .png's
  EXPECT_NEAR(255 * sum / kWidth, 255 * wanted / kWidth, 0.3);
}

/// The longest run of equal pixels in the pictures of a film of a dark gradient, each picture by
/// `step` levels brighter than the one before it.
int longestRun(const std::filesystem::path& path, int frames, double step) {
  constexpr int kWidth = 960, kHeight = 64;
  auto writer = FilmWriter::create(path, kWidth, kHeight, 25);
  EXPECT_TRUE(writer) << writer.error().message;
  for (int i = 0; writer && i < frames; ++i) {
    Image ramp(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        ramp.at(x, y) =
            static_cast<float>(srgbDecode((14 + step * i + 7 * (x + 0.5) / kWidth) / 255));
    }
    EXPECT_TRUE(ok((*writer)->addFrame(ramp)));
  }
  EXPECT_TRUE(writer && ok((*writer)->finish()));
  auto film = FilmReader::open(path);
  int longest = 0;
  for (int i = 0; film && i < frames; ++i) {
    const auto frame = film->next();
    EXPECT_TRUE(frame && *frame);
    for (int y = 0; frame && *frame && y < kHeight; ++y) {
      for (int x = 1, run = 1; x < kWidth; ++x) {
        run = (*frame)->at(x, y, 1) == (*frame)->at(x - 1, y, 1) ? run + 1 : 1;
        longest = std::max(longest, run);
      }
    }
  }
  return longest;
}

/// Encoders spend fewer bits on pictures from which no others are predicted.
TEST_P(Films, FilmsOfOneOrTwoPicturesHaveNoWideBands) {
  const TempFolder folder;
  for (const int frames : {1, 2}) EXPECT_LT(longestRun(folder / GetParam(), frames, 0), 56);
}

TEST(Film, FadesHaveNoWideBands) {
  const TempFolder folder;
  EXPECT_LT(longestRun(folder / "film.mp4", 12, 0.5), 56);
}

TEST_P(Films, AllFramesAndTheirColoursComeBack) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeFilm(folder / GetParam(), 64, 48)));
  EXPECT_EQ(folder.entries(), 1u);
  ASSERT_VALUE(auto film, FilmReader::open(folder / GetParam()));
  EXPECT_EQ(film.info().width, 64);
  EXPECT_EQ(film.info().height, 48);
  EXPECT_NEAR(film.info().framesPerSecond, 25, 1e-9);
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_VALUE(const auto frame, film.next());
    ASSERT_TRUE(frame.has_value()) << i;
    EXPECT_LT(difference(makeFrame(64, 48, i), *frame), 9) << i;  // what 4:2:0 leaves of hard edges
    EXPECT_NEAR(255 * srgbEncode(frame->at(40, 4, 0)), 255 * srgbEncode(0.8), 3);
    EXPECT_NEAR(255 * srgbEncode(frame->at(40, 40, 2)), 255 * srgbEncode(0.3), 3);
  }
  ASSERT_VALUE(const auto end, film.next());
  EXPECT_FALSE(end.has_value());
}

TEST_P(Films, OddSizesArePadded) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeFilm(folder / GetParam(), 33, 17)));
  ASSERT_VALUE(const auto film, FilmReader::open(folder / GetParam()));
  EXPECT_EQ(film.info().width, 34);
  EXPECT_EQ(film.info().height, 18);
}

TEST_P(Films, EqualInputsGiveEqualBytes) {
  const TempFolder folder;
  const std::string name = GetParam();
  ASSERT_TRUE(ok(writeFilm(folder / ("a_" + name), 64, 48)));
  ASSERT_TRUE(ok(writeFilm(folder / ("b_" + name), 64, 48)));
  EXPECT_TRUE(readBytes(folder / ("a_" + name)) == readBytes(folder / ("b_" + name)));
}

TEST_P(Films, AFullDiskLeavesNothing) {
  expectFullDiskLeavesNothing(
      400, [](const TempFolder& folder) { return writeFilm(folder / GetParam(), 64, 48); });
}

TEST_P(Films, DamagedFilmsNeverCrash) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeFilm(folder / GetParam(), 64, 48)));
  const std::string bytes = readBytes(folder / GetParam());
  for (std::size_t i = 0; i < 20; ++i) {
    writeBytes(folder / "b.mp4", bytes.substr(0, i * bytes.size() / 20));
    auto film = FilmReader::open(folder / "b.mp4");
    for (auto frame = film ? film->next() : Result<std::optional<Image>>(); frame && *frame;)
      frame = film->next();
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Films, ::testing::Values("film.mp4", "film.webm"),
                         [](const auto& parameter) {
                           return std::string(parameter.param).substr(5);
                         });

/// The longest run of equal pixels in a row of a dark gradient, as a film shows it.
int longestRun(const std::filesystem::path& path, const FilmStyle& style) {
  constexpr int kWidth = 640, kHeight = 48;
  Image ramp(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c)
        ramp.at(x, y, c) = static_cast<float>(srgbDecode((14 + 6.0 * x / kWidth) / 255));
    }
  }
  auto film = FilmWriter::create(path, kWidth, kHeight, 25, "", style);
  EXPECT_TRUE(film) << film.error().message;
  if (!film)
    return 0;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE((*film)->addFrame(ramp));
  EXPECT_TRUE((*film)->finish());
  auto reader = FilmReader::open(path);
  auto shown = reader->next();
  EXPECT_TRUE(shown && *shown);
  int longest = 0, run = 1;
  for (int x = 1; x < kWidth; ++x) {
    run = (*shown)->at(x, kHeight / 2, 1) == (*shown)->at(x - 1, kHeight / 2, 1) ? run + 1 : 1;
    longest = std::max(longest, run);
    EXPECT_NEAR((*shown)->at(x, kHeight / 2, 1), ramp.at(x, kHeight / 2, 1), 1.5e-3);  // 3 levels
  }
  return longest;
}

/// The same brightness and colour differences under the matrix of another standard.
TEST(Film, ColoursAreDecodedByTheMatrixThatTheFilmStates) {
  const TempFolder folder;
  const std::array<float, 3> color = {0.5F, 0.1F, 0.2F};
  ASSERT_VALUE(auto writer, FilmWriter::create(folder / "film.webm", 64, 48, 25));
  Image flat(64, 48);
  for (std::size_t i = 0; i < flat.pixels.size(); ++i) flat.pixels[i] = color[i % 3];
  ASSERT_TRUE(ok(writer->addFrame(flat)));
  ASSERT_TRUE(ok(writer->finish()));
  std::string bytes = readBytes(folder / "film.webm");
  const std::size_t at = bytes.find("\x49\x83\x42");  // of VP9's key frame, then 3 bits of colour
  ASSERT_NE(at, bytes.npos);

  struct Matrix {
    int number;
    double red, blue;
  };

  for (const auto& [number, red, blue] :
       {Matrix{1, 0.299, 0.114}, {2, 0.2126, 0.0722}, {5, 0.2627, 0.0593}}) {
    bytes[at + 3] = static_cast<char>((bytes[at + 3] & 0x1F) | number << 5);
    writeBytes(folder / "film.webm", bytes);
    ASSERT_VALUE(auto film, FilmReader::open(folder / "film.webm"));
    ASSERT_VALUE(const auto frame, film.next());
    const double r = srgbEncode(color[0]), g = srgbEncode(color[1]), b = srgbEncode(color[2]);
    const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    const double cr = (r - y) / (2 - 2 * 0.2126), cb = (b - y) / (2 - 2 * 0.0722);
    const double other[] = {
        y + (2 - 2 * red) * cr,
        y - ((2 - 2 * red) * red * cr + (2 - 2 * blue) * blue * cb) / (1 - red - blue),
        y + (2 - 2 * blue) * cb};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(255 * srgbEncode(frame->at(30, 20, c)), 255 * other[c], 3) << number << " " << c;
  }
  bytes[at + 3] = static_cast<char>((bytes[at + 3] & 0x1F) | 4 << 5);  // SMPTE 240M
  writeBytes(folder / "film.webm", bytes);
  ASSERT_VALUE(auto film, FilmReader::open(folder / "film.webm"));
  EXPECT_TRUE(ok(film.next()));
}

TEST(Film, BandsAreNoWiderThanLevelsOfTheFilm) {
  const TempFolder folder;
  for (const char* name : {"a.mp4", "a.webm"}) {
    SCOPED_TRACE(name);
    EXPECT_LT(longestRun(folder / name, {}), 107);
    EXPECT_LT(longestRun(folder / name, {.bits = 10}), 32);
  }
}

TEST_P(Films, BlackAndWhiteHaveNoGrain) {
  const TempFolder folder;
  for (const float value : {0.0F, 1.0F}) {
    ASSERT_VALUE(auto writer, FilmWriter::create(folder / GetParam(), 64, 48, 25));
    Image flat(64, 48);
    std::ranges::fill(flat.pixels, value);
    ASSERT_TRUE(ok(writer->addFrame(flat)));
    ASSERT_TRUE(ok(writer->finish()));
    ASSERT_VALUE(auto film, FilmReader::open(folder / GetParam()));
    ASSERT_VALUE(const auto frame, film.next());
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->pixels, flat.pixels);
  }
}

TEST(Film, ALowerRateFactorIsCloser) {
  const TempFolder folder;
  const auto bytes = [&](double factor) {
    auto film = FilmWriter::create(folder / "q.mp4", 64, 48, 25, "", {.rateFactor = factor});
    EXPECT_TRUE(film);
    EXPECT_TRUE((*film)->addFrame(makeFrame(64, 48, 0)));
    EXPECT_TRUE((*film)->finish());
    return std::filesystem::file_size(folder / "q.mp4");
  };
  EXPECT_GT(bytes(1), bytes(40));
  EXPECT_THAT(FilmWriter::create(folder / "a.mp4", 64, 48, 25, "", {.bits = 12}).error().message,
              HasSubstr("12 bits a channel; expected 8 or 10"));
  EXPECT_THAT(
      FilmWriter::create(folder / "a.mp4", 64, 48, 25, "", {.rateFactor = 60}).error().message,
      HasSubstr("a rate factor of 60; expected 0 to 51"));
}

TEST(Film, WrongUseIsNamed) {
  const TempFolder folder;
  EXPECT_EQ(FilmWriter::create(folder / "a.avi", 64, 48, 25).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(FilmWriter::create(folder / "a.mp4", 0, 48, 25).error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(FilmWriter::create(folder / "a.mp4", 64, 48, 0).error().code,
            ErrorCode::kInvalidArgument);
  ASSERT_VALUE(const auto film, FilmWriter::create(folder / "a.mp4", 64, 48, 25));
  EXPECT_EQ(film->addFrame(Image(32, 48)).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(film->finish().error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(FilmReader::open(folder / "none.mp4").error().code, ErrorCode::kNotFound);
}

#else

TEST(Film, ABuildWithoutItSaysSo) {
  EXPECT_THAT(FilmWriter::create("a.mp4", 2, 2, 25).error().message,
              HasSubstr("this build has no libav"));
  const TempFolder folder;
  writeBytes(folder / "a.mp4", "");
  EXPECT_THAT(FilmReader::open(folder / "a.mp4").error().message,
              HasSubstr("VOLUTE_WITH_VIDEO=OFF"));
}

#endif

}  // namespace
}  // namespace volute
