// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// A part of a shader: what its lines are called in messages, and the lines.
struct ShaderPart {
  std::string file;  ///< "volume.glsl"
  std::string text;
};

/// A driver's message about a stage, with "volume.glsl:12" where it numbers lines of the whole.
std::string namedShaderLog(std::string_view log, std::span<const ShaderPart> parts);

/// One shader of a program: the parts follow each other after #version 450.
struct ShaderStage {
  GLenum kind = GL_COMPUTE_SHADER;
  std::vector<ShaderPart> parts;
};

/// A linked program and its uniforms. Uniforms that a program does not use are set to no effect.
class GlProgram {
 public:
  /// kInvalidData with the driver's message, and the file and line that it is about.
  [[nodiscard]] static Result<GlProgram> link(std::span<const ShaderStage> stages);

  void use() const { glUseProgram(object_.name()); }

  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, const std::array<int, 2>& value) const;
  void set(const char* name, const std::array<int, 3>& value) const;
  void set(const char* name, const std::array<int, 4>& value) const;
  void set(const char* name, const std::array<float, 2>& value) const;
  void set(const char* name, const std::array<float, 4>& value) const;
  void set(const char* name, const Vec3& value) const;
  void set(const char* name, const Mat3& value) const;

  /// Arrays.
  void set(const char* name, std::span<const std::array<int, 4>> values) const;
  void set(const char* name, std::span<const std::array<float, 2>> values) const;
  void set(const char* name, std::span<const std::array<float, 4>> values) const;

  /// In double.
  void setExactly(const char* name, const Vec3& value) const;
  void setExactly(const char* name, const Vec2& value) const;

  /// Gives the storage block of that name the buffer, at a binding of its own.
  void bindStorage(const char* block, int binding, const GlBuffer& buffer) const;

 private:
  using Object = GlObject<detail::destroyProgram>;

  explicit GlProgram(Object object) : object_(std::move(object)) {}

  GLint place(const char* name) const { return glGetUniformLocation(object_.name(), name); }

  Object object_;
};

}  // namespace volute
