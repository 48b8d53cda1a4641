"""Positions, and the items of a mission: a MAV_CMD with its frame and parameters. `vencejo.plan` has the same names."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vencejo import _native
from vencejo._given import FLAG, NONE, NUMBER, WHOLE, check, check_each

__all__ = ["Command", "Frame", "GeoPoint", "Home", "MissionItem"]


class Frame(enum.IntEnum):
    """Reference of an item's altitude (MAV_FRAME)."""

    GLOBAL = 0
    """Above mean sea level."""
    MISSION = 2
    """The item has no position."""
    GLOBAL_RELATIVE_ALT = 3
    """Above home."""
    GLOBAL_TERRAIN_ALT = 10
    """Above the terrain below the plane."""


class Command(enum.IntEnum):
    """The most common mission commands (MAV_CMD). Any other number is accepted too."""

    NAV_WAYPOINT = 16
    NAV_LOITER_UNLIM = 17
    NAV_LOITER_TURNS = 18
    NAV_LOITER_TIME = 19
    NAV_RETURN_TO_LAUNCH = 20
    NAV_LAND = 21
    NAV_TAKEOFF = 22
    NAV_CONTINUE_AND_CHANGE_ALT = 30
    NAV_LOITER_TO_ALT = 31
    NAV_DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_RETURN_PATH_START = 188
    DO_LAND_START = 189
    DO_SET_CAM_TRIGG_DIST = 206
    DO_FENCE_ENABLE = 207


@dataclass(frozen=True)
class GeoPoint:
    """A position on the WGS-84 ellipsoid.

    Attributes
    ----------
    lat_deg, lon_deg : float
        Degrees; latitude from -90 to 90, longitude from -180 to 180.
    """

    lat_deg: float
    lon_deg: float

    def __post_init__(self) -> None:
        check(self, lat_deg=NUMBER, lon_deg=NUMBER)


@dataclass(frozen=True)
class Home:
    """The home position, from which altitudes above home count.

    Attributes
    ----------
    lat_deg, lon_deg : float
        Degrees, WGS-84.
    alt_amsl_m : float
        Metres above mean sea level.
    """

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float

    def __post_init__(self) -> None:
        check(self, lat_deg=NUMBER, lon_deg=NUMBER, alt_amsl_m=NUMBER)


@dataclass(frozen=True)
class MissionItem:
    """One item of a mission: a MAV_CMD with its frame and seven parameters.

    Attributes
    ----------
    command : int
        MAV_CMD; see `Command` for the common ones.
    frame : Frame or int
        MAV_FRAME of the altitude.
    params : tuple of seven (float or None)
        Parameters 1 to 4 and then x, y, z: latitude and longitude in degrees and altitude in metres when the
        command has a position. ``None`` for a value that is not given.
    autocontinue : bool
        Whether the vehicle continues to the next item by itself.
    """

    command: int
    frame: int
    params: tuple[float | None, ...]
    autocontinue: bool = True

    def __post_init__(self) -> None:
        check(self, command=WHOLE, frame=WHOLE, autocontinue=FLAG)
        if not (0 <= self.command <= 0xFFFF and 0 <= self.frame <= 0xFF):
            raise ValueError(
                f"command {self.command}, frame {self.frame}: a MAV_CMD is 0 to 65535, a MAV_FRAME 0 to 255"
            )
        params = check_each(self, "params", *NUMBER, NONE)
        if len(params) != 7:
            raise ValueError(f"a mission item has seven parameters, not {len(params)}; use None for absent ones")
        object.__setattr__(self, "params", params)

    @property
    def name(self) -> str:
        """Name of the command in MAVLink, such as ``"NAV_WAYPOINT"``."""
        return _native.command_name(self.command)

    @property
    def has_position(self) -> bool:
        """Whether the command uses latitude, longitude and altitude."""
        return _native.command_has_position(self.command)

    @property
    def is_nav(self) -> bool:
        """Whether the mission stays at it until it is done; ``False`` for an action executed on the way."""
        return _native.command_is_nav(self.command)

    @property
    def lat_deg(self) -> float | None:
        """Latitude in degrees, ``None`` when the command has no position."""
        return self.params[4] if self.has_position else None

    @property
    def lon_deg(self) -> float | None:
        """Longitude in degrees, ``None`` when the command has no position."""
        return self.params[5] if self.has_position else None

    @property
    def alt_m(self) -> float | None:
        """Altitude in metres, in the item's `frame`; ``None`` when the command has no position."""
        return self.params[6] if self.has_position else None

    def with_altitude(self, alt_m: float) -> MissionItem:
        """The same item at another altitude (metres, in the item's frame)."""
        return replace(self, params=(*self.params[:6], alt_m))

    @classmethod
    def at(
        cls,
        command: int,
        lat_deg: float,
        lon_deg: float,
        *,
        alt_rel_home_m: float,
        params: Sequence[float | None] = (0.0, 0.0, 0.0, 0.0),
    ) -> MissionItem:
        """An item with a position, and its altitude above home."""
        p1, p2, p3, p4 = params
        return cls(int(command), Frame.GLOBAL_RELATIVE_ALT, (p1, p2, p3, p4, lat_deg, lon_deg, alt_rel_home_m))

    @classmethod
    def action(cls, command: int, *params: float | None) -> MissionItem:
        """An item without a position; parameters that are not given are 0."""
        if len(params) > 7:
            raise ValueError(f"a mission item has seven parameters, not {len(params)}")
        return cls(int(command), Frame.MISSION, (*params, *(0.0,) * (7 - len(params))))

    @classmethod
    def waypoint(
        cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, acceptance_radius_m: float = 0.0
    ) -> MissionItem:
        """Fly to a point. Radius 0 stands for the vehicle's WP_RADIUS."""
        return cls.at(
            Command.NAV_WAYPOINT,
            lat_deg,
            lon_deg,
            alt_rel_home_m=alt_rel_home_m,
            params=(0.0, acceptance_radius_m, 0.0, 0.0),
        )

    @classmethod
    def takeoff(cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, pitch_deg: float = 15.0) -> MissionItem:
        """Take off and climb to an altitude, with at least this pitch."""
        return cls.at(
            Command.NAV_TAKEOFF, lat_deg, lon_deg, alt_rel_home_m=alt_rel_home_m, params=(pitch_deg, 0.0, 0.0, 0.0)
        )

    @classmethod
    def land(cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float = 0.0) -> MissionItem:
        """Land at a point; the leg to it is the final approach."""
        return cls.at(Command.NAV_LAND, lat_deg, lon_deg, alt_rel_home_m=alt_rel_home_m)

    @classmethod
    def land_start(cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float = 0.0) -> MissionItem:
        """Mark the beginning of a landing sequence, which RTL can use."""
        return cls.at(Command.DO_LAND_START, lat_deg, lon_deg, alt_rel_home_m=alt_rel_home_m)

    @classmethod
    def loiter_turns(
        cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, turns: float, radius_m: float
    ) -> MissionItem:
        """Fly full circles around a point. A negative radius turns counter-clockwise."""
        return cls.at(
            Command.NAV_LOITER_TURNS,
            lat_deg,
            lon_deg,
            alt_rel_home_m=alt_rel_home_m,
            params=(turns, 0.0, radius_m, 1.0),
        )

    @classmethod
    def loiter_time(
        cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, time_s: float, radius_m: float = 0.0
    ) -> MissionItem:
        """Circle around a point for a time. ArduPlane keeps only the sign of the radius; its size is WP_LOITER_RAD."""
        return cls.at(
            Command.NAV_LOITER_TIME,
            lat_deg,
            lon_deg,
            alt_rel_home_m=alt_rel_home_m,
            params=(time_s, 0.0, radius_m, 1.0),
        )

    @classmethod
    def loiter_to_altitude(
        cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, radius_m: float = 0.0
    ) -> MissionItem:
        """Circle around a point until this altitude is reached."""
        return cls.at(
            Command.NAV_LOITER_TO_ALT,
            lat_deg,
            lon_deg,
            alt_rel_home_m=alt_rel_home_m,
            params=(0.0, radius_m, 0.0, 1.0),
        )

    @classmethod
    def loiter(cls, lat_deg: float, lon_deg: float, *, alt_rel_home_m: float, radius_m: float = 0.0) -> MissionItem:
        """Circle around a point indefinitely."""
        return cls.at(
            Command.NAV_LOITER_UNLIM, lat_deg, lon_deg, alt_rel_home_m=alt_rel_home_m, params=(0.0, 0.0, radius_m, 0.0)
        )

    @classmethod
    def return_to_launch(cls) -> MissionItem:
        """Return home, or to the nearest rally point, and circle there."""
        return cls.action(Command.NAV_RETURN_TO_LAUNCH)

    @classmethod
    def change_airspeed(cls, airspeed_m_s: float) -> MissionItem:
        """Fly at this airspeed from here on."""
        return cls.action(Command.DO_CHANGE_SPEED, 0.0, airspeed_m_s, -1.0)

    @classmethod
    def jump(cls, item: int, *, repeats: int = -1) -> MissionItem:
        """Continue at another item, counted from 1 as the plan's items are; -1 repeats for ever."""
        return cls.action(Command.DO_JUMP, float(item), float(repeats))
