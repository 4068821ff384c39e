// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/result.hpp"

// The members of an object of a scene, as a table with one row per member. Reading and writing
// JSON, the schema, the options of commands and the viewer's sliders are loops over its rows.

namespace volute {

enum class FieldType {
  kNumber,  ///< with `choices` also one of these names
  kInteger,
  kFlag,    ///< true or false
  kChoice,  ///< one of `choices`
  kText,
  kFile,       ///< relative to the scene's folder
  kPoint,      ///< three numbers
  kDirection,  ///< likewise
  kColor,      ///< likewise: linear RGB
  kNumbers,    ///< `count` numbers; 0: any number of them
  kRows,       ///< a list of `count` numbers each
  kObject,     ///< members of another table
};

/// The value of a member, in the types of JSON; null: not given. File names are resolved paths, not
/// as written.
using FieldValue = nlohmann::json;

struct FieldRow;
struct FieldTable;
struct MediumFacts;
class ParameterGroup;

/// Tells types apart, in programs without RTTI, too.
template <class T>
constexpr std::string_view typeName() {
  return __PRETTY_FUNCTION__;
}

/// Connects a row with the struct that it describes. member() and part() make one for a plain
/// member, customMember() one from two functions.
struct FieldAccess {
  std::string_view owner = {};  ///< the name of the struct, by typeName()
  FieldValue (*get)(const FieldRow& field, const void* object) = nullptr;
  /// Sets a value allowed by the row. Its error message does not name the place.
  Status (*set)(const FieldRow& field, void* object, const FieldValue& value) = nullptr;
  /// For a kObject: the object, created if there is none; null for read-only access then.
  void* (*make)(void* object) = nullptr;
  const void* (*find)(const void* object) = nullptr;
};

/// The equivalent option of commands; none without a value and a name.
struct FieldOption {
  std::string_view value = {};      ///< its name in the help: "KM"
  std::string_view name = {};       ///< unless it is the member's with `-` for `_`
  std::string_view initial = {};    ///< a default that differs from the struct's
  std::string_view flagValue = {};  ///< a flag that stands for this value
  std::string_view beside = {};     ///< the option without which it has no effect
  std::string_view more = {};       ///< appended to the help
  /// A parser, for another syntax than a number, a name or numbers with commas.
  Result<FieldValue> (*parse)(std::string_view text) = nullptr;
  bool picture = false;  ///< changes the appearance of a medium, not its data
  bool scene = false;    ///< applies to scenes as well
};

/// The slider for the member; none without a label.
struct FieldSlider {
  std::string_view label = {};  ///< "width|height": one for each of two numbers
  double least = -std::numeric_limits<double>::infinity();  ///< unless the member's
  double most = std::numeric_limits<double>::infinity();
  bool logarithmic = false;
  double room = 1;                ///< the range extends to at least this multiple of the value
  std::string_view section = {};  ///< a heading of its own
  std::string_view unit = {};     ///< unless the member's
  /// Whether it applies at present.
  bool (*shown)(const void* object, const MediumFacts& facts) = nullptr;
  /// The distance a kPoint moves per pixel of the mouse.
  double (*step)(const void* object, const MediumFacts& facts) = nullptr;
  /// Adds what one row cannot express. `object` is the struct, for a kObject the member, or null.
  void (*custom)(ParameterGroup& group, const void* object, const MediumFacts& facts) = nullptr;
};

/// One member.
struct FieldRow {
  std::string_view name = {};  ///< in files: "mass_extinction"
  FieldType type = FieldType::kNumber;
  FieldAccess access = {};
  std::string_view help = {};  ///< one sentence, without unit, range and default; no full stop
  std::string_view unit = {};
  double least = -std::numeric_limits<double>::infinity();  ///< of each number
  double most = std::numeric_limits<double>::infinity();
  bool above = false, below = false;  ///< more than `least`, less than `most`
  std::span<const std::string_view> choices = {};
  int count = 3;         ///< of kNumbers and kRows
  int fewest = 0;        ///< minimum count; 0: `count`
  bool whole = false;    ///< kNumbers: integers
  bool several = false;  ///< kFile: a list is allowed, too
  bool flagToo = false;  ///< true or false is allowed, too
  bool required = false;
  bool inherited = false;       ///< its default is the value of the enclosing object
  std::string_view older = {};  ///< what volute-scene-1 means where it is not given
  std::string_view otherName = {};
  std::string_view pattern = {};      ///< kFile: that names match, for the schema
  const FieldTable* table = nullptr;  ///< of a kObject
  FieldOption option = {};
  FieldSlider slider = {};

  bool holds(double number) const {
    return (above ? number > least : number >= least) && (below ? number < most : number <= most);
  }

  bool hasOption() const { return !option.value.empty() || !option.name.empty(); }

  /// Without dashes; for a member of a member, `outer` is the name of the latter.
  std::string optionName(std::string_view outer = {}) const;

  /// "at least 0", "0 to 1", "more than 0"; empty: any.
  std::string rangeText() const;

  /// "three numbers of 0 to 1 [m]".
  std::string expected() const;

  /// "extinction of 1 kg/m3 of soot [m2/kg]".
  std::string sentence() const;
};

/// A kind of object. fieldTable() fills in the struct's part.
struct FieldTable {
  std::string_view name = {};      ///< "fog"
  std::string_view sentence = {};  ///< what it describes
  std::span<const FieldRow> fields = {};
  std::string_view kind = {};                 ///< the value of "kind"; empty: no such member
  std::string_view thing = {};                ///< "an FDS case"
  std::string_view things = {};               ///< "FDS cases"
  const void* usual = nullptr;                ///< the struct with its defaults
  std::shared_ptr<void> (*make)() = nullptr;  ///< another one
  std::string_view owner = {};                ///< its name, by typeName()

  /// Null if there is none; also found by its other name.
  const FieldRow* find(std::string_view name) const;
  /// A row that must exist.
  const FieldRow& at(std::string_view name) const;
};

/// The place of an object in a file or on a command line, for error messages.
struct FieldOrigin {
  std::string file = {};   ///< empty: options of a command line
  std::string path = {};   ///< of the object in the file: "/media/0"
  std::string outer = {};  ///< on a command line: the option whose value is this object

  bool options() const { return file.empty(); }

  /// "scene.json: /media/0/cell" or "cell".
  std::string place(const FieldRow& field) const;

  /// A message about a member, or about the whole object. The code is kInvalidData for files,
  /// kInvalidArgument for options.
  /// @param at  the place within the member: "[2]"
  tl::unexpected<Error> wrong(const FieldRow& field, std::string_view message,
                              std::string_view at = {}) const;
  tl::unexpected<Error> wrong(std::string_view message) const;

  FieldOrigin within(const FieldRow& field) const;
};

/// Checks each member and stores it in `object`, which has the table's type; members not given keep
/// their values. Unknown names are errors, and so are missing required ones.
[[nodiscard]] Status readFields(const FieldTable& table, const FieldValue& json,
                                const FieldOrigin& origin, void* object);

template <class T>
Result<T> readAs(const FieldTable& table, const FieldValue& json, const FieldOrigin& origin) {
  VOLUTE_ASSERT(table.owner == typeName<T>());
  T object{};
  VOLUTE_TRY(readFields(table, json, origin, &object));
  return object;
}

/// Calls `read` for each entry of a list, with its place.
[[nodiscard]] Status eachEntry(
    const FieldValue& json, const FieldOrigin& origin,
    const std::function<Status(const FieldValue& entry, const FieldOrigin& origin)>& read);

/// A list of such objects.
template <class T>
Result<std::vector<T>> readList(const FieldTable& table, const FieldValue& json,
                                const FieldOrigin& origin) {
  std::vector<T> list;
  VOLUTE_TRY(
      eachEntry(json, origin, [&](const FieldValue& entry, const FieldOrigin& place) -> Status {
        VOLUTE_ASSIGN(auto read, readAs<T>(table, entry, place));
        list.push_back(std::move(read));
        return {};
      }));
  return list;
}

/// The JSON that readFields() reads: "kind" if there is one, required members, and members that
/// differ from their defaults. File names are relative to the folder of `file`.
nlohmann::ordered_json writeFields(const FieldTable& table, const void* object,
                                   const std::string& file);

/// The members that name files: "file", "top/map".
std::vector<std::string> filesIn(const FieldTable& table);

/// The default value; null: none.
FieldValue usualValue(const FieldTable& table, const FieldRow& field);

/// Completes a table with the properties of the struct.
template <class T>
FieldTable fieldTable(FieldTable table) {
  static const T kUsual{};
  for ([[maybe_unused]] const FieldRow& field : table.fields)
    VOLUTE_ASSERT(field.access.owner == typeName<T>());
  table.usual = &kUsual;
  table.make = [] { return std::shared_ptr<void>(std::make_shared<T>()); };
  table.owner = typeName<T>();
  return table;
}

}  // namespace volute
