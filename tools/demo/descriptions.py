# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Steps that write what programs read: scenes, cameras, signs, routes."""
import json

from plan import Step


def write_json(folder, path, value):
    (folder / path).write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def json_file(path, value):
    return Step((path,), work=write_json, arguments=(path, value))


def write_text(folder, path, value):
    (folder / path).write_text(value, encoding="utf-8")


def text_file(path, value):
    return Step((path,), work=write_text, arguments=(path, value))
