// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_passes.hpp"

#include <algorithm>

namespace volute {

GlQuery GlPasses::stamp() {
  GLuint name = 0;
  glCreateQueries(GL_TIMESTAMP, 1, &name);
  glQueryCounter(name, GL_TIMESTAMP);
  return GlQuery(name);
}

void GlPasses::collect() {
  for (const Pair& pair : open_) {
    GLuint64 begin = 0, end = 0;
    glGetQueryObjectui64v(pair.begin.name(), GL_QUERY_RESULT, &begin);
    glGetQueryObjectui64v(pair.end.name(), GL_QUERY_RESULT, &end);
    auto found = std::ranges::find_if(times_, [&](const GlPassTime& time) {
      return time.name == pair.name && time.media == pair.media;
    });
    if (found == times_.end())
      found = times_.insert(times_.end(), GlPassTime{pair.name, pair.media});
    ++found->times;
    found->milliseconds += 1e-6 * static_cast<double>(end - begin);
  }
  open_.clear();
}

}  // namespace volute
