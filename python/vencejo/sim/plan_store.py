"""The stored plan: mission, geofence and rally points, as stored by ArduPlane.

ArduPlane packs each mission item into 15 bytes: it stores only the fields that a command uses, in the width of its
structure, and a station reads back only those. The table :data:`_COMMANDS` has them for every command; it agrees with
``facts/arduplane-mission-commands.json``, recorded from a real ArduPlane. The transfer protocol is in
:mod:`vencejo.sim.mavlink.mission`.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

from vencejo.sim.autopilot.interface import RallyPoint, Severity, StoredItem
from vencejo.sim.params import float32

__all__ = [
    "FENCE_MAX_ITEMS",
    "FRAMES",
    "MISSION_MAX_ITEMS",
    "RALLY_MAX_ITEMS",
    "FenceShape",
    "FenceStore",
    "MissionResult",
    "MissionStore",
    "PlanStore",
    "RallyStore",
    "WireItem",
    "normalise",
]

MISSION_MAX_ITEMS = 655
"""Capacity of the mission, home included ("Only 655 items are supported")."""
FENCE_MAX_ITEMS = 84
RALLY_MAX_ITEMS = 50

_ALT_LIMIT_M = 83_000.0
"""Altitudes are 24-bit centimetres in storage."""
_NAN_ALLOWED: dict[int, frozenset[int]] = {command: frozenset({4}) for command in (16, 17, 21, 22, 84)} | {
    85: frozenset({3, 4})
}
"""Parameters that may be NaN ("keep as it is"), by command."""


class MissionResult(IntEnum):
    """MAV_MISSION_RESULT."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    OPERATION_CANCELLED = 15


@dataclass(frozen=True, slots=True)
class WireItem:
    """The fields of MISSION_ITEM_INT, raw: degrees × 10⁷ in ``x`` and ``y`` of a position, metres in ``z``."""

    seq: int
    frame: int
    command: int
    p1: float = 0.0
    p2: float = 0.0
    p3: float = 0.0
    p4: float = 0.0
    x: int = 0
    y: int = 0
    z: float = 0.0
    current: int = 0
    autocontinue: int = 1
    mission_type: int = 0


def _f16(value: float) -> float:
    try:
        return float(struct.unpack("<e", struct.pack("<e", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def _integer(bits: int, *, signed: bool) -> Callable[[float], float]:
    """C's conversion of a float to an integer field: truncated to int32, then to its low bits."""

    def convert(value: float) -> float:
        whole = math.trunc(value) if math.isfinite(value) and abs(value) < 2**31 else 0
        whole &= (1 << bits) - 1
        if signed and whole >> (bits - 1):
            whole -= 1 << bits
        return float(whole)

    return convert


_FIELDS: dict[str, Callable[[float], float]] = {
    "u8": _integer(8, signed=False),
    "i8": _integer(8, signed=True),
    "u16": _integer(16, signed=False),
    "i16": _integer(16, signed=True),
    "f32": float32,
    "f16": _f16,
    "bool": lambda value: 1.0 if value > 0 else 0.0,
    "bit0": lambda value: float(int(value) & 1) if math.isfinite(value) else 0.0,
    "cm": lambda value: float32((math.trunc(value * 100.0) & 0xFFFF) * 0.01),
    "sign": lambda value: -1.0 if value < 0 else 1.0,
    "mount": lambda _value: 2.0,
}


@dataclass(frozen=True, slots=True)
class _Command:
    """Storage of one command: a field type for each stored parameter, and whether x, y, z are a position."""

    position: bool = False
    p1: str = ""
    p2: str = ""
    p3: str = ""
    p4: str = ""
    x: str = ""
    y: str = ""
    z: str = ""


_COMMANDS: dict[int, _Command] = {
    16: _Command(position=True),  # NAV_WAYPOINT: radii, see _special
    17: _Command(position=True),  # NAV_LOITER_UNLIM: radius
    18: _Command(position=True),  # NAV_LOITER_TURNS: turns and radius
    19: _Command(position=True, p1="u16", p3="sign"),  # NAV_LOITER_TIME
    20: _Command(),  # NAV_RETURN_TO_LAUNCH
    21: _Command(position=True, p1="u16", p4="sign"),  # NAV_LAND
    22: _Command(position=True, p1="u16"),  # NAV_TAKEOFF
    30: _Command(position=True, p1="u16"),  # NAV_CONTINUE_AND_CHANGE_ALT
    31: _Command(position=True),  # NAV_LOITER_TO_ALT: radius
    36: _Command(position=True, p1="i16"),  # NAV_ARC_WAYPOINT
    83: _Command(p1="f32", p2="f32", p3="u8"),  # NAV_ALTITUDE_WAIT
    84: _Command(position=True),  # NAV_VTOL_TAKEOFF
    85: _Command(position=True, p1="u16"),  # NAV_VTOL_LAND
    92: _Command(position=True, p1="u16"),  # NAV_GUIDED_ENABLE
    93: _Command(p1="f32", p2="i8", p3="i8", p4="i8"),  # NAV_DELAY
    94: _Command(position=True, p1="cm"),  # NAV_PAYLOAD_PLACE
    112: _Command(p1="f32"),  # CONDITION_DELAY
    114: _Command(p1="f32"),  # CONDITION_DISTANCE
    115: _Command(p1="f32", p2="f32", p3="i8", p4="u8"),  # CONDITION_YAW
    177: _Command(p1="u16", p2="i16"),  # DO_JUMP
    178: _Command(p1="u8", p2="f32", p3="f32"),  # DO_CHANGE_SPEED
    179: _Command(position=True, p1="u16"),  # DO_SET_HOME
    181: _Command(p1="u8", p2="u8"),  # DO_SET_RELAY
    182: _Command(p1="u8", p2="i16", p3="f32"),  # DO_REPEAT_RELAY
    183: _Command(p1="u8", p2="u16"),  # DO_SET_SERVO
    184: _Command(p1="u8", p2="u16", p3="i16", p4="f32"),  # DO_REPEAT_SERVO
    188: _Command(position=True),  # DO_RETURN_PATH_START
    189: _Command(position=True),  # DO_LAND_START
    191: _Command(position=True),  # DO_GO_AROUND
    193: _Command(p1="u16"),  # DO_PAUSE_CONTINUE
    194: _Command(p1="u16"),  # DO_SET_REVERSE
    195: _Command(position=True, p1="u16"),  # DO_SET_ROI_LOCATION
    197: _Command(p1="u16"),  # DO_SET_ROI_NONE
    201: _Command(position=True, p1="u16"),  # DO_SET_ROI
    202: _Command(p1="u8", p2="u16", p3="u8", p4="u16", x="u8", y="u8", z="f32"),  # DO_DIGICAM_CONFIGURE
    203: _Command(p1="u8", p2="u8", p3="i8", p4="u8", x="u8", y="u8"),  # DO_DIGICAM_CONTROL
    205: _Command(p1="f32", p2="f32", p3="f32", z="mount"),  # DO_MOUNT_CONTROL
    206: _Command(p1="f32", p3="u8"),  # DO_SET_CAM_TRIGG_DIST
    207: _Command(p1="u16"),  # DO_FENCE_ENABLE
    208: _Command(p1="u16"),  # DO_PARACHUTE
    210: _Command(p1="u16"),  # DO_INVERTED_FLIGHT
    211: _Command(p1="u8", p2="u8"),  # DO_GRIPPER
    212: _Command(p1="u16"),  # DO_AUTOTUNE_ENABLE
    213: _Command(p1="f32", p2="f32", p3="u8"),  # NAV_SET_YAW_SPEED
    215: _Command(p1="u16"),  # DO_SET_RESUME_REPEAT_DIST
    216: _Command(p1="u16"),  # DO_SPRAYER
    217: _Command(p1="u16", p2="f32", p3="f32", p4="f32"),  # DO_SEND_SCRIPT_MESSAGE
    218: _Command(p1="u16", p2="u8"),  # DO_AUX_FUNCTION
    222: _Command(p1="u16", p2="f32", p3="f32", p4="f32"),  # DO_GUIDED_LIMITS
    223: _Command(p1="bool", p2="bool", p3="cm", p4="bit0"),  # DO_ENGINE_CONTROL
    531: _Command(p1="u8", p2="f32"),  # SET_CAMERA_ZOOM
    532: _Command(p1="u8", p2="f32"),  # SET_CAMERA_FOCUS
    534: _Command(p1="u8", p2="u8", p3="u8"),  # SET_CAMERA_SOURCE
    600: _Command(p1="u16"),  # JUMP_TAG
    601: _Command(p1="u16", p2="i16"),  # DO_JUMP_TAG
    1000: _Command(p1="i8", p2="i16", p3="i8", p4="i8", x="u8", z="u8"),  # DO_GIMBAL_MANAGER_PITCHYAW
    2000: _Command(p1="u8", p2="f32", p3="u16", p4="u16"),  # IMAGE_START_CAPTURE
    2001: _Command(p1="u16"),  # IMAGE_STOP_CAPTURE
    2500: _Command(p1="u8"),  # VIDEO_START_CAPTURE
    2501: _Command(p1="u8"),  # VIDEO_STOP_CAPTURE
    3000: _Command(p1="u8"),  # DO_VTOL_TRANSITION
    42600: _Command(p1="u8", p2="u8", p3="f32", p4="f32"),  # DO_WINCH
    42702: _Command(p1="u8", p2="u8", p3="f16", p4="f16", x="i16", y="i16"),  # NAV_SCRIPT_TIME
    42703: _Command(p1="u16", p2="i16", p3="i8", p4="i16", x="i16"),  # NAV_ATTITUDE_TIME
}

FRAMES = {0: 0, 5: 0, 3: 3, 6: 3, 10: 10, 11: 10}
"""The MAV_FRAME with an altitude: the ``_INT`` variants fold into absolute, relative, terrain."""
_ITEM_FRAMES = FRAMES | {2: 0}
"""Those of mission items: MAV_FRAME_MISSION is stored as absolute."""


def has_position(command: int) -> bool:
    """Whether x, y and z of a command are a position, in degrees in MISSION_ITEM."""
    entry = _COMMANDS.get(command)
    return (entry is not None and entry.position) or command in (5000, 5001, 5002, 5003, 5004, 5100)


def _special(item: WireItem) -> dict[str, float]:
    """Parameters that share packed fields in ArduPlane."""
    match item.command:
        case 16:  # acceptance and pass-by radius, a byte each
            clip = _FIELDS["u16"]
            return {"p2": min(255.0, clip(item.p2)), "p3": min(255.0, clip(item.p3))}
        case 17:  # radius in 16 bits, direction apart
            radius = _FIELDS["u16"](abs(item.p3))
            return {"p3": -radius if item.p3 < 0 and radius else radius}
        case 18:  # turns in a byte (in 1/256 below one turn), radius in a byte (in tens of metres above 255)
            if 0 < item.p1 < 1:
                turns = math.trunc(float32(item.p1 * 256.0)) / 256.0
            else:
                turns = float(math.trunc(min(255.0, max(0.0, item.p1))))
            radius = abs(item.p3)
            stored = (
                float(math.trunc(radius)) if radius <= 255 else math.trunc(min(255.0, float32(radius * 0.1))) * 10.0
            )
            if item.p1 <= -1.0:
                # Turns and radius share sixteen bits, and ArduPlane writes a negative number over both.
                bits = int(stored if radius <= 255 else stored / 10) << 8 | (math.trunc(item.p1) & 0xFFFF)
                turns, stored = float(bits & 0xFF), float(bits >> 8 & 0xFF)
            return {"p1": turns, "p3": -stored if item.p3 < 0 and stored else stored, "p4": float(item.p4 > 0)}
        case 19:
            return {"p4": float(item.p4 > 0)}
        case 31:
            radius = _FIELDS["u16"](abs(item.p2))
            return {"p2": -radius if item.p2 < 0 and radius else radius, "p4": float(item.p4 > 0)}
        case 42703:
            return {
                "p1": _FIELDS["u16"](min(max(item.p1, 0.0), 65535.0)),
                "p2": _FIELDS["i16"](item.p2) if abs(item.p2) <= 180 else 0.0,
                "p3": _FIELDS["i8"](item.p3) if abs(item.p3) <= 90 else 0.0,
                "p4": _FIELDS["i16"](item.p4) if -180 <= item.p4 <= 360 else 0.0,
            }
    return {}


def _check_position(x: int, y: int) -> MissionResult | None:
    if abs(x) > 900_000_000:
        return MissionResult.INVALID_PARAM5_X
    if abs(y) > 1_800_000_000:
        return MissionResult.INVALID_PARAM6_Y
    return None


def normalise(item: WireItem) -> WireItem | MissionResult:
    """The mission item as ArduPlane stores it and reads it back, or the result with which it is refused."""
    allowed = _NAN_ALLOWED.get(item.command, frozenset())
    for number, value in enumerate((item.p1, item.p2, item.p3, item.p4), start=1):
        if math.isinf(value) or (math.isnan(value) and number not in allowed):
            return MissionResult(MissionResult.INVALID_PARAM1 + number - 1)
    if item.command in (0, 1):
        return MissionResult.INVALID
    entry = _COMMANDS.get(item.command)
    if entry is None:
        return MissionResult.UNSUPPORTED

    special = _special(item)

    def kept(name: str) -> float:
        if name in special:
            return special[name]
        kind = getattr(entry, name)
        value = float(getattr(item, name))
        if not kind:
            return 0.0
        return _FIELDS[kind](0.0 if math.isnan(value) else value)

    stored = WireItem(
        seq=item.seq, frame=0, command=item.command, p1=kept("p1"), p2=kept("p2"), p3=kept("p3"), p4=kept("p4")
    )
    if not entry.position:
        return replace(stored, x=int(kept("x")), y=int(kept("y")), z=kept("z"))

    if (refused := _check_position(item.x, item.y)) is not None:
        return refused
    if not math.isfinite(item.z) or abs(item.z) >= _ALT_LIMIT_M:
        return MissionResult.INVALID_PARAM7
    frame = _ITEM_FRAMES.get(item.frame)
    if frame is None:
        return MissionResult.UNSUPPORTED_FRAME
    centimetres = math.trunc(float32(float32(item.z) * 100.0))
    return replace(stored, frame=frame, x=item.x, y=item.y, z=float32(centimetres * float32(0.01)))


class _ListStore:
    """Items that ArduPlane stores one by one as they arrive: an upload is not atomic."""

    max_items: int
    complaints: tuple[tuple[Severity, str], ...] = ()

    def __init__(self) -> None:
        self._items: list[WireItem] = []
        self.revision = 0
        self.clears = 0
        """Number of times that all items were removed."""
        self.may_clear: Callable[[], bool] = lambda: True
        """Returns whether all items may be removed now."""

    def __len__(self) -> int:
        return len(self._items)

    def begin(self, count: int) -> None:
        """Start an upload of ``count`` items: items beyond are removed immediately."""
        self.truncate(count)

    def truncate(self, count: int) -> None:
        """Keep the first ``count`` items."""
        if count < len(self._items):
            del self._items[count:]
            self.revision += 1

    def _store(self, seq: int, stored: WireItem) -> MissionResult:
        """Replace an item, or append the next one."""
        if seq < len(self._items):
            self._items[seq] = stored
        elif seq == len(self._items) and seq < self.max_items:
            self._items.append(stored)
        else:
            return MissionResult.ERROR
        self.revision += 1
        return MissionResult.ACCEPTED

    def complete(self) -> MissionResult:
        """Complete the upload."""
        return MissionResult.ACCEPTED

    def abandon(self) -> None:
        """Abandon the upload; received items stay."""

    def clear(self) -> bool:
        """Remove all items; False when that is not allowed now."""
        if not self.may_clear():
            return False
        self.clears += 1
        self.revision += 1
        self._items.clear()
        return True

    def read(self, seq: int) -> WireItem | None:
        """An item as read back by a station, None when it does not exist."""
        return self._items[seq] if 0 <= seq < len(self._items) else None


class MissionStore(_ListStore):
    """The mission. Item 0 is home: it is written like any other item, and always read as the present home."""

    max_items = MISSION_MAX_ITEMS

    def __init__(self) -> None:
        super().__init__()
        self.home: WireItem | None = None
        """Home as item 0, None until it is set."""

    def set_home(self, lat_deg: float, lon_deg: float, alt_amsl_m: float) -> None:
        """Set home; an empty mission gets its item 0."""
        self.home = WireItem(
            seq=0,
            frame=0,
            command=16,
            x=round(lat_deg * 1e7),
            y=round(lon_deg * 1e7),
            z=float32(round(alt_amsl_m * 100.0) * float32(0.01)),
        )
        if not self._items:
            self._items.append(self.home)
            self.revision += 1

    def put(self, item: WireItem, *, last_seq: int) -> MissionResult:
        """Store an item; jumps beyond ``last_seq`` and to home are refused."""
        stored = normalise(item)
        if isinstance(stored, MissionResult):
            return stored
        if stored.command == 177:
            target = int(stored.p1)
            if target == 0 or (target >= len(self._items) and target > last_seq):
                return MissionResult.ERROR
        return self._store(item.seq, stored)

    def read(self, seq: int) -> WireItem | None:
        """An item as read back by a station, None when it does not exist."""
        return self.home if seq == 0 and self.home is not None else super().read(seq)


class FenceShape:
    """One polygon or circle of the fence, or its return point."""

    __slots__ = ("command", "points", "radius_m")

    def __init__(self, command: int, points: Sequence[tuple[float, float]], radius_m: float) -> None:
        self.command = command
        """MAV_CMD 5000 to 5004."""
        self.points = tuple(points)
        """Vertices or the centre: latitude and longitude, degrees."""
        self.radius_m = radius_m


class FenceStore:
    """The geofence. An upload replaces it only once it is complete and valid."""

    max_items = FENCE_MAX_ITEMS

    def __init__(self) -> None:
        self._items: list[WireItem] = []
        self._staged: list[WireItem | None] | None = None
        self.revision = 0
        self.shapes: tuple[FenceShape, ...] = ()
        self.complaints: tuple[tuple[Severity, str], ...] = ()
        """Texts of the last upload if it was refused as a whole."""

    def __len__(self) -> int:
        return len(self._items) if self._staged is None else len(self._staged)

    @property
    def vertex_total(self) -> int:
        """FENCE_TOTAL: two more than the vertices, of which a circle is one; 0 with fewer than three."""
        return len(self._items) + 2 if len(self._items) >= 3 else 0

    def begin(self, count: int) -> None:
        """Start an upload of ``count`` items."""
        self._staged = [None] * count

    def begin_update(self) -> None:
        """Start a partial write: items not written stay as they are."""
        self._staged = list(self._items)

    def put(self, item: WireItem, *, last_seq: int) -> MissionResult:
        """Stage an item until the upload is complete."""
        del last_seq
        if self._staged is None or item.seq >= len(self._staged):
            return MissionResult.INVALID_SEQUENCE
        if item.frame not in (0, 3, 5, 6, 10, 11):
            return MissionResult.UNSUPPORTED_FRAME
        if item.command not in (5000, 5001, 5002, 5003, 5004):
            return MissionResult.UNSUPPORTED
        p1 = 0.0
        if item.command in (5001, 5002):
            if not 0 <= item.p1 <= 255:
                return MissionResult.INVALID_PARAM1
            p1 = float(int(item.p1))
        elif item.command in (5003, 5004):
            if not math.isfinite(item.p1):
                return MissionResult.INVALID_PARAM1
            p1 = float32(item.p1)
        if (refused := _check_position(item.x, item.y)) is not None:
            return refused
        self._staged[item.seq] = WireItem(
            seq=item.seq, frame=0, command=item.command, p1=p1, x=item.x, y=item.y, autocontinue=0, mission_type=1
        )
        return MissionResult.ACCEPTED

    def complete(self) -> MissionResult:
        """Validate the staged fence and activate it."""
        staged, self._staged = self._staged, None
        if staged is None:
            return MissionResult.ERROR
        items = [item for item in staged if item is not None]
        try:
            if len(items) != len(staged):
                raise _FenceError(Severity.INFO, "Incorrect item count")
            shapes = _fence_shapes(items)
        except _FenceError as error:
            self.complaints = ((error.severity, error.text), (Severity.WARNING, "Fence validation failed"))
            return MissionResult.ERROR
        self._items, self.shapes, self.complaints = items, shapes, ()
        self.revision += 1
        return MissionResult.ACCEPTED

    def abandon(self) -> None:
        """Drop the staged items."""
        self._staged = None

    def clear(self) -> bool:
        """Remove the fence."""
        self.begin(0)
        self.complete()
        return True

    def read(self, seq: int) -> WireItem | None:
        """An item as read back by a station, None when it does not exist."""
        return self._items[seq] if 0 <= seq < len(self._items) else None


class _FenceError(Exception):
    """The fence is invalid; ``text`` is ArduPlane's message."""

    def __init__(self, severity: Severity, text: str) -> None:
        super().__init__(text)
        self.severity = severity
        self.text = text


def _fence_shapes(items: Sequence[WireItem]) -> tuple[FenceShape, ...]:
    """The shapes of a list of fence items."""
    shapes: list[FenceShape] = []
    index = 0
    while index < len(items):
        first = items[index]
        size = int(first.p1) if first.command in (5001, 5002) else 1
        group = items[index : index + size]
        polygon = first.command in (5001, 5002)
        if polygon and size < 3:
            raise _FenceError(Severity.WARNING, f"Invalid vertex count ({size})")
        if len(group) != size or any(i.command != first.command or (polygon and i.p1 != first.p1) for i in group):
            raise _FenceError(Severity.INFO, "Incorrect item count")
        if first.command in (5003, 5004) and first.p1 <= 0:
            raise _FenceError(Severity.WARNING, "Non-positive circle radius")
        radius = first.p1 if first.command in (5003, 5004) else 0.0
        shapes.append(FenceShape(first.command, [(i.x * 1e-7, i.y * 1e-7) for i in group], radius))
        index += size
    return tuple(shapes)


class RallyStore(_ListStore):
    """Rally points; altitudes are whole metres."""

    max_items = RALLY_MAX_ITEMS

    def put(self, item: WireItem, *, last_seq: int) -> MissionResult:
        """Store a point."""
        del last_seq
        if item.command != 5100:
            return MissionResult.UNSUPPORTED
        if (refused := _check_position(item.x, item.y)) is not None:
            return refused
        if not -32768 <= item.z <= 32767:
            return MissionResult.INVALID_PARAM7
        frame = FRAMES.get(item.frame)
        if frame is None:
            return MissionResult.UNSUPPORTED_FRAME
        stored = WireItem(
            seq=item.seq,
            frame=frame,
            command=5100,
            x=item.x,
            y=item.y,
            z=float(math.trunc(item.z)),
            autocontinue=0,
            mission_type=2,
        )
        return self._store(item.seq, stored)

    def points(self) -> Iterable[RallyPoint]:
        """The points in the units of the autopilot."""
        for item in self._items:
            yield RallyPoint(item.x * 1e-7, item.y * 1e-7, item.z, relative=item.frame != 0)


class PlanStore:
    """Mission, fence and rally stores, and the autopilot's view of them."""

    def __init__(self) -> None:
        self.mission_store = MissionStore()
        self.fence_store = FenceStore()
        self.rally_store = RallyStore()
        self._mission_view: tuple[int, tuple[StoredItem, ...]] = (-1, ())
        self._rally_view: tuple[int, tuple[RallyPoint, ...]] = (-1, ())

    @property
    def mission(self) -> Sequence[StoredItem]:
        """Stored items by ``seq``; item 0 is home."""
        if self._mission_view[0] != self.mission_store.revision:
            items = tuple(
                stored_item(item)
                for seq in range(len(self.mission_store))
                if (item := self.mission_store.read(seq)) is not None
            )
            self._mission_view = (self.mission_store.revision, items)
        return self._mission_view[1]

    @property
    def mission_revision(self) -> int:
        """Increases with every change of the mission."""
        return self.mission_store.revision

    @property
    def mission_clears(self) -> int:
        """Number of times that the whole mission was removed: by MISSION_CLEAR_ALL, or before an upload as a file."""
        return self.mission_store.clears

    @property
    def rally(self) -> Sequence[RallyPoint]:
        """Stored rally points."""
        if self._rally_view[0] != self.rally_store.revision:
            self._rally_view = (self.rally_store.revision, tuple(self.rally_store.points()))
        return self._rally_view[1]


def stored_item(item: WireItem) -> StoredItem:
    """A normalised item in the units of the autopilot."""
    position = has_position(item.command)
    return StoredItem(
        seq=item.seq,
        command=item.command,
        frame=item.frame,
        p1=item.p1,
        p2=item.p2,
        p3=item.p3,
        p4=item.p4,
        lat_deg=item.x * 1e-7 if position else 0.0,
        lon_deg=item.y * 1e-7 if position else 0.0,
        alt_m=item.z,
        x=item.x,
        y=item.y,
    )
