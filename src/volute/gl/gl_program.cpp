// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_program.hpp"

#include <algorithm>
#include <regex>

namespace volute {
namespace {

using Shader = GlObject<detail::destroyShader>;

constexpr const char* kVersion = "#version 450 core\n";

std::string joined(const ShaderStage& stage) {
  std::string source = kVersion;
  for (const ShaderPart& part : stage.parts) source += part.text + '\n';
  return source;
}

/// "volume.glsl:12" for a line of the whole; empty where there is none.
std::string placeOf(unsigned long line, std::span<const ShaderPart> parts) {
  unsigned long first = 2;  // after the version's
  for (const ShaderPart& part : parts) {
    const auto lines = static_cast<unsigned long>(1 + std::ranges::count(part.text, '\n'));
    if (line >= first && line < first + lines)
      return fmt::format("{}:{}", part.file, line - first + 1);
    first += lines;
  }
  return {};
}

std::string trimmed(std::string log, GLint length) {
  log.resize(static_cast<std::size_t>(length > 0 ? length : 0));
  while (!log.empty() && (log.back() == '\n' || log.back() == '\0')) log.pop_back();
  return log;
}

constexpr GLsizei kLongestLog = 1 << 14;

std::string shaderLog(GLuint name) {
  std::string log(kLongestLog, '\0');
  GLint length = 0;
  glGetShaderInfoLog(name, kLongestLog, &length, log.data());
  return trimmed(std::move(log), length);
}

std::string programLog(GLuint name) {
  std::string log(kLongestLog, '\0');
  GLint length = 0;
  glGetProgramInfoLog(name, kLongestLog, &length, log.data());
  return trimmed(std::move(log), length);
}

Result<Shader> compiled(const ShaderStage& stage) {
  Shader shader(glCreateShader(stage.kind));
  const std::string source = joined(stage);
  const char* text = source.c_str();
  glShaderSource(shader.name(), 1, &text, nullptr);
  glCompileShader(shader.name());
  GLint good = 0;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &good);
  if (good)
    return shader;
  return fail(ErrorCode::kInvalidData, "the driver refuses a shader: {}",
              namedShaderLog(shaderLog(shader.name()), stage.parts));
}

}  // namespace

std::string namedShaderLog(std::string_view log, std::span<const ShaderPart> parts) {
  // Mesa and AMD: "0:12(5): error"; NVIDIA: "0(12) : error"; Intel: "ERROR: 0:12:". Lines are those
  // of the whole, since Mesa forgets the number of the source that #line can give.
  static const std::regex kPlace(R"((^|\n|ERROR: )\d+[:(](\d{1,8})\)?)");
  std::string named;
  const std::string text(log);
  auto rest = text.cbegin();
  for (std::sregex_iterator it(text.begin(), text.end(), kPlace), end; it != end; ++it) {
    const std::string place = placeOf(std::stoul(it->str(2)), parts);
    named.append(rest, it->prefix().second);
    named += place.empty() ? it->str(0) : it->str(1) + place;
    rest = it->suffix().first;
  }
  return named.append(rest, text.cend());
}

Result<GlProgram> GlProgram::link(std::span<const ShaderStage> stages) {
  Object program(glCreateProgram());
  std::vector<Shader> shaders;
  for (const ShaderStage& stage : stages) {
    VOLUTE_ASSIGN(auto shader, compiled(stage));
    glAttachShader(program.name(), shader.name());
    shaders.push_back(std::move(shader));
  }
  glLinkProgram(program.name());
  for (const Shader& shader : shaders) glDetachShader(program.name(), shader.name());
  GLint good = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &good);
  if (!good) {
    return fail(ErrorCode::kInvalidData, "the driver cannot link a program: {}",
                namedShaderLog(programLog(program.name()), stages.front().parts));
  }
  return GlProgram(std::move(program));
}

void GlProgram::set(const char* name, int value) const {
  glProgramUniform1i(object_.name(), place(name), value);
}

void GlProgram::set(const char* name, float value) const {
  glProgramUniform1f(object_.name(), place(name), value);
}

void GlProgram::set(const char* name, const std::array<int, 2>& value) const {
  glProgramUniform2i(object_.name(), place(name), value[0], value[1]);
}

void GlProgram::set(const char* name, const std::array<int, 3>& value) const {
  glProgramUniform3i(object_.name(), place(name), value[0], value[1], value[2]);
}

void GlProgram::set(const char* name, const std::array<int, 4>& value) const {
  glProgramUniform4i(object_.name(), place(name), value[0], value[1], value[2], value[3]);
}

void GlProgram::setExactly(const char* name, const Vec3& value) const {
  glProgramUniform3dv(object_.name(), place(name), 1, value.data());
}

void GlProgram::setExactly(const char* name, const Vec2& value) const {
  glProgramUniform2dv(object_.name(), place(name), 1, value.data());
}

void GlProgram::bindStorage(const char* block, int binding, const GlBuffer& buffer) const {
  const GLuint index = glGetProgramResourceIndex(object_.name(), GL_SHADER_STORAGE_BLOCK, block);
  if (index == GL_INVALID_INDEX)
    return;
  glShaderStorageBlockBinding(object_.name(), index, static_cast<GLuint>(binding));
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(binding), buffer.name());
}

void GlProgram::set(const char* name, const std::array<float, 2>& value) const {
  glProgramUniform2f(object_.name(), place(name), value[0], value[1]);
}

void GlProgram::set(const char* name, const std::array<float, 4>& value) const {
  glProgramUniform4fv(object_.name(), place(name), 1, value.data());
}

void GlProgram::set(const char* name, const Vec3& value) const {
  glProgramUniform3f(object_.name(), place(name), static_cast<float>(value.x()),
                     static_cast<float>(value.y()), static_cast<float>(value.z()));
}

void GlProgram::set(const char* name, const Mat3& value) const {
  const MatN<float, 3, 3> columns = value.cast<float>();
  glProgramUniformMatrix3fv(object_.name(), place(name), 1, GL_FALSE, columns.data());
}

void GlProgram::set(const char* name, std::span<const std::array<int, 4>> values) const {
  glProgramUniform4iv(object_.name(), place(name), static_cast<GLsizei>(values.size()),
                      values.front().data());
}

void GlProgram::set(const char* name, std::span<const std::array<float, 2>> values) const {
  glProgramUniform2fv(object_.name(), place(name), static_cast<GLsizei>(values.size()),
                      values.front().data());
}

void GlProgram::set(const char* name, std::span<const std::array<float, 4>> values) const {
  glProgramUniform4fv(object_.name(), place(name), static_cast<GLsizei>(values.size()),
                      values.front().data());
}

}  // namespace volute
