// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "volute/image/pixels.hpp"
#include "volute/math/vec.hpp"
#include "volute/media/field.hpp"

// Connects the rows of a table with the members of a struct.

namespace volute {

namespace fields {

template <class Owner, class Member>
Owner ownerOf(Member Owner::*);

template <auto first, auto... rest>
struct Path {
  using Owner = decltype(ownerOf(first));

  static auto& of(auto& owner) {
    if constexpr (sizeof...(rest) == 0)
      return owner.*first;
    else
      return Path<rest...>::of(owner.*first);
  }
};

template <auto first, auto second, auto... rest>
struct PairPath {
  using Owner = decltype(ownerOf(first));

  static auto of(auto& owner) {
    if constexpr (sizeof...(rest) == 0)
      return std::tie(owner.*first, owner.*second);
    else
      return PairPath<second, rest...>::of(owner.*first);
  }
};

template <class T>
FieldValue valueOf(const FieldRow& field, const T& value) {
  if constexpr (std::is_enum_v<T> || std::is_integral_v<T>) {
    if (field.type == FieldType::kChoice)
      return std::string(field.choices[static_cast<std::size_t>(value)]);
  }
  if constexpr (std::is_enum_v<T>)
    return {};
  else
    return value;
}

inline FieldValue valueOf(const FieldRow&, const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

inline FieldValue valueOf(const FieldRow&, const Rgb& c) {
  return {c[0], c[1], c[2]};
}

inline FieldValue valueOf(const FieldRow&, const Pixels& size) {
  return {size.width, size.height};
}

template <class T>
FieldValue valueOf(const FieldRow& field, const std::optional<T>& value) {
  return value ? valueOf(field, *value) : FieldValue();
}

template <class T>
void take(const FieldRow& field, const FieldValue& value, T& out) {
  if constexpr (std::is_enum_v<T> || std::is_integral_v<T>) {
    if (field.type == FieldType::kChoice) {
      std::size_t place = 0;
      while (field.choices[place] != value.get_ref<const std::string&>()) ++place;
      out = static_cast<T>(place);
      return;
    }
  }
  if constexpr (!std::is_enum_v<T>)
    out = value.get<T>();
}

inline void take(const FieldRow&, const FieldValue& value, Vec3& out) {
  out = Vec3::Zero();
  for (std::size_t i = 0; i < value.size(); ++i) out[static_cast<int>(i)] = value[i].get<double>();
}

inline void take(const FieldRow&, const FieldValue& value, Rgb& out) {
  out = {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

inline void take(const FieldRow&, const FieldValue& value, Pixels& out) {
  out = {value[0].get<int>(), value[1].get<int>()};
}

inline void take(const FieldRow&, const FieldValue& value, std::vector<std::string>& out) {
  out = value.is_string() ? std::vector{value.get<std::string>()}
                          : value.get<std::vector<std::string>>();
}

template <class T>
void take(const FieldRow& field, const FieldValue& value, std::optional<T>& out) {
  take(field, value, out.emplace());
}

}  // namespace fields

/// member<&FogDescription::placement, &FogPlacement::cell>(): a member of a member. Enumerations,
/// flags and integers are indices into the row's choices if it is a kChoice.
template <auto... path>
FieldAccess member() {
  using Path = fields::Path<path...>;
  using Owner = typename Path::Owner;
  return {.owner = typeName<Owner>(),
          .get =
              [](const FieldRow& field, const void* object) {
                return fields::valueOf(field, Path::of(*static_cast<const Owner*>(object)));
              },
          .set = [](const FieldRow& field, void* object, const FieldValue& value) -> Status {
            fields::take(field, value, Path::of(*static_cast<Owner*>(object)));
            return {};
          }};
}

/// Two numbers; the last two of `path` are members of the same struct.
template <auto... path>
FieldAccess memberPair() {
  using Pair = fields::PairPath<path...>;
  using Owner = typename Pair::Owner;
  return {.owner = typeName<Owner>(),
          .get = [](const FieldRow&, const void* object) -> FieldValue {
            const auto& [a, b] = Pair::of(*static_cast<const Owner*>(object));
            return {a, b};
          },
          .set = [](const FieldRow&, void* object, const FieldValue& value) -> Status {
            auto [a, b] = Pair::of(*static_cast<Owner*>(object));
            a = value[0].get<double>(), b = value[1].get<double>();
            return {};
          }};
}

/// Access to a member of type kObject.
template <auto... path>
FieldAccess part() {
  using Path = fields::Path<path...>;
  using Owner = typename Path::Owner;
  return {.owner = typeName<Owner>(),
          .make = [](void* object) -> void* { return &Path::of(*static_cast<Owner*>(object)); },
          .find = [](const void* object) -> const void* {
            return &Path::of(*static_cast<const Owner*>(object));
          }};
}

/// Access to an optional member of type kObject.
template <auto... path>
FieldAccess optionalPart() {
  using Path = fields::Path<path...>;
  using Owner = typename Path::Owner;
  return {.owner = typeName<Owner>(),
          .make = [](void* object) -> void* {
            auto& found = Path::of(*static_cast<Owner*>(object));
            return found ? &*found : &found.emplace();
          },
          .find = [](const void* object) -> const void* {
            const auto& found = Path::of(*static_cast<const Owner*>(object));
            return found ? &*found : nullptr;
          }};
}

/// get(const Owner&) gives a FieldValue, set(Owner&, const FieldValue&) a Status.
template <class Owner, auto getter, auto setter>
FieldAccess customMember() {
  return {.owner = typeName<Owner>(),
          .get = [](const FieldRow&, const void* object) -> FieldValue {
            return getter(*static_cast<const Owner*>(object));
          },
          .set = [](const FieldRow&, void* object, const FieldValue& value) -> Status {
            return setter(*static_cast<Owner*>(object), value);
          }};
}

}  // namespace volute
