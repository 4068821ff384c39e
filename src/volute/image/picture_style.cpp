// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/picture_style.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

/// Before a tone curve: how bright the brightest are, and how bright half of what is lit at most.
constexpr double kToneKey = 3, kToneMiddle = 0.6;

// Plain loops: a film takes these for every pixel.
constexpr double kHillIn[3][3] = {
    {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
constexpr double kHillOut[3][3] = {
    {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};

inline double hillCurve(double v) {
  return (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
}

constexpr Mat3 kAgxIn(0.842479062253094, 0.0784335999999992, 0.0792237451477643,  //
                      0.0423282422610123, 0.878468636469772, 0.0791661274605434,  //
                      0.0423756549057051, 0.0784336, 0.879142973793104);
constexpr Mat3 kAgxOut = kAgxIn.inverse();

/// The sigmoid over a logarithmic scale of 16.5 stops, 10 of them below middle grey.
double agxCurve(double light) {
  constexpr double kMin = -12.47393, kMax = 4.026069;
  const double x = std::clamp((std::log2(std::max(light, 1e-10)) - kMin) / (kMax - kMin), 0.0, 1.0);
  return ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x) + 0.1191) * x -
         0.00232;
}

Rgb unitClamped(const Vec3& v) {
  return Rgb(v.array().max(0).min(1));
}

constexpr double kMaxLight = 1e12;  ///< beyond it curves are level

/// toneMapped(kFilmic) of RGB pixels, to the bit, by loops that become vectors.
void mapFilmic(float* pixels, std::size_t count) {
  constexpr std::size_t kBlock = 64;
  double light[3][kBlock], in[3][kBlock];
  bool known = false;
  float plain[3] = {}, shown[3] = {};  // of the last block of one colour
  for (std::size_t first = 0; first < count; first += kBlock) {
    float* at = pixels + 3 * first;
    const std::size_t size = std::min(kBlock, count - first);
    // Each value is that of the pixel before: an empty background.
    const bool even = std::memcmp(at, at + 3, 3 * (size - 1) * sizeof(float)) == 0;
    if (even && known && std::memcmp(at, plain, sizeof plain) == 0) {
      for (std::size_t i = 0; i < size; ++i) std::copy_n(shown, 3, at + 3 * i);
      continue;
    }
    if (even)
      std::copy_n(at, 3, plain);
    for (std::size_t i = 0; i < kBlock; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = i < size ? at[3 * i + c] : 0;
        light[c][i] = value > 0 ? std::min(value, kMaxLight) : 0;
      }
    }
    for (std::size_t row = 0; row < 3; ++row) {
      const double red = kHillIn[row][0], green = kHillIn[row][1], blue = kHillIn[row][2];
      for (std::size_t i = 0; i < kBlock; ++i)
        in[row][i] = hillCurve(red * light[0][i] + green * light[1][i] + blue * light[2][i]);
    }
    for (std::size_t row = 0; row < 3; ++row) {
      const double red = kHillOut[row][0], green = kHillOut[row][1], blue = kHillOut[row][2];
      double out[kBlock];
      for (std::size_t i = 0; i < kBlock; ++i) {
        const double shown = red * in[0][i] + green * in[1][i] + blue * in[2][i];
        out[i] = std::min(std::max(shown, 0.0), 1.0);
      }
      for (std::size_t i = 0; i < size; ++i) at[3 * i + row] = static_cast<float>(out[i]);
    }
    if (even)
      std::copy_n(at, 3, shown), known = true;
  }
}

/// Deviation in pixels, cut off at three of it; sums to 1.
std::vector<float> gaussian(double deviation) {
  const int reach = std::max(1, static_cast<int>(std::ceil(3 * deviation)));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (deviation * deviation)));
    sum += weights.back();
  }
  std::vector<float> out;
  for (const double weight : weights) out.push_back(static_cast<float>(weight / sum));
  return out;
}

/// A place beyond a border counts as its mirror image: what goes out comes back.
int mirrored(int i, int count) {
  const int period = 2 * count;
  const int at = ((i % period) + period) % period;
  return at < count ? at : period - 1 - at;
}

/// Along lines of `count` pixels, `stride` values apart.
void blurLines(const std::vector<float>& from, std::vector<float>& to, int lines, int lineStride,
               int count, int stride, const std::vector<float>& weights) {
  const int reach = static_cast<int>(weights.size() / 2);
  parallelRanges(static_cast<std::size_t>(lines), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t line = begin; line < end; ++line) {
      const std::size_t first = line * static_cast<std::size_t>(lineStride);
      for (int i = 0; i < count; ++i) {
        float sum = 0;
        for (int k = -reach; k <= reach; ++k) {
          sum += weights[static_cast<std::size_t>(k + reach)] *
                 from[first + static_cast<std::size_t>(mirrored(i + k, count)) * stride];
        }
        to[first + static_cast<std::size_t>(i) * stride] = sum;
      }
    }
  });
}

/// One channel of a picture.
std::vector<float> blurred(std::vector<float> plane, int width, int height, double deviation) {
  const auto weights = gaussian(deviation);
  std::vector<float> other(plane.size());
  blurLines(plane, other, height, width, width, 1, weights);
  blurLines(other, plane, width, 1, height, width, weights);
  return plane;
}

/// A wide Gaussian costs little on a smaller picture: 4 x 4 pixels become one, and are spread again
/// evenly over them by two more passes.
std::vector<float> blurredWide(const std::vector<float>& plane, int width, int height,
                               double deviation) {
  constexpr int kStep = 4;
  constexpr double kFine = 8;  // [pixels]
  if (deviation < kFine || width % kStep != 0 || height % kStep != 0)
    return blurred(plane, width, height, deviation);
  const int w = width / kStep, h = height / kStep;
  std::vector<float> small(static_cast<std::size_t>(w) * h, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      small[static_cast<std::size_t>(y / kStep) * w + x / kStep] +=
          plane[static_cast<std::size_t>(y) * width + x] / (kStep * kStep);
    }
  }
  small = blurred(std::move(small), w, h, deviation / kStep);
  std::vector<float> wide(plane.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      wide[static_cast<std::size_t>(y) * width + x] =
          small[static_cast<std::size_t>(y / kStep) * w + x / kStep];
    }
  }
  return blurred(std::move(wide), width, height, kStep / 2.0);
}

}  // namespace

namespace {

constexpr double kKnee = 0.7;  // of pure colours

/// From the knee on with the slope that it had there, and below 1 for ever. White's knee is 1.
double shoulder(double light, double purity) {
  const double knee = 1 - (1 - kKnee) * purity;
  return light > knee ? knee + (1 - knee) * (light - knee) / (1 - 2 * knee + light) : light;
}

}  // namespace

std::string_view nameOf(ToneCurve tone) {
  constexpr std::string_view kNames[] = {"none", "filmic", "agx", "shoulder"};
  return kNames[static_cast<std::size_t>(tone)];
}

Rgb toneMapped(ToneCurve tone, const Rgb& light) {
  if (tone == ToneCurve::kNone)
    return light;
  Vec3 v;
  for (int c = 0; c < 3; ++c) v[c] = light[c] > 0 ? std::min(light[c], kMaxLight) : 0;
  if (tone == ToneCurve::kShoulder) {
    const double most = v.maxCoeff();
    return most > kKnee ? Rgb(v * (shoulder(most, 1 - v.minCoeff() / most) / most)) : Rgb(v);
  }
  if (tone == ToneCurve::kFilmic) {
    double in[3], out[3];
    for (int row = 0; row < 3; ++row)
      in[row] = hillCurve(kHillIn[row][0] * v[0] + kHillIn[row][1] * v[1] + kHillIn[row][2] * v[2]);
    for (int row = 0; row < 3; ++row) {
      const double light =
          kHillOut[row][0] * in[0] + kHillOut[row][1] * in[1] + kHillOut[row][2] * in[2];
      out[row] = std::min(std::max(light, 0.0), 1.0);
    }
    return {out[0], out[1], out[2]};
  }
  const Vec3 in = kAgxIn * v;
  const Rgb shown = unitClamped(kAgxOut * in.unaryExpr(&agxCurve));
  return shown.pow(2.2);
}

Image withGlow(const Image& image, double share) {
  constexpr double kDeviations[] = {1 / 200.0, 1 / 50.0, 1 / 12.0};
  Image out = image;
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  std::vector<float> plane(pixels);
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t i = 0; i < pixels; ++i) plane[i] = image.pixels[i * channels + c];
    for (std::size_t i = 0; i < pixels; ++i)
      out.pixels[i * channels + c] = static_cast<float>((1 - share) * plane[i]);
    for (const double deviation : kDeviations) {
      const auto spread = blurredWide(plane, image.width, image.height, deviation * image.height);
      for (std::size_t i = 0; i < pixels; ++i)
        out.pixels[i * channels + c] += static_cast<float>(share / 3) * spread[i];
    }
  }
  return out;
}

void dither(Image& image) {
  static const auto kShown = [] {
    std::array<float, 257> shown{};
    for (std::size_t i = 0; i < 256; ++i)
      shown[i] = static_cast<float>(srgbDecode(static_cast<double>(i) / 255));
    shown[256] = 2;  // not reached
    return shown;
  }();
  constexpr double kRight = 0.7548776662466927, kDown = 0.5698402909980532, kChannel = 1 / 3.0;
  const auto width = static_cast<std::size_t>(image.width);
  const auto channels = static_cast<std::size_t>(image.channels);
  parallelRanges(
      static_cast<std::size_t>(image.height), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
          float* value = &image.pixels[y * width * channels];
          for (std::size_t x = 0; x < width; ++x) {
            for (std::size_t c = 0; c < channels; ++c, ++value) {
              const double place = kRight * static_cast<double>(x) +
                                   kDown * static_cast<double>(y) +
                                   kChannel * static_cast<double>(c);
              const double threshold = place - static_cast<double>(static_cast<int>(place));
              const float light = *value > 0 ? std::min(*value, 1.0F) : 0;  // NaN gives 0
              std::size_t level = toSrgb8(light);
              // The rounding of what a display shows as it is must not push it to its neighbour.
              constexpr float kRounding = 1e-4F;
              if (light < kShown[level] - kRounding * (kShown[level + 1] - kShown[level]))
                --level;
              const float rest = (light - kShown[level]) / (kShown[level + 1] - kShown[level]);
              *value = kShown[level + (rest > kRounding && rest > threshold ? 1 : 0)];
            }
          }
        }
      });
}

Image developed(Image light, const PictureStyle& style) {
  if (style.exposure != 1)
    light = exposed(std::move(light), style.exposure);
  if (style.glow > 0)
    light = withGlow(light, style.glow);
  if (style.view && light.channels == 3) {
    parallelRanges(light.pixels.size() / 3, 1 << 13, [&](std::size_t begin, std::size_t end) {
      const auto part = std::span(light.pixels).subspan(3 * begin, 3 * (end - begin));
      style.view->apply(part);
      for (float& value : part)
        value = static_cast<float>(srgbDecode(std::clamp(static_cast<double>(value), 0.0, 1.0)));
    });
  } else if (style.tone != ToneCurve::kNone) {
    const auto channels = static_cast<std::size_t>(light.channels);
    parallelRanges(
        light.pixels.size() / channels, 1 << 13, [&](std::size_t begin, std::size_t end) {
          if (style.tone == ToneCurve::kFilmic && channels == 3)
            return mapFilmic(&light.pixels[3 * begin], end - begin);
          for (std::size_t i = begin; i < end; ++i) {
            float* pixel = &light.pixels[i * channels];
            const Rgb shown = toneMapped(
                style.tone, {pixel[0], pixel[channels > 2 ? 1 : 0], pixel[channels > 2 ? 2 : 0]});
            for (std::size_t c = 0; c < channels; ++c) pixel[c] = static_cast<float>(shown[c]);
          }
        });
  }
  if (style.dither)
    dither(light);
  return light;
}

namespace {

/// Whether a level is more than `kEdge` halves of a level off the mean of those on both sides of
/// it.
constexpr int kEdge = 12;

bool isEdge(int level, int before, int after) {
  return std::abs(2 * level - before - after) > kEdge;
}

}  // namespace

std::vector<std::uint8_t> edgePixels(const Image& shown) {
  const auto channels = static_cast<std::size_t>(shown.channels),
             width = static_cast<std::size_t>(shown.width),
             height = static_cast<std::size_t>(shown.height), length = width * channels;
  const auto bytes = toSrgb8(shown);
  std::vector<std::uint8_t> edges(width * height, 0);
  parallelRanges(height, 16, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint8_t> found(length);  // of each channel
    for (std::size_t y = begin; y < end; ++y) {
      const std::uint8_t* row = &bytes[y * length];
      const std::uint8_t* above = y > 0 ? row - length : row;
      const std::uint8_t* below = y + 1 < height ? row + length : row;
      // The first and the last pixel are their own neighbours outside.
      const std::size_t last = length - channels;
      for (std::size_t i = 0; i < length; ++i) found[i] = isEdge(row[i], above[i], below[i]);
      for (std::size_t i = channels; i < last; ++i)
        found[i] |= static_cast<std::uint8_t>(isEdge(row[i], row[i - channels], row[i + channels]));
      for (std::size_t c = 0; c < channels && width > 1; ++c) {
        found[c] |= static_cast<std::uint8_t>(isEdge(row[c], row[c], row[c + channels]));
        found[last + c] |= static_cast<std::uint8_t>(
            isEdge(row[last + c], row[last + c - channels], row[last + c]));
      }
      for (std::size_t c = 0; c < channels; ++c) {
        for (std::size_t x = 0; x < width; ++x) edges[y * width + x] |= found[x * channels + c];
      }
    }
  });
  return edges;
}

double suggestExposure(const std::vector<Image>& pictures, ToneCurve tone, double share) {
  Image all;
  for (const Image& picture : pictures)
    all.pixels.insert(all.pixels.end(), picture.pixels.begin(), picture.pixels.end());
  std::erase_if(all.pixels, [](float v) { return !(v > 0 && std::isfinite(v)); });
  if (all.pixels.empty())
    return 1;
  const double bright = 1 / suggestExposure(all, share);
  if (tone == ToneCurve::kNone)
    return 1 / bright;
  constexpr double kFaint = 0.01;  // of the brightest: counts as dark
  std::erase_if(all.pixels, [&](float v) { return v < kFaint * bright; });
  const double middle = 1 / suggestExposure(all, 0.5);
  return std::min(kToneKey / bright, kToneMiddle / middle);
}

}  // namespace volute
