"""Types of ROS 2 as rosbags has them, and those beside: definitions without comments and constants, which do not count."""

from __future__ import annotations

from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

__all__ = ["Types"]

BESIDE = {
    # rosbags takes its `char` for another type than ROS 2 does.
    "service_msgs/msg/ServiceEventInfo": "uint8 event_type\nbuiltin_interfaces/Time stamp\nuint8[16] client_gid\nint64 sequence_number",
    "geographic_msgs/msg/GeoPoint": "float64 latitude\nfloat64 longitude\nfloat64 altitude",
    "geographic_msgs/msg/GeoPose": "geographic_msgs/GeoPoint position\ngeometry_msgs/Quaternion orientation",
    "geographic_msgs/msg/GeoPoseStamped": "std_msgs/Header header\ngeographic_msgs/GeoPose pose",
    "mavros_msgs/msg/State": (
        "std_msgs/Header header\nbool connected\nbool armed\nbool guided\nbool manual_input\nstring mode\nuint8 system_status"
    ),
    "mavros_msgs/msg/VfrHud": (
        "std_msgs/Header header\nfloat32 airspeed\nfloat32 groundspeed\nint16 heading\nfloat32 throttle\nfloat32 altitude\nfloat32 climb"
    ),
    "mavros_msgs/msg/Waypoint": (
        "uint8 frame\nuint16 command\nbool is_current\nbool autocontinue\nfloat32 param1\nfloat32 param2\nfloat32 param3\nfloat32 param4\n"
        "float64 x_lat\nfloat64 y_long\nfloat64 z_alt"
    ),
    "mavros_msgs/msg/WaypointList": "uint16 current_seq\nmavros_msgs/Waypoint[] waypoints",
}
SERVICES = {
    "std_srvs/srv/SetBool": ("bool data", "bool success\nstring message"),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
    "mavros_msgs/srv/SetMode": ("uint8 base_mode\nstring custom_mode", "bool mode_sent"),
    "mavros_msgs/srv/CommandBool": ("bool value", "bool success\nuint8 result"),
    "mavros_msgs/srv/WaypointClear": ("", "bool success"),
    "mavros_msgs/srv/WaypointPull": ("", "bool success\nuint32 wp_received"),
    "mavros_msgs/srv/WaypointPush": (
        "uint16 start_index\nmavros_msgs/Waypoint[] waypoints",
        "bool success\nuint32 wp_transfered",
    ),
}
NOTHING = "uint8 structure_needs_at_least_one_member"


class Types:
    """Reads, writes and hashes types of a release."""

    def __init__(self, store: Stores = Stores.ROS2_JAZZY) -> None:
        self._store = get_typestore(store)
        for name, text in BESIDE.items():
            self._add(name, text)
        for name, (request, response) in SERVICES.items():
            self._add(f"{name}_Request", request or NOTHING)
            self._add(f"{name}_Response", response)

    def _add(self, name: str, text: str) -> None:
        added = get_types_from_msg(text, name.replace("/srv/", "/msg/"))
        self._store.fielddefs.pop(name, None)
        self._store.types.pop(name, None)
        self._store.register(added)

    def hash(self, name: str) -> str:
        """The hash of a message or service."""
        if "/srv/" not in name:
            return str(self._store.hash_rihs01(name))
        fields = self._store.fielddefs
        for part in ("Request", "Response"):
            fields[f"{name}_{part}"] = fields[f"{name}_{part}".replace("/srv/", "/msg/")]
        one = [(Nodetype.SEQUENCE, ((Nodetype.NAME, f"{name}_{part}"), 1)) for part in ("Request", "Response")]
        event = [
            ("info", (Nodetype.NAME, "service_msgs/msg/ServiceEventInfo")),
            ("request", one[0]),
            ("response", one[1]),
        ]
        fields[f"{name}_Event"] = ([], event)
        parts = ("Request", "Response", "Event")
        fields[name] = ([], [(f"{part.lower()}_message", (Nodetype.NAME, f"{name}_{part}")) for part in parts])
        return str(self._store.hash_rihs01(name))

    def kind(self, name: str) -> Any:
        """The class of a message."""
        return self._store.types[name]

    def read(self, payload: bytes, name: str) -> Any:
        """A message."""
        return self._store.deserialize_cdr(payload, name.replace("/srv/", "/msg/"))

    def write(self, name: str, **fields: object) -> bytes:
        """A message's bytes."""
        name = name.replace("/srv/", "/msg/")
        return bytes(self._store.serialize_cdr(self._store.types[name](**fields), name))
