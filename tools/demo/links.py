# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Links of pages that lead nowhere: `links.py FOLDER` names them, for every .html in it."""
import html.parser
import pathlib
import sys
import urllib.parse


class Links(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.targets, self.ids = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src", "poster") and not (value or "").startswith("data:"):
                self.targets.append(value or "")
            elif name == "id":
                self.ids.append(value)


def dead(folder):
    """[(page, link)] of what is not there, lies outside of the folder, or needs a network; and ids that a page has twice."""
    folder = pathlib.Path(folder).resolve()
    found = []
    for page in sorted(folder.rglob("*.html")):
        links = Links(page.read_text(encoding="utf-8"))
        for target in links.targets:
            parts = urllib.parse.urlsplit(target)
            path = (page.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page
            alive = not parts.scheme and not parts.netloc and path.exists() and path.is_relative_to(folder)
            if alive and parts.fragment and path.suffix == ".html":
                ids = links.ids if path == page else Links(path.read_text(encoding="utf-8")).ids
                alive = parts.fragment in ids
            if not alive:
                found.append((page.relative_to(folder), target))
        found += [(page.relative_to(folder), f"id {one} twice") for one in sorted(set(links.ids)) if links.ids.count(one) > 1]
    return found


if __name__ == "__main__":
    broken = dead(sys.argv[1])
    for page, target in broken:
        print(f"{page}: {target}")
    sys.exit(bool(broken))
