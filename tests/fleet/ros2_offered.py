"""What a gateway has to offer, written down by hand: names and types as MAVROS and ArduPilot have them, and their keys and tokens."""

from __future__ import annotations

from tests.fleet.ros2_types import Types

__all__ = ["HEARD", "MAVROS", "NEWS", "SERVICES", "TOPICS", "key", "tokens"]

MAVROS = "mavros"
TOPICS = {
    MAVROS: {
        "battery": "sensor_msgs/msg/BatteryState",
        "extended_state": "mavros_msgs/msg/ExtendedState",
        "global_position/compass_hdg": "std_msgs/msg/Float64",
        "global_position/global": "sensor_msgs/msg/NavSatFix",
        "global_position/raw/fix": "sensor_msgs/msg/NavSatFix",
        "global_position/rel_alt": "std_msgs/msg/Float64",
        "home_position/home": "mavros_msgs/msg/HomePosition",
        "imu/data": "sensor_msgs/msg/Imu",
        "local_position/odom": "nav_msgs/msg/Odometry",
        "local_position/pose": "geometry_msgs/msg/PoseStamped",
        "local_position/velocity_local": "geometry_msgs/msg/TwistStamped",
        "mission/path": "nav_msgs/msg/Path",
        "mission/reached": "mavros_msgs/msg/WaypointReached",
        "mission/waypoints": "mavros_msgs/msg/WaypointList",
        "rc/in": "mavros_msgs/msg/RCIn",
        "state": "mavros_msgs/msg/State",
        "statustext/recv": "mavros_msgs/msg/StatusText",
        "time_reference": "sensor_msgs/msg/TimeReference",
        "vfr_hud": "mavros_msgs/msg/VfrHud",
        "wind_estimation": "geometry_msgs/msg/TwistWithCovarianceStamped",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/rosout": "rcl_interfaces/msg/Log",
        "/tf": "tf2_msgs/msg/TFMessage",
    },
    "ap": {
        "battery": "sensor_msgs/msg/BatteryState",
        "geopose/filtered": "geographic_msgs/msg/GeoPoseStamped",
        "imu/experimental/data": "sensor_msgs/msg/Imu",
        "navsat": "sensor_msgs/msg/NavSatFix",
        "pose/filtered": "geometry_msgs/msg/PoseStamped",
        "time": "builtin_interfaces/msg/Time",
        "twist/filtered": "geometry_msgs/msg/TwistStamped",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/rosout": "rcl_interfaces/msg/Log",
    },
}
NEWS = {"mission/reached", "statustext/recv"}
"""Topics that say something when it happens only."""
HEARD = {MAVROS: {"setpoint_position/global": "geographic_msgs/msg/GeoPoseStamped"}, "ap": {}}
SERVICES = {
    MAVROS: {
        "cmd/arming": "mavros_msgs/srv/CommandBool",
        "cmd/command": "mavros_msgs/srv/CommandLong",
        "cmd/land": "mavros_msgs/srv/CommandTOL",
        "cmd/set_home": "mavros_msgs/srv/CommandHome",
        "cmd/takeoff": "mavros_msgs/srv/CommandTOL",
        "mission/clear": "mavros_msgs/srv/WaypointClear",
        "mission/pull": "mavros_msgs/srv/WaypointPull",
        "mission/push": "mavros_msgs/srv/WaypointPush",
        "mission/set_current": "mavros_msgs/srv/WaypointSetCurrent",
        "param/describe_parameters": "rcl_interfaces/srv/DescribeParameters",
        "param/get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
        "param/get_parameters": "rcl_interfaces/srv/GetParameters",
        "param/list_parameters": "rcl_interfaces/srv/ListParameters",
        "param/pull": "mavros_msgs/srv/ParamPull",
        "param/set": "mavros_msgs/srv/ParamSetV2",
        "param/set_parameters": "rcl_interfaces/srv/SetParameters",
        "param/set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
        "set_mode": "mavros_msgs/srv/SetMode",
        "vencejo/arm": "std_srvs/srv/SetBool",
        "vencejo/loiter": "std_srvs/srv/Trigger",
        "vencejo/mission_clear": "std_srvs/srv/Trigger",
        "vencejo/mission_start": "std_srvs/srv/Trigger",
        "vencejo/return_to_launch": "std_srvs/srv/Trigger",
    },
    "ap": {"prearm_check": "std_srvs/srv/Trigger"},
}


def _mangled(kind: str) -> str:
    path, _, last = kind.rpartition("/")
    return f"{path.replace('/', '::')}::dds_::{last}_"


def key(types: Types, domain: int, name: str, kind: str) -> str:
    """Where a topic or a service is."""
    return f"{domain}/{name.strip('/')}/{_mangled(kind)}/{types.hash(kind)}"


def whole(at: str, name: str) -> str:
    """A topic's whole name."""
    return name if name.startswith("/") else f"{at}/{name}"


def tokens(types: Types, domain: int, names: str, at: str, node: str) -> set[str]:
    """The tokens of a plane's node, and of that of its parameters, without its session and its numbers, which are the session's: ``NN/…``, ``MP/…``, ``MS/…``, ``SS/…``."""
    space, _, last = node.rpartition("/")
    owner = f"%/{space.replace('/', '%') or '%'}/{last}"
    found = {f"{domain} NN/{owner}"}
    params = f"%/{node.replace('/', '%')}/param"
    if names == MAVROS:
        found.add(f"{domain} NN/{params}")
    reliable, sensor_data = "::,10:,:,:,,", "2::,5:,:,:,,"
    for code, offered, quality in (
        ("MP", TOPICS[names], reliable),
        ("MS", HEARD[names], sensor_data),
        ("SS", SERVICES[names], reliable),
    ):
        for name, kind in offered.items():
            topic = whole(at, name).replace("/", "%")
            of = params if name.startswith("param/") else owner
            found.add(f"{domain} {code}/{of}/{topic}/{_mangled(kind)}/{types.hash(kind)}/{quality}")
    return found
