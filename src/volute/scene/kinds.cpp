// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/kinds.hpp"

#include "volute/media/fds/fds_medium.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/media/volume/volume_medium.hpp"
#include "volute/scene/own_kind.hpp"

namespace volute {

void registerUsualMedia() {
  static const bool once = [] {
    registerMedium(fdsKind());
    registerMedium(smokeKind());
    registerMedium(fogKind());
    registerMedium(volumeKind());  // takes every file that no other does
    registerMedium(billboardKind());
    registerPluginKinds();
    return true;
  }();
  (void)once;
}

}  // namespace volute
