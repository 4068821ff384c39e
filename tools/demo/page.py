# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Writes the demo's page of what is made so far: one static file; pictures and films stay files beside it."""
import html
import json
import os
import pathlib
import re
import shlex
import struct
import sys
import tempfile
import time
import urllib.parse

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import plots
from plan import Build, Choice, Command, Drawn, Fact, Picture, Wipe
from state import NotYet

NBSP = "\u00a0"
FILMS = {".mp4": "video/mp4", ".webm": "video/webm"}
PICTURES = (".png", ".jpg", ".svg")
TITLE = "Volute"
SUBTITLE = "Fire, smoke and fog: compressed, reconstructed from cameras, rendered by exact line integrals, and how far a person sees through them"


def is_shown(file):
    return pathlib.PurePath(file).suffix in (*FILMS, *PICTURES)


def files_of(part):
    """The files that a part of a section shows or names."""
    if isinstance(part, Choice):
        return [file for file, _ in part.files]
    if isinstance(part, Wipe):
        return [part.left[0], part.right[0]]
    if isinstance(part, Picture):
        return [part.file, *filter(None, [part.poster])]
    if isinstance(part, Command):
        return [part.file]
    return []


def text(value):
    """Escaped; `code` in backquotes and [words](file) are set as such."""
    escaped = html.escape(str(value), quote=False)
    escaped = re.sub(r"`([^`]+)`", r"<code>\1</code>", escaped)
    return re.sub(r"\[([^\]]+)\]\(([^)]+)\)", lambda m: link(html.unescape(m[2]), m[1]), escaped)


def attribute(value):
    return html.escape(str(value), quote=True)


def link(file, words):
    """`words` are HTML."""
    return f'<a href="{attribute(urllib.parse.quote(file))}">{words}</a>'


def anchor(*titles):
    return "-".join(re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") for title in titles)


def image_size(path):
    """(width, height) of a PNG, so that the page does not jump while it loads; None for anything else."""
    with open(path, "rb") as file:
        head = file.read(24)
    if len(head) == 24 and head[:8] == b"\x89PNG\r\n\x1a\n":
        return struct.unpack(">II", head[16:24])
    return None


def copyable(command):
    """Lines break between an option with its value and the next one, not within."""
    groups = re.split(r" (?=-)", command)
    shown = " ".join(f"<span>{html.escape(group, quote=False)}</span>" for group in groups)
    return (f'<div class="command"><button type="button" aria-label="Copy the command">Copy</button>'
            f"<pre><code>{shown}</code></pre></div>")


class Page:
    def __init__(self, plan, state, ending, quick, failed, programs):
        """`ending` is None while the demo runs; then done, stopped or failed."""
        self.plan, self.state, self.ending, self.quick = plan, state, ending, quick
        self.failed, self.programs = failed, pathlib.Path(programs)
        self.done = {step.name for step in plan.steps if not isinstance(step, Build) and state.done(step)}

    def made(self, *files):
        return all(self.plan.step_of(file).name in self.done and (self.state.out / file).exists() for file in files)

    def say(self, value):
        """A text, or what a function makes of the results; nothing where they are still missing."""
        try:
            return text(value(self.state) if callable(value) else value)
        except NotYet:
            return ""

    # Pictures

    def provenance(self, file, hidden=False):
        """The command that made a file, and links to what it read and wrote."""
        step = self.plan.step_of(file)

        def links(files):
            return ", ".join(link(one, html.escape(one)) for one in files)

        if step.command:
            body = copyable(step.command)
            said = (f"Reads {links(step.reads)}. " if step.reads else "") + f"Writes {links(step.makes)}."
        else:
            source = pathlib.Path(sys.modules[step.work.__module__].__file__).name
            body = ""
            said = f"Made by tools/demo/{html.escape(source)} from {links(step.reads)}: {links(step.makes)}."
        return f'<div class="made"{" hidden" if hidden else ""}>{body}<p class="files">{said}</p></div>'

    def image(self, file, alt, more=""):
        size = image_size(self.state.out / file)
        measured = f' width="{size[0]}" height="{size[1]}"' if size else ""
        return f'<img src="{attribute(urllib.parse.quote(file))}" alt="{attribute(alt)}" loading="lazy"{measured}{more}>'

    def caption(self, part):
        return f"<figcaption><b>{text(part.label)}</b>{self.say(part.caption)}</figcaption>"

    def picture(self, part):
        suffix = pathlib.PurePath(part.file).suffix
        if suffix not in FILMS:
            return f"<figure>{self.image(part.file, part.label)}{self.caption(part)}{self.provenance(part.file)}</figure>"
        poster, measured = "", ""
        if part.poster and self.made(part.poster):
            size = image_size(self.state.out / part.poster)
            poster = f' poster="{attribute(urllib.parse.quote(part.poster))}"'
            measured = f' width="{size[0]}" height="{size[1]}"' if size else ""
        load = "none" if poster else "metadata"
        return (f'<figure><video controls loop muted playsinline preload="{load}"{poster}{measured} aria-label="{attribute(part.label)}">'
                f'<source src="{attribute(urllib.parse.quote(part.file))}" type="{FILMS[suffix]}"></video>'
                f"{self.caption(part)}{self.provenance(part.file)}</figure>")

    def choice(self, part):
        there = [(file, name) for file, name in part.files if self.made(file)]
        start = min(part.start, len(there) - 1)
        images = "".join(self.image(file, f"{part.label}: {name}",
                                    f' data-name="{attribute(name)}"' + (' class="shown"' if i == start else ""))
                         for i, (file, name) in enumerate(there))
        made = "".join(self.provenance(file, i != start) for i, (file, _) in enumerate(there))
        slider = (f'<label class="slide"><input type="range" min="0" max="{len(there) - 1}" value="{start}" aria-label="{attribute(part.label)}">'
                  f"<output>{html.escape(there[start][1])}</output></label>")
        return f'<figure><div class="stack">{images}</div>{slider}{self.caption(part)}{made}</figure>'

    def wipe(self, part):
        (left, left_name), (right, right_name) = part.left, part.right
        images = self.image(left, left_name) + self.image(right, right_name)
        slider = (f'<label class="slide"><span>{html.escape(left_name)}</span><input type="range" min="0" max="100" value="50" '
                  f'aria-label="{attribute(part.label)}"><span>{html.escape(right_name)}</span></label>')
        return (f'<figure><div class="stack wipe">{images}</div>{slider}{self.caption(part)}'
                f"{self.provenance(left)}{self.provenance(right)}</figure>")

    def figure(self, part):
        """HTML of a part that pictures something; empty until it is made."""
        if isinstance(part, Picture) and self.made(part.file):
            return self.picture(part)
        if isinstance(part, Choice) and any(self.made(file) for file, _ in part.files):
            return self.choice(part)
        if isinstance(part, Wipe) and self.made(part.left[0], part.right[0]):
            return self.wipe(part)
        if isinstance(part, Command) and self.made(part.file):
            return f'<figure{" class=wide" if part.wide else ""}><figcaption>{self.say(part.caption)}</figcaption>{self.provenance(part.file)}</figure>'
        return ""

    # Plots and tables

    def drawn(self, part):
        what = part.draw(self.state)
        if part.kind == "plot":
            caption = what.pop("caption", "")
            return (f'<figure class="plot"><div>{plots.line_plot(**what)}</div>'
                    + (f"<figcaption>{text(caption)}</figcaption>" if caption else "") + "</figure>")
        return table(what)

    # The page

    def section(self, chapter, section):
        parts = section.parts
        facts = [f"<div><dt>{text(part.label)}</dt><dd>{self.say(part.value)}</dd></div>"
                 for part in parts if isinstance(part, Fact) and self.made(*part.needs)]
        figures = "".join(filter(None, map(self.figure, parts)))
        shown = [self.drawn(part) for part in parts if isinstance(part, Drawn) and part.kind == "plot" and self.made(*part.needs)]
        tables = [self.drawn(part) for part in parts if isinstance(part, Drawn) and part.kind == "table" and self.made(*part.needs)]
        if not (facts or figures or shown or tables):
            return ""
        paragraphs = "".join(f"<p>{self.say(one)}</p>" for one in
                             ([section.text] if isinstance(section.text, str) else section.text))
        body = f"<h3>{text(section.title)}</h3>{paragraphs}"
        if facts:
            body += f'<dl class="facts">{"".join(facts)}</dl>'
        if figures:
            body += f'<div class="grid" style="--columns:{section.columns}">{figures}</div>'
        if shown:
            body += f'<div class="plots" style="--columns:{min(2, len(shown))}">{"".join(shown)}</div>'
        return f'<section class="section" id="{anchor(chapter.name, section.title)}">{body}{"".join(tables)}</section>'

    def missing(self, chapter):
        return [step for step in chapter.steps if not isinstance(step, Build) and step.name not in self.done]

    def chapter(self, chapter):
        sections = [(one.title, self.section(chapter, one)) for one in chapter.sections]
        links = "".join(f'<a href="#{anchor(chapter.name, title)}">{text(title)}</a>' for title, body in sections if body)
        left = self.missing(chapter)
        waiting = ""
        if left:
            broken = [step for step in left if step.name in self.failed]
            if broken and self.ending:
                waiting = "Could not be made: " + "; ".join(f"{step.name} ({self.failed[step.name][:300]})" for step in broken) + "."
            elif self.ending:
                steps = sum(not isinstance(step, Build) for step in chapter.steps)
                waiting = f"{len(left)} of {steps} steps of this chapter are missing; `{self.command()}` makes them."
            else:
                waiting = "The rest of this chapter is being made." if any(body for _, body in sections) else "Not started yet."
            waiting = f'<p class="waiting">{text(waiting)}</p>'
        return (f'<section class="chapter" id="{chapter.name}"><h2>{text(chapter.title)}</h2><p class="subtitle">{text(chapter.sentence)}</p>'
                f'<nav aria-label="{attribute(chapter.title)}">{links}</nav>{"".join(body for _, body in sections)}{waiting}</section>')

    def door(self, chapter):
        picture = next(filter(self.made, chapter.door), None)
        if picture:
            face = f'<img src="{attribute(urllib.parse.quote(picture))}" alt="">'
        else:
            face = f'<div class="soon">{"its pictures are not made yet" if self.ending else "its pictures are being made"}</div>'
        return f'<a class="door" href="#{chapter.name}">{face}<div><b>{text(chapter.title)}</b><span>{text(chapter.sentence)}</span></div></a>'

    def command(self):
        return "./dev demo --quick" if self.quick else "./dev demo"

    def status(self, stamp):
        steps = [step for step in self.plan.steps if not isinstance(step, Build)]
        made = f"{len(self.done)} of {len(steps)} steps are done."
        if self.ending is None:
            return (f'<div class="box" id="status" data-page="{stamp}"><p><b class="now">The demo is running</b></p>'
                    f'<progress max="{len(steps)}" value="{len(self.done)}"></progress><p class="rest">{made}</p></div>')
        if self.ending == "done":
            return ""
        lacking = [chapter.title for chapter in self.plan.chapters if self.missing(chapter)]
        why = "The demo was stopped." if self.ending == "stopped" else "Parts could not be made."
        return (f'<div class="box" id="status"><p><b>{why}</b> {made} Incomplete chapters: {html.escape("; ".join(lacking))}.</p>'
                f"<p>This command continues where it stopped:</p>{copyable(self.command())}</div>")

    def shell(self):
        words = f"cd {shlex.quote(str(self.state.out))} && export PATH={shlex.quote(str(self.programs))}:$PATH"
        return (f'<div class="box"><p>Each picture is shown with the command that made it. To try one, change to the folder of this page first, '
                f"then change the command as you like.</p>{copyable(words)}</div>")

    def html(self, stamp):
        doors = "".join(self.door(chapter) for chapter in self.plan.chapters if chapter.door)
        others = "".join(f'<p class="further">Below: <a href="#{chapter.name}">{text(chapter.title)}</a>. {text(chapter.sentence)}</p>'
                         for chapter in self.plan.chapters if not chapter.door)
        seconds = sum(self.state.seconds().get(name, 0) for name in self.done)
        size = "Sizes are those of the quick demo; without --quick, everything is larger. " if self.quick else ""
        script = (HERE / "script.js").read_text(encoding="utf-8")
        refresh = ""
        if self.ending is None:
            script += (HERE / "live.js").read_text(encoding="utf-8")
            refresh = '<noscript><meta http-equiv="refresh" content="15"></noscript>'
        style = (HERE / "style.css").read_text(encoding="utf-8")
        return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, '
                f'initial-scale=1"><title>{TITLE}</title>{refresh}<link rel="icon" href="data:,"><style>{style}</style></head>\n'
                f'<body><header><h1>{TITLE}</h1><p class="subtitle">{SUBTITLE}</p>{self.status(stamp)}<div class="doors">{doors}</div>'
                f'{others}{self.shell()}</header>\n<main>' + "\n".join(self.chapter(chapter) for chapter in self.plan.chapters) +
                f"</main>\n<footer><p>Everything on this page was made from seeds by <code>{self.command()}</code> on this machine, in "
                f"{seconds:.0f}{NBSP}s of CPU time without compiling. {size}{time.strftime('%Y-%m-%d')}.</p></footer>"
                f"<script>{script}</script></body></html>\n")


def table(what):
    """`columns`, `rows` and a `caption`; columns of numbers are right-aligned, None is a dash."""
    columns, rows = what["columns"], what["rows"]
    numeric = [any(isinstance(row[i], (int, float)) or re.match(r"[-+−]?\.?\d", str(row[i])) for row in rows) for i in range(len(columns))]

    def cell(value, column, tag):
        if isinstance(value, (int, float)):
            value = plots.format_number(value)
        return f"<{tag}{' class=number' if numeric[column] else ''}>{'–' if value is None else text(value)}</{tag}>"

    head = "".join(cell(name, i, "th") for i, name in enumerate(columns))
    body = "".join("<tr>" + "".join(cell(value, i, "td") for i, value in enumerate(row)) + "</tr>" for row in rows)
    caption = f"<caption>{text(what['caption'])}</caption>" if what.get("caption") else ""
    return f'<div class="table"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def write_whole(path, content):
    """The file appears whole or not at all."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix="." + path.name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(content)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        pathlib.Path(temporary).unlink(missing_ok=True)
        raise


WRITTEN = {"page": 0}  # the number of the page that status.js tells of


def write(plan, state, ending, quick, failed, programs):
    """Writes OUT/index.html."""
    WRITTEN["page"] = time.time_ns() // 1_000_000
    page = Page(plan, state, ending, quick, failed, programs)
    write_whole(state.out / "index.html", page.html(WRITTEN["page"]))
    if ending is not None:
        steps = [step for step in plan.steps if not isinstance(step, Build)]
        write_status(state.out, {"text": "", "done": len(page.done), "of": len(steps), "left": "Nothing is running"})


def write_status(out, status):
    """What the open page asks for every few seconds: where the demo is, and whether the page is a newer one."""
    status = {**status, "page": WRITTEN["page"], "at": round(time.time())}
    write_whole(out / "status.js", "{const s = " + json.dumps(status) + "; s.age = Date.now() / 1000 - s.at; window.voluteStatus?.(s);}\n")
