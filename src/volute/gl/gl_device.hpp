// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// What draws, and how much of it there is.
struct GlDevice {
  std::string
      renderer;  ///< as the driver calls it: "NVIDIA ...", "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string vendor;
  std::string version;  ///< of OpenGL, with the driver's
  std::string shadingLanguage;
  bool hardware = false;                 ///< false for rasterisers that run on the CPU
  std::int64_t largestTexture = 0;       ///< [texels] a side, 2D
  std::int64_t largestTexture3d = 0;     ///< [texels] a side
  std::int64_t largestStorageBlock = 0;  ///< [bytes] of one shader storage buffer
  std::int64_t storageBindings = 0;      ///< shader storage buffers of a compute shader
  std::int64_t textureUnits = 0;         ///< of a compute shader
  std::int64_t groupInvocations = 0;     ///< of a compute work group
  std::int64_t sharedMemory = 0;         ///< [bytes] of a compute work group

  /// Software rasterisers end a shader's loops, without a word, after so many rounds of all of them
  /// together; no limit on hardware.
  double loopRounds() const;

  /// Of a picture of this width, so many that they fill the device and that a caller who may stop
  /// it between them has not long to wait.
  int rowsAtOnce(int width) const;

  /// The limits with the names that OpenGL gives them.
  std::vector<std::pair<std::string, std::int64_t>> limits() const;
};

/// True when this machine has a graphics device that a driver could drive; costs no more than a
/// look into /dev.
bool graphicsHardwarePresent();

/// A context of OpenGL 4.5 core without a window, by EGL: the first hardware device that has one,
/// else Mesa's software rasteriser. Ends with its owner; used by one thread at a time.
class HeadlessGl {
 public:
  enum class Wanted { kAny, kHardware };

  /// Makes the context and makes it current in this thread. kUnsupported, in one sentence that
  /// says what is missing, where there is none.
  [[nodiscard]] static Result<HeadlessGl> create(Wanted wanted = Wanted::kAny);

  HeadlessGl(HeadlessGl&& other) noexcept;
  HeadlessGl& operator=(HeadlessGl&&) = delete;
  ~HeadlessGl();

  const GlDevice& device() const { return device_; }

 private:
  HeadlessGl() = default;

  void* display_ = nullptr;
  void* context_ = nullptr;
  GlDevice device_;
};

/// Of the context that is current in this thread, whoever made it. kUnsupported when it is older
/// than OpenGL 4.5.
[[nodiscard]] Result<GlDevice> currentGlDevice();

/// kTooLarge, "a fog map of 17000 x 10 texels ...", where the current device's textures are
/// smaller.
/// @param depth  of a texture with three dimensions, else 0
[[nodiscard]] Status checkTextureSize(std::string_view what, std::int64_t width,
                                      std::int64_t height, std::int64_t depth = 0);

}  // namespace volute
