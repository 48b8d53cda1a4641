"""The picture of a flight: what is shown of it (`View`), what happened in it (`Follower`), when it is over (`Outcome`).

Nothing here talks to a vehicle, reads a clock or writes to a terminal: telemetry and mission progress go in, pictures
and notes come out.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

from vencejo import modes
from vencejo.cli.common import clean, distance, duration, number

if TYPE_CHECKING:
    from rich.console import RenderableType

    from vencejo.plan import MissionItem, Plan
    from vencejo.telemetry import Telemetry
    from vencejo.values import MissionProgress, StatusText

STALE_AFTER_S: Final = 3.5
LOST_AFTER_S: Final = 5.0
NAV_LAND: Final = 21
NAV_LOITER_UNLIM: Final = 17
NAV_VTOL_LAND: Final = 85
REST_M_S: Final = 1.0
"""Slower than this over ground the plane stands."""
REST_S: Final = 45.0
"""So long on the ground without being disarmed, the flight counts as over: LAND_DISARMDELAY is 20 s by default."""
REASON_WITHIN_S: Final = 5.0
"""A text this much older than a change of mode may be its reason."""


# What is shown -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class View:
    """One picture of a flight. ``None`` is not known."""

    elapsed_s: float
    mode: str | None
    is_armed: bool | None
    landed: str | None
    item: int | None
    total: int | None
    item_name: str | None
    distance_m: float | None
    time_s: float | None
    leg_distance_m: float | None
    alt_rel_home_m: float | None
    climb_m_s: float | None
    airspeed_m_s: float | None
    groundspeed_m_s: float | None
    heading_deg: float | None
    wind_m_s: float | None
    wind_from_deg: float | None
    voltage_v: float | None
    battery_pct: float | None
    satellites: int | None
    fix: str | None
    lat_deg: float | None
    lon_deg: float | None
    link_age_s: float | None
    texts: tuple[str, ...]

    @property
    def link(self) -> str:
        """The link's age in words; late and lost are said, not only coloured."""
        if self.link_age_s is None:
            return "nothing heard yet"
        if self.link_age_s > LOST_AFTER_S:
            return f"LOST, silent for {duration(self.link_age_s)}"
        mark = "stale, " if self.link_age_s > STALE_AFTER_S else ""
        return f"{mark}heard {self.link_age_s:.1f} s ago"

    def as_json(self) -> dict[str, Any]:
        """The picture as JSON."""
        values = asdict(self)
        del values["texts"]
        return {key: round(value, 7) if isinstance(value, float) else value for key, value in values.items()}


def view_of(
    telemetry: Telemetry,
    progress: MissionProgress,
    texts: Sequence[StatusText],
    *,
    plan: Plan | None,
    elapsed_s: float,
    lines: int = 6,
) -> View:
    """Make the picture of one moment."""
    hud, position, wind, gps = telemetry.hud, telemetry.position, telemetry.wind, telemetry.gps
    voltage_v, battery_pct = _battery(telemetry)
    return View(
        elapsed_s=elapsed_s,
        mode=telemetry.mode,
        is_armed=telemetry.is_armed,
        landed=telemetry.extended.landed if telemetry.extended else None,
        item=progress.item,
        total=progress.total,
        item_name=_item_name(plan, progress.item),
        distance_m=progress.distance_m,
        time_s=progress.time_s,
        leg_distance_m=progress.leg_distance_m,
        alt_rel_home_m=position.alt_rel_home_m if position else None,
        climb_m_s=hud.climb_m_s if hud else None,
        airspeed_m_s=hud.airspeed_m_s if hud else None,
        groundspeed_m_s=hud.groundspeed_m_s if hud else None,
        heading_deg=hud.heading_deg if hud else None,
        wind_m_s=wind.speed_m_s if wind else None,
        wind_from_deg=wind.from_deg if wind else None,
        voltage_v=voltage_v,
        battery_pct=battery_pct,
        satellites=gps.satellites if gps else None,
        fix=gps.fix_name if gps else None,
        lat_deg=position.lat_deg if position else None,
        lon_deg=position.lon_deg if position else None,
        link_age_s=link_age_s(telemetry),
        texts=tuple(f"{text.severity_name}: {clean(text.text)}" for text in list(texts)[-lines:]),
    )


def link_age_s(telemetry: Telemetry) -> float | None:
    """How long the vehicle has been silent: the age of the youngest of its most frequent groups."""
    groups = (telemetry.heartbeat, telemetry.attitude, telemetry.position, telemetry.hud, telemetry.sys_status)
    return min((group.age_s for group in groups if group is not None), default=None)


def _battery(telemetry: Telemetry) -> tuple[float | None, float | None]:
    for battery in telemetry.batteries:
        return battery.voltage_v, battery.remaining_pct
    if telemetry.sys_status is not None:
        return telemetry.sys_status.voltage_v, telemetry.sys_status.battery_remaining_pct
    return None, None


def _item_name(plan: Plan | None, item: int | None) -> str | None:
    if plan is None or item is None or not 1 <= item <= len(plan.items):
        return None
    return plan.items[item - 1].name.removeprefix("MAV_CMD_")


def render(view: View) -> RenderableType:
    """The picture for a terminal."""
    from rich.console import Group
    from rich.panel import Panel
    from rich.progress_bar import ProgressBar
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 3))
    for _ in range(2):
        grid.add_column(style="dim", no_wrap=True)
        grid.add_column(no_wrap=True)
    armed = {True: "armed", False: "disarmed", None: "arming unknown"}[view.is_armed]
    mode = Text(f"{view.mode or '–'}, {armed}", style="bold")
    late = view.link_age_s is None or view.link_age_s > STALE_AFTER_S
    grid.add_row("mode", mode, "item", _item(view))
    grid.add_row(
        "to go", f"{distance(view.distance_m)}, {duration(view.time_s)}", "next", distance(view.leg_distance_m)
    )
    grid.add_row("height", f"{number(view.alt_rel_home_m, 'm')} above home", "climb", number(view.climb_m_s, "m/s", 1))
    grid.add_row("airspeed", number(view.airspeed_m_s, "m/s", 1), "ground", number(view.groundspeed_m_s, "m/s", 1))
    grid.add_row("heading", number(view.heading_deg, "°"), "wind", _wind(view))
    grid.add_row("battery", _power(view), "GPS", f"{view.fix or '–'}, {number(view.satellites)} satellites")
    grid.add_row("link", Text(view.link, style="bold red" if late else ""), "time", duration(view.elapsed_s))
    done = min(view.item or 0, view.total or 0)
    parts: list[RenderableType] = [grid, ProgressBar(total=max(view.total or 1, 1), completed=done, width=64), Text("")]
    parts.extend(Text(text, style="dim", overflow="ellipsis", no_wrap=True) for text in view.texts)
    return Panel(Group(*parts), title="Vencejo", title_align="left", width=78)


def line(view: View) -> str:
    """The picture as one line, for a log."""
    armed = {True: "armed", False: "disarmed", None: "arming unknown"}[view.is_armed]
    return (
        f"{duration(view.elapsed_s)} {view.mode or 'no mode'} {armed}, item {_item(view)}, "
        f"to go {distance(view.distance_m)} {duration(view.time_s)}, height {number(view.alt_rel_home_m, 'm')}, "
        f"air {number(view.airspeed_m_s, 'm/s', 1)}, ground {number(view.groundspeed_m_s, 'm/s', 1)}, "
        f"battery {_power(view)}, link {view.link}"
    )


def _item(view: View) -> str:
    if view.item is None:
        return "–" if not view.total else f"– of {view.total}"
    name = f" {view.item_name}" if view.item_name else ""
    return f"{view.item} of {view.total if view.total is not None else '–'}{name}"


def _wind(view: View) -> str:
    if view.wind_m_s is None:
        return "–"
    return f"{view.wind_m_s:.1f} m/s from {number(view.wind_from_deg, '°')}"


def _power(view: View) -> str:
    return f"{number(view.voltage_v, 'V', 1)} {number(view.battery_pct, '%')}"


# What happened -----------------------------------------------------------------------------------------------------


class Ending(enum.Enum):
    """How a flight ended."""

    LANDED = "landed"
    """On the ground after its whole mission."""
    ENDED_IN_AIR = "mission ended in the air"
    """The mission has no landing and is at its end."""
    INTERRUPTED = "mission interrupted"
    """On the ground, or still flying another mode, without its whole mission."""
    NOT_FLOWN = "not flown"
    """Disarmed before it took off."""


@dataclass(frozen=True)
class Outcome:
    """The end of a flight.

    Attributes
    ----------
    ending : Ending
    ok : bool
        Whether it is what was asked for.
    text : str
        What to tell.
    """

    ending: Ending
    ok: bool
    text: str


@dataclass(frozen=True)
class Note:
    """Something that happened: kind, words, and values for JSON."""

    kind: str
    text: str
    values: dict[str, Any]


@dataclass(frozen=True)
class _Left:
    item: int | None
    mode: str
    since_s: float
    reason: str


class Follower:
    """Watches a flight that has been started until it is over. It only looks: it never sends anything.

    Parameters
    ----------
    plan : Plan
        What is flown.
    patience_s : float
        How long a plane that has left AUTO is followed before the flight counts as interrupted.
    """

    def __init__(self, plan: Plan, *, patience_s: float = 120.0) -> None:
        self._plan = plan
        self._patience_s = patience_s
        self._began_s: float | None = None
        self._vehicle_began_s: float | None = None
        self._clock_s = 0.0
        self._mode: str | None = None
        self._auto_seen = False
        self._armed_seen = False
        self._flown = False
        self._airborne_s: float | None = None
        self._ground_s: float | None = None
        self._rest_since_s: float | None = None
        self._running_seen = False
        self._flies = False
        self._left: _Left | None = None
        self._resumed: _Left | None = None
        self._skipped: _Left | None = None
        self._lost = False
        self._text_s: float | None = None
        self._reached: frozenset[int] = frozenset()
        """Items reported as reached in this run of the mission."""
        self._item: int | None = None
        self._recent: list[StatusText] = []
        self.outcome: Outcome | None = None

    @property
    def elapsed_s(self) -> float:
        """Time since the start, by the vehicle's clock if it sends it: a simulation may run faster than real time."""
        return self._clock_s

    @property
    def flight_time_s(self) -> float | None:
        """From take-off to touch-down, or until now; ``None`` when it has not flown."""
        if self._airborne_s is None or self._ground_s is None:
            return None
        return self._ground_s - self._airborne_s

    def step(self, telemetry: Telemetry, progress: MissionProgress, texts: Sequence[StatusText]) -> list[Note]:
        """Look at one moment; gives back what happened since the last one. Sets `outcome` at the end."""
        now_s = telemetry.time_s
        if self._began_s is None:
            self._began_s = now_s
            self._text_s = now_s
            self._vehicle_began_s = _vehicle_clock_s(telemetry)
        self._clock_s = self._elapsed(telemetry, now_s)
        notes = [*self._new_texts(texts, now_s)]
        age_s = link_age_s(telemetry)
        heartbeat = telemetry.heartbeat
        if age_s is None or age_s > LOST_AFTER_S or heartbeat is None:
            if not self._lost:
                self._lost = True
                notes.append(Note("lost", "the link is silent: waiting for it, the plane goes on by itself", {}))
            return notes  # nothing is concluded from old values
        if self._lost:
            self._lost = False
            notes.append(Note("regained", "the vehicle is heard again", {}))
        self._armed_seen |= heartbeat.is_armed
        self._look_at_the_ground(telemetry, now_s)
        notes.extend(self._new_items(progress))
        notes.extend(self._mode_change(heartbeat.mode, progress, now_s))
        self._running_seen |= heartbeat.mode in modes.MISSION and not _complete(telemetry, progress)
        self.outcome = self._end(telemetry, progress, heartbeat.mode, heartbeat.is_armed, now_s)
        return notes

    def _elapsed(self, telemetry: Telemetry, now_s: float) -> float:
        vehicle_s = _vehicle_clock_s(telemetry)
        if self._vehicle_began_s is not None and vehicle_s is not None:
            return max(self._clock_s, vehicle_s - self._vehicle_began_s)
        return max(self._clock_s, now_s - (self._began_s or now_s))

    def _new_texts(self, texts: Sequence[StatusText], now_s: float) -> list[Note]:
        after_s = self._text_s
        assert after_s is not None
        fresh = [text for text in texts if text.time_s > after_s]
        if fresh:
            self._text_s = max(text.time_s for text in fresh)
        self._recent = [text for text in texts if now_s - text.time_s <= REASON_WITHIN_S]
        return [
            Note("text", f"{text.severity_name}: {clean(text.text)}", {"severity": text.severity, "said": text.text})
            for text in fresh
        ]

    def _new_items(self, progress: MissionProgress) -> list[Note]:
        notes = []
        reached = frozenset(progress.reached)
        for item in sorted(reached - self._reached):
            name = _item_name(self._plan, item)
            notes.append(Note("item_reached", f"reached item {item}" + (f" {name}" if name else ""), {"item": item}))
        self._reached = reached
        if progress.item is not None:
            self._item = progress.item
        before = self._resumed.item if self._resumed is not None else None
        if before is not None and self._item is not None and self._item != before:
            # The vehicle may go on elsewhere than it left off: to its landing sequence, for instance.
            if self._item > _next_place(self._plan, before):
                self._skipped = self._resumed
            self._resumed = None
        return notes

    def _mode_change(self, mode: str, progress: MissionProgress, now_s: float) -> list[Note]:
        before, self._mode = self._mode, mode
        if mode in modes.MISSION:
            self._auto_seen = True
            if self._left is None:
                return []
            self._resumed, self._left = self._left, None
            text = f"back in {mode} at item {progress.item or '–'}"
            return [Note("mode", text, {"mode": mode, "item": progress.item})]
        if not self._auto_seen or before == mode:
            return []
        reason = self._reason()
        landed = self._flown and not self._flies and self._at_landing()
        if before in modes.MISSION and not landed:
            self._left = _Left(self._item, mode, now_s, reason)
        where = f" at item {self._item}" if self._item is not None else ""
        text = f"mode {before} → {mode}{where}: {reason}"
        return [Note("mode", text, {"mode": mode, "item": self._item, "reason": reason})]

    def _reason(self) -> str:
        words = ("failsafe", "fence", "mission complete", "mode change", "breach", "battery")
        for text in reversed(self._recent):
            if any(word in text.text.lower() for word in words):
                return clean(text.text)
        return "changed by the pilot, another station or the vehicle itself"

    def _at_landing(self) -> bool:
        land = landing_item(self._plan)
        return land is not None and self._item is not None and self._item >= land

    def _look_at_the_ground(self, telemetry: Telemetry, now_s: float) -> None:
        position, hud = telemetry.position, telemetry.hud
        height_m = position.alt_rel_home_m if position else None
        speed_m_s = hud.groundspeed_m_s if hud else None
        said = telemetry.extended.landed if telemetry.extended else None
        flies = said in ("in air", "landing") or (
            said in (None, "undefined") and (height_m or 0.0) > 5.0 and (speed_m_s or 0.0) > 5.0
        )
        self._flies = flies
        if flies:
            self._flown = True
            self._airborne_s = self._airborne_s if self._airborne_s is not None else self._clock_s
            self._ground_s = self._clock_s
            self._rest_since_s = None
        elif self._flown and speed_m_s is not None and speed_m_s < REST_M_S:
            self._rest_since_s = self._rest_since_s if self._rest_since_s is not None else now_s
        else:
            self._rest_since_s = None

    def _end(
        self, telemetry: Telemetry, progress: MissionProgress, mode: str, is_armed: bool, now_s: float
    ) -> Outcome | None:
        complete = self._running_seen and _complete(telemetry, progress)
        if self._left is not None and "mission complete" in self._left.reason.lower():
            complete = True  # reported before MISSION_CURRENT shows it
        at = f"item {self._item} of {progress.total or len(self._plan.items)}" if self._item is not None else "no item"
        if self._armed_seen and not is_armed:
            if not self._flown:
                return Outcome(Ending.NOT_FLOWN, False, f"the plane was disarmed before it flew, at {at}")
            return self._on_ground("disarmed", at, complete)
        if self._rest_since_s is not None and now_s - self._rest_since_s > REST_S:
            return self._on_ground("STILL ARMED", at, complete)
        if complete and self._flown and not ends_with_landing(self._plan) and telemetry.is_on_ground is not True:
            return Outcome(
                Ending.ENDED_IN_AIR, True, f"the mission is flown to its end without a landing: the plane is in {mode}"
            )
        if self._circles_at_the_end(progress, mode):
            return Outcome(
                Ending.ENDED_IN_AIR, True, f"the mission ends circling at {at}: the plane goes on circling in {mode}"
            )
        if self._left is not None and now_s - self._left.since_s > self._patience_s:
            return Outcome(
                Ending.INTERRUPTED,
                False,
                f"the plane left AUTO at item {self._left.item or '–'} for {self._left.mode} ({self._left.reason}) and has "
                f"not come back for {duration(now_s - self._left.since_s)}; it flies on in {mode}",
            )
        return None

    def _on_ground(self, state: str, at: str, complete: bool) -> Outcome:
        left = self._skipped or (None if complete else self._left)
        if left is not None:
            return Outcome(
                Ending.INTERRUPTED,
                False,
                f"the plane is on the ground and {state}, but it left AUTO at item {left.item or '–'} for {left.mode} "
                f"({left.reason})",
            )
        if not complete and not self._at_landing():
            return Outcome(Ending.INTERRUPTED, False, f"the plane came to the ground and is {state} at {at}")
        return Outcome(Ending.LANDED, True, f"the plane has landed and is {state}")

    def _circles_at_the_end(self, progress: MissionProgress, mode: str) -> bool:
        last = last_place(self._plan)
        if last is None or mode not in modes.MISSION or not self._flown or progress.leg_distance_m is None:
            return False
        index, item = last
        if item.command != NAV_LOITER_UNLIM or progress.item != index:
            return False
        radius_m = abs(item.params[2] or 0.0) or 80.0
        return progress.leg_distance_m <= radius_m + 40.0


def _vehicle_clock_s(telemetry: Telemetry) -> float | None:
    system_time = telemetry.system_time
    return None if system_time is None else system_time.boot_ms / 1000.0


def _complete(telemetry: Telemetry, progress: MissionProgress) -> bool:
    state = telemetry.mission.state if telemetry.mission else None
    return progress.is_complete or state == "complete"


def last_place(plan: Plan) -> tuple[int, MissionItem] | None:
    """The last item to go to (not a DO or CONDITION command), with its number counted from 1."""
    for index in range(len(plan.items), 0, -1):
        item = plan.items[index - 1]
        if item.is_nav:
            return index, item
    return None


def _next_place(plan: Plan, item: int) -> int:
    """Number of the next item to go to after one."""
    for index in range(item + 1, len(plan.items) + 1):
        if plan.items[index - 1].is_nav:
            return index
    return len(plan.items)


def landing_item(plan: Plan) -> int | None:
    """Number of the last landing item, counted from 1."""
    for index in range(len(plan.items), 0, -1):
        if plan.items[index - 1].command in (NAV_LAND, NAV_VTOL_LAND):
            return index
    return None


def ends_with_landing(plan: Plan) -> bool:
    """Whether the last place of a plan is a landing."""
    last = last_place(plan)
    return last is not None and last[1].command in (NAV_LAND, NAV_VTOL_LAND)


def distance_from_landing_m(plan: Plan, telemetry: Telemetry) -> float | None:
    """How far from its landing point the plane stands; ``None`` without either."""
    from vencejo import MissionItem, Plan

    index = landing_item(plan)
    position = telemetry.position
    if index is None or position is None or position.lat_deg is None or position.lon_deg is None:
        return None
    item = plan.items[index - 1]
    if item.lat_deg is None or item.lon_deg is None:
        return None
    here = MissionItem.waypoint(position.lat_deg, position.lon_deg, alt_rel_home_m=0.0)
    there = MissionItem.waypoint(item.lat_deg, item.lon_deg, alt_rel_home_m=0.0)
    return Plan(items=(there, here)).length_m
