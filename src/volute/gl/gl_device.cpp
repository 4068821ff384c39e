// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_device.hpp"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>

namespace volute {
namespace {

std::string text(GLenum name) {
  const auto* value = reinterpret_cast<const char*>(glGetString(name));
  return value ? value : "";
}

std::int64_t limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return value;
}

bool isSoftware(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software"}) {
    if (renderer.find(name) != std::string::npos)
      return true;
  }
  return false;
}

/// libepoxy ends the program when a library is missing, so they are looked for first.
Status findLibraries() {
  for (const char* name : {"libEGL.so.1", "libGL.so.1"}) {
    if (void* library = ::dlopen(name, RTLD_LAZY | RTLD_LOCAL)) {
      ::dlclose(library);
      continue;
    }
    return fail(
        ErrorCode::kUnsupported, Hint::set("renderer", "cpu").so("does without"),
        "there is no OpenGL here: {} is missing; install libegl1, libgl1 and libgl1-mesa-dri "
        "or the graphics card's driver",
        name);
  }
  return {};
}

bool hasClientExtension(const char* name) {
  return epoxy_has_egl_extension(EGL_NO_DISPLAY, name);
}

/// Displays to try, hardware before software.
std::vector<EGLDisplay> displays(HeadlessGl::Wanted wanted) {
  std::vector<EGLDisplay> hardware, software;
  if (hasClientExtension("EGL_EXT_device_enumeration") &&
      hasClientExtension("EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 32> devices{};
    EGLint count = 0;
    eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
    for (EGLint i = 0; i < count; ++i) {
      const char* found = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
      const bool slow = found && std::string_view(found).find("EGL_MESA_device_software") !=
                                     std::string_view::npos;
      (slow ? software : hardware)
          .push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
    }
  }
  if (wanted == HeadlessGl::Wanted::kHardware)
    return hardware;
  if (hasClientExtension("EGL_MESA_platform_surfaceless")) {
    hardware.push_back(
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  hardware.insert(hardware.end(), software.begin(), software.end());
  return hardware;
}

/// EGL has one state for each display, whoever asked for it: it ends with the last of its users.
void countUsers(EGLDisplay display, int change) {
  static std::mutex mutex;
  static std::map<EGLDisplay, int> users;
  const std::scoped_lock lock(mutex);
  users[display] += change;
  if (users[display] <= 0)
    eglTerminate(display);
}

constexpr EGLint kWanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                              4,
                              EGL_CONTEXT_MINOR_VERSION,
                              5,
                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                              EGL_NONE};
constexpr EGLint kAnyVersion[] = {EGL_NONE};

/// A context that is current, or EGL_NO_CONTEXT where the display has no such version.
EGLContext contextOn(EGLDisplay display, const EGLint* version) {
  if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API))
    return EGL_NO_CONTEXT;
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config = EGL_NO_CONFIG_KHR;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count) || count == 0)
    config = EGL_NO_CONFIG_KHR;
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
  if (context == EGL_NO_CONTEXT)
    return EGL_NO_CONTEXT;
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    return context;
  eglDestroyContext(display, context);
  return EGL_NO_CONTEXT;
}

Error tooOld(const std::string& version, const std::string& renderer) {
  return fail(ErrorCode::kUnsupported, Hint::set("renderer", "cpu").so("does without"),
              "OpenGL 4.5 is needed, and {} has {}; update the graphics driver",
              renderer.empty() ? "this driver" : renderer, version)
      .value();
}

/// What an old driver has, where there is one.
std::optional<Error> olderThanWanted(EGLDisplay display) {
  const EGLContext context = contextOn(display, kAnyVersion);
  if (context == EGL_NO_CONTEXT)
    return std::nullopt;
  const Error error = tooOld(text(GL_VERSION), text(GL_RENDERER));
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context);
  return error;
}

}  // namespace

std::vector<std::pair<std::string, std::int64_t>> GlDevice::limits() const {
  return {{"max_texture_size", largestTexture},
          {"max_3d_texture_size", largestTexture3d},
          {"max_shader_storage_block_size", largestStorageBlock},
          {"max_compute_shader_storage_blocks", storageBindings},
          {"max_compute_texture_image_units", textureUnits},
          {"max_compute_work_group_invocations", groupInvocations},
          {"max_compute_shared_memory_size", sharedMemory}};
}

double GlDevice::loopRounds() const {
  constexpr double kSoftwareRounds = 65535;  // llvmpipe's LP_MAX_TGSI_LOOP_ITERATIONS
  return hardware ? std::numeric_limits<double>::infinity() : kSoftwareRounds;
}

int GlDevice::rowsAtOnce(int width) const {
  constexpr int kMin = 64, kPixels = 1 << 18;  // as many threads as a large card has
  return hardware ? std::max(kMin, kPixels / std::max(width, 1) / 8 * 8) : kMin;
}

bool graphicsHardwarePresent() {
  std::error_code ignored;
  for (const char* node : {"/dev/nvidia0", "/dev/dxg"}) {
    if (std::filesystem::exists(node, ignored))
      return true;
  }
  for (const auto& entry : std::filesystem::directory_iterator("/dev/dri", ignored)) {
    if (entry.path().filename().string().starts_with("renderD"))
      return true;
  }
  return false;
}

Result<GlDevice> currentGlDevice() {
  if (epoxy_gl_version() < 45 || !epoxy_is_desktop_gl())
    return tl::unexpected(tooOld(text(GL_VERSION), text(GL_RENDERER)));
  GlDevice device;
  device.renderer = text(GL_RENDERER);
  device.vendor = text(GL_VENDOR);
  device.version = text(GL_VERSION);
  device.shadingLanguage = text(GL_SHADING_LANGUAGE_VERSION);
  device.hardware = !isSoftware(device.renderer);
  device.largestTexture = limit(GL_MAX_TEXTURE_SIZE);
  device.largestTexture3d = limit(GL_MAX_3D_TEXTURE_SIZE);
  device.largestStorageBlock = limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE);
  device.storageBindings = limit(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
  device.textureUnits = limit(GL_MAX_COMPUTE_TEXTURE_IMAGE_UNITS);
  device.groupInvocations = limit(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);
  device.sharedMemory = limit(GL_MAX_COMPUTE_SHARED_MEMORY_SIZE);
  return device;
}

Status checkTextureSize(std::string_view what, std::int64_t width, std::int64_t height,
                        std::int64_t depth) {
  const std::int64_t most = limit(depth ? GL_MAX_3D_TEXTURE_SIZE : GL_MAX_TEXTURE_SIZE);
  if (std::max({width, height, depth}) <= most)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
              "{} of {} x {}{} texels is larger than the {} a side that the graphics device has",
              what, width, height, depth ? fmt::format(" x {}", depth) : "", most);
}

Result<HeadlessGl> HeadlessGl::create(Wanted wanted) {
  VOLUTE_TRY(findLibraries());
  ::setenv("EGL_LOG_LEVEL", "fatal", 0);  // what drivers say of displays that do not matter
  std::optional<Error> refused;
  for (const EGLDisplay display : displays(wanted)) {
    if (display == EGL_NO_DISPLAY)
      continue;
    countUsers(display, 1);
    const EGLContext context = contextOn(display, kWanted);
    if (context == EGL_NO_CONTEXT) {
      if (!refused)
        refused = olderThanWanted(display);
      countUsers(display, -1);
      continue;
    }
    HeadlessGl gl;
    gl.display_ = display;
    gl.context_ = context;
    auto device = currentGlDevice();
    if (!device) {
      refused = device.error();
      continue;
    }
    gl.device_ = std::move(*device);
    if (wanted == Wanted::kAny || gl.device_.hardware)
      return gl;
  }
  if (refused)
    return tl::unexpected(std::move(*refused));
  if (wanted == Wanted::kHardware)
    return fail(ErrorCode::kUnsupported,
                "no graphics hardware here has OpenGL 4.5 without a display");
  return fail(
      ErrorCode::kUnsupported, Hint::set("renderer", "cpu").so("does without"),
      "no driver here has OpenGL without a display; install libgl1-mesa-dri or the graphics card's "
      "driver");
}

HeadlessGl::HeadlessGl(HeadlessGl&& other) noexcept
    : display_(std::exchange(other.display_, nullptr)),
      context_(std::exchange(other.context_, nullptr)),
      device_(std::move(other.device_)) {}

HeadlessGl::~HeadlessGl() {
  if (!context_)
    return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  countUsers(display_, -1);
}

}  // namespace volute
