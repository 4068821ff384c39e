// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The lanes of all kernels of tetrahedra, for each SIMD target.
#if defined(VOLUTE_TETMESH_TET_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_TETMESH_TET_LANES_INL
#undef VOLUTE_TETMESH_TET_LANES_INL
#else
#define VOLUTE_TETMESH_TET_LANES_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using Mask = hn::Mask<DF>;
constexpr DF df;
constexpr DI di;
constexpr std::size_t kWidest = 16;

HWY_INLINE VF Constant(float x) {
  return hn::Set(df, x);
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();
#endif
