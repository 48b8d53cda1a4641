"""ROS 2 itself, as far as PyPI has it, in a Python of its own: `.cache/ros/bin/python -m tests.fleet.ros2_rclpy`.

It reads and writes messages by the C libraries of the distribution, and tells the hashes that its packages were made with.
"""

from __future__ import annotations

import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.fleet.ros2_lines import answer_all


def plain(value: Any) -> Any:
    """A message as text alone has it."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return value[0]
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def kind_of(name: str) -> Any:
    """The class of a message, such as `std_srvs/srv/SetBool_Request`."""
    package, group, last = name.split("/")
    last, _, part = last.partition("_")
    found = getattr(import_module(f"{package}.{group}"), last)
    return getattr(found, part) if part else found


def answer(do: str, name: str, **of: Any) -> Any:
    """Does one thing; `None` for a type that is not there."""
    from rclpy.serialization import deserialize_message, serialize_message

    if do == "hash":
        described = Path(sys.prefix, "share", f"{name}.json")
        if not described.is_file():
            return None
        hashes = json.loads(described.read_text(encoding="utf-8"))["type_hashes"]
        return next(one["hash_string"] for one in hashes if one["type_name"] == name)
    if do == "read":
        return plain(deserialize_message(bytes.fromhex(of["payload"]), kind_of(name)))
    assert do == "write"
    return serialize_message(kind_of(name)(**of["fields"])).hex()


if __name__ == "__main__":
    answer_all(answer)
