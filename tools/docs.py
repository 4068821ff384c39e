#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The documentation as a site: docs.py --out FOLDER [--check].

Doxygen makes it of the pages in docs/, the public headers and the Python package's docstrings; search needs no server. Links of the
pages are checked; one that leads nowhere is an error, and all that --check looks for."""
import argparse
import ast
import html
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"(^```.*?^```$|^(?:    [^\n]*\n)+|`[^`\n]+`)", re.S | re.M)

# The order of the pages, as in docs/index.md; a page that is not listed is found by links alone.
PARTS = [
    ("Tutorials", "From your own files to a picture and a number.", "docs/tutorials/*.md"),
    ("How-to guides", "Install Volute, use its viewer, call it from other languages, run it on many machines.",
     "docs/install.md docs/python.md docs/viewer.md docs/opengl.md docs/cluster.md"),
    ("Commands", "Each command with all its options, as `volute help` prints them.", "docs/cli/*.md"),
    ("Reference", "File formats, scenes, captures and units.",
     "docs/scene.md docs/scene_members.md docs/geometry.md docs/capture.md docs/fds.md docs/meshes.md docs/format.md docs/units.md SECURITY.md"),
    ("Explanation", "What is computed, and why it is right.",
     "docs/idea.md docs/pictures.md docs/smoke.md docs/visibility.md docs/tenability.md docs/real-captures.md docs/robustness.md docs/papers.md"),
    ("Design", "How the parts work, and decisions that are costly to undo.", "docs/design/*.md docs/adr/*.md"),
    ("Measurements", "Times and errors, with date and commit.", "docs/measurements/*.md"),
    ("The project", "", "docs/index.md CHANGELOG.md CONTRIBUTING.md"),
]

STYLE = """
body, div, p, ul, li, td, th, dl { font-family: system-ui, sans-serif; }
body { line-height: 1.45; }
div.contents { max-width: 62em; }
h1, h2, h3, .title { font-family: system-ui, sans-serif; font-weight: 600; }
code, pre.fragment, div.fragment, div.line { font-family: ui-monospace, monospace; font-size: 13px; }
div.contents h1 { font-size: 1.35em; margin-top: 1.4em; }
div.contents h2 { font-size: 1.15em; }
table.markdownTable { border-collapse: collapse; }
table.markdownTable td, table.markdownTable th, th.markdownTableHeadLeft, th.markdownTableHeadCenter, th.markdownTableHeadNone
  { text-align: left; padding: 3px 10px; border: 1px solid #d0d7e2; background: none; color: inherit; }
div.fragment, pre.fragment { padding: 6px 10px; border-radius: 4px; line-height: 1.35; }
img.footer { height: 1em; }
img { max-width: 100%; }
"""


def identifier(path):
    """The page of a file; README is the first one."""
    name = path.relative_to(ROOT).with_suffix("").as_posix()
    return "index" if name == "README" else "page_" + re.sub(r"\W", "_", name)


def title_of(path):
    found = re.search(r"^# (.+)$", path.read_text(), re.M)
    return found[1].strip() if found else path.stem


class Site:
    def __init__(self, out):
        self.out, self.pages = out, out / "pages"
        shutil.rmtree(out, ignore_errors=True)
        self.pages.mkdir(parents=True)
        self.files = set()  # copied as they are
        self.faults = []
        found = {path for pattern in ("*.md", "docs/**/*.md") for path in ROOT.glob(pattern)}
        self.known = {path for path in found if "node_modules" not in path.parts}

    def link(self, page, match):
        image, text, target = match.groups()
        place, _, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target):
            return match[0]
        if not place:
            return f"[{text}](@ref {identifier(page)})"
        path = (page.parent / place).resolve()
        if path in self.known:
            if text.endswith(".md"):
                text = title_of(path)  # names of files say nothing here
            return f"[{text}](@ref {identifier(path)})"
        if path.is_dir():
            return text
        if not path.is_file():
            self.faults.append(f"{page.relative_to(ROOT)}: {target} is not there")
            return text
        self.files.add(path)
        name = "files/" + path.relative_to(ROOT).as_posix()
        return f'<img src="{name}" alt="{html.escape(text)}">' if image else f'<a href="{name}">{text}</a>'

    def plain(self, path, text):
        """Text that is no code: Doxygen would take signs for its commands, and two hyphens for a dash."""
        text = LINK.sub(lambda match: self.link(path, match), text.replace("\\", "\\\\").replace("@", "\\@"))
        return re.sub(r"(?<![-\w])--(?=\w)", r"\\--", text.replace("](\\@ref", "](@ref"))

    def quoted(self, path, text):
        """A code span as Doxygen 1.9 reads it: `..' is a quotation to it, and the rest of the line is text."""
        if re.match(r"`[^`]*'(?![\w])[^`]*`\Z", text):
            self.faults.append(f"{path.relative_to(ROOT)}: Doxygen ends {text} at its quote; use double ones")
        return text

    def page(self, path):
        parts = FENCE.split(re.sub(r"\A(<!--.*?-->\s*)+", "", path.read_text(), flags=re.S))
        text = "".join(self.quoted(path, part) if i % 2 else self.plain(path, part) for i, part in enumerate(parts))
        text = re.sub(r"^# (.+)$", lambda match: f"# {match[1].strip()} {{#{identifier(path)}}}", text, count=1, flags=re.M)
        if path.name == "README.md":
            text = re.sub(r"^# .*$", "", text, count=1, flags=re.M)
            text = "# Volute {#mainpage}\n" + text
        # A file name that says the place: two pages may have one name.
        name = "-".join(path.relative_to(ROOT).parts)
        (self.pages / name).write_text(text)

    def parts(self):
        for number, (title, sentence, patterns) in enumerate(PARTS):
            listed = [path for pattern in patterns.split() for path in sorted(ROOT.glob(pattern)) if path in self.known]
            lines = "".join(f"- @subpage {identifier(path)}\n" for path in listed)
            (self.pages / f"{number:02}-part.md").write_text(f"# {title} {{#part_{number:02}}}\n{sentence}\n\n{lines}")


def python_reference(package):
    """What help() says, as a page; from the sources, so that nothing must be built."""
    text = "# Python reference {#part_99_python}\n`import volute`. Types are in the package's stubs.\n"

    def clean(doc):
        return re.sub(r"([@\\])", r"\\\1", doc or "")

    def signature(node):
        arguments = ast.unparse(node.args)
        return re.sub(r"^self(, )?", "", arguments)

    for source, prefix in [("_volume.py", "volute"), ("_compress.py", "volute"), ("_scene_api.py", "volute"), ("fds.py", "volute.fds"), ("vtk.py", "volute.vtk"),
                           ("_errors.py", "volute")]:
        if not (package / source).exists():
            continue
        for node in ast.parse((package / source).read_text()).body:
            if getattr(node, "name", "_").startswith("_") or not isinstance(node, (ast.ClassDef, ast.FunctionDef)) or not ast.get_docstring(node):
                continue
            if isinstance(node, ast.FunctionDef):
                text += f"\n## {prefix}.{node.name}()\n```\n{prefix}.{node.name}({signature(node)})\n```\n```\n{ast.get_docstring(node)}\n```\n"
                continue
            text += f"\n## {prefix}.{node.name}\n{clean(ast.get_docstring(node))}\n"
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and not member.name.startswith("_") and ast.get_docstring(member):
                    kind = "" if any(getattr(d, "id", "") == "property" for d in member.decorator_list) else f"({signature(member)})"
                    text += f"\n- `{member.name}{kind}`: {clean(' '.join(ast.get_docstring(member).split()))}\n"
    return text


def public_headers():
    wanted = re.findall(r'#include "(volute/.*?)"', (ROOT / "include/volute/volute.hpp").read_text()) + ["volute/gl/gl_scene_renderer.hpp", "volute/cluster/cluster.hpp", "volute/media/field_members.hpp"]
    return [ROOT / "include/volute" / name for name in ("volute.h", "medium.h")] + [ROOT / "src" / name for name in wanted]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    out = arguments.out.resolve()
    site = Site(out)
    for path in sorted(site.known):
        site.page(path)
    site.parts()
    if arguments.check:
        print("\n".join(site.faults) or f"{len(site.known)} pages")
        return 1 if site.faults else 0
    (site.pages / "99-python.md").write_text(python_reference(ROOT / "python/volute"))
    (out / "style.css").write_text(STYLE)
    version = ".".join(re.findall(r"^#define VOLUTE_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", (ROOT / "src/volute/base/version.hpp").read_text(), re.M))
    settings = {
        "PROJECT_NAME": "Volute", "PROJECT_NUMBER": version, "OUTPUT_DIRECTORY": out, "HTML_OUTPUT": "html", "GENERATE_LATEX": "NO",
        "INPUT": " ".join(map(str, [site.pages, *public_headers()])), "FILE_PATTERNS": "*.md *.hpp *.h", "EXTENSION_MAPPING": "h=C",
        "STRIP_FROM_PATH": f"{ROOT}/src {ROOT}/include", "STRIP_FROM_INC_PATH": f"{ROOT}/src {ROOT}/include",
        "EXTRACT_ALL": "YES", "HIDE_UNDOC_CLASSES": "YES", "JAVADOC_AUTOBRIEF": "YES", "GENERATE_TREEVIEW": "YES", "SEARCHENGINE": "YES",
        "SERVER_BASED_SEARCH": "NO", "HTML_EXTRA_STYLESHEET": out / "style.css", "TOC_INCLUDE_HEADINGS": "0", "WARN_IF_UNDOCUMENTED": "NO",
        "WARN_LOGFILE": out / "warnings.txt", "QUIET": "YES", "MACRO_EXPANSION": "YES", "EXCLUDE_SYMBOLS": "volute::detail", "HAVE_DOT": "NO",
        "PREDEFINED": "[[nodiscard]]=", "HTML_DYNAMIC_SECTIONS": "YES", "DISABLE_INDEX": "NO", "FULL_SIDEBAR": "NO", "VERBATIM_HEADERS": "NO",
        "CLASS_GRAPH": "TEXT", "ENUM_VALUES_PER_LINE": "1", "TIMESTAMP": "NO", "HTML_TIMESTAMP": "NO",
    }
    (out / "Doxyfile").write_text("".join(f"{key} = {value}\n" for key, value in settings.items()))
    done = subprocess.run(["doxygen", out / "Doxyfile"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(done.stdout)
    for path in site.files:
        to = out / "html/files" / path.relative_to(ROOT)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, to)
    warnings = (out / "warnings.txt").read_text().splitlines()
    for line in site.faults + [line for line in warnings if "unable to resolve reference" in line]:
        print(f"docs.py: {line}", file=sys.stderr)
    print(out / "html/index.html")
    return 1 if site.faults else 0


if __name__ == "__main__":
    sys.exit(main())
