"""Somebody of ROS 2 who is not ours, by `zenoh-ros2-sdk`: `python -m tests.fleet.ros2_sdk PORT FOLDER`.

It works out keys, hashes and tokens by itself, from the definitions in a folder; it would fetch those that are missing, and may not.
"""

from __future__ import annotations

import sys
import threading
from functools import partial
from pathlib import Path
from typing import Any

import zenoh_ros2_sdk as sdk
from zenoh_ros2_sdk import message_registry

from tests.fleet.ros2_lines import answer_all
from tests.fleet.ros2_types import plain

PATIENCE_S = 60.0


def missing(*of: object) -> None:
    """In place of fetching a definition."""
    raise AssertionError(f"no definition: {of}")


class Peer:
    """Hears topics, asks services, and says where to fly."""

    def __init__(self, port: int, definitions: Path) -> None:
        self._at: dict[str, Any] = {"router_ip": "127.0.0.1", "router_port": port}
        message_registry.clone_to_cache = message_registry.get_message_file_path = missing
        message_registry.get_registry().messages_dir = definitions
        self._session = sdk.ZenohSession.get_instance(**self._at)
        self._heard: dict[str, list[Any]] = {}
        self._more = threading.Condition()
        self._kept: list[object] = []
        self._publishers: dict[str, Any] = {}

    def _hear(self, name: str, message: object) -> None:
        with self._more:
            self._heard.setdefault(name, []).append(plain(message))
            self._more.notify_all()

    def _fly_to(self, at: dict[str, Any], name: str, kind: str, position: dict[str, float]) -> None:
        """Publishes a position."""
        if name not in self._publishers:
            self._publishers[name] = sdk.ROS2Publisher(name, kind, **at)
        types = self._session.store.types
        stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
        attitude = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
        place = types["geographic_msgs/msg/GeoPoint"](**position)
        self._publishers[name].publish(
            header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
            pose=types["geographic_msgs/msg/GeoPose"](position=place, orientation=attitude),
        )

    def answer(self, do: str, domain: int, **of: Any) -> Any:
        """Does one thing."""
        at = {"domain_id": domain, **self._at}
        if do == "listed":
            listed = (
                sdk.get_topic_names_and_types(**at, timeout=3.0),
                sdk.get_service_names_and_types(**at, timeout=3.0),
            )
            return [dict(found) for found in listed]
        if do == "listen":
            for name, kind in of["topics"]:
                assert message_registry.load_message_type(kind), kind
                self._kept.append(sdk.ROS2Subscriber(name, kind, partial(self._hear, name), **at))
            return None
        if do == "heard":
            with self._more:
                assert self._more.wait_for(lambda: all(name in self._heard for name in of["names"]), PATIENCE_S), (
                    set(of["names"]) - self._heard.keys()
                )
                return {name: self._heard[name][0] for name in of["names"]}
        if do == "fly_to":
            return self._fly_to(at, **of)
        assert do == "call"
        client = sdk.ROS2ServiceClient(of["name"], of["kind"], timeout=PATIENCE_S, **at)
        types = self._session.store.types
        request = {
            name: [types["mavros_msgs/msg/Waypoint"](**one) for one in value] if name == "waypoints" else value
            for name, value in of["request"].items()
        }
        try:
            return plain(client.call(**request))
        finally:
            client.close()


if __name__ == "__main__":
    answer_all(Peer(int(sys.argv[1]), Path(sys.argv[2])).answer)
