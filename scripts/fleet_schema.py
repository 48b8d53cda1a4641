#!/usr/bin/env python3
"""Writes the Protobuf descriptors embedded in history files, generated from the Rust payloads, for other programs.

The Rust types are the only definition of these messages; `tests/house/test_fleet_schema.py` fails if the committed
bytes differ.
Needs the package `protobuf`.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from google.protobuf import timestamp_pb2
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    EnumDescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)

ROOT = Path(__file__).resolve().parent.parent
FLEET = ROOT / "crates/fleet/src"
#: Sources: Rust files whose messages go into a descriptor file and package.
SPOKEN = ("payload", "deed", "outcome", "content", "plans", "wire", "history/record")
MADE = {
    FLEET / "history/vencejo.binpb": ("vencejo.v1", tuple(FLEET / f"{name}.rs" for name in SPOKEN)),
    FLEET / "history/location_fix.binpb": ("foxglove", (FLEET / "history/location.rs",)),
}
#: Messages of other packages.
WELL_KNOWN = {"Timestamp": "google.protobuf.Timestamp"}

BLOCK = re.compile(
    r"#\[derive\([^)]*prost::(Message|Oneof|Enumeration)\)\]\s*(?:#\[[^\]]*\]\s*)*pub (?:struct|enum) (\w+) \{(.*?)\n?\}\n",
    re.S,
)
FIELD = re.compile(r"#\[prost\(\s*([^)]*)\)\]\s*(?:pub )?(\w+)(?:: ([^,\n]+|[^\n]+)|\(([^)]*)\)),")
TAG = re.compile(r'\btag = "(\d+)"')


def snake(name: str) -> str:
    """Convert `ReturnToLaunch` to `return_to_launch`."""
    return re.sub(r"(?<=.)([A-Z])", r"_\1", name).lower()


def inner(rust: str) -> str:
    """Return the type in an `Option`, `Vec` or `Box`, without its module."""
    found = re.fullmatch(r"(?:Option|Vec|Box)<(.+)>", rust.strip())
    return inner(found[1]) if found else rust.strip().rsplit("::", 1)[-1]


class Reader:
    """Reads the messages of some Rust files."""

    def __init__(self, package: str, texts: list[str]) -> None:
        self.package = package
        self.blocks = {name: (kind, body) for text in texts for kind, name, body in BLOCK.findall(text)}

    def file(self, name: str) -> FileDescriptorProto:
        """Return all messages as one file."""
        made = FileDescriptorProto(name=name, package=self.package, syntax="proto3")
        for block, (kind, body) in self.blocks.items():
            if kind == "Message":
                made.message_type.append(self.message(block, body))
            elif kind == "Enumeration":
                values = EnumDescriptorProto(name=block)
                for value, number in re.findall(r"^\s*(\w+) = (\d+),", body, re.M):
                    values.value.add(name=f"{snake(block)}_{snake(value)}".upper(), number=int(number))
                made.enum_type.append(values)
        return made

    def message(self, name: str, body: str) -> DescriptorProto:
        """Return one message."""
        made = DescriptorProto(name=name)
        optional = []
        for options, field, rust, _ in FIELD.findall(body):
            if options.startswith("oneof"):
                made.oneof_decl.add(name=field)
                at = len(made.oneof_decl) - 1
                for choice_options, choice, _, choice_rust in FIELD.findall(self.blocks[inner(rust)][1]):
                    made.field.append(self.field(choice_options, snake(choice), choice_rust, oneof=at))
                continue
            made.field.append(self.field(options, field, rust))
            if "optional" in options and not options.startswith("message"):
                optional.append(made.field[-1])
        # Like protoc: the synthetic oneofs of optional fields come last.
        for each in optional:
            each.proto3_optional = True
            each.oneof_index = len(made.oneof_decl)
            made.oneof_decl.add(name=f"_{each.name}")
        return made

    def field(self, options: str, name: str, rust: str, oneof: int | None = None) -> FieldDescriptorProto:
        """Return one field."""
        kind = re.match(r"\w+", options)
        tag = TAG.search(options)
        assert kind is not None, f"{name}: {options}"
        assert tag is not None, f"{name}: {options}"
        made = FieldDescriptorProto(name=name, number=int(tag[1]), label=FieldDescriptorProto.LABEL_OPTIONAL)
        if "repeated" in options:
            made.label = FieldDescriptorProto.LABEL_REPEATED
        if oneof is not None:
            made.oneof_index = oneof
        if kind[0] == "enumeration":
            made.type = FieldDescriptorProto.TYPE_ENUM
            named = options.split('"')[1]
            made.type_name = f".{self.package}.{named}"
        else:
            made.type = FieldDescriptorProto.Type.Value(f"TYPE_{kind[0].upper()}")
        if kind[0] == "message":
            made.type_name = "." + WELL_KNOWN.get(inner(rust), f"{self.package}.{inner(rust)}")
        return made


def made() -> dict[Path, bytes]:
    """Return the intended content of the committed files."""
    result = {}
    for path, (package, sources) in MADE.items():
        file = Reader(package, [source.read_text(encoding="utf-8") for source in sources]).file(f"{path.stem}.proto")
        files = FileDescriptorSet()
        if any(field.type_name == ".google.protobuf.Timestamp" for each in file.message_type for field in each.field):
            timestamp_pb2.DESCRIPTOR.CopyToProto(files.file.add())
            file.dependency.append(timestamp_pb2.DESCRIPTOR.name)
            del file.message_type[[each.name for each in file.message_type].index("Timestamp")]
        files.file.append(file)
        result[path] = files.SerializeToString(deterministic=True)
    return result


def main() -> int:
    """Write the files."""
    for path, content in made().items():
        path.write_bytes(content)
        print(f"{path.relative_to(ROOT)}: {len(content)} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
