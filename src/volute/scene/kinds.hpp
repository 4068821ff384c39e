// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// The media that Volute has by itself; once, whoever asks.
void registerUsualMedia();

}  // namespace volute
