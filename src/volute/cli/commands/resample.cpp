// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/file_name.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/values.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/volume_files/volume_resampling.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::cli {
namespace {

Result<Vec3> voxelSizeOf(std::string_view text) {
  VOLUTE_ASSIGN(const auto numbers, parseNumbers(text));
  if ((numbers.size() != 1 && numbers.size() != 3) || std::ranges::min(numbers) <= 0) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is no size of voxels; expected one number or X,Y,Z above 0, in metres", text);
  }
  return numbers.size() == 1 ? Vec3(Vec3::Constant(numbers[0]))
                             : Vec3(numbers[0], numbers[1], numbers[2]);
}

/// Three rows of four numbers, and perhaps 0,0,0,1.
Result<GridMatrix> matrixOf(std::string_view text) {
  VOLUTE_ASSIGN(const auto numbers, parseNumbers(text));
  const bool whole = numbers.size() == 16 && numbers[12] == 0 && numbers[13] == 0 &&
                     numbers[14] == 0 && numbers[15] == 1;
  if (numbers.size() != 12 && !whole) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' has {} numbers; expected three rows of four, and 0,0,0,1 after them or not",
                text, numbers.size());
  }
  GridMatrix matrix;
  std::copy_n(numbers.begin(), matrix.size(), matrix.begin());
  return matrix;
}

Status runResample(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkTarget(target, context));
  ResampleRequest request;
  request.fields = arguments.find<std::string>("field").value_or("");
  request.frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  request.stated.framesPerSecond = arguments.find<double>("fps");
  request.bounds = arguments.find<Box3>("bounds");
  request.like = arguments.find<std::string>("like").value_or("");
  request.basis = *basisNamed(arguments.get<std::string>("basis"));
  request.rms = arguments.get<double>("rms");
  if (const auto text = arguments.find<std::string>("voxel-size")) {
    VOLUTE_ASSIGN(request.voxelSize, ofOption("voxel-size", voxelSizeOf(*text)));
  }
  if (const auto text = arguments.find<std::string>("matrix")) {
    VOLUTE_ASSIGN(request.matrix, ofOption("matrix", matrixOf(*text)));
  }
  if (arguments.given("rms") && !isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--rms: is the error of a .volute, and '{}' is none; leave it out", target);
  }
  if (request.stated.framesPerSecond && !statesTimes(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--fps: '{}' does not say when its frames are shown; leave it out", target);
  }
  if (!request.like.empty() && request.bounds) {
    return fail(ErrorCode::kInvalidArgument,
                "--bounds: the voxels of {} have bounds of their own; leave out one of them",
                request.like);
  }
  VOLUTE_ASSIGN(const auto report,
                resampleVolume(arguments.positional(0), target, request, context, context.team));
  context.print(report);
  return {};
}

}  // namespace

Command resampleCommand() {
  using enum ValueKind;
  return {
      .name = "resample",
      .summary = "Writes a volume on other voxels: of another size, along other axes, in a box",
      .examples = {"volute resample cache_%04d.vdb -o coarse_%04d.vdb --voxel-size 0.2",
                   "volute resample frustum.vdb -o box.vdb --voxel-size 0.05",
                   "volute resample turned.vti -o straight.npy --bounds=-1,-1,0,1,1,4",
                   "volute resample fire.volute -o fitted.volute --like smoke_0001.vdb"},
      .description =
          "Reads every kind of voxel file: .vdb, .nvdb, .volute, .npy, .npz, .vti, .pvd, .nc, .h5 "
          "and .zarr. All "
          "grids "
          "that "
          "hold volumes are resampled, each on voxels of its own unless --matrix or --like states "
          "them. Voxels that are turned, sheared, mirrored or moving come to lie along the axes, "
          "in one box around all frames; so do the voxels of a frustum, which widen with the "
          "distance from a camera.\n\nA new voxel gets the value of the basis at its centre. Where "
          "it is longer than the old ones, it is cut along each axis into as many parts as it is "
          "long in old voxels, at most 16, and gets the mean over the centres of the parts, so "
          "that "
          "the sum over a volume stays what it was. It is active where an active voxel counts in "
          "its value; what is empty stays empty. Distances of level sets stay metres. Vectors are "
          "vectors of the world and keep their direction; those that OpenVDB calls local are "
          "turned as their type says. Where all new voxels are old ones, values are copied.",
      .positionals = {{.name = "IN", .help = "a volume: a file, a pattern or a folder"}},
      .options = {outputOption(
                      "OUT",
                      ".volute, .npy, a pattern %04d.vdb, %04d.nvdb or %04d.vti with the frame's "
                      "number, .pvd, .nc, .h5, or - for a .npy on standard output; with {grid} a "
                      "file for each grid"),
                  fieldsOption("grids of a file with several; if not given, all"),
                  framesOption(),
                  {.name = "voxel-size",
                   .kind = kText,
                   .value = "S | X,Y,Z",
                   .help = "size of the new voxels [m]; if not given, that of the old ones, of a "
                           "frustum the smallest side of a voxel in its middle"},
                  {.name = "bounds",
                   .kind = kBounds,
                   .value = "X0,Y0,Z0,X1,Y1,Z1",
                   .help = "box of the new voxels [m], made larger at its upper end to hold whole "
                           "ones; if not given, what the volume takes in any frame"},
                  {.name = "matrix",
                   .kind = kText,
                   .value = "M11,M12,...,M34",
                   .help = "from the index of a new voxel to the place of its centre in the world "
                           "[m], three rows of four numbers"},
                  {.name = "like",
                   .kind = kFile,
                   .value = "FILE",
                   .help = "a volume whose first frame's voxels are the new ones"},
                  {.name = "basis",
                   .kind = kChoice,
                   .value = "BASIS",
                   .help = "how old voxels are interpolated: box takes the nearest one, trilinear "
                           "goes from centre to centre, cubic smooths by B-splines",
                   .initial = "trilinear",
                   .choices = {"box", "trilinear", "cubic"}},
                  filesRateOption(),
                  rmsOption("relative RMS error of a .volute", "0.001")},
      .oneOf = {{{"voxel-size", "matrix", "like"}}},
      .run = runResample};
}

}  // namespace volute::cli
