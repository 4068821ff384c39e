// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "volute/base/assert.hpp"

namespace volute {

/// A window on N-dimensional data that somebody else owns: a pointer, extents and strides (in
/// elements). The last axis is the fastest when it is made from a contiguous array. Stands in for
/// std::mdspan.
template <class T, std::size_t N>
class View {
 public:
  using Index = std::array<std::ptrdiff_t, N>;

  View() = default;

  View(T* data, const Index& extents, const Index& strides)
      : data_(data), extents_(extents), strides_(strides) {}

  /// A contiguous array in C order; `data` holds exactly the product of the extents.
  View(std::span<T> data, const Index& extents) : data_(data.data()), extents_(extents) {
    std::ptrdiff_t stride = 1;
    for (std::size_t axis = N; axis-- > 0;) {
      strides_[axis] = stride;
      stride *= extents[axis];
    }
    VOLUTE_ASSERT(static_cast<std::size_t>(stride) == data.size());
  }

  // A view of mutable data is a view of const data.
  operator View<const T, N>() const  // NOLINT(google-explicit-constructor)
    requires(!std::is_const_v<T>)
  {
    return {data_, extents_, strides_};
  }

  template <class... I>
  T& operator()(I... index) const {
    static_assert(sizeof...(I) == N);
    return (*this)[Index{static_cast<std::ptrdiff_t>(index)...}];
  }

  T& operator[](const Index& index) const {
    std::ptrdiff_t offset = 0;
    for (std::size_t axis = 0; axis < N; ++axis) {
      VOLUTE_ASSERT(index[axis] >= 0 && index[axis] < extents_[axis]);
      offset += index[axis] * strides_[axis];
    }
    return data_[offset];
  }

  T* data() const { return data_; }

  const Index& extents() const { return extents_; }

  const Index& strides() const { return strides_; }

  std::ptrdiff_t extent(std::size_t axis) const { return extents_[axis]; }

  std::ptrdiff_t stride(std::size_t axis) const { return strides_[axis]; }

  std::size_t size() const {
    std::size_t product = 1;
    for (auto extent : extents_) product *= static_cast<std::size_t>(extent);
    return product;
  }

  /// The part that begins at `origin` and has `extents`; shares the data.
  View sub(const Index& origin, const Index& extents) const {
    std::ptrdiff_t offset = 0;
    for (std::size_t axis = 0; axis < N; ++axis) {
      VOLUTE_ASSERT(origin[axis] >= 0 && extents[axis] >= 0 &&
                    origin[axis] + extents[axis] <= extents_[axis]);
      offset += origin[axis] * strides_[axis];
    }
    return {data_ + offset, extents, strides_};
  }

 private:
  T* data_ = nullptr;
  Index extents_{};
  Index strides_{};
};

}  // namespace volute
