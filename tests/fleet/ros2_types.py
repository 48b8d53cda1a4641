"""Types of ROS 2 as rosbags has them, and those beside: definitions without comments and constants, which do not count."""

from __future__ import annotations

import dataclasses
import functools
import json
from pathlib import Path
from typing import Any

from mcap_ros2._dynamic import generate_dynamic, serialize_dynamic
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

__all__ = ["Types", "plain"]

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
    "mavros_msgs/msg/HomePosition": (
        "std_msgs/Header header\ngeographic_msgs/GeoPoint geo\ngeometry_msgs/Point position\n"
        "geometry_msgs/Quaternion orientation\ngeometry_msgs/Vector3 approach"
    ),
    "mavros_msgs/msg/StatusText": "std_msgs/Header header\nuint8 severity\nstring text",
    "mavros_msgs/msg/ExtendedState": "std_msgs/Header header\nuint8 vtol_state\nuint8 landed_state",
    "mavros_msgs/msg/WaypointReached": "std_msgs/Header header\nuint16 wp_seq",
    "mavros_msgs/msg/RCIn": "std_msgs/Header header\nuint8 rssi\nuint16[] channels",
}
SERVICES = {
    "std_srvs/srv/SetBool": ("bool data", "bool success\nstring message"),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
    "mavros_msgs/srv/SetMode": ("uint8 base_mode\nstring custom_mode", "bool mode_sent"),
    "mavros_msgs/srv/CommandBool": ("bool value", "bool success\nuint8 result"),
    "mavros_msgs/srv/CommandTOL": (
        "float32 min_pitch\nfloat32 yaw\nfloat32 latitude\nfloat32 longitude\nfloat32 altitude",
        "bool success\nuint8 result",
    ),
    "mavros_msgs/srv/CommandHome": (
        "bool current_gps\nfloat32 yaw\nfloat32 latitude\nfloat32 longitude\nfloat32 altitude",
        "bool success\nuint8 result",
    ),
    "mavros_msgs/srv/CommandLong": (
        "bool broadcast\nuint16 command\nuint8 confirmation\n" + "\n".join(f"float32 param{n}" for n in range(1, 8)),
        "bool success\nuint8 result",
    ),
    "mavros_msgs/srv/ParamPull": ("bool force_pull", "bool success\nuint32 param_received"),
    "mavros_msgs/srv/ParamSetV2": (
        "bool force_set\nstring param_id\nrcl_interfaces/ParameterValue value",
        "bool success\nrcl_interfaces/ParameterValue value",
    ),
    "rcl_interfaces/srv/GetParameters": ("string[] names", "rcl_interfaces/ParameterValue[] values"),
    "rcl_interfaces/srv/GetParameterTypes": ("string[] names", "uint8[] types"),
    "rcl_interfaces/srv/DescribeParameters": ("string[] names", "rcl_interfaces/ParameterDescriptor[] descriptors"),
    "rcl_interfaces/srv/ListParameters": (
        "string[] prefixes\nuint64 depth",
        "rcl_interfaces/ListParametersResult result",
    ),
    "rcl_interfaces/srv/SetParameters": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult[] results",
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult result",
    ),
    "mavros_msgs/srv/WaypointSetCurrent": ("uint16 wp_seq", "bool success"),
    "mavros_msgs/srv/WaypointClear": ("", "bool success"),
    "mavros_msgs/srv/WaypointPull": ("", "bool success\nuint32 wp_received"),
    "mavros_msgs/srv/WaypointPush": (
        "uint16 start_index\nmavros_msgs/Waypoint[] waypoints",
        "bool success\nuint32 wp_transfered",
    ),
}
WITHIN = [
    "mavros_msgs/msg/Waypoint",
    *(
        f"rcl_interfaces/msg/{name}"
        for name in ("Parameter", "ParameterDescriptor", "ListParametersResult", "SetParametersResult")
    ),
]
"""What is in the services' requests and answers."""
NOTHING = "uint8 structure_needs_at_least_one_member"


def plain(message: Any) -> Any:
    """A message as text alone has it, whoever read it: names with values, lists, numbers."""
    if dataclasses.is_dataclass(message) or hasattr(message, "__slots__"):
        fields = getattr(message, "__dataclass_fields__", None) or message.__slots__
        # Neither constants nor what stands in for nothing.
        names = [name for name in fields if not (name.isupper() or name.startswith("_") or name in NOTHING)]
        return {name: plain(getattr(message, name)) for name in names}
    if hasattr(message, "tolist"):
        return message.tolist()
    return [plain(one) for one in message] if isinstance(message, (list, tuple, bytes)) else message


class Types:
    """Reads, writes and hashes types of a release, by rosbags; what it reads and writes is read by Foxglove's reader too."""

    def __init__(self, store: Stores = Stores.ROS2_JAZZY) -> None:
        self._store = get_typestore(store)
        self._readers = functools.cache(self._reader)
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

    def text(self, name: str) -> str:
        """The definition of a message, followed by those that are in it."""
        return str(self._store.generate_msgdef(name.replace("/srv/", "/msg/"), ros_version=2)[0])

    def _reader(self, name: str) -> Any:
        return generate_dynamic(name, self.text(name))[name], serialize_dynamic(name, self.text(name))[name]

    def _same(self, payload: bytes, name: str) -> Any:
        """A message, which two readers understand alike."""
        message = self._store.deserialize_cdr(payload, name)
        ours, theirs = plain(message), plain(self._readers(name)[0](payload))
        assert json.dumps(ours) == json.dumps(theirs), name
        return message

    def read(self, payload: bytes, name: str) -> Any:
        """A message."""
        return self._same(payload, name.replace("/srv/", "/msg/"))

    def write(self, name: str, **fields: object) -> bytes:
        """A message's bytes."""
        name = name.replace("/srv/", "/msg/")
        payload = bytes(self._store.serialize_cdr(self._store.types[name](**fields), name))
        self._same(payload, name)
        return payload

    def files(self, folder: Path, *kinds: str) -> None:
        """Writes the definitions of messages and services, and of what is in them, as a package of ROS 2 has them."""
        for kind in kinds:
            if "/srv/" in kind:
                request, response = SERVICES[kind]
                self._file(folder, f"{kind}.srv", f"{request or NOTHING}\n---\n{response}")
                self.files(folder, *WITHIN)
                continue
            first, *others = self.text(kind).split("=" * 80 + "\n")
            self._file(folder, f"{kind}.msg", first)
            for other in others:
                head, _, text = other.partition("\n")
                package, _, name = head.removeprefix("MSG: ").partition("/")
                self._file(folder, f"{package}/msg/{name.rpartition('/')[2]}.msg", text)

    @staticmethod
    def _file(folder: Path, name: str, text: str) -> None:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
