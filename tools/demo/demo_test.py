#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Tests of the demo with programs that stand in for Volute's: `python3 tools/demo/demo_test.py`."""
import contextlib
import dataclasses
import io
import json
import os
import pathlib
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import effects
import laboratory
import links
import page
import papers
import progress
import safety
import words
from compile import Compiler
from plan import Build, Chapter, Plan, Scale, Step
from runner import Runner
from state import State


def plan(quick):
    scale = Scale(quick)
    return Plan([chapter.chapter(scale) for chapter in (effects, laboratory, safety, papers)], scale.measured())


class Demo(unittest.TestCase):
    """The whole demo, as a program."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.path = pathlib.Path(cls.folder.name)
        cls.bin, cls.log = cls.path / "bin", cls.path / "log"
        cls.bin.mkdir()
        for name in ("volute", "volute-paper-figures"):
            shutil.copy(HERE / "fake_volute.py", cls.bin / name)
            (cls.bin / name).chmod(0o755)
        cls.environment = {**os.environ, "FAKE_LOG": str(cls.log), "FAKE_PICTURES": str(HERE.parents[1] / "tests" / "cli")}

    def setUp(self):
        self.said = self.errors = ""
        self.out = self.path / self.id().rsplit(".", maxsplit=1)[-1]

    def whole(self):
        """A finished demo; it is made once."""
        finished = self.path / "finished"
        if not finished.exists():
            out, self.out = self.out, finished
            self.assertEqual(self.run_demo(), 0, self.errors)
            type(self).first = (self.calls(), self.errors)
            self.out = out
        shutil.copytree(finished, self.out)

    def start(self, *more, **environment):
        self.log.unlink(missing_ok=True)
        return subprocess.Popen([sys.executable, str(HERE), "--bin", str(self.bin), "--out", str(self.out), "--quick", *more], cwd=self.path,
                                env={**self.environment, **environment}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run_demo(self, *more, **environment):
        process = self.start(*more, **environment)
        self.said, self.errors = process.communicate(timeout=120)
        return process.returncode

    def calls(self):
        return self.log.read_text(encoding="utf-8").splitlines() if self.log.exists() else []

    def assert_in_page(self, part, html):
        self.assertTrue(part in html, f"{part!r} is not in the page")

    def html(self):
        return (self.out / "index.html").read_text(encoding="utf-8")

    def test_a_whole_run_and_what_a_second_one_makes(self):
        self.whole()
        calls, errors = self.first
        html = self.html()
        self.assertEqual(links.dead(self.out), [])
        self.assertFalse("0.0000" in html)
        self.assertFalse("status.js" in html)
        self.assertFalse("http-equiv" in html)
        commands = [" ".join(step.words) for step in plan(True).steps if not isinstance(step, Build) and step.command]
        self.assertEqual([call.removesuffix(" --json") for call in calls], commands)
        for chapter in plan(True).chapters:
            for part in (part for section in chapter.sections for part in section.parts):
                for file in page.files_of(part):
                    self.assert_in_page(f'"{file}"', html)
        for part in ("MB on this disk", "four chapters (", "Ctrl-C stops it", "[1/"):
            self.assertIn(part, errors)

        self.assertEqual(self.run_demo(), 0, self.errors)
        self.assertEqual(self.calls(), [])

        (self.out / "effects/fire.png").unlink()
        self.assertEqual(self.run_demo(), 0, self.errors)
        self.assertEqual([call.split()[4] for call in self.calls()], ["effects/fire.png"])

    def test_another_program_or_size_makes_it_anew(self):
        self.whole()
        program = self.bin / "volute-paper-figures"
        self.addCleanup(program.write_bytes, program.read_bytes())
        with open(program, "a", encoding="utf-8") as file:
            file.write("# another version\n")
        self.assertEqual(self.run_demo(), 0, self.errors)
        self.assertEqual({call.split()[0] for call in self.calls()}, {"volute-paper-figures"})
        self.assertEqual(len(self.calls()), 2)

        quick, full = plan(True), plan(False)
        self.assertTrue(all(State(self.out, quick, self.bin).done(step) for step in quick.maker.values()))
        large = State(self.out, full, self.bin)
        kept = {name for name, step in full.maker.items() if large.done(step)}
        self.assertIn("papers/ball.vtu", kept)
        for name in ("effects/fire/", "effects/fire.volute", "safety/plan/", "papers/by_volume.png"):
            self.assertNotIn(name, kept)

    def wait_for(self, what, seconds=60):
        end = time.monotonic() + seconds
        while not what():
            self.assertLess(time.monotonic(), end, "it took too long")
            time.sleep(0.05)

    def test_ctrl_c_leaves_a_page_and_the_next_run_goes_on(self):
        slow = "laboratory/fire.volute"
        process = self.start(FAKE_SLOW=slow)
        self.wait_for(lambda: any(slow in call for call in self.calls()))
        self.wait_for(lambda: (self.out / "status.js").exists() and slow in (self.out / "status.js").read_text())
        running = self.html()
        self.assertIn("status.js", running)
        self.assertEqual(links.dead(self.out), [])
        done = len(self.calls()) - 1
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("the same command continues", said)
        self.assertNotIn("Traceback", errors)
        html = self.html()
        self.assert_in_page("The demo was stopped.", html)
        self.assert_in_page("./dev demo --quick", html)
        self.assert_in_page("Incomplete chapters: Laboratory; Fire safety; The papers", html)
        self.assertFalse("status.js" in html)
        self.assertFalse(f'"{slow}"' in html)
        self.assertEqual(links.dead(self.out), [])

        self.assertEqual(self.run_demo(), 0, self.errors)
        commands = [step for step in plan(True).steps if not isinstance(step, Build) and step.command]
        self.assertEqual(len(self.calls()), len(commands) - done)
        self.assertIn(slow, self.calls()[0])
        self.assertNotEqual((self.out / slow).read_bytes(), b"half")
        self.assertIn(slow, self.html())

    def test_a_failure_leaves_out_what_needs_it(self):
        self.whole()
        shutil.rmtree(self.out / "laboratory")
        self.assertEqual(self.run_demo(FAKE_FAIL="laboratory/fire.npy"), 1)
        html = self.html()
        self.assert_in_page("it cannot", html)
        self.assertFalse("laboratory/found.png\"" in html)
        self.assert_in_page("effects/fire.mp4", html)
        self.assert_in_page("safety/plan/aset.png", html)
        self.assertEqual(links.dead(self.out), [])
        self.assertEqual(self.run_demo(), 0, self.errors)
        self.assertIn("laboratory/found.png", self.html())

    def test_pictures_of_nothing_or_of_another_are_told(self):
        self.whole()
        shutil.rmtree(self.out / "effects")
        same = "effects/fire.png:effects/smoke.png"
        self.assertEqual(self.run_demo(FAKE_SAME=same), 1)
        self.assertIn("effects/smoke.png is the same picture as effects/fire.png", self.errors)
        self.assertEqual(self.run_demo(FAKE_BLACK="effects/smoke.png"), 1)
        self.assertIn("effects/smoke.png has one colour alone", self.errors)
        self.assertEqual(self.run_demo(), 0, self.errors)

    def test_two_demos_do_not_share_a_folder(self):
        first = self.start(FAKE_SLOW="effects/fire.volute")
        self.wait_for(lambda: any("effects/fire.volute" in call for call in self.calls()))
        self.assertEqual(self.run_demo(), 1)
        self.assertIn("another demo", self.errors)
        first.terminate()
        first.communicate(timeout=30)
        self.assertEqual(first.returncode, 130)

    def test_what_an_earlier_version_made_goes(self):
        self.whole()
        (self.out / "old.png").write_bytes(b"x")
        (self.out / "mine.png").write_bytes(b"x")
        record = {"name": "old.png", "stamp": "", "makes": {"old.png": [1, 1], "../log": [1, 1]}, "seconds": 1, "report": None}
        (self.out / ".state/old.json").write_text(json.dumps(record))
        self.assertEqual(self.run_demo(), 0, self.errors)
        self.assertFalse((self.out / "old.png").exists())
        self.assertTrue((self.out / "mine.png").exists())
        self.assertEqual(self.calls(), [])


class Plans(unittest.TestCase):
    def test_commands_name_what_they_read_and_make(self):
        for quick in (False, True):
            for step in plan(quick).steps:
                if isinstance(step, Build) or not step.command:
                    continue
                for file in step.makes[:1]:
                    self.assertIn(file.rstrip("/"), step.command)
                for file in () if ".json" in step.command else step.reads:  # a scene names files, too
                    if file != "laboratory/views/":
                        self.assertIn(file.rstrip("/"), step.command)

    def test_every_step_is_shown_or_used(self):
        for quick in (False, True):
            whole = plan(quick)
            shown = {whole.step_of(file).name for chapter in whole.chapters for section in chapter.sections for part in section.parts
                     for file in [*page.files_of(part), *getattr(part, "needs", ())]}
            read = {whole.maker[file].name for step in whole.steps if not isinstance(step, Build) for file in step.reads}
            for step in whole.steps:
                if not isinstance(step, Build):
                    self.assertIn(step.name, shown | read)

    def test_the_time_of_every_step_is_known(self):
        for quick in (False, True):
            scale = Scale(quick)
            self.assertEqual(set(scale.measured()), {step.name for step in plan(quick).maker.values()},
                             f"refresh {scale.table()}: run the demo, then again with --measured")

    def test_captions_do_not_repeat_titles(self):
        for chapter in plan(False).chapters:
            for section in chapter.sections:
                for part in section.parts:
                    if hasattr(part, "label") and isinstance(getattr(part, "caption", None), str):
                        self.assertNotIn(part.label.lower(), part.caption.lower())

    def test_a_file_must_be_made_before_it_is_read(self):
        with self.assertRaisesRegex(ValueError, "reads b"):
            Plan([Chapter("c", "", "", (Step(("a",), "x", reads=("b",)),), ())])
        with self.assertRaisesRegex(ValueError, "made twice"):
            Plan([Chapter("c", "", "", (Step(("a",), "x"), Step(("a",), "y")), ())])


class Links(unittest.TestCase):
    def test_dead_links_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "a b.png").write_bytes(b"")
            (path / "index.html").write_text('<p id="one"><a href="#one"></a><a href="#two"></a><img src="a%20b.png"><img src="c.png">'
                                             '<video poster="d.png"></video><a href="https://x.org"></a><a href="../x"></a><b id="one"></b>')
            self.assertEqual([target for _, target in links.dead(path)], ["#two", "c.png", "d.png", "https://x.org", "../x", "id one twice"])


class Words(unittest.TestCase):
    def test_figures_have_digits_that_count(self):
        self.assertEqual(words.percent(0.00001234).replace(words.NBSP, " "), "0.0012 %")
        self.assertEqual(words.percent(0.5).replace(words.NBSP, " "), "50 %")
        self.assertEqual(words.percent(0), "0" + words.NBSP + "%")
        self.assertEqual(words.digits(0.00002, 2), "2.0·10⁻⁵")
        self.assertEqual(words.digits(1234.5), "1234")
        self.assertEqual(words.bytes_of(1234567).replace(words.NBSP, " "), "1.23 MB")

    def test_time_left_learns(self):
        forecast = progress.Forecast(slowness=1.0)
        before = forecast.wall(10)
        forecast.seen(20, 3 * forecast.wall(20))
        self.assertGreater(forecast.wall(10), 1.5 * before)
        self.assertLess(forecast.wall(10), 3.01 * before)


class Compiling(unittest.TestCase):
    """With a stand-in for cmake and ninja."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def program(self, name, body):
        path = self.path / name
        path.write_text("#!/bin/sh\n" + body)
        path.chmod(path.stat().st_mode | stat.S_IEXEC)
        return path

    def test_progress_is_read_from_ninja(self):
        cmake = self.program("cmake", 'if [ "$1" = --build ]; then echo "[1/3] a"; sleep 0.1; echo "[2/3] b"; sleep 0.1; echo "[3/3] c"; fi\n')
        told = []
        Compiler(self.path, "release", 2, str(cmake)).build("volute", lambda done, of: told.append((done, of)))
        self.assertIn((1, 3), told)
        self.assertEqual(told[-1], (3, 3))

    def test_what_the_compiler_said_is_passed_on(self):
        cmake = self.program("cmake", 'if [ "$1" = --build ]; then echo "[1/3] a"; echo "a.cpp:1: error: no"; exit 1; fi\n')
        with self.assertRaisesRegex(Exception, "a.cpp:1: error: no"):
            Compiler(self.path, "release", 2, str(cmake)).build("volute", lambda done, of: None)


class BuildingAndShowing(unittest.TestCase):
    """What is needed first is built first, with a stand-in for cmake that makes the programs."""

    def test_pictures_come_before_the_papers_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            out, log = path / "demo", path / "builds"
            cmake = path / "cmake"
            cmake.write_text(f'''#!/bin/sh
[ "$1" = --build ] || exit 0
for target; do :; done
echo "$target $(ls {out}/index.html | wc -l) $(find {out} -name '*.png' | wc -l) $(grep -c 'Compiling\\|compile' {out}/status.js)" >> {log}
echo "[1/1] linking"
mkdir -p {path}/build/release/bin
cp {HERE}/fake_volute.py {path}/build/release/bin/$target
chmod +x {path}/build/release/bin/$target
''')
            cmake.chmod(0o755)
            environment = {"FAKE_LOG": str(path / "log"), "FAKE_PICTURES": str(HERE.parents[1] / "tests" / "cli")}
            with unittest.mock.patch.dict(os.environ, environment), contextlib.redirect_stderr(io.StringIO()), \
                    contextlib.redirect_stdout(io.StringIO()) as said:
                compiler = Compiler(path, "release", 2, str(cmake))
                small = Plan([effects.chapter(Scale(True)), dataclasses.replace(safety.chapter(Scale(True)), sections=()), *self.papers_program_alone()])
                state = State(out, small, compiler.binaries)
                self.assertTrue(state.lock())
                self.assertTrue(Runner(small, state, compiler, progress.Forecast(1.0), True).run())
            command, vdb, readers, papers_program = (line.split() for line in log.read_text().splitlines())
            self.assertEqual(command, ["volute", "1", "0", "1"])
            self.assertEqual(vdb[:3], ["volute_io_vdb", "1", "0"])
            self.assertEqual(readers[:3], ["volute-plugins", "1", "1"])  # the first picture is there
            self.assertEqual(papers_program[:2], ["volute-paper-figures", "1"])
            self.assertGreater(int(papers_program[2]), 10)
            self.assertIn("The first picture: ", said.getvalue())

    def test_a_compiler_that_fails_is_told_once(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "cmake").write_text("#!/bin/sh\necho a.cpp:1: error: no >&2\nexit 1\n")
            (path / "cmake").chmod(0o755)
            compiler = Compiler(path, "release", 2, str(path / "cmake"))
            with contextlib.redirect_stderr(io.StringIO()) as said:
                state = State(path / "demo", plan(True), compiler.binaries)
                self.assertFalse(Runner(plan(True), state, compiler, progress.Forecast(1.0), True).run())
            self.assertEqual(said.getvalue().count("a.cpp:1: error: no"), 5)  # once for each target
            self.assertEqual(said.getvalue().count("effects/fire.png"), 0)
            self.assertIn("needs volute", (path / "demo/index.html").read_text())
            self.assertEqual(links.dead(path / "demo"), [])

    @staticmethod
    def papers_program_alone():
        """The chapter of the papers with its steps of trees alone."""
        scale = Scale(True)
        chapter = papers.chapter(scale)
        return [dataclasses.replace(chapter, steps=tuple(papers.tree_steps(scale)), sections=papers.tree_sections(scale))]


if __name__ == "__main__":
    unittest.main()
