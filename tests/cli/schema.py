# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""As much of JSON Schema as docs/scene.schema.json uses, with the standard library alone."""
import json
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = json.loads((ROOT / "docs/scene.schema.json").read_text())

KNOWN = {"$schema", "$defs", "$ref", "title", "description", "type", "const", "enum", "oneOf", "required", "properties",
         "additionalProperties", "items", "minItems", "maxItems", "minimum", "maximum", "exclusiveMinimum",
         "exclusiveMaximum", "pattern", "default"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": int}


def is_type(value, name):
    return isinstance(value, TYPES[name]) and (name == "boolean" or not isinstance(value, bool))


def faults(value, schema=SCENE, path=""):
    """What is wrong with a value, as a list of sentences; empty when it is valid."""
    assert set(schema) <= KNOWN, set(schema) - KNOWN
    found = []
    if "$ref" in schema:
        found += faults(value, SCENE["$defs"][schema["$ref"].removeprefix("#/$defs/")], path)
    if "type" in schema and not is_type(value, schema["type"]):
        return found + [f"{path}: not of type {schema['type']}"]
    if "const" in schema and value != schema["const"]:
        found.append(f"{path}: not {schema['const']}")
    if "enum" in schema and value not in schema["enum"]:
        found.append(f"{path}: none of {schema['enum']}")
    if "pattern" in schema and not re.search(schema["pattern"], value):
        found.append(f"{path}: does not match {schema['pattern']}")
    if "oneOf" in schema:
        options = [faults(value, {k: v for k, v in option.items()}, path) for option in schema["oneOf"]]
        if sum(not option for option in options) != 1:
            found.append(f"{path}: not exactly one of {len(options)} choices: {options}")
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        for limit, good in (("minimum", lambda a, b: a >= b), ("maximum", lambda a, b: a <= b),
                            ("exclusiveMinimum", lambda a, b: a > b), ("exclusiveMaximum", lambda a, b: a < b)):
            if limit in schema and not good(value, schema[limit]):
                found.append(f"{path}: {limit} {schema[limit]}")
    if isinstance(value, list):
        if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
            found.append(f"{path}: {len(value)} items")
        for i, item in enumerate(value):
            found += faults(item, schema.get("items", {}), f"{path}/{i}")
    if isinstance(value, dict):
        found += [f"{path}/{key}: is missing" for key in schema.get("required", []) if key not in value]
        for key, item in value.items():
            if key in schema.get("properties", {}):
                found += faults(item, schema["properties"][key], f"{path}/{key}")
            elif not schema.get("additionalProperties", True):
                found.append(f"{path}/{key}: is unknown")
    return found
