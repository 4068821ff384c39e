#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Builds the demo's page: `demo_page.py FOLDER` reads FOLDER/results.json and writes FOLDER/index.html.

The page is one static file without external resources; pictures and films stay files beside it. results.json:

    {"title": "..",                         required
     "subtitle": "..",                      one line below it
     "intro": "..",                         a paragraph, or a list of paragraphs
     "footer": "..",
     "sections": [{
        "title": "..",                      required
        "id": "..",                         anchor; made from the title when missing
        "text": "..",                       a paragraph, or a list of paragraphs
        "facts": [{"value": "41 : 1", "label": "raw to compressed"}],
        "figures": [{
            "file": "fire.png",             required; relative to FOLDER. .mp4 and .webm are films
            "caption": "..",                states units, scale and mode
            "label": "0.066",               a short title above the caption
            "alt": "..",                    for people who cannot see it; the caption when missing
            "poster": "fire.png"}],         films only
        "columns": 2,                       figures side by side on a wide screen, 1..6 (default: at most 3)
        "tables": [{
            "caption": "..",
            "columns": ["name", ..],        required
            "rows": [["fire", 1.5, ..]]}],  required; columns of numbers are right-aligned, null is a dash
        "plots": [{
            "kind": "line" | "bar",         line when missing
            "caption": "..",
            ...}]}]}                        the arguments of plots.line_plot or plots.bar_chart by name

Within a section the order is text, facts, figures, plots, tables. All text is plain; `code` in backquotes is set so.
"""
import html
import json
import os
import pathlib
import re
import struct
import sys
import tempfile
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import plots

FILMS = {".mp4": "video/mp4", ".webm": "video/webm"}
PICTURES = (".png", ".jpg", ".jpeg", ".svg", ".webp")

STYLE = """
:root { color-scheme: light dark; --ink: #1f2328; --quiet: #59636e; --rule: #d8dde3; --paper: #ffffff; --panel: #f6f7f9;
  --accent: #b4440e; --plot-paper: transparent; --plot-ink: var(--ink); --plot-quiet: var(--quiet); --plot-grid: #e3e6ea; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8eaed; --quiet: #9aa4af; --rule: #343b44; --paper: #0f1216; --panel: #171b21; --accent: #ff9a5c;
    --plot-grid: #2b323b; --plot-0: #4ea8e6; --plot-1: #ff8345; --plot-2: #2fc49a; --plot-3: #e39cc4; --plot-4: #f2b736;
    --plot-5: #86cdf5; --plot-6: #a8b0b9; } }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 17px/1.6 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; }
header, main, footer { max-width: 1120px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 72px; }
h1 { font-size: clamp(2.2rem, 5.5vw, 3.4rem); line-height: 1.08; letter-spacing: -0.025em; margin: 0 0 12px; }
.subtitle { font-size: 1.25rem; line-height: 1.45; color: var(--quiet); margin: 0 0 24px; max-width: 44rem; }
nav { display: flex; flex-wrap: wrap; gap: 6px 22px; border-block: 1px solid var(--rule); padding: 12px 0; margin: 32px 0 0;
  font-size: 0.94rem; }
nav a { color: var(--quiet); text-decoration: none; }
nav a:hover, nav a:focus-visible { color: var(--accent); text-decoration: underline; text-underline-offset: 4px; }
section { padding-top: 56px; }
h2 { font-size: 1.7rem; line-height: 1.2; letter-spacing: -0.015em; margin: 0 0 12px; }
p { margin: 0 0 14px; max-width: 44rem; text-wrap: pretty; }
code { font: 0.88em ui-monospace, "SF Mono", Menlo, "Liberation Mono", monospace; background: var(--panel);
  border-radius: 4px; padding: 0.1em 0.35em; overflow-wrap: anywhere; }
.facts { display: flex; flex-wrap: wrap; gap: 20px 48px; margin: 22px 0 28px; padding: 0; }
.facts div { min-width: 7rem; }
.facts dt { font-size: 0.9rem; color: var(--quiet); }
.facts dd { margin: 0; font-size: 1.8rem; line-height: 1.2; font-weight: 650; letter-spacing: -0.02em;
  font-variant-numeric: tabular-nums; }
.facts div { display: flex; flex-direction: column-reverse; }
.grid { display: grid; gap: 24px; margin: 24px 0; grid-template-columns: minmax(0, 1fr); align-items: start; }
figure { margin: 0; min-width: 0; }
figure img, figure video { display: block; width: 100%; height: auto; border-radius: 8px; background: #000; }
figcaption { font-size: 0.9rem; line-height: 1.5; color: var(--quiet); margin-top: 10px; }
figcaption b { display: block; color: var(--ink); font-weight: 600; }
.plots { display: grid; gap: 24px; margin: 24px 0; grid-template-columns: minmax(0, 1fr); }
.plot { border: 1px solid var(--rule); border-radius: 10px; padding: 14px 14px 16px; }
.plot > div { overflow-x: auto; }
.plot svg { min-width: 440px; max-width: none !important; }
.plot figcaption { padding: 0 14px; }
.table { margin: 24px 0; overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 0.95rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-size: 0.9rem; color: var(--quiet); padding-bottom: 10px; }
th, td { text-align: left; padding: 9px 28px 9px 0; border-bottom: 1px solid var(--rule); vertical-align: baseline; }
th { font-weight: 600; font-size: 0.88rem; color: var(--quiet); border-bottom-color: var(--quiet); }
.number { text-align: right; white-space: nowrap; }
th:last-child, td:last-child { padding-right: 0; }
footer { color: var(--quiet); font-size: 0.9rem; padding-top: 40px; padding-bottom: 56px; margin-top: 64px; }
footer p { border-top: 1px solid var(--rule); padding-top: 20px; max-width: none; }
@media (min-width: 620px) { .grid { grid-template-columns: repeat(min(2, var(--columns)), minmax(0, 1fr)); } }
@media (min-width: 900px) { .grid { grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); }
  .plots { grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); align-items: start; }
  .plots:has(> :only-child) { max-width: 820px; } }
@media (max-width: 620px) { header { padding-top: 40px; } header, main, footer { padding-left: 18px; padding-right: 18px; }
  section { padding-top: 44px; } .plot { padding-left: 0; padding-right: 0; } }
@media print { nav { display: none; } section { break-inside: avoid-page; } }
"""

# Films play while they are seen, unless the reader asked for less motion.
SCRIPT = """
if (!matchMedia("(prefers-reduced-motion: reduce)").matches && "IntersectionObserver" in window) {
  const seen = new IntersectionObserver(entries => entries.forEach(({target, isIntersecting}) =>
    isIntersecting ? target.play().catch(() => {}) : target.pause()), {threshold: 0.4});
  document.querySelectorAll("video").forEach(video => seen.observe(video));
}
"""


class BadResults(Exception):
    """One sentence: where in results.json, and what is expected."""


def text(value):
    """Escaped, with `code` set as such."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(str(value), quote=False))


def attribute(value):
    return html.escape(str(value), quote=True)


def paragraphs(value):
    values = [value] if isinstance(value, str) else value or []
    return "".join(f"<p>{text(one)}</p>" for one in values)


def need(mapping, key, where):
    if not isinstance(mapping, dict) or key not in mapping:
        raise BadResults(f"{where}: '{key}' is missing")
    return mapping[key]


def anchor(section):
    return section.get("id") or re.sub(r"[^a-z0-9]+", "-", section["title"].lower()).strip("-") or "section"


def image_size(path):
    """(width, height) of a PNG, so that the page does not jump while it loads; None for anything else."""
    with open(path, "rb") as file:
        head = file.read(24)
    if len(head) == 24 and head[:8] == b"\x89PNG\r\n\x1a\n":
        return struct.unpack(">II", head[16:24])
    return None


class Page:
    def __init__(self, folder, results):
        self.folder = pathlib.Path(folder)
        self.results = results

    def local(self, name, where):
        """The path of a file in the folder, which must exist."""
        path = self.folder / name
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise BadResults(f"{where}: '{name}' is outside of {self.folder}")
        if not path.is_file():
            raise BadResults(f"{where}: there is no file '{name}' in {self.folder}")
        return path

    def figure(self, figure, where):
        name = need(figure, "file", where)
        path = self.local(name, where)
        link = attribute(urllib.parse.quote(name))
        alt = attribute(figure.get("alt") or figure.get("caption") or figure.get("label") or name)
        kind = path.suffix.lower()
        if kind in FILMS:
            poster, size = "", None
            if "poster" in figure:
                size = image_size(self.local(figure["poster"], where))
                poster = f' poster="{attribute(urllib.parse.quote(figure["poster"]))}"'
            load = "none" if poster else "metadata"
            body = (f'<video controls loop muted playsinline preload="{load}"{poster}{self.measure(size)} '
                    f'aria-label="{alt}"><source src="{link}" type="{FILMS[kind]}"></video>')
        elif kind in PICTURES:
            body = f'<img src="{link}" alt="{alt}" loading="lazy"{self.measure(image_size(path))}>'
        else:
            expected = ", ".join(PICTURES + tuple(FILMS))
            raise BadResults(f"{where}: '{name}' is neither a picture nor a film; expected one of {expected}")
        return f"<figure>{body}{self.caption(figure)}</figure>"

    @staticmethod
    def measure(size):
        return f' width="{size[0]}" height="{size[1]}"' if size else ""

    @staticmethod
    def caption(thing):
        label = f"<b>{text(thing['label'])}</b>" if thing.get("label") else ""
        return f"<figcaption>{label}{text(thing.get('caption', ''))}</figcaption>" if label or thing.get("caption") else ""

    def plot(self, plot, where):
        arguments = {key: value for key, value in plot.items() if key not in ("kind", "caption", "label")}
        draw = {"line": plots.line_plot, "bar": plots.bar_chart}.get(plot.get("kind", "line"))
        if draw is None:
            raise BadResults(f"{where}: kind '{plot['kind']}' is unknown; expected line or bar")
        try:
            return f'<figure class="plot"><div>{draw(**arguments)}</div>{self.caption(plot)}</figure>'
        except (TypeError, ValueError, KeyError) as error:
            raise BadResults(f"{where}: {error}") from error

    @staticmethod
    def table(table, where):
        columns, rows = need(table, "columns", where), need(table, "rows", where)
        for index, row in enumerate(rows):
            if len(row) != len(columns):
                raise BadResults(f"{where}.rows[{index}]: {len(row)} cells; expected {len(columns)}, one for each column")
        numeric = [any(re.match(r"[-+−]?\.?\d", str(row[i])) for row in rows) for i in range(len(columns))]

        def cell(value, column, tag):
            if isinstance(value, int):
                value = f"{value:,}".replace(",", "\u202f")  # a narrow space
            elif isinstance(value, float):
                value = plots.format_number(value)
            shown = "–" if value is None else text(value)
            return f"<{tag}{' class=number' if numeric[column] else ''}>{shown}</{tag}>"

        caption = f"<caption>{text(table['caption'])}</caption>" if table.get("caption") else ""
        head = "".join(cell(name, i, "th") for i, name in enumerate(columns))
        body = "".join("<tr>" + "".join(cell(v, i, "td") for i, v in enumerate(row)) + "</tr>" for row in rows)
        return f'<div class="table"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'

    def section(self, section, where):
        title = need(section, "title", where)
        parts = [f'<section id="{attribute(anchor(section))}"><h2>{text(title)}</h2>', paragraphs(section.get("text"))]
        if section.get("facts"):
            facts = "".join(f"<div><dt>{text(need(fact, 'label', f'{where}.facts[{i}]'))}</dt>"
                            f"<dd>{text(need(fact, 'value', f'{where}.facts[{i}]'))}</dd></div>"
                            for i, fact in enumerate(section["facts"]))
            parts.append(f'<dl class="facts">{facts}</dl>')
        figures = [self.figure(one, f"{where}.figures[{i}]") for i, one in enumerate(section.get("figures", []))]
        if figures:
            columns = int(section.get("columns", min(3, len(figures))))
            parts.append(f'<div class="grid" style="--columns:{columns}">{"".join(figures)}</div>')
        drawn = [self.plot(one, f"{where}.plots[{i}]") for i, one in enumerate(section.get("plots", []))]
        if drawn:
            parts.append(f'<div class="plots" style="--columns:{min(2, len(drawn))}">{"".join(drawn)}</div>')
        parts += [self.table(one, f"{where}.tables[{i}]") for i, one in enumerate(section.get("tables", []))]
        return "".join(parts) + "</section>"

    def html(self):
        results = self.results
        title = need(results, "title", "results.json")
        sections = [self.section(one, f"sections[{i}]") for i, one in enumerate(results.get("sections", []))]
        links = "".join(f'<a href="#{attribute(anchor(one))}">{text(one["title"])}</a>' for one in results.get("sections", []))
        subtitle = f'<p class="subtitle">{text(results["subtitle"])}</p>' if results.get("subtitle") else ""
        footer = f'<footer><p>{text(results["footer"])}</p></footer>' if results.get("footer") else ""
        return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
                f'content="width=device-width, initial-scale=1"><title>{text(title)}</title><link rel="icon" href="data:,">'
                f"<style>{STYLE}</style></head>\n<body><header><h1>{text(title)}</h1>{subtitle}"
                f'{paragraphs(results.get("intro"))}<nav aria-label="Sections">{links}</nav></header>\n<main>'
                + "\n".join(sections) + f"</main>\n{footer}<script>{SCRIPT}</script></body></html>\n")


def build(folder):
    """Writes FOLDER/index.html, whole or not at all, and returns its path."""
    folder = pathlib.Path(folder)
    try:
        results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    except OSError as error:
        raise BadResults(f"{folder / 'results.json'}: {error.strerror}") from error
    except ValueError as error:
        raise BadResults(f"{folder / 'results.json'}: {error}") from error
    page = Page(folder, results).html()
    handle, temporary = tempfile.mkstemp(dir=folder, prefix=".index", suffix=".html")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(page)
        os.chmod(temporary, 0o644)
        os.replace(temporary, folder / "index.html")
    except OSError:
        os.unlink(temporary)
        raise
    return folder / "index.html"


def main(arguments):
    if len(arguments) != 1:
        print("usage: demo_page.py FOLDER", file=sys.stderr)
        return 2
    try:
        print(build(arguments[0]))
    except (BadResults, OSError) as error:
        print(f"demo_page: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
