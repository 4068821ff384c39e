#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Tests of plots.py and codec_plot.py: `python3 tools/plots_test.py`."""
import contextlib
import io
import json
import math
import pathlib
import random
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import codec_plot
import plots


class Ticks(unittest.TestCase):
    def test_linear_ticks_are_round_and_cover(self):
        self.assertEqual(plots.linear_ticks(0, 1), [0, 0.2, 0.4, 0.6, 0.8, 1])
        self.assertEqual(plots.linear_ticks(0, 0.305), [0, 0.1, 0.2, 0.3, 0.4])
        self.assertEqual(plots.linear_ticks(-3, 17, 5), [-5, 0, 5, 10, 15, 20])

    def test_any_linear_range(self):
        source = random.Random(1)
        for _ in range(500):
            low = source.uniform(-1, 1) * 10 ** source.uniform(-6, 6)
            high = low + 10 ** source.uniform(-3, 6) * abs(low)
            ticks = plots.linear_ticks(low, high)
            self.assertLessEqual(ticks[0], low + 1e-6 * (high - low))
            self.assertGreaterEqual(ticks[-1], high - 1e-6 * (high - low))
            self.assertTrue(2 <= len(ticks) <= 9, (low, high, ticks))
            self.assertEqual(ticks, sorted(set(ticks)))

    def test_one_value_has_a_range(self):
        for value in (0, 5, -2):
            ticks = plots.linear_ticks(value, value)
            self.assertLess(ticks[0], ticks[-1])
        self.assertLess(plots.log_ticks(3, 3)[0][0], plots.log_ticks(3, 3)[-1][0])

    def test_log_ticks(self):
        labelled = [v for v, shown in plots.log_ticks(0.019, 0.305) if shown]
        for got, expected in zip(labelled, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5), strict=True):
            self.assertAlmostEqual(got, expected)
        labelled = [v for v, shown in plots.log_ticks(1e-5, 1) if shown]
        self.assertEqual([round(math.log10(v)) for v in labelled], [-5, -4, -3, -2, -1, 0])

    def test_numbers(self):
        expected = {0: "0", 0.1 + 0.2: "0.3", 1e-5: "10⁻⁵", 2.5e6: "2.5·10⁶", 15000: "15 000", -3: "−3", 200: "200"}
        for value, text in expected.items():
            self.assertEqual(plots.format_number(value), text)


class Svg(unittest.TestCase):
    EVIL = '<b a="1">&\''

    def texts(self, svg):
        root = ElementTree.fromstring(svg)
        return [e.text for e in root.iter("{http://www.w3.org/2000/svg}text")]

    def test_text_is_escaped(self):
        svg = plots.line_plot([{"name": self.EVIL, "x": [1, 2], "y": [3, 4]}, {"name": "b", "x": [1], "y": [2]}],
                              self.EVIL, self.EVIL, self.EVIL)
        self.assertEqual(self.texts(svg).count(self.EVIL), 4)
        svg = plots.bar_chart([self.EVIL], [{"name": self.EVIL, "values": [1]}, {"name": "b", "values": [2]}], self.EVIL,
                              self.EVIL)
        self.assertEqual(self.texts(svg).count(self.EVIL), 4)

    def test_points_stay_inside(self):
        series = [{"name": "a", "x": [0.019, 0.066, 0.305], "y": [1e-3, None, 1e-1], "dash": True},
                  {"name": "b", "x": [0, 0.1], "y": [5, 0.01], "marker": "none"}]
        svg = plots.line_plot(series, "t", "x", "y", x_log=True, y_log=True)
        root = ElementTree.fromstring(svg)
        for circle in root.iter("{http://www.w3.org/2000/svg}circle"):
            self.assertTrue(0 < float(circle.get("cx")) < 720 and 0 < float(circle.get("cy")) < 430)
        self.assertNotIn("nan", svg)

    def test_lengths_must_agree(self):
        with self.assertRaisesRegex(ValueError, "series 'a'"):
            plots.line_plot([{"name": "a", "x": [1], "y": []}], "t", "x", "y")


class CodecPlot(unittest.TestCase):
    @staticmethod
    def row(figure, codec, target, value, **more):
        return {"value": value, "labels": {"data": "a b", "figure": figure, "codec": codec, "target": target}, **more}

    def test_draws_what_the_benchmark_says(self):
        rows = [self.row("size", "A", "0.01", 0.01), self.row("size", "A", "0.001", 0.1),
                self.row("size", "B", "0.01", 0.3), self.row("size", "B", "0.001", 0.3),
                self.row("relative RMS", "A", "0.01", 0.0098), self.row("relative RMS", "A", "0.001", 0.00099),
                self.row("relative RMS", "B", "0.001", 0, note="at every target"),
                {"value": None, "labels": {"data": "a b", "figure": "missing", "codec": "C"}, "note": "not measured"}]
        self.assertEqual(codec_plot.curves(rows), {"a b": {"A": [(0.01, 0.0098, 0.01), (0.001, 0.00099, 0.1)],
                                                           "B": [(0.01, None, 0.3), (0.001, None, 0.3)]}})
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            codec_plot.main([folder], io.StringIO(json.dumps({"benchmarks": [{"rows": rows}]})))
            svg = (pathlib.Path(folder) / "a_b.svg").read_text(encoding="utf-8")
        for part in ("a b", "A", "B (fixed)", "relative RMS error", "stroke-dasharray"):
            self.assertIn(part, svg)
        self.assertEqual(svg.count("A: "), 2)

    def test_refuses_what_has_no_sizes(self):
        with self.assertRaisesRegex(SystemExit, "no sizes"):
            codec_plot.main(["nowhere"], io.StringIO('{"benchmarks": []}'))


if __name__ == "__main__":
    unittest.main()
