// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Kinds of media whose entries are objects of Python, behind the functions of volute/medium.h. What
// these objects raise goes through all that looks through them, and ends the call as itself.

#include "volute/scene/own_kind.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bridge.hpp"
#include "volute/medium.h"
#include "volute/medium/conformance_checks.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene.hpp"

namespace volute::python {
namespace {

template <class T>
using Dense = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// (name, help, unit, defaults, minimum, maximum)
using MemberSaid =
    std::tuple<std::string, std::string, std::string, std::vector<double>, double, double>;

/// Stays until the program ends, as the class does.
struct PythonKind {
  std::string name, sentence, ending;
  std::vector<MemberSaid> said;
  py::object type;
  std::vector<volute_medium_member> members{};
};

const py::object& objectOf(void* medium) {
  return *static_cast<const py::object*>(medium);
}

/// A method's name for messages: "Ball.pieces()".
std::string methodOf(const py::object& object, const char* method) {
  return fmt::format("{}.{}()", py::type::of(object).attr("__name__").cast<std::string>(), method);
}

/// Numbers of a shape that a method returned.
Dense<double> numbersFrom(const py::object& object, const char* method, const py::object& returned,
                          const std::vector<py::ssize_t>& shape) {
  const auto array = Dense<double>::ensure(returned);
  if (!array)
    throw py::error_already_set();
  if (!std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim())) {
    const auto text = [](auto begin, auto end) {
      return fmt::format("({}{})", fmt::join(begin, end, ", "), end - begin == 1 ? "," : "");
    };
    throw py::value_error(fmt::format("{} returned shape {}; expected {}", methodOf(object, method),
                                      text(array.shape(), array.shape() + array.ndim()),
                                      text(shape.begin(), shape.end())));
  }
  return array;
}

const char* openObject(void* user, const double* values, const char* file, void** medium) {
  const auto& kind = *static_cast<const PythonKind*>(user);
  const PythonFunction running;
  py::dict members;
  for (const auto& [name, help, unit, usual, low, high] : kind.said) {
    if (usual.size() == 1)
      members[name.c_str()] = *values;
    else
      members[name.c_str()] = py::array_t<double>(static_cast<py::ssize_t>(usual.size()), values);
    values += usual.size();
  }
  if (!kind.ending.empty())
    members["file"] = file ? py::object(py::str(file)) : py::object(py::none());
  *medium = new py::object(kind.type(**members));
  return nullptr;
}

void closeObject(void* medium) {
  const PythonFunction running;
  delete static_cast<py::object*>(medium);
}

const char* boundsOfObject(void* medium, double bounds[6]) {
  const PythonFunction running;
  const py::object& object = objectOf(medium);
  const auto found = numbersFrom(object, "bounds", object.attr("bounds")(), {2, 3});
  std::copy_n(found.data(), 6, bounds);
  return nullptr;
}

std::size_t timesOfObject(void* medium, double* times, std::size_t room) {
  const PythonFunction running;
  const py::object& object = objectOf(medium);
  const py::object said = py::getattr(object, "times", py::none());
  if (said.is_none()) {
    if (room > 0)
      times[0] = 0;
    return 1;
  }
  const auto found = said.cast<std::vector<double>>();
  std::copy_n(found.data(), std::min(room, found.size()), times);
  return found.size();
}

py::array_t<volute_segment> arrayOfSegments(const volute_segment* segments, std::size_t count) {
  return py::array_t<volute_segment>(static_cast<py::ssize_t>(count), segments);
}

const char* piecesOfObject(void* medium, double time, const volute_segment* segments,
                           std::size_t count, volute_pieces_function give, void* to) {
  const PythonFunction running;
  const py::object& object = objectOf(medium);
  const py::object returned = object.attr("pieces")(arrayOfSegments(segments, count), time);
  if (!py::isinstance<py::array>(returned) ||
      !py::array(returned).dtype().equal(py::dtype::of<volute_piece>())) {
    throw py::type_error(methodOf(object, "pieces") +
                         ": expected an array of the type volute.PIECE, as volute.pieces() makes");
  }
  const auto pieces = Dense<volute_piece>::ensure(returned);
  give(to, pieces.data(), static_cast<std::size_t>(pieces.size()));
  return nullptr;
}

const char* depthsOfObject(void* medium, double time, const volute_segment* segments,
                           std::size_t count, double* depths) {
  const PythonFunction running;
  const py::object& object = objectOf(medium);
  const auto found = numbersFrom(
      object, "optical_depth", object.attr("optical_depth")(arrayOfSegments(segments, count), time),
      {static_cast<py::ssize_t>(count)});
  std::copy_n(found.data(), count, depths);
  return nullptr;
}

const char* valuesOfObject(void* medium, double time, const double* points, std::size_t count,
                           double* extinction, double* emission) {
  const PythonFunction running;
  const py::object& object = objectOf(medium);
  const auto n = static_cast<py::ssize_t>(count);
  py::object returned =
      object.attr("values")(py::array_t<double>(std::vector<py::ssize_t>{n, 3}, points), time);
  std::fill_n(emission, 3 * count, 0.0);
  if (py::isinstance<py::tuple>(returned) && py::len(returned) == 2) {
    const auto light = numbersFrom(object, "values", returned[py::int_(1)], {n, 3});
    std::copy_n(light.data(), 3 * count, emission);
    returned = returned[py::int_(0)];
  }
  const auto found = numbersFrom(object, "values", returned, {n});
  std::copy_n(found.data(), count, extinction);
  return nullptr;
}

void registerKind(const std::string& name, const std::string& sentence, const std::string& ending,
                  const std::vector<MemberSaid>& members, const py::object& type) {
  auto* kept = new PythonKind{name, sentence, ending, members, type};
  for (const auto& [member, help, unit, usual, low, high] : kept->said) {
    kept->members.push_back({member.c_str(), help.c_str(), unit.c_str(),
                             static_cast<std::int32_t>(usual.size()), usual.data(), low, high});
  }
  volute_medium_kind kind{};
  kind.size = sizeof kind;
  kind.name = kept->name.c_str();
  kind.sentence = kept->sentence.c_str();
  kind.members = kept->members.data();
  kind.member_count = kept->members.size();
  kind.ending = ending.empty() ? nullptr : kept->ending.c_str();
  kind.user = kept;
  kind.open = openObject;
  kind.close = closeObject;
  kind.bounds = boundsOfObject;
  kind.times = timesOfObject;
  kind.pieces = piecesOfObject;
  kind.optical_depth = py::hasattr(type, "optical_depth") ? depthsOfObject : nullptr;
  kind.values = py::hasattr(type, "values") ? valuesOfObject : nullptr;
  registerUsualMedia();
  take(registerOwnKind(kind));
}

/// What the conformance suite finds wrong.
std::vector<std::string> checkMedium(const std::string& json, const std::string& file, double time,
                                     const py::object& listener) {
  return run(listener, [&](Progress& progress) -> Result<std::vector<std::string>> {
    const SceneOptions options;
    VOLUTE_ASSIGN(auto scene,
                  Scene::make(nlohmann::ordered_json::parse(json), file, options, progress));
    VOLUTE_ASSIGN(const auto snapshot, scene.at({.time = time, .lit = false}, progress));
    std::vector<std::string> found;
    std::vector<AnyMedium> media;
    for (const auto& medium : snapshot.media) medium->addMedia(media);
    for (const AnyMedium& medium : media) {
      const auto tested = conformance::underTest(medium);
      const auto checks = conformance::checks();
      for (std::size_t i = 0; i < checks.size(); ++i) {
        progress.report("checking", static_cast<double>(i), static_cast<double>(checks.size()));
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped");
        if (checks[i].linearOnly)
          continue;
        for (const std::string& fault : checks[i].run(tested))
          found.push_back(fmt::format("{}: {}", checks[i].name, fault));
      }
    }
    return found;
  });
}

}  // namespace

void addOwnKinds(py::module_& m) {
  using namespace py::literals;
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown)
        std::rethrow_exception(thrown);
    } catch (const OwnMediumFault& fault) {
      const py::object type = py::module_::import("volute._errors").attr("InvalidData");
      PyErr_SetString(type.ptr(), fault.what());
    }
  });
  PYBIND11_NUMPY_DTYPE(volute_segment, origin, direction, begin, end);
  PYBIND11_NUMPY_DTYPE(volute_piece, segment, begin, end, extinction, emission, decay);
  m.attr("SEGMENT") = py::dtype::of<volute_segment>();
  m.attr("PIECE") = py::dtype::of<volute_piece>();
  m.def("register_kind", &registerKind, "name"_a, "sentence"_a, "ending"_a, "members"_a, "type"_a);
  m.def("check_medium", &checkMedium, "json"_a, "file"_a, "time"_a, "listener"_a);
}

}  // namespace volute::python
