// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <mutex>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// While a function of the caller's runs in this thread: a callback of C, a function of Python.
class CallersFunction {
 public:
  CallersFunction() { ++depth_; }

  ~CallersFunction() { --depth_; }

  CallersFunction(const CallersFunction&) = delete;
  CallersFunction& operator=(const CallersFunction&) = delete;

  static bool runs() { return depth_ > 0; }

 private:
  static inline thread_local int depth_ = 0;
};

/// Locks what calls wait for. kInvalidArgument where a function of the caller's asks for what is in
/// use: it may be the call that waits for this function, and both would wait for ever.
/// @param what  "the scene"
[[nodiscard]] inline Result<std::unique_lock<std::mutex>> waitFor(std::mutex& mutex,
                                                                  std::string_view what) {
  if (!CallersFunction::runs())
    return std::unique_lock(mutex);
  std::unique_lock lock(mutex, std::try_to_lock);
  if (lock.owns_lock())
    return lock;
  return fail(ErrorCode::kInvalidArgument,
              "{} is in use by a call that waits for this function; use another one in it", what);
}

}  // namespace volute
