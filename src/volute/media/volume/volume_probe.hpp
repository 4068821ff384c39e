// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/media/field_probe.hpp"

namespace volute {

class VolumeMedium;

/// The values of all grids of a volume's files, where and when it is shown.
std::unique_ptr<FieldProbe> volumeProbe(const VolumeMedium& volume);

}  // namespace volute
