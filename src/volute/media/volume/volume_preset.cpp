// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_preset.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "volute/base/lower_case.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/codec/kept_grids.hpp"
#include "volute/grid/look_figures.hpp"
#include "volute/io/unit.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/volume_files/memory_volumes.hpp"
#include "volute/volume_files/volume_grids.hpp"

namespace volute {
namespace {

using Names = std::span<const std::string_view>;

// As simulations call their grids.
constexpr std::string_view kDensityNames[] = {"density", "extinction", "smoke", "soot",
                                              "fog",     "cloud",      "steam"};
constexpr std::string_view kFlameNames[] = {"flame", "flames", "fire", "burn", "burning"};
constexpr std::string_view kHeatNames[] = {"temperature", "temp", "heat"};
constexpr std::string_view kLightNames[] = {"emission", "radiance", "light"};
constexpr std::string_view kVelocityNames[] = {"velocity", "vel", "v"};
constexpr std::string_view kColorNames[] = {"color", "colour", "Cd", "albedo"};
// As people call files of one grid without a name.
constexpr std::string_view kFireWords[] = {"fire", "flame", "burn", "torch", "explosion"};
constexpr std::string_view kSmokeWords[] = {"smoke", "density", "soot", "fog",
                                            "cloud", "steam",   "mist"};

constexpr std::string_view kFogClass = "fog volume";

constexpr double kSmokeDepth = 6;  ///< optical depth of dense columns
constexpr double kFireLight = 4;   ///< radiance of bright columns
constexpr double kSmokeAlbedo = 0.9;
constexpr double kSmokeAsymmetry = 0.3;
constexpr double kKelvins = 600;  ///< temperatures that reach it are in kelvins

bool holdsWord(const std::string& text, Names words) {
  return std::ranges::any_of(
      words, [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

/// The words of a grid's name, in lower case: "voxelFog_density[1]" is voxel, fog, density and 1.
std::vector<std::string> wordsOf(const std::string& name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const auto before = static_cast<unsigned char>(i > 0 ? name[i - 1] : '_');
    const bool begins = (std::isupper(c) && std::islower(before)) ||
                        (std::isdigit(c) != 0) != (std::isdigit(before) != 0);
    if ((begins || !std::isalnum(c)) && !words.back().empty())
      words.emplace_back();
    if (std::isalnum(c))
      words.back() += static_cast<char>(std::tolower(c));
  }
  return words;
}

/// Words that make something else of a density or a temperature.
constexpr std::string_view kOtherWords[] = {"gradient", "grad",   "velocity", "vel",
                                            "rate",     "mask",   "shadow",   "difference",
                                            "diff",     "source", "rest"};

/// The name that is one of these or, where none is, has one of them among its words; empty: there
/// is none.
std::string nameAmong(const std::vector<std::string>& names, Names wanted) {
  for (const std::string_view one : wanted) {
    for (const std::string& name : names) {
      if (lowerCase(name) == lowerCase(one))
        return name;
    }
  }
  for (const std::string_view one : wanted) {
    for (const std::string& name : names) {
      const auto words = wordsOf(name);
      const auto has = [&](std::string_view word) {
        return std::ranges::find(words, lowerCase(word)) != words.end();
      };
      if (has(one) && std::ranges::none_of(kOtherWords, has))
        return name;
    }
  }
  return "";
}

/// A .volute says it; else some frames are read for it.
Result<LookFigures> figuresOf(const VolumeInput& volume) {
  if (volume.reader && volume.reader->grid().look)
    return *volume.reader->grid().look;
  return lookFigures(*volume.source);
}

/// The grids of a volume, and what presets want to know of them.
class Grids {
 public:
  static Result<Grids> open(const std::string& path, const InputOptions& input, Reading& reading,
                            std::shared_ptr<LoneFrame> frame) {
    Grids grids(path, input, reading, std::move(frame));
    InputOptions first = input;
    first.notFinite = NotFinite::kRefuse;  // as whoever draws it does
    Progress quiet;
    RemarkLog heard(quiet);
    Reading silent = reading.with(heard);
    auto found = openVolume(path, first, silent);
    const auto unclear = [&] {
      return !found && input.grid.empty() &&
             (found.error().code == ErrorCode::kInvalidArgument ||
              found.error().code == ErrorCode::kInvalidData);
    };
    // Nothing is called as expected, or nothing is in it: what a preset could show instead.
    std::vector<std::string> there;
    if (unclear() && VolumeGrids::mayBe(path)) {
      if (const auto cache = VolumeGrids::open(path, input, silent)) {
        for (const VolumeGrid& grid : (*cache)->grids()) {
          if (!grid.empty && grid.kept.empty())
            there.push_back(grid.name);
        }
      }
    }
    for (const Names names : {Names(kDensityNames), Names(kFlameNames), Names(kHeatNames)}) {
      const std::string matching = nameAmong(there, names);
      std::vector<std::string> tried(names.begin(), names.end());
      if (!matching.empty())
        tried.insert(tried.begin(), matching);
      for (const std::string& name : tried) {
        if (!unclear())
          break;
        first.grid = name;
        auto other = openVolume(path, first, silent);
        if (other)
          found = std::move(other);
      }
    }
    for (std::size_t i = 0; i < there.size() && unclear(); ++i) {
      first.grid = there[i];
      if (auto other = openVolume(path, first, silent);
          other && other->source->info().channels == 1)
        found = std::move(other), grids.taken_ = there[i];
    }
    if (!found)
      return tl::unexpected(std::move(found.error()));
    grids.main_ = std::move(*found);
    std::ranges::copy_if(
        heard.remarks(), std::back_inserter(grids.levelSets_), [](const Remark& one) {
          return one.code == RemarkCode::kLeftOut && one.sentence.ends_with("(level set)");
        });
    grids.keep(grids.main_);
    grids.names_ = grids.main_.source->otherGrids();
    grids.named_ = grids.isNamed(path);
    if (grids.named_)
      grids.names_.insert(grids.names_.begin(), grids.mainName());
    return grids;
  }

  const VolumeInfo& info() const { return main_.source->info(); }

  std::string mainName() const { return info().name; }

  /// Whether the format says what its values are.
  bool named() const { return named_; }

  const std::vector<std::string>& names() const { return names_; }

  /// Whether somebody said which grid is meant.
  bool stated() const { return !input_.grid.empty(); }

  /// The first of several of which no name says anything; empty: there is no need.
  const std::string& taken() const { return taken_; }

  /// What opening it tells of level sets, as long as no grid is named.
  const std::vector<Remark>& levelSets() const { return levelSets_; }

  const std::string& gridClass() const { return main_.gridClass; }

  /// All but these, with what a .volute keeps as bytes: "'density[1]', 'mask' (bool)".
  std::string others(std::span<const std::string> shown) const {
    std::vector<std::string> all;
    const auto isEmpty = [&](const std::string& name) {
      return main_.reader && std::ranges::any_of(main_.reader->grids(), [&](const VoluteGrid& one) {
               return one.info.name == name && one.empty;
             });
    };
    for (const std::string& name : names_) {
      if (std::ranges::find(shown, name) == shown.end() && !isEmpty(name))
        all.push_back(fmt::format("'{}'", name));
    }
    if (main_.reader) {
      for (const KeptGrid& grid : main_.reader->kept().grids)
        all.push_back(fmt::format("'{}' (kept as it was)", grid.name));
    }
    return fmt::format("{}", fmt::join(all, ", "));
  }

  /// As nameAmong().
  std::string find(Names wanted) const { return nameAmong(names_, wanted); }

  /// A grid with colours; as find(), or the first part of three grids' names.
  std::string findColors() const {
    if (std::string whole = find(kColorNames); !whole.empty())
      return whole;
    for (const std::string_view one : kColorNames) {
      const std::string base(one);
      const auto has = [&](const char* end) {
        return std::ranges::find(names_, base + end) != names_.end();
      };
      if (has("_r") && has("_g") && has("_b"))
        return base;
    }
    return "";
  }

  /// By its unit, of a grid of which range() was asked.
  std::optional<double> extinctionOf(const std::string& name) const {
    const auto info = infos_.find(name);
    return info != infos_.end() ? extinctionByUnit(info->second) : std::nullopt;
  }

  Result<LookFigures> range(const std::string& name) {
    if (name == mainName()) {
      infos_[name] = info();
      return figuresOf(main_);
    }
    InputOptions one = input_;
    one.grid = name;
    Progress quiet;
    Reading silent = reading_.with(quiet);
    auto other = openVolume(path_, one, silent);
    if (!other && other.error().code == ErrorCode::kInvalidData)
      return LookFigures();  // nothing is active in it
    if (!other)
      return tl::unexpected(std::move(other.error()));
    infos_[name] = other->source->info();
    other->source = asFinite(std::move(other->source), NotFinite::kRefuse, path_);
    keep(*other);
    if (auto figures = figuresOf(*other); figures || figures.error().code == ErrorCode::kCancelled)
      return figures;
    // It may not be drawn at all.
    VOLUTE_ASSIGN(*other, openVolume(path_, one, silent));
    return figuresOf(*other);
  }

  /// What makes kelvins of a grid that range() was asked about; nothing where it states no other
  /// unit.
  std::optional<UnitChange> kelvinsOf(const std::string& name) const {
    const auto info = infos_.find(name);
    const auto change = info != infos_.end() ? unitChange(info->second.unit, "K") : std::nullopt;
    return change && (change->factor != 1 || change->offset != 0) ? change : std::nullopt;
  }

 private:
  Grids(const std::string& path, const InputOptions& input, Reading& reading,
        std::shared_ptr<LoneFrame> frame)
      : path_(path), input_(input), reading_(reading), frame_(std::move(frame)) {}

  void keep(VolumeInput& input) const {
    if (!input.reader)
      input.source = LoneFrame::keeping(std::move(input.source), frame_);
  }

  /// A .npy has no names, nor has an array without one in a .npz or in memory, or a grid that
  /// OpenVDB calls "[0]", and a .volute of that alone says "density" of whatever it holds.
  bool isNamed(const std::string& path) const {
    std::error_code error;
    const bool nameless = isNumpyPath(path) || MemoryVolumes::isName(path);
    if ((nameless && info().name == VolumeInfo().name) || info().name.starts_with('[') ||
        (std::filesystem::is_directory(path, error) && volumesIn(path).value_or(".vdb") == ".npy"))
      return false;
    const std::string file = lowerCase(std::filesystem::path(path).stem().string());
    return !(isVolutePath(path) && names_.empty() && info().name == VolumeInfo().name &&
             holdsWord(file, kFireWords));
  }

  std::string path_;
  InputOptions input_;
  Reading& reading_;
  std::shared_ptr<LoneFrame> frame_;
  VolumeInput main_;
  std::vector<std::string> names_;
  std::string taken_;
  std::map<std::string, VolumeInfo> infos_;  // of those that range() was asked about
  std::vector<Remark> levelSets_;
  bool named_ = true;
};

/// Which grids a preset shows.
struct Choice {
  VolumePreset preset = VolumePreset::kNone;
  std::string density, flame, heat;
  std::string unusable;  // the grid whose name or class says what it is, and why it cannot be that
  LookFigures densityRange, flameRange, heatRange;  // the last of them in kelvins
  std::string heatUnit;                             // " K" where the file has another one
};

/// By names. A grid that somebody states is the one that is shown.
Choice namedChoice(VolumePreset wanted, const Grids& grids) {
  Choice choice;
  choice.density = grids.find(kDensityNames);
  choice.flame = grids.find(kFlameNames);
  choice.heat = grids.find(kHeatNames);
  if (!grids.stated() || wanted == VolumePreset::kFireAndSmoke)
    return choice;
  const std::string shown = grids.mainName();
  const auto isAmong = [&](Names names) { return !nameAmong({shown}, names).empty(); };
  if (isAmong(kDensityNames) || wanted == VolumePreset::kSmoke) {
    choice.density = shown;
  } else if (isAmong(kHeatNames) && !isAmong(kFlameNames)) {
    choice.heat = shown, choice.density.clear(), choice.flame.clear();
  } else {
    const bool burns = isAmong(kFlameNames) || wanted == VolumePreset::kFire;
    choice.flame = burns ? shown : "";
    choice.density.clear();
    if (!burns)
      choice.heat.clear();
  }
  return choice;
}

Result<Choice> choose(VolumePreset wanted, Grids& grids, const std::string& path) {
  const bool automatic = wanted == VolumePreset::kAuto;
  Choice choice;
  if (grids.info().channels == 3) {
    if (automatic)
      return choice;  // colours are light
    if (wanted != VolumePreset::kSmoke) {
      return fail(ErrorCode::kInvalidArgument, Hint::set("preset", "none"),
                  "{}: the preset is for grids of one channel, but '{}' has three, which are shown "
                  "as light without it",
                  path, grids.mainName());
    }
    choice.density = grids.mainName();
  } else if (grids.named()) {
    choice = namedChoice(wanted, grids);
  } else {
    const std::string file = lowerCase(std::filesystem::path(path).stem().string());
    const bool fire = wanted == VolumePreset::kFire || (automatic && holdsWord(file, kFireWords));
    const bool smoke =
        wanted == VolumePreset::kSmoke || (automatic && holdsWord(file, kSmokeWords));
    (fire ? choice.flame : choice.density) = fire || smoke ? grids.mainName() : "";
  }
  // The only grid, or the one that is chosen, is what somebody says it is.
  const bool one = grids.names().size() == 1 || grids.stated();
  if (one && wanted == VolumePreset::kFire && choice.flame.empty())
    choice.flame = grids.mainName(), choice.density.clear();
  if (one && wanted == VolumePreset::kSmoke && choice.density.empty())
    choice.density = grids.mainName(), choice.flame.clear();
  // Of whatever name: fog is what its class says.
  const bool unknown = choice.density.empty() && choice.flame.empty() && choice.heat.empty();
  if (automatic && unknown && grids.gridClass() == kFogClass)
    choice.density = grids.mainName();
  for (const auto& [name, range] :
       {std::pair(&choice.density, &choice.densityRange),
        std::pair(&choice.flame, &choice.flameRange), std::pair(&choice.heat, &choice.heatRange)}) {
    if (name->empty())
      continue;
    VOLUTE_ASSIGN(*range, grids.range(*name));
    // What is below zero as far as above it is no amount of anything, whatever its name.
    if (range->any() && !(range->least < -0.5 * range->most))
      continue;
    if (*name == grids.mainName())
      choice.unusable = range->any() ? fmt::format(
                                           "its values, {:.3g} to {:.3g}, are no amount of "
                                           "smoke or fire",
                                           range->least, range->most)
                                     : std::string("none of its values is above 0");
    name->clear();
  }
  if (const auto change = grids.kelvinsOf(choice.heat)) {
    choice.heatRange.most = (*change)(choice.heatRange.most);
    choice.heatRange.column =
        change->factor * choice.heatRange.column + change->offset * grids.info().bounds.size().z();
    choice.heatUnit = " K";
  }
  const bool kelvins = choice.heatRange.most >= kKelvins;
  const bool burns = !choice.flame.empty() || (!choice.heat.empty() && kelvins);
  const bool smokes = !choice.density.empty();
  if (automatic) {
    choice.preset = burns && smokes ? VolumePreset::kFireAndSmoke
                    : burns         ? VolumePreset::kFire
                    : smokes        ? VolumePreset::kSmoke
                                    : VolumePreset::kNone;
    return choice;
  }
  choice.preset = wanted;
  std::string missing;
  if (wanted != VolumePreset::kSmoke && !burns)
    missing =
        "a grid of flames (flame, fire, burn) or of temperatures in kelvins (temperature, heat)";
  else if (wanted != VolumePreset::kFire && !smokes)
    missing = "a grid of smoke (density, smoke, soot)";
  if (missing.empty())
    return choice;
  return fail(ErrorCode::kInvalidArgument,
              "{}: the preset needs {} that is not empty; the file has {}", path, missing,
              grids.names().empty() ? std::string("one without a name")
                                    : fmt::format("{}", fmt::join(grids.names(), ", ")));
}

double rounded(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

}  // namespace

/// A level set is no amount of anything, whatever its distances are in.
std::optional<double> extinctionByUnit(const VolumeInfo& info) {
  const auto perMetre = info.levelSet ? std::nullopt : unitChange(info.unit, "1/m");
  return perMetre ? std::optional(perMetre->factor) : std::nullopt;
}

Result<VolumePreset> applyPreset(VolumePreset preset, const std::string& path, InputOptions& input,
                                 Appearance& appearance, Reading& reading,
                                 const std::shared_ptr<LoneFrame>& frame,
                                 const std::function<bool(const char*)>& stated, bool depths) {
  if (preset == VolumePreset::kNone)
    return preset;
  VOLUTE_ASSIGN(auto grids, Grids::open(path, input, reading, frame));
  if (!grids.taken().empty()) {
    input.grid = grids.taken();
    std::string others;
    for (const std::string& name : grids.names()) {
      if (name != grids.taken())
        others += (others.empty() ? "" : ", ") + name;
    }
    reading.progress.remark(Remark(RemarkCode::kAssumed,
                                   fmt::format("{}: the grid '{}' is read; it also has {}", path,
                                               grids.taken(), others),
                                   {Hint::choose("field")})
                                .in(path));
  }
  const auto tellOthers = [&](const std::vector<std::string>& shown) {
    if (grids.stated())
      return;
    for (const Remark& one : grids.levelSets()) reading.progress.remark(one);
    if (const std::string others = grids.others(shown); !others.empty()) {
      reading.progress.remark(Remark(RemarkCode::kNote,
                                     fmt::format("{}: not shown: {}", path, others),
                                     {Hint::choose("field")})
                                  .in(path));
    }
  };
  // Light that somebody has measured or computed is shown as it is.
  const std::string light = grids.find(kLightNames);
  if (preset == VolumePreset::kAuto && !light.empty() && grids.named()) {
    if (light != grids.mainName() && input.grid.empty()) {
      input.grid = light;
      reading.progress.remark(Remark(RemarkCode::kAssumed,
                                     fmt::format("{}: shown by the light of '{}'", path, light),
                                     {Hint::choose("field")})
                                  .in(path));
      tellOthers({light});
    }
    return VolumePreset::kNone;
  }
  if (grids.info().levelSet && (preset == VolumePreset::kAuto || preset == VolumePreset::kSmoke)) {
    constexpr double kDepthOfAVoxel = 4;
    appearance.emission = 0;
    appearance.surface = preset == VolumePreset::kAuto;
    std::string text = "the surface of the level set, grey";
    if (!appearance.surface) {
      appearance.extinction = rounded(kDepthOfAVoxel / grids.info().voxelSize().minCoeff());
      appearance.albedo = Rgb::Constant(kSmokeAlbedo);
      text = fmt::format("dense matter of extinction {:.3g} inside of the level set",
                         appearance.extinction);
    }
    reading.progress.remark(
        Remark(RemarkCode::kAssumed,
               fmt::format("{}: '{}' is shown as {}", path, grids.mainName(), text),
               {Hint::set("preset", appearance.surface ? "smoke" : "auto")
                    .so(appearance.surface ? "shows its inside as dense matter"
                                           : "shows its surface")})
            .in(path));
    input.grid = grids.named() ? grids.mainName() : input.grid;
    tellOthers({grids.mainName()});
    return VolumePreset::kSmoke;
  }
  VOLUTE_ASSIGN(const Choice choice, choose(preset, grids, path));
  if (choice.preset == VolumePreset::kNone) {
    const std::string shown = grids.mainName();
    const bool grey = grids.info().channels == 1;
    const bool called =
        !grey && ((grids.named() && !nameAmong({shown}, kDensityNames).empty()) ||
                  holdsWord(lowerCase(std::filesystem::path(path).stem().string()), kSmokeWords));
    if (called || isVdbPath(path) || (grids.named() && !shown.empty())) {
      std::string text = fmt::format("{}: '{}' is shown as light", path, shown);
      text +=
          grey && !choice.unusable.empty() ? ": " + choice.unusable
          : grey ? std::string(": neither its name nor its class says that it is smoke or fire")
          : called
              ? std::string(", its values as red, green and blue, although its name says smoke")
              : ", its values as red, green and blue, none where they are below 0: its name does "
                "not say what they are";
      Hints hints;
      if (grey || called)
        hints.push_back(Hint::set("preset", "smoke").so("shows it as smoke"));
      reading.progress.remark(Remark(RemarkCode::kAssumed, std::move(text), hints).in(path));
    } else if (preset == VolumePreset::kAuto && grey && !MemoryVolumes::isName(path)) {
      reading.progress.remark(
          Remark(
              RemarkCode::kNote,
              fmt::format("{}: shown as light, as an array has no name that says what it is", path),
              {Hint::set("preset", "smoke").so("shows it as smoke")})
              .in(path));
    }
    tellOthers(grids.names());  // opening it names those
    return choice.preset;
  }
  const bool smokes = choice.preset != VolumePreset::kFire;
  const bool burns = choice.preset != VolumePreset::kSmoke;
  if (grids.named())
    input.grid = smokes ? choice.density : choice.flame.empty() ? choice.heat : choice.flame;
  appearance.emission = 0;
  std::string text;
  if (smokes) {
    appearance.extinction = rounded(kSmokeDepth / choice.densityRange.column);
    appearance.albedo = Rgb::Constant(kSmokeAlbedo);
    appearance.asymmetry = kSmokeAsymmetry;
    appearance.colors = grids.findColors();
    text = fmt::format("smoke from {}'{}' ({:.3g} to {:.3g})",
                       grids.info().channels == 3 ? "the mean of the three channels of " : "",
                       choice.density, std::min(0.0, choice.densityRange.least),
                       choice.densityRange.most);
    for (const auto& [name, value] :
         {std::pair("extinction", appearance.extinction), std::pair("albedo", kSmokeAlbedo),
          std::pair("asymmetry", kSmokeAsymmetry)}) {
      const bool byUnit =
          depths && name == std::string_view("extinction") && grids.extinctionOf(choice.density);
      if (!byUnit && (!stated || !stated(name)))
        text += fmt::format(", {} {:.3g}", name, value);
    }
  }
  if (burns) {
    Flames flames;
    flames.field = choice.flame;
    const LookFigures& range = choice.flame.empty() ? choice.heatRange : choice.flameRange;
    if (choice.flame.empty()) {
      flames.temperature = choice.heat;
      flames.hottest = range.most;
      flames.brightness = rounded(kFireLight / (range.column / range.most));
    } else {
      flames.scale = 1 / range.most;
      flames.brightness = rounded(kFireLight / (range.column / range.most));
      if (choice.heatRange.most >= kKelvins)
        flames.temperature = choice.heat;
    }
    if (!text.empty())
      text += "; ";
    text += fmt::format("fire from '{}' (0 to {:.3g}{}) as black bodies {}",
                        choice.flame.empty() ? choice.heat : choice.flame, range.most,
                        choice.flame.empty() ? choice.heatUnit : "",
                        flames.temperature.empty()
                            ? fmt::format("of {:g} to {:g} K", flames.coolest, flames.hottest)
                            : fmt::format("as hot as '{}' says", flames.temperature));
    appearance.flames = flames;
  }
  // What was asked for is no assumption.
  const RemarkCode code = preset == VolumePreset::kAuto ? RemarkCode::kAssumed : RemarkCode::kNote;
  reading.progress.remark(Remark(code, fmt::format("{}: shown as {}", path, text),
                                 {Hint::set("preset", "none").so("shows plain values as light")})
                              .in(path));
  std::vector<std::string> shown{grids.mainName(), input.grid};
  if (appearance.flames)
    shown.insert(shown.end(), {appearance.flames->field, appearance.flames->temperature});
  for (const char* end : {"", "_r", "_g", "_b"}) {
    if (!appearance.colors.empty())
      shown.push_back(appearance.colors + end);
  }
  if (appearance.interpolation != Interpolation::kNone &&
      appearance.interpolation != Interpolation::kLinear) {
    std::ranges::copy_if(grids.names(), std::back_inserter(shown), [](const std::string& name) {
      return std::ranges::find(kVelocityNames, wordsOf(name).front()) != std::end(kVelocityNames);
    });
  }
  tellOthers(shown);
  return choice.preset;
}

}  // namespace volute
