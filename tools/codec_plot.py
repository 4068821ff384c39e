#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Draws size against error from what the benchmark says: `volute bench codec --json | tools/codec_plot.py FOLDER`.

One FOLDER/DATA.svg for each volume that was measured.
"""
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import plots

# Viridis for what has an error to choose, plasma for what has none; both without their ends too pale for white.
COLORS = ("#440154", "#414487", "#2a788e", "#22a884", "#7ad151")
FIXED_COLORS = ("#b12a90", "#e16462", "#f1993b")


def curves(rows):
    """{data: {codec: [(target, relative RMS, size), ..]}}; the RMS is None where it cannot be chosen."""
    sizes, errors = {}, {}
    for row in rows:
        labels = row.get("labels", {})
        key = tuple(labels.get(name) for name in ("data", "codec", "target"))
        if labels.get("figure") == "size":
            sizes[key] = row["value"]
        elif labels.get("figure") == "relative RMS" and "note" not in row:
            errors[key] = row["value"]
    result = {}
    for (data, codec, target), size in sizes.items():
        result.setdefault(data, {}).setdefault(codec, []).append(
            (float(target), errors.get((data, codec, target)), size))
    return result


def series_of(codecs):
    """Lines with markers through what was reached; dashed ones at the size of what is (nearly) lossless as it is."""
    errors = [error for points in codecs.values() for _, error, _ in points if error] or [1e-3]
    ticks = [tick for tick, _ in plots.log_ticks(min(errors), max(errors))]
    chosen, fixed = [], []
    for codec, points in codecs.items():
        points = sorted(points)
        if any(error is not None for _, error, _ in points):
            chosen.append({"name": codec, "color": COLORS[len(chosen) % len(COLORS)],
                           "marker": plots.MARKERS[len(chosen) % len(plots.MARKERS)],
                           "x": [error for _, error, _ in points], "y": [size for _, _, size in points]})
        else:
            size = points[0][2]
            fixed.append({"name": f"{codec} (fixed)", "color": FIXED_COLORS[len(fixed) % len(FIXED_COLORS)],
                          "marker": "none", "dash": True, "x": [ticks[0], ticks[-1]], "y": [size, size]})
    return chosen + fixed


def draw(data, codecs):
    return plots.line_plot(series_of(codecs), f"Size of files against their error: {data}",
                           "relative RMS error [share of the value range]", "size [share of raw float32]",
                           x_log=True, y_log=True)


def main(arguments, stream):
    if len(arguments) != 1:
        sys.exit("codec_plot: expected one FOLDER, and the output of `volute bench codec --json` on standard input")
    folder = pathlib.Path(arguments[0])
    rows = [row for benchmark in json.load(stream)["benchmarks"] for row in benchmark["rows"]]
    drawn = curves(rows)
    if not drawn:
        sys.exit("codec_plot: no sizes in the input; expected the output of `volute bench codec --json`")
    folder.mkdir(parents=True, exist_ok=True)
    for data, codecs in drawn.items():
        path = folder / (re.sub(r"[^\w.-]+", "_", data) + ".svg")
        path.write_text(draw(data, codecs), encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main(sys.argv[1:], sys.stdin)
