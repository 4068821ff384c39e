// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// All that is public. Headers that these include are installed with them, and may change without a
// word. Each can be included alone, which compiles faster.

#include "volute/base/version.hpp"

// A medium, rays through it, and pictures.
#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/image/srgb.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/medium/integrate.hpp"
#include "volute/medium/medium.hpp"
#include "volute/render/render.hpp"

// Volumes of voxels, and .volute files.
#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/array_source.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/volume_info.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/tree4d/tree4d.hpp"

// Fog, smoke on tetrahedra, results of the Fire Dynamics Simulator.
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_volume.hpp"
#include "volute/fog/fog_map.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

// Scenes, and kinds of media of one's own.
#include "volute/film/draw_picture.hpp"
#include "volute/media/field.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/scene/own_kind.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/scene/scene_snapshot.hpp"
#include "volute/volume_files/memory_volumes.hpp"

// From where signs are seen, and what people take in; fire from pictures, smoke from lines; made-up
// data.
#include "volute/synth/synth.hpp"
#include "volute/tenability/walking_speed.hpp"
#include "volute/tomography/line_reconstruction.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/sign_file.hpp"
#include "volute/visibility/survey.hpp"

// Files of others.
#include "volute/io/image_file.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/io/reader_helper.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/io/volume_source.hpp"
