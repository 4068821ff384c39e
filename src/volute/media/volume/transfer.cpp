// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/transfer.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/image/srgb.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/knots.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kMaps[] = {"viridis", "inferno", "plasma"};
constexpr std::string_view kOff = "off";
constexpr double kDensest = 1e9;  ///< [1/m]
constexpr std::string_view kPoints = "transfer/points/", kRange = "transfer/range/";

FieldValue pointsOf(const Transfer& transfer) {
  return transfer.points;
}

Status setPoints(Transfer& transfer, const FieldValue& value) {
  transfer.points.clear();
  for (const FieldValue& row : value) {
    const double at = row[0].get<double>(), extinction = row[1].get<double>();
    if (!(extinction >= 0 && extinction <= kDensest))
      return fail(ErrorCode::kInvalidData,
                  "the extinction {} is out of range; expected 0 to {:g} 1/m", extinction,
                  kDensest);
    if (!transfer.points.empty() && at < transfer.points.back()[0]) {
      return fail(ErrorCode::kInvalidData,
                  "the value {} follows {}; expected the values in ascending order", at,
                  transfer.points.back()[0]);
    }
    transfer.points.push_back({at, extinction});
  }
  if (transfer.points.size() < 2)
    return fail(ErrorCode::kInvalidData, "expected two points or more, [value, extinction] each");
  return {};
}

FieldValue rangeOf(const Transfer& transfer) {
  return {transfer.least, transfer.most};
}

Status setRange(Transfer& transfer, const FieldValue& value) {
  transfer.least = value[0].get<double>(), transfer.most = value[1].get<double>();
  if (!(transfer.least < transfer.most))
    return fail(ErrorCode::kInvalidData, "expected two numbers, the smaller one first");
  return {};
}

/// "transfer/points/1": 1.
std::size_t placeIn(const std::string& key) {
  return static_cast<std::size_t>(std::stoul(key.substr(key.find_last_of('/') + 1)));
}

/// As dense as smoke at the largest value, clear at the smallest.
OrderedJson usualTransfer(const std::string& map, const ValueCounts& values, double size) {
  constexpr double kDepth = 12;  // through all of it, were it of the largest value
  double least = values.least, most = values.most;
  if (!(least < most))
    most = least + 1;
  const double dense = size > 0 ? kDepth / size : 1;
  OrderedJson made = {{"map", map}};
  made["range"] = {least, most};
  made["points"] = OrderedJson::array({OrderedJson::array({least, 0.0}),
                                       OrderedJson::array({0.5 * (least + most), 0.25 * dense}),
                                       OrderedJson::array({most, dense})});
  return made;
}

}  // namespace

double Transfer::extinctionOf(double value) const {
  const auto after =
      std::ranges::upper_bound(points, value, {}, [](const auto& p) { return p[0]; });
  if (after == points.begin())
    return points.front()[1];
  if (after == points.end())
    return points.back()[1];
  const auto& [from, low] = *std::prev(after);
  const auto& [to, high] = *after;
  return low + (high - low) * (value - from) / (to - from);
}

Rgb Transfer::colorOf(double value) const {
  const Rgb shown = displayColor(map, (value - least) / (most - least));
  return {srgbDecode(shown[0]), srgbDecode(shown[1]), srgbDecode(shown[2])};
}

const FieldTable& transferFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "map", .type = kChoice, .access = member<&Transfer::map>(),
       .help = "perceptual colour map, dark to light", .choices = kMaps},
      {.name = "range", .type = kNumbers, .access = customMember<Transfer, rangeOf, setRange>(),
       .help = "the values with the first and the last colour", .count = 2},
      {.name = "points", .type = kRows, .access = customMember<Transfer, pointsOf, setPoints>(),
       .help = "value and extinction [1/m] in each row, by ascending values; linear in between, "
               "constant beyond", .count = 2}};
  // clang-format on
  static const FieldTable kTable = fieldTable<Transfer>(
      {.name = "transfer",
       .sentence = "a transfer function: values as colours, as dense as its points say",
       .fields = kFields});
  return kTable;
}

float scalarAt(const float* values, int channels, int stride) {
  if (channels == 1)
    return values[0];
  float square = 0;
  for (int c = 0; c < channels; ++c) square += values[c * stride] * values[c * stride];
  return std::sqrt(square);
}

ValueCounts ValueCounts::of(const BrickSlice& slice) {
  constexpr int kVoxels = BrickSlice::kVoxels, kSide = BrickSlice::kSide, kSteps = 64;
  ValueCounts all;
  const auto each = [&](auto&& take) {
    for (const BrickSlice::Entry& entry : slice.entries()) {
      const float* values = slice.brick(entry.stored);
      for (int i = 0; i < kVoxels; ++i) {
        if (entry.place[0] * kSide + i % kSide < slice.x() &&
            entry.place[1] * kSide + i / kSide % kSide < slice.y() &&
            entry.place[2] * kSide + i / kSide / kSide < slice.z())
          take(scalarAt(values + i, slice.channels(), kVoxels));
      }
    }
  };
  each([&](double value) {
    all.least = std::min(all.least, value), all.most = std::max(all.most, value);
  });
  const bool everywhere = static_cast<std::int64_t>(slice.entries().size()) * kVoxels >=
                          std::int64_t{slice.x()} * slice.y() * slice.z();
  if (everywhere) {  // no value of 0 is implied
    all.least = all.most;
    each([&](double value) { all.least = std::min(all.least, value); });
  }
  all.counts.assign(kSteps, 0);
  if (!(all.least < all.most))
    return all;
  each([&](double value) {
    const double share = (value - all.least) / (all.most - all.least);
    ++all.counts[static_cast<std::size_t>(std::min(share * kSteps, kSteps - 1.0))];
  });
  return all;
}

void addTransfer(ParameterGroup& group, const Transfer* transfer, const ValueCounts& values) {
  std::vector<std::string_view> choices{kOff};
  choices.insert(choices.end(), std::begin(kMaps), std::end(kMaps));
  const auto chosen = transfer ? 1 + static_cast<std::size_t>(transfer->map) : 0;
  group.choice("colours by value", "transfer/map", choices, choices[chosen]).help =
      "a transfer function, instead of emission, extinction and preset: values as colours of a "
      "perceptual map, as dense as its points say";
  if (!transfer)
    return;
  group.section("transfer function");
  const double least = std::min(values.least, transfer->least),
               most = std::max(values.most, transfer->most), wide = most - least;
  const auto number = [&](const char* label, const char* key, double value, const char* help) {
    Parameter& made = group.add(label, key, Parameter::Kind::kNumber, {value});
    made.least = least - 0.25 * wide, made.most = most + 0.25 * wide, made.help = help;
  };
  number("first colour", "transfer/range/0", transfer->least, "the value with the first colour");
  number("last colour", "transfer/range/1", transfer->most, "the value with the last colour");
  for (std::size_t i = 0; i < transfer->points.size(); ++i) {
    Parameter& point =
        group.add(fmt::format("point {}", i + 1), fmt::format("{}{}", kPoints, i),
                  Parameter::Kind::kPoint, {transfer->points[i][0], transfer->points[i][1]});
    point.step = wide / 300;
    point.entry = true, point.removable = transfer->points.size() > 2;
    point.help = "value; extinction there [1/m]";
    if (i > 0)
      continue;
    point.least = values.least, point.most = values.most;
    point.counts = values.counts;
  }
  group.section("");
}

bool setTransfer(OrderedJson& volume, const std::string& key, const std::string& choice,
                 const std::vector<double>& value, const ValueCounts& values, double size) {
  if (key == "transfer/map") {
    if (choice == kOff)
      volume.erase("transfer");
    else if (volume.contains("transfer"))
      volume["transfer"]["map"] = choice;
    else
      volume["transfer"] = usualTransfer(choice, values, size);
    return true;
  }
  if (key.starts_with(kRange)) {
    OrderedJson& range = volume["transfer"]["range"];
    if (!range.is_array())
      range = {Transfer{}.least, Transfer{}.most};
    const std::size_t moved = placeIn(key);
    const double other = range[1 - moved].get<double>();
    const double apart = std::max(1e-6 * std::abs(other), 1e-12);
    range[moved] =
        moved == 0 ? std::min(value[0], other - apart) : std::max(value[0], other + apart);
    return true;
  }
  if (!key.starts_with(kPoints))
    return false;
  OrderedJson& points = volume["transfer"]["points"];
  if (!points.is_array())
    points = Transfer{}.points;
  setKnot(points, placeIn(key), value, kDensest);
  return true;
}

Result<std::optional<std::string>> editTransfer(OrderedJson& volume, const std::string& key,
                                                bool more) {
  if (!key.starts_with(kPoints) || !volume.contains("transfer"))
    return std::nullopt;
  OrderedJson& points = volume["transfer"]["points"];
  if (!points.is_array())
    points = Transfer{}.points;
  if (placeIn(key) >= points.size())
    return std::nullopt;
  if (more)
    duplicateKnot(points, placeIn(key), 1e-9);
  else if (points.size() > 2)
    points.erase(placeIn(key));
  else
    return fail(ErrorCode::kInvalidArgument, "{}: a transfer function needs two points", key);
  return fmt::format("a point is {}", more ? "added" : "removed");
}

}  // namespace volute
