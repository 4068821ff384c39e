// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance.hpp"

#include "volute/medium/conformance/dummy_media.hpp"

namespace volute {

VOLUTE_CONFORMANCE(TrilinearVoxels, conformance::trilinearVoxelsUnderTest());
VOLUTE_CONFORMANCE(Atmosphere, conformance::atmosphereUnderTest());
VOLUTE_CONFORMANCE(TwoBoxes, conformance::twoBoxesUnderTest());

}  // namespace volute
