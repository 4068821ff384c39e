# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Help, exit codes, and what wrong usage is answered with."""
import zipfile

import support
from support import volute, write_npy

COMMANDS = ["info", "compress", "extract", "compare", "synthesize", "render", "bench", "help", "man", "completion"]


class Usage(support.TestCase):
    def test_overview_lists_every_command(self):
        for words in ([], ["--help"], ["help"]):
            overview = self.works(*words).text
            for command in COMMANDS:
                self.assertRegex(overview, rf"(?m)^  {command}\s+\w")

    def test_help_opens_with_an_example(self):
        for command in COMMANDS:
            by_option = self.works(command, "--help").text
            self.assertEqual(by_option, self.works("help", command).text)
            self.assertRegex(by_option, rf"\AExamples?:\n  (.*<\()?volute {command}")
            self.assertIn("Usage:\n  volute " + command, by_option)
            self.assertIn("--threads", by_option)

    def test_help_states_defaults_and_units(self):
        text = self.works("render", "--help").text
        self.assertIn("[default auto]", text)
        self.assertIn("[degrees]", text)

    def test_outputs_have_the_input_s_name_unless_one_is_given(self):
        support.write_npy(self.path("cloud_0001.npy"), (1, 8, 8, 8), [0.5] * 256 + [1.5] * 256)
        cloud, here = self.path("cloud_0001.npy"), {"cwd": self.path("here")}
        self.path("here").mkdir()
        done = self.works("compress", cloud, **here)
        self.assertIn("writes cloud_0001.volute; --output gives another name", done.message)
        self.assertLessEqual(self.works("info", "cloud_0001.volute", "--json", **here).json["relative_rms"], 0.003)
        for name in ("cloud_0001.png", "cloud_0001_2.png", "cloud_0001_3.png"):
            self.assertIn(f"writes {name}; ", self.works("render", "cloud_0001.volute", "--size", "8x8", **here).message)
        self.assertEqual(sorted(p.name for p in self.path("here").iterdir()),
                         ["cloud_0001.png", "cloud_0001.volute", "cloud_0001_2.png", "cloud_0001_3.png"])
        self.works("synthesize", "flame", "-o", self.path("fire_%04d.vti"), "--size", 16, "--frames", 2)
        self.works("compress", self.path("fire_%04d.vti"), **here)
        self.assertTrue(self.path("here/fire.volute").exists())

    def test_version(self):
        self.assertRegex(self.works("--version").text, r"\Avolute \d+\.\d+\.\d+\n\Z")
        self.assertEqual(self.works("info", "--version").text, self.works("--version").text)

    def test_unknown_names_suggest_the_nearest(self):
        self.assertIn("did you mean 'compress'?", self.fails(2, "comprss"))
        self.assertIn("did you mean --rms?", self.fails(2, "compress", "a.npy", "-o", "b.volute", "--rsm", "1"))
        self.assertIn("did you mean --quiet?", self.fails(2, "--quit"))
        self.assertIn("did you mean 'haar'?",
                      self.fails(2, "compress", "a.npy", "-o", "b.volute", "--rms", "1", "--wavelet", "har"))
        self.assertNotIn("did you mean", self.fails(2, "xyzzy"))

    def test_options_that_others_leave_without_effect_are_refused(self):
        write_npy(self.path("a.npy"), (1, 4, 4, 4), [0.5] * 64)
        for words, said in ((("--block-mode", "plain:haar:2", "--wavelet", "haar"), "2 of --wavelet, --block-mode are given"),
                            (("--max-error", "0.1", "--rms-over", "all"), "--rms-over has no effect with --max-error"),
                            (("--quality", "draft", "--rms-over", "all"), "--rms-over has no effect with --quality"),
                            (("--keep", "nosuch"), "--keep: is for grids of a cache"),
                            (("--uncoded", "drop"), "--uncoded: is for grids of a cache")):
            self.assertIn(said, self.fails(2, "compress", self.path("a.npy"), "-o", self.path("x.volute"), *words))
        picture = ("render", self.path("a.npy"), "-o", self.path("x.png"), "--size", "4x4")
        for words, said in ((("--speed", "3"), "--speed has no effect on one picture"),
                            (("--cache", "none", "--cache-size", "1M"), "--cache-size has no effect with --cache none")):
            self.assertIn(said, self.fails(2, *picture, *words))
        self.works(*picture, "--fps", "10")
        self.assertIn("--peers has no effect: it is for codec", self.fails(2, "bench", "light", "--peers", self.path("none")))

    def test_wrong_usage_is_exit_2(self):
        for words in (["info"], ["compress"], ["extract", "a.volute"],
                      ["compress", "-o", "b.volute"],
                      ["compress", "a.npy", "-o", "b.volute", "--rms", "1", "--psnr", "40"],
                      ["compress", "a.npy", "-o", "b.volute", "--rms", "x"],
                      ["compress", "a.npy", "-o", "b.volute", "--rms", "-1"],
                      ["compress", "a.npy", "-o", "b.volute", "--rms"],
                      ["compress", "a.npy", "-o", "b.volute", "--rms", "3"],
                      ["join", "a.volute", "b.volute", "-o", "c.volute", "--rms", "1.5"],
                      ["compress", "a.npy", "-o", "b.txt", "--rms", "1"],
                      ["extract", "a.volute", "-o", "b.npy", "--region", "0:4,0:4"],
                      ["extract", "a.volute", "-o", "b.npy", "--frames", "4:2"],
                      ["extract", "a.volute", "-o", "b.npy", "--level", "-1"],
                      ["extract", "a.volute", "-o", "-", "--json"],
                      ["compare", "a.npy"], ["compare", "a.png", "b.npy"], ["synthesize", "water", "-o", "x.npy"],
                      ["render", "a.volute", "-o", "b.gif"], ["render", "a.volute", "-o", "b.png", "--size", "0x5"],
                      ["render", "a.volute", "-o", "b.png", "--fov", "30", "--ortho", "2"],
                      ["help", "nothing"], ["man", "--markdown", "nothing"], ["completion", "tcsh"], ["bench", "nothing"],
                      ["info", "x", "--threads", "-1"], ["info", "x", "--max-memory", "much"]):
            with self.subTest(words=words):
                self.fails(2, *words)

    def test_common_options_may_stand_anywhere(self):
        source = self.make_npy()
        self.works("--threads", "1", "--json", "info", source).json
        self.works("info", source, "--threads=2", "--max-memory", "1G", "-q", "-v")

    def test_results_and_remarks_are_apart(self):
        result = self.works("render", self.make_volute(), "-o", self.path("x.png"), "--size", "8x8")
        self.assertEqual(result.text, "")
        self.assertIn("exposure", result.message)
        quiet = self.works("render", self.path("in.volute"), "-o", self.path("x.png"), "--size", "8x8", "--quiet")
        self.assertEqual((quiet.text, quiet.message), ("", ""))

    def test_remarks_are_in_the_results_and_errors_where_they_are_strict(self):
        source = self.path("two.npz")
        numpy_file = self.make_npy("one.npy").read_bytes()
        with zipfile.ZipFile(source, "w") as archive:
            archive.writestr("density.npy", numpy_file)
            archive.writestr("heat.npy", numpy_file)
        made = self.works("compress", source, "-o", self.path("x.volute"), "--rms", "0.1", "--json")
        said = [remark for remark in made.json["remarks"] if "also has heat" in remark["sentence"]]
        self.assertEqual([remark["code"] for remark in said], ["assumed"])
        self.assertIn("choose one with --field", made.message)
        (self.path("x.volute")).unlink()
        strict = self.fails(1, "compress", source, "-o", self.path("x.volute"), "--rms", "0.1", "--strict")
        self.assertRegex(strict.splitlines()[-1], "^volute compress: not with --strict: .*also has heat.*--field")
        self.assertEqual(strict.count("also has heat"), 1)
        self.assertFalse(self.path("x.volute").exists())
        self.works("compress", source, "--field", "heat", "--fps", "25", "--bounds", "0,0,0,1,1,1", "-o", self.path("x.volute"), "--rms", "0.1", "--strict")

    def test_results_that_cannot_be_written_are_an_error(self):
        with open("/dev/full", "wb") as full:
            self.assertIn("standard output", self.fails(1, "info", self.make_npy(), stdout=full))
            self.assertIn("standard output", self.fails(1, "help", stdout=full))
            self.fails(1, "extract", self.make_volute(), "-o", "-", stdout=full)


if __name__ == "__main__":
    support.main()
