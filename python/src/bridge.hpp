// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "volute/base/advice.hpp"
#include "volute/base/callers_function.hpp"
#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/grid/array_source.hpp"

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

/// A setting as an argument: renderer="cpu".
inline std::string argumentText(const std::string& setting, const std::string& value) {
  return value.empty() ? setting : fmt::format("{}=\"{}\"", setting, value);
}

/// A text that may have a file's name in it, whose bytes need not be UTF-8.
inline py::object pathText(const std::string& text) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
}

inline void translateFailures() {
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown)
        std::rethrow_exception(thrown);
    } catch (const Failure& failure) {
      const Error& error = failure.error;
      const py::object type = py::module_::import("volute._errors").attr(nameOf(error.code));
      const std::string hint = adviceText(error.hints, argumentText);
      const auto text = [](const std::string& said) {
        return said.empty() ? py::object(py::none()) : pathText(said);
      };
      const py::object made = type(pathText(fullText(error, argumentText)));
      made.attr("code") = std::string(errorName(error.code));
      made.attr("path") = text(error.path);
      made.attr("member") = text(error.member);
      made.attr("hint") = text(hint);
      PyErr_SetObject(type.ptr(), made.ptr());
    }
  });
}

/// What volute._progress.Listener takes of a remark. With the interpreter's lock.
inline void tell(const py::object& listener, const Remark& remark) {
  py::list hints;
  for (const Hint& hint : remark.hints) hints.append(pathText(adviceText({hint}, argumentText)));
  listener.attr("remark")(pathText(fullText(remark, argumentText)),
                          std::string(remarkName(remark.code)), pathText(remark.file),
                          pathText(remark.place), hints);
}

/// The interpreter's lock for something of the caller's.
class PythonFunction {
  py::gil_scoped_acquire lock_;
  CallersFunction running_;
};

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
    guarded([&] { listener_.attr("report")(pathText(std::string(stage)), done, total); });
  }

  void remark(const Remark& remark) override {
    if (!listener_.is_none())
      guarded([&] { tell(listener_, remark); });
  }

  bool cancelled() const override {
    auto& self = const_cast<PythonProgress&>(*this);
    if (!stopped_ && std::this_thread::get_id() == thread_ && self.due(self.asked_)) {
      self.guarded([] {
        if (PyErr_CheckSignals() != 0)
          throw py::error_already_set();
      });
    }
    return stopped_.has_value() || endsWithInterpreter();
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
  static bool endsWithInterpreter();

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
    const PythonFunction running;
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

/// Calls that work without the interpreter's lock. A thread that asks for the lock when the
/// interpreter has ended is ended where it stands, and with it the program: at the end, calls of
/// other threads (daemons) are stopped and waited for, and these threads never go on.
class CallInProgress {
 public:
  /// With the interpreter's lock.
  CallInProgress() {
    if (ending_ && std::this_thread::get_id() == ender_)
      throw Failure{Error{ErrorCode::kCancelled, "the interpreter ends"}};
    if (ending_) {
      const py::gil_scoped_release release;
      rest();
    }
    ++count_;
  }

  ~CallInProgress() { --count_; }

  CallInProgress(const CallInProgress&) = delete;
  CallInProgress& operator=(const CallInProgress&) = delete;

  static bool stops() { return ending_; }

  /// Without the lock, when the call is done.
  void restAtTheEnd() {
    if (!ending_)
      return;
    --count_;
    rest();
  }

  /// Has the interpreter stop all calls when it ends.
  static void watchEnd() {
    py::module_::import("atexit").attr("register")(py::cpp_function(endAll));
    const py::module_ os = py::module_::import("os");
    if (py::hasattr(os, "register_at_fork"))
      os.attr("register_at_fork")(py::arg("after_in_child") = py::cpp_function([] { count_ = 0; }));
  }

 private:
  static void endAll() {
    ender_ = std::this_thread::get_id();
    ending_ = true;
    const py::gil_scoped_release release;
    while (count_ > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  [[noreturn]] static void rest() {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }

  static inline std::atomic<int> count_ = 0;
  static inline std::atomic<bool> ending_ = false;
  static inline std::thread::id ender_;
};

inline bool PythonProgress::endsWithInterpreter() {
  return CallInProgress::stops();
}

/// call() without the interpreter's lock.
template <class Call>
auto unlocked(Call&& call) {
  CallInProgress here;
  const py::gil_scoped_release release;
  auto result = call();
  here.restAtTheEnd();
  return result;
}

/// call(progress), which returns a Result, without the interpreter's lock.
template <class Call>
auto run(PythonProgress& progress, Call&& call) {
  auto result = unlocked([&] { return call(progress); });
  progress.rethrow();
  return take(std::move(result));
}

template <class Call>
auto run(const py::object& listener, Call&& call) {
  PythonProgress progress(listener);
  return run(progress, std::forward<Call>(call));
}

/// An array that owns what `values` held.
template <class T>
py::array_t<T> owned(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept,
                          [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

/// An object that C++ keeps: whoever lets go of it last may not have the interpreter's lock.
inline std::shared_ptr<const py::object> keptObject(py::object object) {
  return {new py::object(std::move(object)), [](const py::object* kept) {
            const py::gil_scoped_acquire lock;
            delete kept;
          }};
}

/// An array of NumPy's as it lies in memory, without a copy. Its shape must be (t, z, y, x, c).
inline NumberArray numbersOf(const py::array& array) {
  const auto code = array.dtype().attr("str").cast<std::string>();
  const auto type = numberTypeOf(code);
  if (!type)
    throw py::type_error(fmt::format("values of type {}; expected real numbers", code));
  if (array.ndim() != 5)
    throw py::value_error(fmt::format("{} axes; expected (t, z, y, x, c)", array.ndim()));
  NumberArray numbers{static_cast<const std::byte*>(array.data()), *type};
  for (int axis = 0; axis < 5; ++axis)
    numbers.strides[static_cast<std::size_t>(axis)] = array.strides(axis);
  numbers.owner = keptObject(array);
  return numbers;
}

using Shape = std::array<int, 5>;
using Bounds = std::array<std::array<double, 3>, 2>;

inline Box3 boxOf(const Bounds& bounds) {
  return {Vec3(bounds[0][0], bounds[0][1], bounds[0][2]),
          Vec3(bounds[1][0], bounds[1][1], bounds[1][2])};
}

/// Sets what Python's own part says of a sequence of volumes, in a dict.
inline void restate(VolumeInfo& info, const py::dict& said) {
  const auto given = [&](const char* key) { return said.contains(key) && !said[key].is_none(); };
  if (given("name") && py::len(said["name"]) > 0)
    info.name = said["name"].cast<std::string>();
  if (given("unit"))
    info.unit = said["unit"].cast<std::string>();
  if (given("basis"))
    info.basis = basisNamed(said["basis"].cast<std::string>()).value_or(Basis::kBox);
  if (const std::string up = given("up") ? said["up"].cast<std::string>() : std::string();
      up.size() == 1)
    info.up = up[0];
  if (given("times"))
    info.times = said["times"].cast<std::vector<double>>();
  if (given("frame_numbers")) {
    info.frameNumbers = said["frame_numbers"].cast<std::vector<int>>();
    info.frameScale.decimals = given("decimals") ? said["decimals"].cast<int>() : 0;
  }
  info.fillDefaults();
  if (given("bounds"))
    info.bounds = boxOf(said["bounds"].cast<Bounds>());
}

/// Of such a dict.
inline VolumeInfo infoOf(const Shape& shape, const py::dict& said) {
  VolumeInfo info;
  std::tie(info.frames, info.z, info.y, info.x, info.channels) = std::tuple_cat(shape);
  restate(info, said);
  return info;
}

}  // namespace volute::python
