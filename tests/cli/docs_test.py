# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""docs/cli/COMMAND.md, docs/scene.schema.json and docs/scene_members.md are what the program generates. `VOLUTE=...
docs_test.py --update` writes them anew."""
import pathlib
import re
import sys

import support

FOLDER = pathlib.Path(__file__).parents[2] / "docs" / "cli"


def commands():
    return re.findall(r"(?m)^  (\w+)\s+[A-Z]", support.volute("help").text.split("Commands:")[1].split("\n\n")[0])


def page(command):
    return support.volute("man", "--markdown", command).text


def generated():
    """{path: text} of what describes scenes."""
    docs = FOLDER.parent
    return {docs / "scene.schema.json": support.volute("man", "--schema").text,
            docs / "scene_members.md": support.volute("man", "--members").text}


class Docs(support.TestCase):
    def test_pages_are_current(self):
        self.assertEqual(sorted(path.stem for path in FOLDER.glob("*.md")), sorted(commands()))
        for command in commands():
            stale = f"docs/cli/{command}.md is stale; run tests/cli/docs_test.py --update"
            self.assertEqual((FOLDER / f"{command}.md").read_text(), page(command), stale)

    def test_what_describes_scenes_is_current(self):
        for path, text in generated().items():
            self.assertEqual(path.read_text(), text, f"{path} is stale; run tests/cli/docs_test.py --update")


if __name__ == "__main__":
    if "--update" in sys.argv:
        FOLDER.mkdir(parents=True, exist_ok=True)
        for path in FOLDER.glob("*.md"):
            path.unlink()
        for command in commands():
            (FOLDER / f"{command}.md").write_text(page(command))
        for path, text in generated().items():
            path.write_text(text)
    else:
        support.main()
