// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/spectrum.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/capture/json_value.hpp"
#include "volute/io/table.hpp"

namespace volute {
namespace {

struct Sample {
  double wavelength = 0;
  Rgb sensitivity = Rgb::Zero();
};

Result<Sample> sampleOf(const std::vector<double>& numbers, const JsonValue& value) {
  constexpr double kShortest = 200, kLongest = 3000;
  if (numbers.size() != 4)
    return value.fault("expected rows of 4 numbers: wavelength [nm], red, green, blue");
  if (!(numbers[0] >= kShortest && numbers[0] <= kLongest))
    return value.fault(
        fmt::format("a wavelength is {:g}; expected {} to {} nm", numbers[0], kShortest, kLongest));
  const Rgb sensitivity(numbers[1], numbers[2], numbers[3]);
  if (!(sensitivity.minCoeff() >= 0) || !sensitivity.isFinite().all())
    return value.fault(
        fmt::format("the sensitivities at {:g} nm are not all 0 or more", numbers[0]));
  return Sample{numbers[0], sensitivity};
}

/// A table of wavelengths and sensitivities, by the names of its columns; without names they are
/// wavelength [nm], red, green and blue.
Result<std::vector<Sample>> tableOf(const std::filesystem::path& file, const JsonValue& value) {
  VOLUTE_ASSIGN(const std::string text, readText(file));
  const std::vector<TableColumn> columns{
      {"wavelength", "nm", {"nm", "wavelength_nm", "wavelengths", "lambda"}},
      {"red", "", {"r"}},
      {"green", "", {"g"}},
      {"blue", "", {"b"}}};
  TableRules rules;
  rules.unnamed = {columns.size(), columns.size()};
  rules.blanks = text.find_first_of(",;\t") == std::string::npos;
  TableReader table(file.string(), columns, rules);
  std::vector<Sample> samples;
  const Status read = readTable(table, text, [&]() -> Status {
    std::vector<double> numbers;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!table.has(i))
        return fail(ErrorCode::kInvalidData, "{}: no column is called {}", file.string(),
                    columns[i].name);
      VOLUTE_ASSIGN(numbers.emplace_back(), table.number(i));
    }
    VOLUTE_ASSIGN(samples.emplace_back(), sampleOf(numbers, value));
    return {};
  });
  if (!read)
    return value.fault(read.error().message);
  return samples;
}

Result<std::vector<CaptureSpectrum::Line>> linesOf(const std::vector<Sample>& samples,
                                                   const JsonValue& value) {
  if (samples.size() < 2)
    return value.fault("expected at least two wavelengths");
  std::vector<CaptureSpectrum::Line> lines;
  Rgb sum = Rgb::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double now = samples[i].wavelength;
    const double before = i > 0 ? samples[i - 1].wavelength : now;
    const double after = i + 1 < samples.size() ? samples[i + 1].wavelength : now;
    if (i > 0 && !(now > before))
      return value.fault(fmt::format("the wavelengths do not ascend at {:g} nm", now));
    lines.push_back({now, samples[i].sensitivity * (0.5 * (after - before))});
    sum += lines.back().weight;
  }
  if (!(sum.minCoeff() > 0))
    return value.fault(
        "a channel sees no light at all; expected sensitivities of red, green and blue");
  return lines;
}

/// What a channel sees beyond the ends of its table counts as nothing.
void remarkOnEnds(const std::vector<Sample>& samples, std::vector<Remark>& remarks) {
  constexpr double kNothing = 0.05;  // of a channel's largest sensitivity
  constexpr std::array kNames{"red", "green", "blue"};
  Rgb largest = Rgb::Zero();
  for (const Sample& sample : samples) largest = largest.max(sample.sensitivity);
  for (const Sample& end : {samples.front(), samples.back()}) {
    for (int c = 0; c < 3; ++c) {
      const double share = end.sensitivity[c] / largest[c];
      if (share > kNothing)
        remarks.emplace_back(
            RemarkCode::kDoubtful,
            fmt::format(
                "spectrum.sensitivities: the table ends at {:g} nm, where {} is {:.0f} % of "
                "its largest: what the channel sees beyond is missing, and temperatures "
                "are wrong for it; expected a table that goes to 0 at both ends",
                end.wavelength, kNames[static_cast<std::size_t>(c)], 100 * share));
    }
  }
}

/// Channels are red, green and blue, in this order.
void remarkOnOrder(const CaptureSpectrum& spectrum, const char* member,
                   std::vector<Remark>& remarks) {
  Rgb centre = Rgb::Zero(), sum = Rgb::Zero();
  for (const CaptureSpectrum::Line& line : spectrum.lines) {
    centre += line.wavelength * line.weight;
    sum += line.weight;
  }
  centre /= sum;
  if (!(centre[0] > centre[1] && centre[1] > centre[2]))
    remarks.emplace_back(
        RemarkCode::kDoubtful,
        fmt::format("spectrum.{}: red sees {:.0f} nm, green {:.0f} nm and blue {:.0f} nm; expected "
                    "the longest first: in another order?",
                    member, centre[0], centre[1], centre[2]));
}

Result<Rgb> positive(const JsonValue& value) {
  VOLUTE_ASSIGN(const Vec3 numbers, value.vector());
  if (!(numbers.minCoeff() > 0))
    return value.fault("expected three numbers above 0");
  return Rgb(numbers.array());
}

Status readScale(const JsonValue& value, CaptureSpectrum& spectrum) {
  const auto body = value.find("black_body"), scale = value.find("radiance_scale");
  if (body.has_value() == scale.has_value())
    return value.fault("expected one of 'black_body' and 'radiance_scale'");
  if (scale) {
    VOLUTE_ASSIGN(const double number, scale->number());
    if (!(number > 0))
      return scale->fault(fmt::format("is {:g}; expected more than 0", number));
    spectrum.scale.setConstant(number);
    return {};
  }
  constexpr double kColdest = 500, kHottest = 6000;
  VOLUTE_ASSIGN(const auto kelvin, body->at("temperature"));
  VOLUTE_ASSIGN(const double temperature, kelvin.number());
  if (!(temperature >= kColdest && temperature <= kHottest))
    return kelvin.fault(
        fmt::format("is {:g}; expected {} to {} K", temperature, kColdest, kHottest));
  VOLUTE_ASSIGN(const auto light, body->at("radiance"));
  VOLUTE_ASSIGN(const Rgb seen, positive(light));
  spectrum.scale = seen / spectrum.blackBody(temperature);
  return {};
}

Result<CaptureSpectrum> writtenSpectrum(const JsonValue& value, const JsonValue& lines) {
  CaptureSpectrum spectrum;
  VOLUTE_ASSIGN(const auto rows, lines.items());
  for (const JsonValue& row : rows) {
    VOLUTE_ASSIGN(const auto numbers, row.numbers());
    VOLUTE_ASSIGN(const Sample sample, sampleOf(numbers, row));
    spectrum.lines.push_back({sample.wavelength, sample.sensitivity});
  }
  if (spectrum.lines.empty())
    return lines.fault("expected at least one line");
  VOLUTE_TRY(readMember(value, "scale", spectrum.scale, positive));
  VOLUTE_TRY(readMember(value, "soot_exponent", spectrum.sootExponent, &JsonValue::number));
  return spectrum;
}

}  // namespace

double planck(double wavelength, double temperature) {
  constexpr double kFirst = 1.191042972e-16;  // 2 h c^2 [W m^2 / sr]
  constexpr double kSecond = 1.438776877e-2;  // h c / k [m K]
  const double metres = 1e-9 * wavelength;
  return 1e-9 * kFirst / (std::pow(metres, 5) * std::expm1(kSecond / (metres * temperature)));
}

Rgb CaptureSpectrum::blackBody(double temperature) const {
  Rgb sum = Rgb::Zero();
  for (const Line& line : lines) sum += line.weight * planck(line.wavelength, temperature);
  return scale * sum;
}

Rgb CaptureSpectrum::sootEmission(double temperature) const {
  Rgb sum = Rgb::Zero();
  for (const Line& line : lines)
    sum += line.weight * (std::pow(kReference / line.wavelength, sootExponent) *
                          planck(line.wavelength, temperature));
  return scale * sum;
}

Result<CaptureSpectrum> readSpectrum(const JsonValue& value, const std::filesystem::path& folder,
                                     std::vector<Remark>& remarks) {
  CaptureSpectrum spectrum;
  if (const auto lines = value.find("lines"))  // as writeCapture() writes it
    return writtenSpectrum(value, *lines);
  const auto table = value.find("sensitivities"), narrow = value.find("wavelengths");
  if (table.has_value() == narrow.has_value())
    return value.fault("expected one of 'sensitivities' and 'wavelengths'");
  if (narrow) {
    VOLUTE_ASSIGN(const Rgb at, positive(*narrow));
    for (int c = 0; c < 3; ++c) {
      VOLUTE_TRY(sampleOf({at[c], 1, 1, 1}, *narrow));
      spectrum.lines.push_back({at[c], Rgb::Zero()});
      spectrum.lines.back().weight[c] = 1;
    }
    remarkOnOrder(spectrum, "wavelengths", remarks);
  } else {
    std::vector<Sample> samples;
    if (table->json().is_string()) {
      VOLUTE_ASSIGN(const auto name, table->text());
      VOLUTE_ASSIGN(samples, tableOf(folder / name, *table));
    } else {
      VOLUTE_ASSIGN(const auto rows, table->items());
      for (const JsonValue& row : rows) {
        VOLUTE_ASSIGN(const auto numbers, row.numbers());
        VOLUTE_ASSIGN(const Sample sample, sampleOf(numbers, row));
        samples.push_back(sample);
      }
    }
    VOLUTE_ASSIGN(spectrum.lines, linesOf(samples, *table));
    remarkOnEnds(samples, remarks);
    remarkOnOrder(spectrum, "sensitivities", remarks);
  }
  if (const auto exponent = value.find("soot_exponent")) {
    constexpr double kMax = 4;
    VOLUTE_ASSIGN(spectrum.sootExponent, exponent->number());
    if (!(spectrum.sootExponent >= 0 && spectrum.sootExponent <= kMax))
      return exponent->fault(fmt::format("is {:g}; expected 0 to {}", spectrum.sootExponent, kMax));
  }
  VOLUTE_TRY(readScale(value, spectrum));
  return spectrum;
}

}  // namespace volute
