# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""docs/cli/COMMAND.md is what the program generates. `VOLUTE=... docs_test.py --update` writes it anew."""
import pathlib
import re
import sys

import support

FOLDER = pathlib.Path(__file__).parents[2] / "docs" / "cli"


def commands():
    return re.findall(r"(?m)^  (\w+)\s+[A-Z]", support.volute("help").text.split("Commands:")[1].split("\n\n")[0])


def page(command):
    return support.volute("man", "--markdown", command).text


class Docs(support.TestCase):
    def test_pages_are_current(self):
        self.assertEqual(sorted(path.stem for path in FOLDER.glob("*.md")), sorted(commands()))
        for command in commands():
            stale = f"docs/cli/{command}.md is stale; run tests/cli/docs_test.py --update"
            self.assertEqual((FOLDER / f"{command}.md").read_text(), page(command), stale)


if __name__ == "__main__":
    if "--update" in sys.argv:
        FOLDER.mkdir(parents=True, exist_ok=True)
        for path in FOLDER.glob("*.md"):
            path.unlink()
        for command in commands():
            (FOLDER / f"{command}.md").write_text(page(command))
    else:
        support.main()
