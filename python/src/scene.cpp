// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// volute._scene: scenes and pictures; the module.

#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

#include "scene_bridge.hpp"
#include "volute/film/render_request.hpp"
#include "volute/film/write_film.hpp"
#ifdef VOLUTE_WITH_GL
#include "volute/gl/gl_scene_renderer.hpp"
#endif
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/volume_files/volume_resampling.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::python {
namespace {

/// What it raises goes through all that reads it, and ends the call.
ValueFunction valuesOf(const py::object& function) {
  return [kept = keptObject(function)](const PlacesAtTime& at, std::span<float> values) -> Status {
    const PythonFunction running;
    const auto numbers = [](std::span<const double> from) {
      return py::array_t<double>(static_cast<py::ssize_t>(from.size()), from.data());
    };
    const py::array_t<float, py::array::c_style | py::array::forcecast> found =
        kept->attr("_values")(numbers(at.x), numbers(at.y), numbers(at.z), at.time);
    std::copy_n(found.data(), values.size(), values.data());
    return {};
  };
}

/// What volute.Mesh has checked.
MemoryMesh meshOf(const py::object& mesh) {
  const auto numbersIn = [](const auto& array) {
    return std::vector(array.data(), array.data() + array.size());
  };
  const auto [points, corners, offsets, shapes] =
      mesh.attr("_cells")
          .cast<std::tuple<py::array_t<double>, py::array_t<std::int64_t>,
                           py::array_t<std::int64_t>, py::array_t<std::uint8_t>>>();
  MemoryMesh made;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    const double* at = points.data(i, 0);
    made.cells.vertices.emplace_back(at[0], at[1], at[2]);
  }
  made.cells.connectivity = numbersIn(corners);
  made.cells.offsets = numbersIn(offsets);
  for (const std::uint8_t shape : numbersIn(shapes))
    made.cells.shapes.push_back(static_cast<CellShape>(shape));
  made.ghosts = mesh.attr("_ghosts").cast<std::uint64_t>();
  made.times = mesh.attr("times").cast<std::vector<double>>();
  using Fields = std::vector<std::tuple<std::string, bool, py::array_t<float>>>;
  for (const auto& [name, ofCells, values] : mesh.attr("_fields").cast<Fields>()) {
    MemoryMesh::Field& field = made.fields.emplace_back();
    field.name = name, field.ofCells = ofCells;
    for (py::ssize_t time = 0; time < values.shape(0); ++time)
      field.values.emplace_back(values.data(time), values.data(time) + values.shape(1));
  }
  return made;
}

}  // namespace

void addVolumes(MemoryVolumes& to, const Volumes& volumes) {
  for (const auto& [name, values, shape, said] : volumes) {
    take(!shape || !said ? to.add(name, meshOf(values))
         : py::isinstance<py::array>(values)
             ? to.add(name, infoOf(*shape, *said), numbersOf(values))
             : to.add(name, infoOf(*shape, *said), valuesOf(values)));
  }
}

namespace {

py::array_t<float> arrayOf(Image&& image) {
  std::vector<py::ssize_t> shape{image.height, image.width};
  if (image.channels != 1)
    shape.push_back(image.channels);
  return owned(std::move(image.pixels), std::move(shape));
}

Image imageOf(const py::array_t<float, py::array::c_style | py::array::forcecast>& array) {
  const bool colour = array.ndim() == 3 && array.shape(2) == 3;
  if (!colour && array.ndim() != 2)
    throw py::value_error("a picture has shape (height, width) or (height, width, 3)");
  Image image(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), colour ? 3 : 1);
  std::copy_n(array.data(), image.pixels.size(), image.pixels.data());
  return image;
}

/// What Python's own part asks of a picture.
RenderRequest requestOf(const py::dict& said) {
  RenderRequest request;
  const auto given = [&](const char* key) { return said.contains(key) && !said[key].is_none(); };
  if (given("target"))
    request.frames.target = said["target"].cast<std::string>();
  if (given("time"))
    request.frames.time = said["time"].cast<double>();
  if (given("frames"))
    request.frames.frames = frameRangeOf(said["frames"]);
  if (given("speed"))
    request.frames.speed = said["speed"].cast<double>();
  if (given("orbit"))
    request.frames.orbit = said["orbit"].cast<double>();
  if (given("camera"))
    request.camera = take(parseCamera(jsonOf(said["camera"].cast<std::string>()), {"camera"}));
  if (given("size")) {
    const auto size = said["size"].cast<std::array<int, 2>>();
    constexpr int kLargest = 32768;
    if (std::ranges::any_of(size, [](int side) { return side < 1 || side > kLargest; })) {
      throw Failure{Error{ErrorCode::kInvalidArgument,
                          fmt::format("size: {} x {} pixels; expected 1 to {} on each side",
                                      size[0], size[1], kLargest)}};
    }
    request.size = Pixels{size[0], size[1]};
  }
  if (given("background")) {
    const auto light = said["background"].cast<std::array<double, 3>>();
    request.background = Rgb(light[0], light[1], light[2]);
  }
  const auto choice = [&](const char* key) {
    return given(key) ? said[key].cast<std::string>() : std::string();
  };
  const std::string aov = choice("aov"), tone = choice("tone"), colors = choice("colormap");
  request.aov = aov == "optical-depth"   ? Aov::kOpticalDepth
                : aov == "transmittance" ? Aov::kTransmittance
                                         : Aov::kNone;
  if (!tone.empty()) {
    if (const Status taken = takeTone(tone, request); !taken)
      throw Failure{taken.error()};
  }
  if (!colors.empty())
    request.colors = colors == "viridis" ? ColorMap::kViridis : ColorMap::kInferno;
  if (given("measured"))
    request.measured = said["measured"].cast<bool>();
  if (given("exposure"))
    request.exposure = said["exposure"].cast<double>();
  if (given("bloom"))
    request.bloom = said["bloom"].cast<double>();
  if (given("shutter"))
    request.shutter = said["shutter"].cast<double>();
  if (given("samples"))
    request.samples = said["samples"].cast<int>();
  if (given("legend"))
    request.legend = said["legend"].cast<bool>();
  return request;
}

/// A scene that is open. Calls from several threads wait for each other.
class PythonScene {
 public:
  PythonScene(Scene scene, std::shared_ptr<MemoryVolumes> volumes, std::uint64_t maxMemory)
      : job_{std::move(scene), Camera::framing({}, 1, 1), {}, std::make_unique<CpuRenderer>()},
        volumes_(std::move(volumes)),
        maxMemory_(maxMemory) {}

  /// Names of files that are no UTF-8 have U+FFFD in place of what is not.
  std::string json() const {
    return job_.scene.json().dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  }

  py::object path() const { return pathText(job_.scene.path()); }

  py::tuple bounds() const { return boundsTuple(job_.scene.bounds()); }

  std::vector<double> times() const { return job_.scene.times(); }

  std::vector<std::tuple<std::string, py::object, std::string>> media() const {
    std::vector<std::tuple<std::string, py::object, std::string>> result;
    for (const auto& medium : job_.scene.media()) {
      const MediumInfo& info = medium->info();
      result.emplace_back(info.what, pathText(info.file), info.size);
    }
    return result;
  }

  void change(const std::string& json, const Volumes& volumes, const py::object& listener) {
    MemoryVolumes more;
    addVolumes(more, volumes);
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      volumes_->add(more);
      return job_.scene.change(jsonOf(json), progress);
    });
  }

  /// Lets go of volumes in memory but those of these names.
  void keep(const std::vector<std::string>& names) {
    run(py::none(), [&](Progress&) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      volumes_->keep(names);
      return {};
    });
  }

  /// Light, as a .exr has it.
  py::array_t<float> render(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    return arrayOf(run(listener, [&](Progress& progress) -> Result<Image> {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Result<Image> {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(const auto development, developmentOf(request, job_));
        return linearPicture(job_, development, progress);
      });
    }));
  }

  /// Bytes, as a .png has them.
  py::array_t<std::uint8_t> picture(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    const Image image = run(listener, [&](Progress& progress) -> Result<Image> {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Result<Image> {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(auto development, developmentOf(request, job_));
        return visiblePicture(job_, development, progress);
      });
    });
    std::vector<py::ssize_t> shape{image.height, image.width};
    if (image.channels != 1)
      shape.push_back(image.channels);
    return owned(toSrgb8(image), std::move(shape));
  }

  void film(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Status {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(auto development, developmentOf(request, job_));
        Team alone;
        return writeFilm(job_, request.frames.target, development, maxMemory_, progress, alone);
      });
    });
  }

 private:
  /// draw() with a renderer for it alone: a context of OpenGL belongs to its thread.
  template <class Draw>
  std::invoke_result_t<Draw> drawnBy(const std::string& name, Draw&& draw) {
    VOLUTE_ASSIGN(auto renderer, rendererNamed(name));
    std::swap(job_.renderer, renderer);
    auto drawn = draw();
    std::swap(job_.renderer, renderer);
    return drawn;
  }

  static Result<std::unique_ptr<SceneRenderer>> rendererNamed(const std::string& name) {
    if (name != "gl") {
      return std::make_unique<CpuRenderer>(name == "reference" ? Renderer::kReference
                                                               : Renderer::kCpu);
    }
#ifdef VOLUTE_WITH_GL
    return createGlRenderer(false);
#else
    return fail(ErrorCode::kUnsupported, "this build has no OpenGL");
#endif
  }

  FilmJob job_;
  std::shared_ptr<MemoryVolumes> volumes_;  // that job_.scene finds by name
  std::uint64_t maxMemory_;
  std::mutex mutex_;
};

/// `volute resample`.
void resampleFile(const std::string& path, const std::string& target, const py::dict& said,
                  std::uint64_t maxMemory, const py::object& listener) {
  ResampleRequest request;
  const auto given = [&](const char* key) { return !said[key].is_none(); };
  request.fields = said["grids"].cast<std::string>();
  request.partial = said["partial"].cast<bool>();
  request.like = said["like"].cast<std::string>();
  request.rms = said["rms"].cast<double>();
  request.basis = *basisNamed(said["basis"].cast<std::string>());
  if (given("frames"))
    request.frames = frameRangeOf(said["frames"]);
  if (given("voxel_size")) {
    const auto size = said["voxel_size"].cast<std::array<double, 3>>();
    request.voxelSize = Vec3(size[0], size[1], size[2]);
  }
  if (given("bounds")) {
    const auto b = said["bounds"].cast<std::array<std::array<double, 3>, 2>>();
    request.bounds = Box3{Vec3(b[0][0], b[0][1], b[0][2]), Vec3(b[1][0], b[1][1], b[1][2])};
  }
  if (given("matrix"))
    request.matrix = said["matrix"].cast<GridMatrix>();
  run(listener, [&](Progress& progress) -> Status {
    Reading reading{progress, maxMemory};
    Team alone;
    auto done = resampleVolume(path, target, request, reading, alone);
    if (!done)
      return tl::unexpected<Error>(renamed(std::move(done.error()), "field", "grids"));
    return {};
  });
}

}  // namespace
}  // namespace volute::python

PYBIND11_MODULE(_scene, m) {
  using namespace volute::python;
  using namespace volute;
  using namespace py::literals;
  translateFailures();
  CallInProgress::watchEnd();
  m.doc() = "What of Volute shows and looks through scenes; use the package `volute`.";
  py::class_<PythonScene>(m, "Scene")
      .def_static(
          "open",
          [](const std::string& path, const std::string& members, const Volumes& volumes,
             bool measured, bool depth, std::uint64_t maxMemory, const py::object& listener) {
            const auto own = std::make_shared<MemoryVolumes>();
            addVolumes(*own, volumes);
            Scene scene = run(listener, [&](Progress& progress) {
              SceneOptions options = sceneOptions(members, maxMemory);
              options.files.volumes = own;
              addUsualMembers(path, {.measured = measured, .depth = depth}, options);
              return Scene::open(path, options, progress);
            });
            return std::make_unique<PythonScene>(std::move(scene), own, maxMemory);
          },
          "path"_a, "members"_a, "volumes"_a, "measured"_a, "depth"_a, "max_memory"_a, "listener"_a)
      .def_static(
          "make",
          [](const std::string& json, const std::string& file, const Volumes& volumes,
             bool measured, bool depth, std::uint64_t maxMemory, const py::object& listener) {
            const auto own = std::make_shared<MemoryVolumes>();
            addVolumes(*own, volumes);
            Scene scene = run(listener, [&](Progress& progress) {
              SceneOptions options = sceneOptions("{}", maxMemory);
              options.files.volumes = own;
              options.files.measured = measured;
              options.files.depths = depth;
              return Scene::make(jsonOf(json), file, options, progress);
            });
            return std::make_unique<PythonScene>(std::move(scene), own, maxMemory);
          },
          "json"_a, "file"_a, "volumes"_a, "measured"_a, "depth"_a, "max_memory"_a, "listener"_a)
      .def_property_readonly("json", &PythonScene::json)
      .def_property_readonly("path", &PythonScene::path)
      .def_property_readonly("bounds", &PythonScene::bounds)
      .def_property_readonly("times", &PythonScene::times)
      .def_property_readonly("media", &PythonScene::media)
      .def("change", &PythonScene::change, "json"_a, "volumes"_a, "listener"_a)
      .def("keep", &PythonScene::keep, "names"_a)
      .def("render", &PythonScene::render, "said"_a, "listener"_a)
      .def("picture", &PythonScene::picture, "said"_a, "listener"_a)
      .def("film", &PythonScene::film, "said"_a, "listener"_a);

  m.def("resample", &resampleFile, "path"_a, "target"_a, "said"_a, "max_memory"_a, "listener"_a);

  addSights(m);
  addOwnKinds(m);
  addReconstruction(m);
  m.def(
      "read_image",
      [](const std::filesystem::path& path) {
        return arrayOf(run(py::none(), [&](Progress&) { return readImage(path); }));
      },
      "path"_a);
  m.def(
      "write_image",
      [](const std::filesystem::path& path,
         const py::array_t<float, py::array::c_style | py::array::forcecast>& array) {
        const Image image = imageOf(array);
        run(py::none(), [&](Progress&) { return writeImage(path, image); });
      },
      "path"_a, "image"_a);
}
