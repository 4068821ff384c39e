// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

// OpenGL's objects, owned. They must be made and ended while their context is current.

namespace volute {

/// An object's name; `Destroy` ends it.
template <auto Destroy>
class GlObject {
 public:
  GlObject() = default;

  explicit GlObject(GLuint name) : name_(name) {}

  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}

  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }

  ~GlObject() {
    if (name_)
      Destroy(name_);
  }

  GLuint name() const { return name_; }

  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

namespace detail {
inline void destroyBuffer(GLuint name) {
  glDeleteBuffers(1, &name);
}

inline void destroyTexture(GLuint name) {
  glDeleteTextures(1, &name);
}

inline void destroyFramebuffer(GLuint name) {
  glDeleteFramebuffers(1, &name);
}

inline void destroyVertexArray(GLuint name) {
  glDeleteVertexArrays(1, &name);
}

inline void destroyQuery(GLuint name) {
  glDeleteQueries(1, &name);
}

inline void destroySampler(GLuint name) {
  glDeleteSamplers(1, &name);
}

inline void destroyShader(GLuint name) {
  glDeleteShader(name);
}

inline void destroyProgram(GLuint name) {
  glDeleteProgram(name);
}
}  // namespace detail

using GlBuffer = GlObject<detail::destroyBuffer>;
using GlTexture = GlObject<detail::destroyTexture>;
using GlFramebuffer = GlObject<detail::destroyFramebuffer>;
using GlVertexArray = GlObject<detail::destroyVertexArray>;
using GlQuery = GlObject<detail::destroyQuery>;

/// A buffer of these values; never empty, since a binding of nothing is an error.
template <class T>
GlBuffer makeBuffer(std::span<const T> values) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  constexpr GLsizeiptr kMin = 16;
  const auto bytes = static_cast<GLsizeiptr>(values.size_bytes());
  glNamedBufferStorage(name, bytes > kMin ? bytes : kMin, bytes > kMin ? values.data() : nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  if (bytes > 0 && bytes <= kMin)
    glNamedBufferSubData(name, 0, bytes, values.data());
  return GlBuffer(name);
}

template <class T>
GlBuffer makeBuffer(const std::vector<T>& values) {
  return makeBuffer(std::span<const T>(values));
}

/// One to be filled later.
inline GlBuffer makeEmptyBuffer(std::size_t bytes) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes > 16 ? bytes : 16), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  return GlBuffer(name);
}

inline GlVertexArray makeVertexArray() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  return GlVertexArray(name);
}

inline GlFramebuffer makeFramebuffer() {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  return GlFramebuffer(name);
}

/// A texture without mipmaps that is read texel by texel.
inline GlTexture makeTexture2d(GLenum format, int width, int height) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  glTextureStorage2D(name, 1, format, width, height);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return GlTexture(name);
}

inline GlTexture makeTexture3d(GLenum format, int width, int height, int depth) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_3D, 1, &name);
  glTextureStorage3D(name, 1, format, width, height, depth);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return GlTexture(name);
}

}  // namespace volute
