#!/usr/bin/env python3
"""Writes crates/proto/src/layouts.rs: name, type and wire order of the fields of every message in the dialect.

The Rust crate for MAVLink has types but no tables; the API uses messages by field name. The layouts come from
pymavlink's generated dialect, hence from MAVLink's own definitions.

Usage: ``.venv/bin/python scripts/message_layouts.py [--check]``
"""

from __future__ import annotations

import sys
from pathlib import Path

FILE = Path(__file__).resolve().parent.parent / "crates/proto/src/layouts.rs"
TYPES = {
    "uint8_t": "u8", "int8_t": "i8", "uint16_t": "u16", "int16_t": "i16", "uint32_t": "u32", "int32_t": "i32",
    "uint64_t": "u64", "int64_t": "i64", "float": "f32", "double": "f64", "char": "c",
    "uint8_t_mavlink_version": "u8",
}  # fmt: skip
HEAD = """\
//! Fields of every message of the dialect, in their order on the wire: `name:type`, with `*n` for n of them; `c` is text.
//!
//! Written by scripts/message_layouts.py from MAVLink's definitions; do not edit.

/// Message ids, ascending, with their fields.
#[rustfmt::skip]
pub(crate) const LAYOUTS: &[(u32, &str)] = &[
"""


def layouts() -> dict[int, str]:
    """Return the layout of each message by id."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    found = {}
    for number, message in dialect.mavlink_map.items():
        types = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
        fields = []
        for name, length, array in zip(message.ordered_fieldnames, message.lengths, message.array_lengths, strict=True):
            count = array if types[name] == "char" else length
            kind = TYPES[types[name]]
            fields.append(f"{name}:{kind}" + (f"*{count}" if count > 1 or array else ""))
        found[int(number)] = " ".join(fields)
    return dict(sorted(found.items()))


def main() -> int:
    """Write the file, or with --check return whether it is current."""
    text = HEAD + "".join(f'    ({number}, "{fields}"),\n' for number, fields in layouts().items()) + "];\n"
    if "--check" in sys.argv:
        return 0 if FILE.read_text(encoding="utf-8") == text else 1
    FILE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
