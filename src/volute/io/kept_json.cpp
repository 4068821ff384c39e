// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/kept_json.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace volute {

template <class Value>
KeptJson<Value>::KeptJson() : KeptJson(Value::object()) {}

template <class Value>
KeptJson<Value>::KeptJson(Value value) : value_(std::make_unique<Value>(std::move(value))) {}

template <class Value>
KeptJson<Value>::KeptJson(const KeptJson& other) : KeptJson(*other) {}

template <class Value>
KeptJson<Value>::KeptJson(KeptJson&& other) noexcept = default;

template <class Value>
KeptJson<Value>& KeptJson<Value>::operator=(const KeptJson& other) {
  *this = KeptJson(other);
  return *this;
}

template <class Value>
KeptJson<Value>& KeptJson<Value>::operator=(KeptJson&& other) noexcept = default;

template <class Value>
KeptJson<Value>::~KeptJson() = default;

template class KeptJson<nlohmann::json>;
template class KeptJson<nlohmann::ordered_json>;

}  // namespace volute
