// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/mesh_air.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "volute/base/file_name.hpp"
#include "volute/base/lower_case.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/suggest.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/media/smoke/tet_sight.hpp"

namespace volute {
namespace {

/// A quantity of the air, what fields of it are usually called, and its molar mass [g/mol].
struct UsualField {
  std::string_view quantity;
  std::array<std::string_view, 3> names;
  double molarMass = 0;
};

constexpr UsualField kUsual[] = {{"temperature", {"t", "temperature", "temp"}},
                                 {"radiant-flux", {"radiant_flux", "", ""}},
                                 {"carbon-monoxide", {"co", "x_co", ""}, 28.01},
                                 {"carbon-dioxide", {"co2", "x_co2", ""}, 44.01},
                                 {"oxygen", {"o2", "x_o2", ""}, 32.0},
                                 {"hydrogen-cyanide", {"hcn", "x_hcn", ""}, 27.03},
                                 {"nitric-oxide", {"no", "x_no", ""}, 30.01},
                                 {"nitrogen-dioxide", {"no2", "x_no2", ""}, 46.01},
                                 {"hydrogen-chloride", {"hcl", "x_hcl", ""}, 36.46},
                                 {"hydrogen-bromide", {"hbr", "x_hbr", ""}, 80.91},
                                 {"hydrogen-fluoride", {"hf", "x_hf", ""}, 20.01},
                                 {"sulfur-dioxide", {"so2", "x_so2", ""}, 64.06},
                                 {"acrolein", {"c3h4o", "acrolein", ""}, 56.06},
                                 {"formaldehyde", {"ch2o", "formaldehyde", ""}, 30.03}};

constexpr double kAir = 28.96;  // [g/mol]

const UsualField* usualField(std::string_view quantity) {
  const auto* found = std::ranges::find(kUsual, quantity, &UsualField::quantity);
  return found == std::end(kUsual) ? nullptr : found;
}

/// What a field's values are multiplied with, and then added to, for the quantity's own unit.
struct Conversion {
  double factor = 1, added = 0;
};

std::optional<Conversion> conversionOf(const UsualField& usual, std::string_view unit) {
  if (usual.quantity == "temperature") {
    if (unit == "K")
      return Conversion{1, -273.15};
    return unit == "C" ? std::optional(Conversion{}) : std::nullopt;
  }
  if (usual.quantity == "radiant-flux") {
    if (unit == "W/m2")
      return Conversion{1e-3, 0};
    return unit == "kW/m2" ? std::optional(Conversion{}) : std::nullopt;
  }
  if (unit == "mol/mol")
    return Conversion{};
  if (unit == "%")
    return Conversion{1e-2, 0};
  if (unit == "ppm")
    return Conversion{1e-6, 0};
  return unit == "kg/kg" ? std::optional(Conversion{kAir / usual.molarMass, 0}) : std::nullopt;
}

bool isOfGas(const UsualField& usual) {
  return usual.molarMass > 0;
}

std::string_view unitsOf(const UsualField& usual) {
  return usual.quantity == "temperature"    ? "K or C"
         : usual.quantity == "radiant-flux" ? "kW/m2 or W/m2"
                                            : "mol/mol, %, ppm or kg/kg";
}

/// A field of a mesh as a quantity of the air.
class MeshPoints final : public PointField {
 public:
  MeshPoints(MeshSource source, MeshAirField named, Conversion conversion, bool ofGas,
             std::shared_ptr<MeshGasRead> read = nullptr)
      : source_(std::move(source)),
        named_(std::move(named)),
        conversion_(conversion),
        ofGas_(ofGas),
        read_(std::move(read)) {}

  std::string description() const override {
    return fmt::format("{} (field '{}' in {})", named_.quantity, named_.field, named_.unit);
  }

  std::span<const double> times() const override { return source_.times(); }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
    const auto place = storedPlace(times(), time);
    if (!place)
      return {};
    VOLUTE_ASSIGN(const auto first, frame(place->first));
    first->extinction(points, out);
    if (place->share > 0) {
      VOLUTE_ASSIGN(const auto second, frame(place->second));
      std::vector<double> later(points.size());
      second->extinction(points, later);
      for (std::size_t i = 0; i < later.size(); ++i) out[i] += place->share * (later[i] - out[i]);
    }
    for (double& value : out) value = conversion_.factor * value + conversion_.added;
    return {};
  }

 private:
  /// Of a gas: no air has more of it than all. Less than none is what schemes of a solver leave,
  /// unless it is much.
  Status checkGas(std::span<const float> values, std::size_t number) const {
    constexpr double kAll = 1.01, kLittle = 1e-4, kShare = 0.01;  // shares; kShare of the largest
    const auto [least, most] = std::ranges::minmax(values);
    const double factor = named_.unit == "kg/kg" ? 1 : conversion_.factor;
    const double low = factor * least, high = factor * most;
    if (high <= kAll && low >= -std::max(kLittle, kShare * high))
      return {};
    const std::string found = fmt::format(
        "{}: field '{}' is {:g} at {} s, read in {}", source_.path().string(), named_.field,
        high > kAll ? most : least, plainNumber(times()[number]), named_.unit);
    if (high <= kAll)
      return fail(ErrorCode::kInvalidData, "{}; expected none or more of a gas", found);
    return fail(ErrorCode::kInvalidData, Hint::set("air_fields"),
                "{}; expected no more than all of the air: state its unit, as {}={}:%", found,
                named_.quantity, named_.field);
  }

  /// The values of a stored time; TetSightSnapshot interpolates whatever they are.
  Result<std::shared_ptr<const TetSightSnapshot>> frame(std::size_t number) {
    if (const auto kept = kept_.find(number); kept != kept_.end())
      return kept->second;
    VOLUTE_ASSIGN(auto read, source_.read(number));
    if (ofGas_) {
      VOLUTE_TRY(checkGas(read.values, number));
      const auto all = static_cast<float>(1 / conversion_.factor);
      for (float& value : read.values) value = std::clamp(value, 0.0F, all);
      if (read_)
        read_->most = std::max<double>(read_->most, std::ranges::max(read.values));
    }
    if (!locator_ || &locator_->mesh() != read.mesh.get())
      locator_ = std::make_shared<const TetLocator>(read.mesh);
    if (kept_.size() == 2)
      kept_.erase(kept_.begin()->first < number ? kept_.begin() : std::prev(kept_.end()));
    return kept_[number] =
               std::make_shared<const TetSightSnapshot>(locator_, std::move(read.values));
  }

  MeshSource source_;
  MeshAirField named_;
  Conversion conversion_;
  bool ofGas_;
  std::shared_ptr<MeshGasRead> read_;                                    // null: nobody asks
  std::shared_ptr<const TetLocator> locator_;                            // of the last mesh
  std::map<std::size_t, std::shared_ptr<const TetSightSnapshot>> kept_;  // two at most
};

/// What OpenFOAM states of a field, at the first time that has it.
std::optional<FoamDimensions> dimensionsOf(const MeshSource& mesh, const std::string& field) {
  if (extensionOf(mesh.path()) != ".foam")
    return std::nullopt;
  for (const double time : mesh.times()) {
    if (const auto stated = foamDimensions(mesh.path(), field, time))
      return stated;
  }
  return std::nullopt;
}

/// The unit of a field of which nobody said it, and whose dimensions are the quantity's, or none.
Result<std::string> unitOf(const MeshSource& mesh, const UsualField& usual,
                           const MeshFieldSummary& field) {
  constexpr double kKelvin = 150;  // no air is as cold, nor as hot everywhere
  constexpr FoamDimensions kNone{};
  const bool heat = usual.quantity == "temperature", flux = usual.quantity == "radiant-flux";
  const auto stated = dimensionsOf(mesh, field.name);
  const bool says = stated && *stated != kNone;
  if (heat && says && field.least < kKelvin) {
    return fail(ErrorCode::kInvalidData, Hint::set("air_fields"),
                "{}: field '{}' is {:g} and more, and the file states K; state its unit, as "
                "temperature={}:C",
                mesh.path().string(), field.name, field.least, field.name);
  }
  if (heat)
    return std::string(says || field.least >= kKelvin ? "K" : "C");
  if (flux)
    return std::string(says ? "W/m2" : "kW/m2");
  return std::string(extensionOf(mesh.path()) == ".foam" ? "kg/kg" : "mol/mol");
}

/// A unit that somebody said, where the field is no temperature, or no oxygen, of air in it.
Status checkUnit(const MeshSource& mesh, const UsualField& usual, const MeshFieldSummary& field,
                 const std::string& unit) {
  constexpr double kNoRoom = 200, kNoAir = 150;  // [degrees C] everywhere, [K]
  constexpr double kNoOxygen = 0.01;             // [mol/mol]
  const auto wrong = [&](double value, const char* how, std::string_view better) {
    return fail(
        ErrorCode::kInvalidData, Hint::set("air_fields"),
        "{}: field '{}' is {:.4g} and {}, read in {}; expected what air has: is it {}={}:{}?",
        mesh.path().string(), field.name, value, how, unit, usual.quantity, field.name, better);
  };
  if (usual.quantity == "temperature" && unit == "C" && field.least >= kNoRoom)
    return wrong(field.least, "more", "K");
  if (usual.quantity == "temperature" && unit == "K" && field.most < kNoAir)
    return wrong(field.most, "less", "C");
  const double share = field.most * conversionOf(usual, unit)->factor;
  if (usual.quantity == "oxygen" && field.most > 0 && share < kNoOxygen)
    return wrong(field.most, "less", field.most <= 1 ? "mol/mol" : "%");
  return {};
}

Status checkDimensions(const MeshSource& mesh, const UsualField& usual, const std::string& field) {
  constexpr FoamDimensions kNone{}, kHeat{0, 0, 0, 1}, kFlux{1, 0, -3};
  const FoamDimensions& expected = usual.quantity == "temperature"    ? kHeat
                                   : usual.quantity == "radiant-flux" ? kFlux
                                                                      : kNone;
  const auto stated = dimensionsOf(mesh, field);
  if (!stated || *stated == kNone || *stated == expected)
    return {};
  return fail(ErrorCode::kInvalidData, Hint::set("air_fields"),
              "{}: field '{}': the file states {}, and {} has {}", mesh.path().string(), field,
              textOfDimensions(*stated), usual.quantity, textOfDimensions(expected));
}

/// A scalar that is not there at the first time of a case, but later.
template <class Wanted>
std::optional<MeshFieldSummary> laterField(const MeshSource& mesh, const MeshFieldNames& later,
                                           const Wanted& wanted) {
  for (const auto& names : later) {
    const auto name = std::ranges::find_if(names, wanted);
    if (name == names.end())
      continue;
    const auto source = mesh.withField(*name, Negatives::kKeep);
    const auto described = source ? source->describe(0) : tl::unexpected(source.error());
    if (!described)
      return std::nullopt;
    const auto field = std::ranges::find_if(
        described->fields, [&](const MeshFieldSummary& one) { return one.name == *name; });
    const bool found = field != described->fields.end() && field->components == 1;
    return found ? std::optional(*field) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<MeshAirField>> parseMeshAir(std::string_view text) {
  std::vector<MeshAirField> all;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find(','));
    text.remove_prefix(std::min(one.size() + 1, text.size()));
    const auto equals = one.find('='), colon = one.rfind(':');
    MeshAirField field;
    field.quantity = one.substr(0, equals);
    if (equals != one.npos) {
      const bool unit = colon != one.npos && colon > equals;
      field.field = one.substr(equals + 1, unit ? colon - equals - 1 : one.npos);
      field.unit = unit ? one.substr(colon + 1) : "";
    }
    if (field.field.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "'{}': expected QUANTITY=FIELD:UNIT, such as temperature=T:K,oxygen=O2:%", one);
    }
    const UsualField* usual = usualField(field.quantity);
    if (usual == nullptr) {
      std::vector<std::string_view> names;
      for (const UsualField& known : kUsual) names.push_back(known.quantity);
      const auto near = nearest(field.quantity, names);
      return fail(ErrorCode::kInvalidArgument, "quantity '{}' is unknown{}; expected one of {}",
                  field.quantity, near.empty() ? "" : fmt::format("; did you mean '{}'?", near),
                  fmt::join(names, ", "));
    }
    if (!field.unit.empty() && !conversionOf(*usual, field.unit)) {
      return fail(ErrorCode::kInvalidArgument, "{}: unit '{}' is unknown; expected {}",
                  field.quantity, field.unit, unitsOf(*usual));
    }
    if (std::ranges::find(all, field.quantity, &MeshAirField::quantity) != all.end())
      return fail(ErrorCode::kInvalidArgument, "{} is there twice", field.quantity);
    all.push_back(std::move(field));
  }
  return all;
}

std::optional<Remark> MeshGasRead::doubt() const {
  constexpr double kHarmless = 1;  // [ppm], of any gas
  if (named.unit != "ppm" || !(most > 0) || most >= kHarmless)
    return std::nullopt;
  return Remark(RemarkCode::kDoubtful,
                fmt::format("field '{}' is at most {:.3g}, read in ppm: is it {}={}:mol/mol?",
                            named.field, most, named.quantity, named.field),
                {Hint::set("air_fields")});
}

Result<std::unique_ptr<PointField>> meshConditions(
    const MeshSource& mesh, std::string_view quantity, std::span<const MeshAirField> named,
    std::span<const MeshFieldSummary> fields, const std::function<const MeshFieldNames&()>& later,
    std::vector<std::shared_ptr<MeshGasRead>>& gases) {
  const UsualField* usual = usualField(quantity);
  const auto said = std::ranges::find(named, quantity, &MeshAirField::quantity);
  MeshAirField one{std::string(quantity), "", ""};
  const auto wanted = [&](std::string_view name) {
    if (said != named.end())
      return name == said->field;
    return usual != nullptr &&
           std::ranges::find(usual->names, lowerCase(name)) != usual->names.end();
  };
  std::optional<MeshFieldSummary> summary;
  for (const MeshFieldSummary& field : fields) {
    if (!summary && field.components == 1 && wanted(field.name))
      summary = field;
  }
  if (!summary)
    summary = laterField(mesh, later(), wanted);
  if (!summary) {
    if (said != named.end())
      return fail(ErrorCode::kNotFound, "the mesh has no scalar field '{}'", said->field);
    return fail(ErrorCode::kNotFound, "the mesh has no field with a usual name of {}", quantity);
  }
  one.field = summary->name;
  one.unit = said != named.end() ? said->unit : "";
  VOLUTE_TRY(checkDimensions(mesh, *usual, one.field));
  const bool ofGas = isOfGas(*usual);
  std::shared_ptr<MeshGasRead> read;
  if (one.unit.empty()) {
    VOLUTE_ASSIGN(one.unit, unitOf(mesh, *usual, *summary));
  } else {
    VOLUTE_TRY(checkUnit(mesh, *usual, *summary, one.unit));
    if (ofGas)
      read = gases.emplace_back(std::make_shared<MeshGasRead>(MeshGasRead{one}));
  }
  VOLUTE_ASSIGN(auto source,
                mesh.withField(one.field, ofGas ? Negatives::kKeep : Negatives::kClamp));
  const Conversion conversion = *conversionOf(*usual, one.unit);
  return std::make_unique<MeshPoints>(std::move(source), std::move(one), conversion, ofGas,
                                      std::move(read));
}

Result<std::unique_ptr<PointField>> meshField(const MeshSource& mesh, const std::string& field) {
  VOLUTE_ASSIGN(auto source, mesh.withField(field, Negatives::kKeep));
  return std::make_unique<MeshPoints>(std::move(source), MeshAirField{field, field, ""},
                                      Conversion{}, false);
}

}  // namespace volute
