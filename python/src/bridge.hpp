// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"

// What both extension modules need: errors become exceptions, long calls run without the
// interpreter's lock, report to Python, and stop at Ctrl-C.

namespace volute::python {

namespace py = pybind11;

/// An Error on its way to Python.
struct Failure {
  Error error;
};

/// Names as in volute._errors.
inline const char* nameOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return "InvalidArgument";
    case ErrorCode::kNotFound:
      return "NotFound";
    case ErrorCode::kInvalidData:
      return "InvalidData";
    case ErrorCode::kTruncated:
      return "Truncated";
    case ErrorCode::kUnsupported:
      return "Unsupported";
    case ErrorCode::kTooLarge:
      return "TooLarge";
    case ErrorCode::kIo:
      return "IoError";
    case ErrorCode::kCancelled:
      return "Cancelled";
  }
  return "Error";
}

inline void translateFailures() {
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown)
        std::rethrow_exception(thrown);
    } catch (const Failure& failure) {
      const py::object type =
          py::module_::import("volute._errors").attr(nameOf(failure.error.code));
      PyErr_SetString(type.ptr(), failure.error.message.c_str());
    }
  });
}

template <class T>
T take(Result<T> result) {
  if (!result)
    throw Failure{std::move(result.error())};
  if constexpr (!std::is_void_v<T>)
    return std::move(*result);
}

/// Hands what happens to volute._progress.Listener, a few times a second, and asks there whether a
/// signal came. Its methods take the interpreter's lock themselves.
class PythonProgress final : public Progress {
 public:
  /// @param listener  None, or with the methods report(stage, done, total) and remark(text)
  explicit PythonProgress(py::object listener) : listener_(std::move(listener)) {}

  void report(std::string_view stage, double done, double total) override {
    if (listener_.is_none() || (done < total && !due(reported_)))
      return;
    guarded([&] { listener_.attr("report")(py::str(stage.data(), stage.size()), done, total); });
  }

  void remark(std::string_view message) override {
    if (!listener_.is_none())
      guarded([&] { listener_.attr("remark")(py::str(message.data(), message.size())); });
  }

  bool cancelled() const override {
    auto& self = const_cast<PythonProgress&>(*this);
    if (!stopped_ && std::this_thread::get_id() == thread_ && self.due(self.asked_)) {
      self.guarded([] {
        if (PyErr_CheckSignals() != 0)
          throw py::error_already_set();
      });
    }
    return stopped_.has_value();
  }

  /// The library is to stop, and Python to see this exception. With the interpreter's lock.
  void stop(py::error_already_set&& why) {
    if (!stopped_)
      stopped_.emplace(std::move(why));
  }

  /// Throws what stopped it. With the interpreter's lock.
  void rethrow() {
    if (stopped_)
      throw py::error_already_set(std::move(*stopped_));
  }

 private:
  using Clock = std::chrono::steady_clock;

  static bool due(Clock::time_point& last) {
    constexpr auto kBetween = std::chrono::milliseconds(50);
    const auto now = Clock::now();
    if (now - last < kBetween)
      return false;
    last = now;
    return true;
  }

  template <class Call>
  void guarded(Call&& call) {
    const py::gil_scoped_acquire lock;
    if (stopped_)
      return;
    try {
      call();
    } catch (py::error_already_set& thrown) {
      stop(std::move(thrown));
    }
  }

  py::object listener_;
  std::thread::id thread_ = std::this_thread::get_id();
  Clock::time_point reported_, asked_;
  std::optional<py::error_already_set> stopped_;
};

/// call(progress), which returns a Result, without the interpreter's lock.
template <class Call>
auto run(const py::object& listener, Call&& call) {
  PythonProgress progress(listener);
  auto result = [&] {
    const py::gil_scoped_release release;
    return call(progress);
  }();
  progress.rethrow();
  return take(std::move(result));
}

/// An array that owns what `values` held.
template <class T>
py::array_t<T> owned(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept,
                          [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

}  // namespace volute::python
