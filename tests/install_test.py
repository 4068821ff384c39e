# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Installs what is built into a folder, and builds projects outside of the tree against it: install_test.py SOURCE BUILD."""
import configparser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest
import xml.etree.ElementTree

SOURCE, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
del sys.argv[1:]
# The same folder each time, so that ccache knows what is compiled there.
FOLDER = BUILD / "install_test"
PREFIX = FOLDER / "prefix"
sys.path.insert(0, str(SOURCE / "tools"))
import fds_case  # noqa: E402

UMBRELLA = """
#include <cstdio>

#include <volute/volute.hpp>

int main() {
  volute::CpuRenderer renderer;
  std::puts(VOLUTE_VERSION);
  std::puts(volute::VoluteReader::open("nothing.volute").error().message.c_str());
}
"""


# The picture of a file, and of its values in memory.
PICTURE = """
#include <cstdio>
#include <memory>

#include <volute/volute.hpp>

volute::Status draw(const char* file, const char* png, const char* fromMemory) {
  volute::Progress quiet;
  volute::PictureOptions request;
  request.size = {64, 48}, request.time = 0.4;
  VOLUTE_ASSIGN(const auto picture, volute::drawPicture(file, request, {}, quiet));
  VOLUTE_TRY(volute::writeImage(png, picture));
  VOLUTE_ASSIGN(const auto source, volute::openSource(file, {}));
  VOLUTE_ASSIGN(const auto values, volute::readAll(*source, 1 << 30));
  auto volumes = std::make_shared<volute::MemoryVolumes>();
  const volute::NumberType floats;
  VOLUTE_TRY(volumes->add("mine", values.info, volute::NumberArray{reinterpret_cast<const std::byte*>(values.values.data()), floats,
                                                                   volute::denseStrides(values.info, floats)}));
  volute::SceneOptions options;
  options.files.volumes = volumes;
  VOLUTE_ASSIGN(const auto same, volute::drawPicture("memory:mine", request, options, quiet));
  VOLUTE_TRY(volute::writeImage(fromMemory, same));
  request.size = {0, 48};
  std::puts(volute::drawPicture(file, request, {}, quiet).error().message.c_str());
  return {};
}

int main(int, char** argv) {
  const volute::ReaderHelper helper;
  const auto done = draw(argv[1], argv[2], argv[3]);
  if (!done) std::puts(done.error().message.c_str());
  return done ? 0 : 1;
}
"""

# What a program sees of types that hold vectors, and what the library has written into them; vectors from and to Eigen.
LAYOUT = """
#include <cstdio>

#include <nlohmann/json.hpp>
#include <volute/math/eigen.hpp>
#include <volute/volute.hpp>

int main() {
  const Eigen::Vector3d far = 2 * Eigen::Vector3d::Ones() - Eigen::Vector3d::Constant(1);
  const auto camera = volute::Camera::framing({volute::Vec3::Zero(), far}, 64, 48);
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  if (volute::asEigen(volute::Mat3(turn)) != turn || (volute::Mat3(turn) * volute::Vec3(1, 0, 0)).y() != 1) return 1;
  std::printf("%zu %zu %zu %zu: %g %g\\n", sizeof(volute::Camera), sizeof(volute::SceneGeometry), alignof(volute::SceneGeometry),
              sizeof(volute::SightField), camera.principalPoint().x(), camera.principalPoint().y());
  const char* json = R"({"format": "volute-scene-1", "geometry": [{"file": "a.obj", "transform": [1,0,0,2, 0,1,0,3, 0,0,1,4, 0,0,0,1]}],
                         "media": [], "camera": {"eye": [0, -5, 1], "target": [0, 0, 1], "fov": 40}})";
  volute::Progress quiet;
  double sum = 0;
  for (int i = 0; i < 50; ++i) {  // on a heap whose blocks are not aligned to 32 bytes
    const auto scene = volute::Scene::make(nlohmann::ordered_json::parse(json, nullptr, false), "scene.json", {}, quiet);
    if (!scene) return std::puts(scene.error().message.c_str());
    for (const auto& geometry : scene->description().geometry) sum += geometry.transform.sum();
  }
  std::printf("%g\\n", sum);
}
"""


def run(*command, **more):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **({"cwd": FOLDER} | more))


def install(component, **environment):
    return run("cmake", "--install", BUILD, "--prefix", PREFIX, "--component", component, env=os.environ | environment)


def configure(source, build, *options):
    faster = []
    if shutil.which("ccache"):
        faster.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if shutil.which("mold"):
        faster.append("-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold -Wl,-z,separate-code")
    return run("cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={PREFIX}",
               *faster, *options)


def project(name, text, **files):
    """A folder with a project whose only language is C++."""
    folder = FOLDER / name
    folder.mkdir()
    (folder / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.25)\nproject({name} LANGUAGES CXX)\n{text}\n")
    (folder / "main.cpp").write_text(files.get("main", ""))
    return folder


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir()
        plugins = [path.stem[len("volute_io_"):] for path in (BUILD / "lib/volute").glob("volute_io_*.so") if "hostile" not in path.name]
        for component in ["headers", "command", "c", "core", "shared", "shared-dev", *plugins]:
            result = install(component)
            assert result.returncode == 0, result.stdout
        # Archives with debug information take 575 MB.
        result = install("library", CMAKE_INSTALL_MODE="ABS_SYMLINK")
        assert result.returncode == 0, result.stdout
        cls.examples = FOLDER / "examples"
        for result in [configure(SOURCE / "examples", cls.examples), run("cmake", "--build", cls.examples, "-j", "2")]:
            assert result.returncode == 0, result.stdout
        cls.work = FOLDER / "work"
        cls.work.mkdir()

    def works(self, *command, **more):
        result = run(*command, **({"cwd": self.work} | more))
        self.assertEqual(result.returncode, 0, result.stdout)
        return result.stdout

    def example(self, number, *arguments, **more):
        return self.works(self.examples / f"example_{number:02}", *arguments, **more)

    def test_every_example_is_built_and_run(self):
        names = sorted(path.name for path in (SOURCE / "examples").glob("*.cpp"))
        self.assertEqual([name[:2] for name in names], [f"{i:02}" for i in range(1, 10)], "say below what a new one prints")

    def test_integrate_a_segment(self):
        self.assertIn("optical depth 1.000, transmittance 0.368", self.example(1))

    def test_read_and_write_then_a_picture_of_the_file(self):
        self.assertIn("4 of 24 blocks were decoded", self.example(2))
        self.assertIn("32 x 32 x 48 voxels, 20 frames", self.example(4, "cloud.volute", 0.4, "cloud.png"))
        self.assertTrue((self.work / "cloud.png").read_bytes().startswith(b"\x89PNG"))

    def test_render_from_the_tree(self):
        self.assertIn("nodes take", self.example(3))
        self.assertTrue((self.work / "fire.png").exists())

    def test_kind_of_medium(self):
        self.assertIn("2 s: 0.2231 of the light", self.example(5))

    def test_tetrahedra(self):
        self.assertIn("optical depth 1.500000", self.example(6))

    def test_fds_and_visibility(self):
        room = fds_case.Mesh("room", (0, 8, 0, 3, 0, 2.4), (16, 6, 5))
        case = fds_case.FdsCase([room], (0.0, 10.0, 20.0), lambda time, x, y, z: 0.1 * time).write(self.work)
        said = self.example(7, case)
        self.assertIn("10.0 s,  7.2 m away: optical depth 7.200, seen", said)
        self.assertIn("20.0 s,  7.2 m away: optical depth 14.400, not seen", said)

    def test_evacuation_loop(self):
        room = fds_case.Mesh("hall", (0, 12, 0, 6, 0, 2.4), (24, 12, 5))
        case = fds_case.FdsCase([room], (0.0, 10.0, 20.0), lambda time, x, y, z: 0.01 * time).write(self.work)
        (self.work / "exits.json").write_text('{"signs": [{"name": "exit", "position": [12, 3, 2], "normal": [-1, 0, 0]}]}')
        said = self.example(9, case, "exits.json")
        self.assertIn("0.0 s: 18 people, 0 see no sign, 0 reach an exit", said)
        self.assertIn("not assessed: temperature >= 60", said)
        self.assertIn("2 people are left", said)  # they stand beside the sign, from where it cannot be read

    def test_tomography(self):
        self.assertRegex(self.example(8), r"relative error 0\.0")

    def test_the_whole_library_in_a_project_of_cxx_alone(self):
        folder = project("whole", "find_package(volute REQUIRED)\nadd_executable(whole main.cpp)\n"
                         "if(TARGET embree OR TARGET PNG::PNG)\n  message(FATAL_ERROR \"the shared library needs no more than headers\")\nendif()\n"
                         "target_compile_options(whole PRIVATE -Wall -Wextra -Werror)\n"
                         "target_link_libraries(whole PRIVATE volute::volute)", main=UMBRELLA)
        result = configure(folder, folder / "build")
        self.assertEqual(result.returncode, 0, result.stdout)
        self.works("cmake", "--build", folder / "build")
        version, error = self.works(folder / "build/whole").splitlines()
        self.assertEqual(f"volute {version}\n", self.works(PREFIX / "bin/volute", "--version"))
        self.assertIn("nothing.volute", error)

    def test_shared_libraries(self):
        """Programs whose sources were compiled for the archives run with libvolute.so, those of files with libvolute-core.so alone."""
        libraries = next(PREFIX.rglob("libvolute.so.0")).parent
        linked = ["-L", libraries, f"-Wl,-rpath,{libraries}", "-lfmt"] + (["-fuse-ld=mold", "-Wl,-z,separate-code"] if shutil.which("mold") else [])
        for number, library in [*((i, "volute") for i in range(1, 9)), (2, "volute-core")]:
            objects = [*self.examples.glob(f"CMakeFiles/example_{number:02}.dir/*.o")]
            program = self.work / f"shared_{number}_{library}"
            self.works("c++", *objects, *linked, f"-l{library}", "-o", program)
            needed = self.works("readelf", "-d", program)
            self.assertIn(f"[lib{library}.so.0]", needed)
        self.assertIn("optical depth 1.000", self.works(self.work / "shared_1_volute"))
        for library in ["volute", "volute-core"]:
            self.assertIn("4 of 24 blocks were decoded", self.works(self.work / f"shared_2_{library}"))
        self.assertIn("32 x 32 x 48 voxels, 20 frames", self.works(self.work / "shared_4_volute", "cloud.volute", 0.4, "shared.png"))
        self.assertIn("2 s: 0.2231 of the light", self.works(self.work / "shared_5_volute"))
        core = self.works("readelf", "-d", libraries / "libvolute-core.so.0")
        needs = {name.split(".so")[0] for name in re.findall(r"NEEDED.*\[(.*)\]", core)}
        self.assertEqual(needs - {"libstdc++", "libm", "libgcc_s", "libc", "ld-linux-x86-64", "ld-linux-aarch64"},
                         {"libtbb", "libfmt", "libhwy", "libzstd", "libz"})

    def test_shared_libraries_show_what_installed_headers_declare(self):
        headers = "\n".join(path.read_text() for path in (PREFIX / "include").rglob("*.hpp"))
        words = set(re.findall(r"\w+", headers))
        for library in ["libvolute.so.0", "libvolute-core.so.0"]:
            listed = self.works("nm", "-DC", "--defined-only", next(PREFIX.rglob(library)))
            shown = [line.split(maxsplit=2)[2] for line in listed.splitlines() if " A " not in line]
            self.assertTrue(any("volute::VoluteReader::open(" in name for name in shown), library)
            for name in shown:
                self.assertRegex(name, r"^((vtable|typeinfo|typeinfo name|VTT|guard variable) for |(non-)?virtual thunk to )?volute::", library)
                outer = re.search(r"volute::((?:detail::)?\w+)", name)[1].split("::")[-1]
                self.assertTrue(outer in words, f"{library} shows {name}, and no installed header has {outer}")

    def test_as_a_folder_of_another_project(self):
        folder = project("outer", f"""enable_language(C)
add_subdirectory({SOURCE} volute EXCLUDE_FROM_ALL)
add_executable(mine main.cpp)
target_link_libraries(mine PRIVATE volute::volute)""", main=UMBRELLA)
        result = configure(folder, FOLDER / "outer_build", "-DVOLUTE_TESTS=OFF", "-DVOLUTE_BENCH=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
                           "-DVOLUTE_WITH_PYTHON=OFF")
        self.assertEqual(result.returncode, 0, result.stdout)
        commands = (FOLDER / "outer_build/compile_commands.json").read_text()
        self.assertIn(f"-I{SOURCE}/include", commands)
        links = self.works("ninja", "-C", FOLDER / "outer_build", "-t", "query", "mine")
        self.assertIn("libvolute_scene.a", links)

    def test_packages_need_what_is_loaded_late(self):
        """What a message asks to install is what the Debian packages depend on or recommend."""
        said = re.search(r"is missing; install (.*?)\W*$", (SOURCE / "src/volute/gl/gl_device.cpp").read_text(), re.M)[1]
        packages = re.findall(r"lib[\w-]+", said)
        table = (SOURCE / "cmake/VolutePackages.cmake").read_text()
        self.assertEqual(re.search(r"^set\(openGl (.*)\)$", table, re.M)[1].split(), packages)
        for name in ("volute", "volute-view", "libvolute0"):
            self.assertRegex(table, rf"(?s)volute_deb\({name} (?:(?!volute_deb).)*?\$\{{openGl\}}")

    def test_a_part_looks_for_what_it_needs_alone(self):
        folder = project("part", "find_package(volute 0.2 REQUIRED COMPONENTS codec)\n"
                         "if(TARGET PNG::PNG OR TARGET nlohmann_json::nlohmann_json OR TARGET embree OR NOT TARGET volute::codec)\n"
                         "  message(FATAL_ERROR \"wrong dependencies\")\nendif()")
        result = configure(folder, folder / "build")
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_what_is_not_there_is_refused(self):
        for number, (asked, answer) in enumerate([("COMPONENTS codec cheese", "volute has no component cheese"), ("0.1", "version: 0.2"),
                                                  ("1.0", "version: 0.2")]):
            folder = project(f"refused{number}", f"find_package(volute {asked} REQUIRED)")
            result = configure(folder, folder / "build")
            self.assertNotEqual(result.returncode, 0, asked)
            self.assertIn(answer, " ".join(result.stdout.split()))

    def test_pkg_config(self):
        environment = os.environ | {"PKG_CONFIG_PATH": str(next(PREFIX.rglob("volute.pc")).parent)}
        flags = self.works("pkg-config", "--cflags", "--libs", "volute", env=environment).split()
        launcher = ["ccache"] if shutil.which("ccache") else []
        self.assertFalse([flag for flag in flags if flag.startswith("-std")])  # the program's own choice
        self.works(*launcher, "c++", "-std=c++20", "-c", SOURCE / "examples/02_read_and_write.cpp", "-o", "by_pc.o",
                   *(flag for flag in flags if not flag.startswith("-l")))
        for name in ["volute", "volute-core", "volute-static"]:
            flags = self.works("pkg-config", "--libs", name, env=environment).split()
            self.works("c++", "by_pc.o", *flags, "-o", name)
            library = next(PREFIX.rglob("libvolute.so.0")).parent
            self.assertIn("4 of 24 blocks were decoded", self.works(f"./{name}", env=os.environ | {"LD_LIBRARY_PATH": str(library)}))

    def test_a_picture_is_that_of_the_command(self):
        self.example(2)
        library = next(PREFIX.rglob("libvolute.so.0")).parent
        environment = os.environ | {"PKG_CONFIG_PATH": str(next(PREFIX.rglob("volute.pc")).parent), "LD_LIBRARY_PATH": str(library)}
        flags = self.works("pkg-config", "--cflags", "--libs", "volute", env=environment).split()
        (self.work / "draw.cpp").write_text(PICTURE)
        self.works("c++", "-std=c++20", "draw.cpp", *flags, "-o", "draw")
        command = PREFIX / "bin/volute"
        self.works(command, "extract", "cloud.volute", "-o", "values.npy")
        self.assertIn("0 x 48 pixels; expected 1 to 32768", self.works("./draw", "values.npy", "mine.png", "memory.png", env=environment))
        self.works(command, "render", "values.npy", "-o", "its.png", "--size", "64x48", "--time", 0.4)
        for name in ("mine.png", "memory.png"):
            self.assertRegex(self.works(command, "compare", name, "its.png"), r"max error +0\n", name)

    def test_programs_with_other_flags_of_the_compiler(self):
        """Types of the headers are laid out as in the library whatever a program is compiled with, or the compiler refuses."""
        library = next(PREFIX.rglob("libvolute.so.0")).parent
        environment = os.environ | {"PKG_CONFIG_PATH": str(next(PREFIX.rglob("volute.pc")).parent), "LD_LIBRARY_PATH": str(library)}
        flags = self.works("pkg-config", "--cflags", "volute", env=environment).split()
        libraries = self.works("pkg-config", "--libs", "volute", env=environment).split()
        (self.work / "layout.cpp").write_text(LAYOUT)
        (self.work / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        cpu = pathlib.Path("/proc/cpuinfo").read_text()
        ways = [("g++", [], True), ("g++", ["-march=native"], True), ("g++", ["-mavx"], " avx " in cpu), ("g++", ["-mavx512f", "-DEIGEN_DONT_VECTORIZE"], " avx512f " in cpu),
                ("g++", ["-DEIGEN_DONT_ALIGN"], True), ("g++", ["-DEIGEN_DEFAULT_TO_ROW_MAJOR"], True),
                ("g++", ["-fno-rtti", "-fno-exceptions"], True), ("clang++-19", ["-march=native", "-std=c++23"], True)]
        said = {}
        for compiler, more, runs in ways:
            if shutil.which(compiler):
                self.works(compiler, "-std=c++20", *flags, *more, "layout.cpp", *libraries, "-o", "layout")
                if runs:
                    said[compiler, *more] = self.works("./layout", env=environment)
        self.assertEqual(set(said.values()), {said["g++",]}, said)
        self.assertIn(": 32 24\n", said["g++",])
        self.assertIn(f"\n{50 * (4 + 2 + 3 + 4)}\n", said["g++",])

    def test_in_c_alone(self):
        """By compilers that know no C++, from the shared library, which shows what its header says and nothing else."""
        library = next(PREFIX.rglob("libvolute_c.so.0"))
        exported = {line.split()[-1].split("@")[0] for line in self.works("nm", "-D", "--defined-only", library).splitlines()
                    if line.split()[-2] != "A"}
        text = re.sub(r"/\*.*?\*/", "", (PREFIX / "include/volute/volute.h").read_text(), flags=re.S)
        declared = set(re.findall(r"\b(volute_\w+)\(", text))
        self.assertGreater(len(declared), 10)
        self.assertEqual(exported, declared)
        environment = os.environ | {"PKG_CONFIG_PATH": str(next(PREFIX.rglob("volute-c.pc")).parent),
                                    "LD_LIBRARY_PATH": str(library.parent)}
        for compiler in filter(shutil.which, ["gcc", "clang-19"]):
            build = FOLDER / f"c-{compiler}"
            self.works("cmake", "-S", SOURCE / "examples/c", "-B", build, "-G", "Ninja", f"-DCMAKE_C_COMPILER={compiler}",
                       "-DCMAKE_C_FLAGS=-Wall -Wextra -Wpedantic -Werror", env=environment)
            self.works("cmake", "--build", build)
            said = self.works(build / "example_c", env=environment)
            self.assertIn("there is no frame 3; there are 3", said)
            self.assertIn("20 s: optical depth 6.00 in the smoke, 0.00 above it", said)
            self.assertRegex(self.works(build / "example_c_picture", env=environment), r"^[1-9]\d* reports; then: .*stopped|cancel")
            puff, ball = self.works(build / "example_c_function", env=environment).splitlines()
            self.assertRegex(puff, r"^middle (0\.[1-9]|[1-9])\S*, corner 0\.0\d+$")
            self.assertEqual(ball, "middle 0.1353, corner 1.0000")  # exp(-2 * 2 * 0.5)
            picture = (self.work / "picture.ppm").read_bytes()
            self.assertGreater(len(set(picture[-3 * 320 * 240:])), 20)
            self.works(build / "example_c_picture", "smoke.volute", env=environment)
            self.assertNotEqual((self.work / "picture.ppm").read_bytes(), picture)

    def test_threads_of_c(self):
        self.example(2)
        library = next(PREFIX.rglob("libvolute_c.so.0")).parent
        self.works("cc", "-std=c11", "-Wall", "-Wextra", "-Werror", SOURCE / "tests/threads.c", "-I", PREFIX / "include", "-L", library,
                   f"-Wl,-rpath,{library}", "-lvolute_c", "-pthread", "-o", "threads")
        self.assertEqual(self.works("./threads", "cloud.volute"), "4 threads read 20 frames 10 times\n")

    def test_values_of_c(self):
        library = next(PREFIX.rglob("libvolute_c.so.0")).parent
        self.works("cc", "-std=c11", "-Wall", "-Wextra", "-Werror", SOURCE / "tests/values.c", "-I", PREFIX / "include", "-L", library,
                   f"-Wl,-rpath,{library}", "-lvolute_c", "-lm", "-o", "values")
        self.assertEqual(self.works("./values", SOURCE / "tests/data/cache.volute"), "values are seen through\n")

    def test_walkers_of_c(self):
        library = next(PREFIX.rglob("libvolute_c.so.0")).parent
        self.works("cc", "-std=c11", "-Wall", "-Wextra", "-Werror", SOURCE / "tests/engine.c", "-I", PREFIX / "include", "-L", library,
                   f"-Wl,-rpath,{library}", "-lvolute_c", "-lm", "-o", "engine")
        self.works(PREFIX / "bin/volute", "synthesize", "hall", "-o", "hall.smv", "--cell", 0.8, "--frames", 8)
        (self.work / "exit.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [0.1, 6, 2.4], "normal": [1, 0, 0]}]}))
        self.assertEqual(self.works("./engine", "hall.smv", "exit.json"), "doses, and the most that they may be\n")

    def test_python_package(self):
        module = next((BUILD / "python/volute").glob("_core.*.so"), None)
        if not module:
            self.skipTest("the Python package was not built: it wants python3-dev, python3-numpy and pybind11-dev")
        for component in ["python", "python-render"]:
            result = install(component)
            self.assertEqual(result.returncode, 0, result.stdout)
        self.example(2)
        folder = next(PREFIX.rglob("volute/__init__.py")).parents[1]
        said = self.works("/usr/bin/python3", "-c", "import os, volute; print(volute.open('cloud.volute').shape, os.environ['VOLUTE_PLUGIN_FOLDER'])\n"
                          "print(volute.render('cloud.volute', size=(8, 6)).shape)",
                          env={key: value for key, value in os.environ.items() if not key.startswith("VOLUTE_")} | {"PYTHONPATH": str(folder)})
        self.assertEqual(said.splitlines(), [f"(20, 48, 32, 32) {PREFIX}/lib/volute", "(6, 8, 3)"])

    def test_no_header_is_missing(self):
        headers = {path.relative_to(PREFIX / "include").as_posix() for path in (PREFIX / "include").rglob("*.hpp")}
        self.assertIn("volute/volute.hpp", headers)
        for header in headers:
            for included in re.findall(r'#include "(volute/[^"]+)"', (PREFIX / "include" / header).read_text()):
                self.assertIn(included, headers, header)

    def test_the_command_has_its_plugins_manual_and_completions(self):
        program = PREFIX / "bin/volute"
        self.example(2)
        if (PREFIX / "lib/volute/volute_io_vdb.so").exists():
            self.works(program, "extract", "cloud.volute", "-o", "one.vdb", "--frames", "3")
            self.assertRegex(self.works(program, "info", "one.vdb"), r"size +\d+ x \d+ x \d+ voxels")
            # Programs elsewhere say where the plug-ins are.
            result = run(self.examples / "example_04", "one.vdb", 0, "one.png", cwd=self.work)
            self.assertEqual(result.returncode, 1)
            self.assertIn("VOLUTE_PLUGIN_FOLDER", result.stdout)
            self.example(4, "one.vdb", 0, "one.png", env=os.environ | {"VOLUTE_PLUGIN_FOLDER": str(PREFIX / "lib/volute")})
        self.assertIn(".TH VOLUTE 1", (PREFIX / "share/man/man1/volute.1").read_text())
        for file, word in [("bash-completion/completions/volute", "complete"), ("zsh/site-functions/_volute", "#compdef"),
                           ("fish/vendor_completions.d/volute.fish", "complete -c volute")]:
            self.assertIn(word, (PREFIX / "share" / file).read_text())

    def test_the_desktop_knows_the_viewer_and_its_files(self):
        if not (BUILD / "bin/volute-view").exists():
            self.skipTest("the viewer was not built")
        result = install("viewer")
        self.assertEqual(result.returncode, 0, result.stdout)
        file = PREFIX / "share/applications/volute-view.desktop"
        desktop = configparser.ConfigParser(interpolation=None)
        desktop.optionxform = str
        desktop.read_string(file.read_text())
        entry = desktop["Desktop Entry"]
        self.assertEqual((entry["Type"], entry["Exec"]), ("Application", "volute-view %F"))
        self.assertTrue(os.access(PREFIX / "bin/volute-view", os.X_OK))
        icon = PREFIX / f"share/icons/hicolor/scalable/apps/{entry['Icon']}.svg"
        self.assertTrue(xml.etree.ElementTree.parse(icon).getroot().tag.endswith("svg"))
        if shutil.which("desktop-file-validate"):
            self.assertEqual(self.works("desktop-file-validate", file), "")
        space = "{http://www.freedesktop.org/standards/shared-mime-info}"
        types = xml.etree.ElementTree.parse(PREFIX / "share/mime/packages/volute.xml").getroot().findall(f"{space}mime-type")
        self.assertEqual([kind.get("type") for kind in types], entry["MimeType"].strip(";").split(";"))
        self.assertEqual([glob.get("pattern") for glob in types[0].iter(f"{space}glob")], ["*.volute"])
        self.example(2)
        match = types[0].find(f"{space}magic/{space}match")
        magic = match.get("value").encode().decode("unicode_escape").encode("latin-1")
        self.assertEqual((match.get("type"), match.get("offset")), ("string", "0"))
        self.assertTrue((self.work / "cloud.volute").read_bytes().startswith(magic))
        if shutil.which("update-mime-database") and shutil.which("gio"):
            self.works("update-mime-database", PREFIX / "share/mime")
            said = self.works("gio", "info", "-a", "standard::content-type", "cloud.volute",
                              env=os.environ | {"XDG_DATA_DIRS": f"{PREFIX}/share:/usr/share", "XDG_DATA_HOME": str(self.work)})
            self.assertIn("application/x-volute", said)


if __name__ == "__main__":
    unittest.main(verbosity=2)
