#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Plots as SVG text, with the standard library alone.

    line_plot(series, title, x_label, y_label, x_log=False, y_log=False, ...) -> str
    bar_chart(labels, series, title, x_label, ...) -> str

A series is a mapping: `name`, `x` and `y` (numbers; None leaves a gap), optionally `dash` (true for a dashed line),
`color` (an index or a CSS colour) and `marker` (circle, square, triangle, diamond; "none" for none). Series that
belong together can so share a colour and differ in dash and marker. In a bar chart `values` stands instead of x and y.

The SVG scales to the width it is given. It is light by itself; a page that sets the CSS variables --plot-ink,
--plot-quiet, --plot-grid, --plot-paper and --plot-0 .. --plot-6 recolours it, for a dark mode for instance.
"""
import html
import math

# Okabe and Ito's colours, told apart with any colour vision; black and yellow left out, the order by contrast.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#6B6B6B")
MARKERS = ("circle", "square", "triangle", "diamond")
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Liberation Sans', sans-serif"
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "−"


def text_width(text, size):
    """About how wide `text` is in a sans-serif font of `size`."""
    narrow = sum(text.count(c) for c in "iljtfr.,:;'|!()[] ")
    return size * (0.58 * (len(text) - narrow) + 0.32 * narrow)


def linear_ticks(low, high, count=6):
    """About `count` round numbers that cover low..high: the first at most `low`, the last at least `high`."""
    if not high > low:
        low, high = low - (abs(low) or 1) / 2, low + (abs(low) or 1) / 2
    rough = (high - low) / max(1, count - 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next((m * power for m in (1, 2, 2.5, 5, 10) if m * power >= rough * (1 - 1e-9)), 10 * power)
    first = math.floor(low / step + 1e-9)
    last = math.ceil(high / step - 1e-9)
    return [round(i * step, 12 - math.floor(math.log10(step))) for i in range(first, last + 1)]


def log_ticks(low, high):
    """Ticks (value, labelled) that cover low..high, both > 0: the range begins and ends at the outer ones."""
    decades = math.log10(high / low) if high > low else 0
    steps = (1, 2, 5) if decades < 2.2 else (1,)
    candidates = [m * 10.0 ** e
                  for e in range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 2)
                  for m in (1, 2, 3, 4, 5, 6, 7, 8, 9)]
    labelled = [v for e, v in ((round(v / 10.0 ** math.floor(math.log10(v) + 1e-9)), v) for v in candidates) if e in steps]
    begin = max(v for v in labelled if v <= low * (1 + 1e-9))
    end = min(v for v in labelled if v >= high * (1 - 1e-9) and v > begin * (1 + 1e-9))
    inside = [v for v in candidates if begin * (1 - 1e-9) <= v <= end * (1 + 1e-9)]
    return [(v, any(math.isclose(v, w) for w in labelled)) for v in inside]


def format_number(value):
    """Short, without float noise: 0.05, 1 500, 10⁻⁵."""
    if value == 0:
        return "0"
    size = abs(value)
    if size < 1e-4 or size >= 1e6:
        exponent = math.floor(math.log10(size) + 1e-9)
        mantissa = value / 10.0 ** exponent
        power = "10" + str(exponent).translate(SUPERSCRIPTS)
        text = power if math.isclose(mantissa, 1) else f"{mantissa:.3g}·{power}"
    elif size >= 1e4:
        text = f"{value:,.0f}".replace(",", " ")
    else:
        text = f"{value:.4g}"
    return text.replace("-", MINUS)


class Axis:
    """Maps values to pixels and knows its ticks."""

    def __init__(self, values, log, limits, count):
        values = [v for v in values if v is not None and math.isfinite(v) and (v > 0 or not log)]
        low, high = (min(values), max(values)) if values else (1.0, 10.0)
        if limits:
            low, high = limits
        self.log = log
        if log:
            self.ticks = log_ticks(low, high)
        else:
            self.ticks = [(v, True) for v in linear_ticks(low, high, count)]
        self.low, self.high = self.ticks[0][0], self.ticks[-1][0]

    def place(self, begin, end):
        self.begin, self.end = begin, end

    def usable(self, value):
        return value is not None and math.isfinite(value) and (value > 0 or not self.log)

    def at(self, value):
        if self.log:
            share = math.log(value / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)


class Drawing:
    """Collects SVG elements; colours are roles or indices of series, so that a page can restyle them."""

    ROLES = {"ink": "#1f2328", "quiet": "#59636e", "grid": "#e3e6ea", "paper": "#ffffff"}

    def __init__(self, width, height, title):
        self.width, self.height, self.title = width, height, title
        self.parts = []

    @classmethod
    def color(cls, role):
        if isinstance(role, int):
            index = role % len(COLORS)
            return f"var(--plot-{index}, {COLORS[index]})"
        return f"var(--plot-{role}, {cls.ROLES[role]})" if role in cls.ROLES else html.escape(role, quote=True)

    def line(self, x1, y1, x2, y2, role, width=1.0):
        self.parts.append(f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" '
                          f'style="stroke:{self.color(role)};stroke-width:{width}"/>')

    def text(self, x, y, text, role="quiet", size=13, anchor="start", weight=400, turn=0):
        turned = f' transform="rotate({turn} {x:.1f} {y:.1f})"' if turn else ""
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{turned} style="fill:{self.color(role)};'
                          f'font-size:{size}px;font-weight:{weight}">{html.escape(text)}</text>')

    def path(self, points, role, dash=False):
        steps = " ".join(f"{'L' if i else 'M'}{x:.1f} {y:.1f}" for i, (x, y) in enumerate(points))
        dashes = ";stroke-dasharray:6 5" if dash else ""
        self.parts.append(f'<path d="{steps}" style="fill:none;stroke:{self.color(role)};stroke-width:2.2;'
                          f'stroke-linejoin:round;stroke-linecap:round{dashes}"/>')

    def marker(self, x, y, kind, role, tip=""):
        shapes = {"circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.4"',
                  "square": f'<rect x="{x - 4:.1f}" y="{y - 4:.1f}" width="8" height="8" rx="1"',
                  "triangle": f'<path d="M{x:.1f} {y - 5.4:.1f}l5.2 9.2h-10.4z"',
                  "diamond": f'<path d="M{x:.1f} {y - 5.8:.1f}l5.4 5.8l-5.4 5.8l-5.4 -5.8z"'}
        inner = f"<title>{html.escape(tip)}</title>" if tip else ""
        self.parts.append(f'{shapes[kind]} style="fill:{self.color(role)};stroke:{self.color("paper")};stroke-width:1.4">'
                          f'{inner}</{"circle" if kind == "circle" else "rect" if kind == "square" else "path"}>')

    def bar(self, x, y, width, height, role, tip=""):
        self.parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{max(0.0, width):.1f}" height="{height:.1f}" rx="2" '
                          f'style="fill:{self.color(role)}"><title>{html.escape(tip)}</title></rect>')

    def svg(self):
        name = html.escape(self.title, quote=True)
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" role="img" '
                f'aria-label="{name}" style="width:100%;max-width:{self.width}px;height:auto;display:block;'
                f'font-family:{html.escape(FONT, quote=True)}">'
                f'<rect width="{self.width}" height="{self.height}" style="fill:{self.color("paper")}"/>'
                + "".join(self.parts) + "</svg>")


def appearance(series):
    """(colour, marker, dash) of each series, as stated or in turn."""
    looks = []
    for index, one in enumerate(series):
        looks.append((one.get("color", index), one.get("marker", MARKERS[index % len(MARKERS)]), bool(one.get("dash"))))
    return looks


def draw_legend(drawing, names, looks, left, right, y):
    """Entries side by side from `left`, in as many rows as they need; returns the y below them."""
    if len(names) < 2:
        return y
    x = left
    for name, (color, marker, dash) in zip(names, looks):
        width = 34 + text_width(name, 13) + 22
        if x > left and x + width - 22 > right:
            x, y = left, y + 22
        if marker == "bar":
            drawing.bar(x + 10, y - 6, 16, 12, color)
        else:
            drawing.path([(x, y), (x + 26, y)], color, dash)
            if marker != "none":
                drawing.marker(x + 13, y, marker, color)
        drawing.text(x + 34, y + 4.5, name, "ink")
        x += width
    return y + 20


def draw_axes(drawing, x, y, x_label, y_label):
    for value, labelled in y.ticks:
        drawing.line(x.begin, y.at(value), x.end, y.at(value), "grid", 1.0 if labelled else 0.5)
        if labelled:
            drawing.text(x.begin - 9, y.at(value) + 4.5, format_number(value), anchor="end")
    for value, labelled in x.ticks:
        drawing.line(x.at(value), y.begin, x.at(value), y.end, "grid", 1.0 if labelled else 0.5)
        if labelled:
            drawing.text(x.at(value), y.begin + 20, format_number(value), anchor="middle")
    drawing.line(x.begin, y.begin, x.end, y.begin, "quiet", 1.2)
    drawing.text((x.begin + x.end) / 2, y.begin + 44, x_label, "ink", anchor="middle")
    drawing.text(18, (y.begin + y.end) / 2, y_label, "ink", anchor="middle", turn=-90)


def line_plot(series, title, x_label, y_label, x_log=False, y_log=False, x_range=None, y_range=None,
              width=720, height=430):
    """Lines with markers. Axis titles should name the unit; `x_range` and `y_range` are (low, high) to be covered.
    Values that a logarithmic axis cannot show are left out."""
    for one in series:
        if len(one["x"]) != len(one["y"]):
            raise ValueError(f"series '{one['name']}': {len(one['x'])} x values, but {len(one['y'])} y values")
    drawing = Drawing(width, height, title)
    looks = appearance(series)
    x = Axis([v for one in series for v in one["x"]], x_log, x_range, 7)
    y = Axis([v for one in series for v in one["y"]], y_log, y_range, 6)
    widest = max(text_width(format_number(v), 13) for v, labelled in y.ticks if labelled)
    left, right = 46 + widest, width - 22
    drawing.text(14, 28, title, "ink", 16, weight=600)
    top = draw_legend(drawing, [one["name"] for one in series], looks, 14, right, 52) + 4
    x.place(left, right)
    y.place(height - 60, top)
    draw_axes(drawing, x, y, x_label, y_label)
    for one, (color, marker, dash) in zip(series, looks):
        run, runs = [], []
        for vx, vy in zip(one["x"], one["y"]):
            if x.usable(vx) and y.usable(vy):
                run.append((vx, vy))
            elif run:
                runs.append(run)
                run = []
        for run in filter(None, runs + [run]):
            drawing.path([(x.at(vx), y.at(vy)) for vx, vy in run], color, dash)
            for vx, vy in run if marker != "none" else ():
                tip = f"{one['name']}: {format_number(vx)}, {format_number(vy)}"
                drawing.marker(x.at(vx), y.at(vy), marker, color, tip)
    return drawing.svg()


def bar_chart(labels, series, title, x_label, width=720, x_range=None):
    """Horizontal bars from 0, one group for each label; `series` are mappings with `name` and `values` (>= 0)."""
    for one in series:
        if len(one["values"]) != len(labels):
            raise ValueError(f"series '{one['name']}': {len(one['values'])} values, but {len(labels)} labels")
    looks = [(one.get("color", index), "bar", False) for index, one in enumerate(series)]
    thick, gap = (22, 16) if len(series) == 1 else (17, 18)
    group = thick * len(series) + gap
    legend = Drawing(width, 0, "")
    top = draw_legend(legend, [one["name"] for one in series], looks, 14, width - 22, 54) + 2
    height = round(top + group * len(labels) + 62)
    drawing = Drawing(width, height, title)
    drawing.parts = legend.parts
    drawing.text(14, 28, title, "ink", 16, weight=600)
    x = Axis([0] + [v for one in series for v in one["values"]], False, x_range, 6)
    left = min(0.45 * width, 26 + max(text_width(label, 13) for label in labels))
    x.place(left, width - 70)
    bottom = top + group * len(labels)
    for value, _ in x.ticks:
        drawing.line(x.at(value), top, x.at(value), bottom, "grid")
        drawing.text(x.at(value), bottom + 20, format_number(value), anchor="middle")
    for row, label in enumerate(labels):
        y = top + row * group + gap / 2
        drawing.text(left - 10, y + thick * len(series) / 2 + 4.5, label, "ink", anchor="end")
        for index, (one, (color, _, _)) in enumerate(zip(series, looks)):
            value = one["values"][row]
            if value is None:
                continue
            tip = f"{one['name']}, {label}: {format_number(value)}"
            drawing.bar(x.at(0), y + index * thick, x.at(value) - x.at(0), thick - 2, color, tip)
            drawing.text(x.at(value) + 6, y + index * thick + thick / 2 + 3.5, format_number(value), "ink", 12)
    drawing.line(left, top, left, bottom, "quiet", 1.2)
    drawing.text((left + width - 70) / 2, bottom + 44, x_label, "ink", anchor="middle")
    return drawing.svg()
