// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace volute {

/// A member of a type of nlohmann/json, in a header that need not include it. Copying copies the
/// value; it starts as an empty object.
template <class Value>
class KeptJson {
 public:
  KeptJson();
  KeptJson(Value value);
  KeptJson(const KeptJson& other);
  KeptJson(KeptJson&& other) noexcept;
  KeptJson& operator=(const KeptJson& other);
  KeptJson& operator=(KeptJson&& other) noexcept;
  ~KeptJson();

  const Value& operator*() const { return *value_; }

  Value& operator*() { return *value_; }

  const Value* operator->() const { return value_.get(); }

  Value* operator->() { return value_.get(); }

 private:
  std::unique_ptr<Value> value_;  // never null, but after a move
};

extern template class KeptJson<nlohmann::json>;
extern template class KeptJson<nlohmann::ordered_json>;

}  // namespace volute
