// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/stored_color.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

namespace volute {
namespace {

/// XYZ of sRGB's primaries, adapted to the white of ICC profiles (D50).
Mat3 profileFromSrgb() {
  return {0.4360747, 0.3850649, 0.1430804,  //
          0.2225045, 0.7168786, 0.0606169,  //
          0.0139322, 0.0971045, 0.7141733};
}

/// Nothing where both have the same primaries but for what files round.
Result<std::optional<Mat3>> srgbFromProfile(const Mat3& profileFromOwn) {
  constexpr double kSame = 4e-3;
  if (!profileFromOwn.allFinite() || !(std::abs(profileFromOwn.determinant()) > 1e-6))
    return fail(ErrorCode::kInvalidData, "its primaries span no colors");
  const Mat3 srgbFromOwn = profileFromSrgb().inverse() * profileFromOwn;
  if ((srgbFromOwn - Mat3::Identity()).cwiseAbs().maxCoeff() < kSame)
    return std::optional<Mat3>();
  return std::optional<Mat3>(srgbFromOwn);
}

/// Numbers of an ICC profile, in big-endian order; 0 beyond its end.
class ProfileBytes {
 public:
  explicit ProfileBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint32_t word(std::size_t at) const { return half(at) << 16 | half(at + 2); }

  std::uint32_t half(std::size_t at) const { return byte(at) << 8 | byte(at + 1); }

  double fixed(std::size_t at) const { return static_cast<std::int32_t>(word(at)) / 65536.0; }

  /// The bytes of a tag, none if there is no such tag.
  ProfileBytes tag(std::string_view name) const {
    constexpr std::size_t kHeader = 128, kEntry = 12;
    for (std::size_t i = 0, n = std::min<std::size_t>(word(kHeader), 100); i < n; ++i) {
      const std::size_t at = kHeader + 4 + kEntry * i;
      if (!is(at, name))
        continue;
      const std::size_t begin = std::min<std::size_t>(word(at + 4), bytes_.size());
      const std::size_t size = std::min<std::size_t>(word(at + 8), bytes_.size() - begin);
      return ProfileBytes(bytes_.subspan(begin, size));
    }
    return ProfileBytes({});
  }

  bool is(std::size_t at, std::string_view name) const {
    for (std::size_t i = 0; i < name.size(); ++i) {
      if (byte(at + i) != static_cast<unsigned char>(name[i]))
        return false;
    }
    return true;
  }

  std::size_t size() const { return bytes_.size(); }

 private:
  std::uint32_t byte(std::size_t at) const {
    return at < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at]) : 0;
  }

  std::span<const std::byte> bytes_;
};

/// curveType and parametricCurveType of ICC.1:2010, 10.5 and 10.15. An empty function: neither.
StoredColor::Curve curveOf(const ProfileBytes& tag) {
  if (tag.is(0, "curv")) {
    const std::size_t count = tag.word(8);
    if (count == 0)
      return [](double v) { return v; };
    if (tag.size() < 12 + 2 * count)
      return {};
    if (count == 1)
      return [exponent = tag.half(12) / 256.0](double v) { return std::pow(v, exponent); };
    std::vector<double> table(count);
    for (std::size_t i = 0; i < count; ++i) table[i] = tag.half(12 + 2 * i) / 65535.0;
    return [table = std::move(table)](double v) {
      const double place = std::clamp(v, 0.0, 1.0) * static_cast<double>(table.size() - 1);
      const auto below = std::min(static_cast<std::size_t>(place), table.size() - 2);
      const double share = place - static_cast<double>(below);
      return (1 - share) * table[below] + share * table[below + 1];
    };
  }
  static constexpr std::size_t kCounts[] = {1, 3, 4, 5, 7};
  const std::size_t kind = tag.half(8);
  if (!tag.is(0, "para") || kind >= std::size(kCounts) || tag.size() < 12 + 4 * kCounts[kind])
    return {};
  std::array<double, 7> p{};  // g a b c d e f
  for (std::size_t i = 0; i < kCounts[kind]; ++i) p[i] = tag.fixed(12 + 4 * i);
  const auto [g, a, b, c, d, e, f] = p;
  switch (kind) {
    case 0:
      return [g = g](double v) { return std::pow(v, g); };
    case 1:
      return
          [g = g, a = a, b = b](double v) { return a * v + b >= 0 ? std::pow(a * v + b, g) : 0; };
    case 2:
      return [g = g, a = a, b = b, c = c](double v) {
        return (a * v + b >= 0 ? std::pow(a * v + b, g) : 0) + c;
      };
    default:
      return [g = g, a = a, b = b, c = c, d = d, e = e, f = f](double v) {
        return v >= d ? std::pow(std::max(a * v + b, 0.0), g) + e : c * v + f;
      };
  }
}

/// Whether a curve leads from 0 to 1 and does not fall.
bool isSound(const StoredColor::Curve& curve) {
  constexpr int kSteps = 256;
  double last = -0.01;
  for (int i = 0; i <= kSteps; ++i) {
    const double value = curve(static_cast<double>(i) / kSteps);
    if (!(value >= last - 1e-4) || !(value < 1.01))
      return false;
    last = value;
  }
  return last > 0.5;
}

bool isSame(const StoredColor::Curve& a, const StoredColor::Curve& b) {
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    const double v = static_cast<double>(i) / kSteps;
    if (std::abs(a(v) - b(v)) > 1e-4)
      return false;
  }
  return true;
}

}  // namespace

StoredColor colorOfGamma(double exponent) {
  constexpr double kSrgb = 1 / 2.2, kRounded = 0.002;
  StoredColor color;
  if (std::abs(exponent - kSrgb) < kRounded)
    return color;
  color.curves.fill(exponent == 1
                        ? StoredColor::Curve([](double v) { return v; })
                        : [power = 1 / exponent](double v) { return std::pow(v, power); });
  return color;
}

Result<std::optional<Mat3>> srgbFromPrimaries(const std::array<double, 8>& places) {
  constexpr std::array<double, 8> kSrgb = {0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
  constexpr double kRounded = 1.5e-3;
  bool same = true;
  for (std::size_t i = 0; i < places.size(); ++i)
    same = same && std::abs(places[i] - kSrgb[i]) < kRounded;
  if (same)
    return std::optional<Mat3>();
  const auto xyz = [&](std::size_t i) {
    const double x = places[2 * i], y = places[2 * i + 1];
    return Vec3(x / y, 1, (1 - x - y) / y);
  };
  Mat3 own = Mat3::ofColumns(xyz(1), xyz(2), xyz(3));
  if (!own.allFinite() || !xyz(0).allFinite() || !(std::abs(own.determinant()) > 1e-6))
    return fail(ErrorCode::kInvalidData, "its primaries span no colors");
  const Vec3 white = xyz(0);
  own = own * (own.inverse() * white).asDiagonal();
  // Bradford's adaptation, as profiles have it.
  const Mat3 cones(0.8951, 0.2664, -0.1614,  //
                   -0.7502, 1.7135, 0.0367,  //
                   0.0389, -0.0685, 1.0296);
  const Vec3 d50(0.96422, 1, 0.82521);
  const Vec3 scale = (cones * d50).cwiseQuotient(cones * white);
  return srgbFromProfile(cones.inverse() * scale.asDiagonal() * cones * own);
}

void transformColors(const Mat3& matrix, Image& image) {
  for (std::size_t at = 0; at + 2 < image.pixels.size(); at += 3) {
    const Vec3 light(image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]);
    const Vec3 other = matrix * light;
    for (int c = 0; c < 3; ++c) image.pixels[at + c] = static_cast<float>(other[c]);
  }
}

Result<StoredColor> colorOfProfile(std::span<const std::byte> profile, bool grey) {
  const ProfileBytes bytes(profile);
  StoredColor color;
  static constexpr std::string_view kCurves[] = {"rTRC", "gTRC", "bTRC"};
  static constexpr std::string_view kPrimaries[] = {"rXYZ", "gXYZ", "bXYZ"};
  for (std::size_t i = 0; i < 3; ++i) {
    color.curves[i] = curveOf(bytes.tag(grey ? "kTRC" : kCurves[i]));
    if (!color.curves[i])
      return fail(ErrorCode::kUnsupported, "its color profile has no curve for each channel");
    if (!isSound(color.curves[i]))
      return fail(ErrorCode::kInvalidData, "a curve of its color profile is damaged");
    color.sameCurves = color.sameCurves && isSame(color.curves[0], color.curves[i]);
  }
  if (grey)
    return color;
  Mat3 own;
  for (std::size_t i = 0; i < 3; ++i) {
    const ProfileBytes place = bytes.tag(kPrimaries[i]);
    own.col(static_cast<int>(i)) = Vec3(place.fixed(8), place.fixed(12), place.fixed(16));
  }
  VOLUTE_ASSIGN(color.toSrgb, srgbFromProfile(own));
  return color;
}

Result<StoredColor> colorOfCodePoints(int primaries, int curve) {
  constexpr int kGamma22 = 4, kGamma28 = 5, kLinear = 8, kSrgb = 13;
  StoredColor color;
  if (curve == kLinear || curve == kGamma22 || curve == kGamma28) {
    const double power = curve == kLinear ? 1 : curve == kGamma22 ? 2.2 : 2.8;
    color.curves.fill([power](double v) { return power == 1 ? v : std::pow(v, power); });
  } else if (curve != kSrgb) {
    return fail(ErrorCode::kUnsupported, "it states transfer function {} (cICP)", curve);
  }
  constexpr int kRec709 = 1, kRec2020 = 9, kDisplayP3 = 12;
  if (primaries == kRec709)
    return color;
  if (primaries != kRec2020 && primaries != kDisplayP3)
    return fail(ErrorCode::kUnsupported, "it states primaries {} (cICP)", primaries);
  constexpr std::array<double, 8> kWide = {0.3127, 0.3290, 0.708, 0.292,
                                           0.170,  0.797,  0.131, 0.046};
  constexpr std::array<double, 8> kP3 = {0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
  VOLUTE_ASSIGN(color.toSrgb, srgbFromPrimaries(primaries == kRec2020 ? kWide : kP3));
  return color;
}

Result<std::optional<std::vector<double>>> sampledCurve(const StoredColor& color,
                                                        const std::filesystem::path& path) {
  if (!color.curves[0])
    return std::nullopt;
  if (!color.sameCurves) {
    return fail(ErrorCode::kUnsupported,
                "{}: its color profile has another curve for each channel; expected one for all, "
                "as of sRGB; convert it to sRGB",
                path.string());
  }
  constexpr int kSteps = 4096;
  std::vector<double> linear;
  for (int i = 0; i <= kSteps; ++i)
    linear.push_back(std::max({color.curves[0](static_cast<double>(i) / kSteps), 0.0,
                               linear.empty() ? 0.0 : linear.back()}));
  return linear;
}

}  // namespace volute
