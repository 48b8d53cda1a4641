#!/usr/bin/env python3
"""Writes the classes in python/vencejo/telemetry.py from schemas/openapi.json: telemetry groups with documented fields.

The groups are defined in crates/vehicle/src/telemetry/groups.rs; `npm --prefix gcs run api` copies them into the
schema, and this script into Python, between the marker lines. Groups keep their order there; new ones come last.

Usage: ``python3 scripts/telemetry_classes.py [--check]``
"""

from __future__ import annotations

import json
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts.marked import main, refilled  # noqa: E402

FILE = ROOT / "python/vencejo/telemetry.py"
SCHEMA = ROOT / "schemas/openapi.json"
WIDTH = 120

SCALARS = {"number": "float", "integer": "int", "boolean": "bool", "string": "str"}
COMMON = {"age_s", "has_invalid"}
"""Fields of all groups, defined in their base class."""
VECTORS = {"acc_g", "gyro_rad_s", "mag_gauss", "vibration_m_s2", "clipping"}
"""Fields with three elements, one per axis; the schema does not contain lengths."""
EXACT = {"uid"}
"""64-bit integers, which are strings in JSON."""
LISTS = {"batteries": "battery"}
"""Groups of which a vehicle has several, and the singular of their name."""


def type_of(name: str, schema: Mapping[str, Any]) -> str:
    """Return the Python type of a field."""
    kinds = [schema["type"]] if isinstance(schema["type"], str) else list(schema["type"])
    optional = " | None" if "null" in kinds else ""
    (kind,) = (kind for kind in kinds if kind != "null")
    if kind == "array":
        part = type_of("", schema["items"])
        return f"tuple[{', '.join([part] * 3) if name in VECTORS else f'{part}, ...'}]{optional}"
    return ("int" if name in EXACT else SCALARS[kind]) + optional


def words(description: str) -> str:
    """Convert a description to Python's terms."""
    return re.sub(r"\bnull\b", "``None``", re.sub(r"`([^`]+)`", r"``\1``", " ".join(description.split())))


def class_of(name: str, schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield the class of a group."""
    summary = f'    """{words(schema["description"])}'
    if len(summary) > WIDTH:
        raise SystemExit(
            f"{name}: its description is longer than a line of {WIDTH} characters: {schema['description']}"
        )
    fields = {field: schema["properties"][field] for field in schema["required"] if field not in COMMON}
    yield from (
        "@dataclass(frozen=True, kw_only=True)",
        f"class {name}(Group):",
        summary,
        "",
        "    Attributes",
        "    ----------",
    )
    for field, described in fields.items():
        yield f"    {field} : {type_of(field, described).replace(' | ', ' or ')}"
        yield from textwrap.wrap(
            words(described["description"]), WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 8
        )
    yield from ('    """', "")
    for field, described in fields.items():
        yield f"    {field}: {type_of(field, described)}"
    if {"lat_deg", "lon_deg"} <= fields.keys():
        yield from point("None" in type_of("lat_deg", fields["lat_deg"]))


def point(is_optional: bool) -> Iterator[str]:
    """Yield the property of a group that is at a place."""
    yield from ("", "    @property", f"    def point(self) -> GeoPoint{' | None' if is_optional else ''}:")
    if is_optional:
        yield '        """The position as functions of `vencejo.geodesy` take it; ``None`` without one."""'
        yield "        return None if self.lat_deg is None or self.lon_deg is None else _point(self.lat_deg, self.lon_deg)"
    else:
        yield '        """The position as functions of `vencejo.geodesy` take it."""'
        yield "        return _point(self.lat_deg, self.lon_deg)"


def text() -> str:
    """Return the file's intended content."""
    schemas = json.loads(SCHEMA.read_text(encoding="utf-8"))["components"]["schemas"]
    old = FILE.read_text(encoding="utf-8")
    groups: dict[str, str] = {}
    for name, schema in schemas["TelemetryGroups"]["properties"].items():
        if name in LISTS:
            groups[LISTS[name]] = schema["items"]["$ref"].rsplit("/", 1)[1]
        elif "oneOf" in schema:
            groups[name] = schema["oneOf"][0]["$ref"].rsplit("/", 1)[1]
    here = re.findall(r'^    "(\w+)": \w+,$', old, re.MULTILINE)
    groups = {
        name: groups[name] for name in sorted(groups, key=lambda name: here.index(name) if name in here else len(here))
    }
    classes = re.findall(r"^class (\w+)\(Group\):$", old, re.MULTILINE)

    parts = ["", ""]
    for name in sorted(groups.values(), key=lambda name: classes.index(name) if name in classes else len(classes)):
        parts += [*class_of(name, schemas[name]), "", ""]
    table = "\n".join(f'    "{name}": {kind},' for name, kind in groups.items())
    parts += [
        "GROUPS: Final[dict[str, type[Group]]] = {",
        table,
        "}",
        '"""The class of each group by its name in a snapshot."""',
    ]
    properties = [""]
    for name, kind in groups.items():
        if name not in LISTS.values():
            properties += [
                "    @cached_property",
                f"    def {name}(self) -> {kind} | None:",
                f'        """See `{kind}`."""',
            ]
            properties += [f'        return self._group("{name}", {kind})', ""]

    return refilled(FILE, __file__, ["\n".join(parts) + "\n", "\n".join(properties) + "\n"])


if __name__ == "__main__":
    sys.exit(main(FILE, text()))
