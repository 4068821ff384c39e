// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// The media that OpenGL draws by itself; once, whoever asks.
void registerUsualGlMedia();

}  // namespace volute
