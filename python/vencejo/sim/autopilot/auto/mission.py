"""The flow of a mission: navigation commands, DO and CONDITION commands, jumps and landing sequences.

One navigation command is flown at a time. The DO and CONDITION commands before the next navigation command run one
after another meanwhile; those not reached when it completes are skipped, as by ArduPlane. The host executes the
commands.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from typing import Protocol

from vencejo.sim.autopilot.geo import ground_distance_m
from vencejo.sim.autopilot.interface import PlanView, Severity, StoredItem

from .names import AT_ONCE, Cmd, is_nav, word

__all__ = ["MissionHost", "MissionRunner", "RunState"]

_FIRST = 1
_FOREVER = -1
_HISTORY = 7
"""Number of past waypoints kept (AP_MISSION_MAX_WP_HISTORY)."""
_LANDINGS = (Cmd.NAV_LAND, Cmd.NAV_VTOL_LAND)
_TAKEOFFS = (Cmd.NAV_TAKEOFF, Cmd.NAV_VTOL_TAKEOFF)


class RunState(Enum):
    """State of the mission."""

    STOPPED = 0
    RUNNING = 1
    COMPLETE = 2


class MissionHost(Protocol):
    """Executes the commands of a mission."""

    def start_command(self, item: StoredItem) -> bool:
        """Start a command; False when the plane cannot execute it."""
        ...

    def verify_command(self, item: StoredItem) -> bool:
        """True when the command is complete."""
        ...

    def mission_complete(self) -> None:
        """The last command is complete."""
        ...

    def say(self, severity: Severity, text: str) -> None:
        """Send a status text."""
        ...

    def where(self) -> tuple[float, float]:
        """Latitude and longitude of the plane, degrees."""
        ...


class MissionRunner:
    """Runs the stored mission.

    Attributes
    ----------
    state : RunState
        State of the mission.
    nav : StoredItem or None
        The present or last navigation command.
    in_landing_sequence, in_return_path : bool
        Set by landing commands and by jumps into those parts of the mission.
    """

    def __init__(self, plan: PlanView, host: MissionHost) -> None:
        self._plan = plan
        self._host = host
        self._revision = plan.mission_revision
        self._clears = plan.mission_clears
        self.state = RunState.STOPPED
        self.nav: StoredItem | None = None
        self.in_landing_sequence = False
        self.in_return_path = False
        self.previous_nav_command: int | None = None
        self._nav_loaded = False
        self._do: StoredItem | None = None
        self._do_loaded = False
        self._do_all_done = False
        self._previous_wp_seq: int | None = None
        self._jumps: dict[int, int] = {}
        self._way: deque[StoredItem] = deque(maxlen=_HISTORY)
        """The last waypoints flown to, the present one last."""
        self._repeat_m = 0.0
        self._resume: StoredItem | None = None
        self._resuming = False
        self._left_at: tuple[float, float] | None = None

    # reading

    @property
    def nav_command(self) -> int | None:
        """MAV_CMD of the present navigation command."""
        return None if self.nav is None else self.nav.command

    @property
    def total(self) -> int:
        """Number of items, home excluded."""
        return max(0, len(self._plan.mission) - 1)

    @property
    def current_seq(self) -> int:
        """Sequence number of the present navigation command, 0 before the first."""
        return 0 if self.nav is None else self.nav.seq

    def next_nav(self, start: int) -> StoredItem | None:
        """The navigation command at or after ``start``; jumps are followed but not counted."""
        seq = start
        for _ in range(self.total + 1):
            item = self._next(seq, count=False)
            if item is None or is_nav(item.command):
                return item
            seq = item.seq + 1
        return None

    def starts_with_takeoff(self, *, restart: bool) -> bool:
        """True when the next navigation command is a take-off; with ``restart`` that of the mission's beginning."""
        start = _FIRST if restart or self.nav is None else self.nav.seq
        for _ in range(16):
            item = self.next_nav(start)
            if item is None:
                return False
            if item.command in _TAKEOFFS:
                return True
            if item.command != Cmd.NAV_DELAY:
                return False
            start = item.seq + 1
        return False

    # running

    def start_or_resume(self, *, restart: bool) -> None:
        """Enter AUTO: resume the mission, or start it from the beginning."""
        self._forget_removed()
        if restart or self.state is RunState.COMPLETE or self.nav is None or self.nav.seq >= len(self._plan.mission):
            self._start()
            return
        self.state = RunState.RUNNING
        if self._rewind():
            return
        if self._do_loaded and self._do is not None:
            self.set_current(self._do.seq)
        elif self._nav_loaded:
            self.set_current(self.nav.seq)

    def stop(self) -> None:
        """Stop the mission, when AUTO is left."""
        if self.state is RunState.RUNNING:
            self.state = RunState.STOPPED

    def reset(self) -> None:
        """Return to before the first command."""
        self.nav = None
        self.previous_nav_command = None
        self._previous_wp_seq = None
        self.in_landing_sequence = self.in_return_path = False
        self._nav_loaded = self._do_loaded = self._do_all_done = False
        self._do = None
        self._jumps.clear()
        self._forget_way()

    def repeat_on_resume(self, distance_m: float) -> None:
        """DO_SET_RESUME_REPEAT_DIST: an interrupted mission resumes this far back along the path flown."""
        self._repeat_m = distance_m

    def update(self) -> list[int]:
        """Verify the running commands, 10 times a second; returns the items that were completed."""
        reached: list[int] = []
        if self.state is not RunState.RUNNING or self.total == 0:
            return reached
        self._left_at = self._host.where()
        if not self._nav_loaded or self.nav is None:
            if not self._advance_nav(None):
                self._complete()
                return reached
        elif self._verify(self.nav, reached):
            self._nav_loaded = False
            if not self._advance_nav(None):
                self._complete()
                return reached
        if not self._running():
            # A command has changed the mode.
            return reached
        if not self._do_loaded:
            self._advance_do()
        elif self._do is not None and self._verify(self._do, reached):
            self._do_loaded = False
        return reached

    def notice_change(self) -> bool:
        """Stop and reset the present command when the mission was removed; True when the mission has changed."""
        self._forget_removed()
        revision = self._plan.mission_revision
        is_new = revision != self._revision
        self._revision = revision
        return is_new

    def set_current(self, seq: int) -> bool:
        """Make an item the current one; False when it does not exist."""
        self._forget_removed()
        self.in_landing_sequence = self.in_return_path = False
        self._forget_way()
        items = self._plan.mission
        if not 0 <= seq < len(items) or self.total == 0:
            return False
        self.in_landing_sequence = items[seq].command == Cmd.DO_LAND_START
        self.in_return_path = items[seq].command == Cmd.DO_RETURN_PATH_START
        self._do = None
        self._do_loaded = self._do_all_done = self._nav_loaded = False
        if seq == 0 or self.state is RunState.COMPLETE:
            self.previous_nav_command = None
            self._previous_wp_seq = None
            self._jumps.clear()
            seq = max(seq, _FIRST)
        if self.state is RunState.RUNNING:
            if not self._advance_nav(seq):
                self._complete()
                return False
            return True
        # Not running: only set where the mission resumes.
        for _ in range(self.total + 1):
            item = self._next(seq, count=True)
            if item is None:
                self.nav = None
                return False
            if is_nav(item.command):
                self.nav = item
                self._nav_loaded = True
                break
            if not self._do_loaded:
                self._do, self._do_loaded = item, True
            seq = item.seq + 1
        self._do_all_done = not self._do_loaded
        self.state = RunState.STOPPED
        return True

    # landing and return

    def landing_start(self, distance_to: Callable[[StoredItem], float | None]) -> int | None:
        """The nearest DO_LAND_START. ``distance_to`` returns None for an item without a position."""
        best: tuple[float, int] | None = None
        for item in self._plan.mission[_FIRST:]:
            if item.command != Cmd.DO_LAND_START:
                continue
            distance = distance_to(item)
            if distance is None:
                following = self.next_nav(item.seq)
                distance = None if following is None else distance_to(following)
            if distance is not None and (best is None or distance < best[0]):
                best = (distance, item.seq)
        return None if best is None else best[1]

    def jump_to_landing(self, distance_to: Callable[[StoredItem], float | None]) -> bool:
        """Jump to the nearest landing sequence; False and a warning without one."""
        seq = self.landing_start(distance_to)
        if seq is not None and self.set_current(seq):
            if self.state is RunState.STOPPED:
                self.start_or_resume(restart=False)
            self._host.say(Severity.INFO, "Landing sequence start")
            self.in_landing_sequence = True
            return True
        self._host.say(Severity.WARNING, "Unable to start landing sequence")
        return False

    def jump_to_abort(self, distance_to: Callable[[StoredItem], float | None]) -> bool:
        """Jump to the nearest DO_GO_AROUND, the start of an abort pattern; False and a warning without one."""

        def distance_m(item: StoredItem) -> float:
            distance = distance_to(item)
            return math.inf if distance is None else distance

        patterns = [item for item in self._plan.mission[_FIRST:] if item.command == Cmd.DO_GO_AROUND]
        if patterns and self.set_current(min(patterns, key=distance_m).seq):
            self._host.say(Severity.INFO, "Landing abort sequence start")
            return True
        self._host.say(Severity.WARNING, "Unable to start find a landing abort sequence")
        return False

    def jump_to_return_path(self, distance_to: Callable[[StoredItem], float | None]) -> bool:
        """Join the return path (the items after a DO_RETURN_PATH_START) at its nearest waypoint."""
        if self.state is RunState.RUNNING and self.in_landing_sequence:
            self._host.say(Severity.INFO, "Landing sequence active")
            return True
        if self.state is RunState.RUNNING and self.in_return_path:
            self._host.say(Severity.INFO, "Return path active")
            return True
        best: tuple[float, int] | None = None
        inside = False
        for item in self._plan.mission[_FIRST:]:
            if item.command == Cmd.DO_RETURN_PATH_START:
                inside = True
            elif inside and (item.command == Cmd.DO_LAND_START or item.command in _LANDINGS):
                inside = False
            elif inside and is_nav(item.command):
                distance = distance_to(item)
                if distance is not None and (best is None or distance < best[0]):
                    best = (distance, item.seq)
        if best is not None and self.set_current(best[1]):
            if self.state is RunState.STOPPED:
                self.start_or_resume(restart=False)
            self._host.say(Severity.INFO, "Return path started")
            self.in_return_path = True
            return True
        return False

    def restart_landing(self, distance_to: Callable[[StoredItem], float | None]) -> bool:
        """Restart an aborted landing: at the climb item after it, at DO_LAND_START, or at the waypoint before it."""
        if self.nav is None or self.nav.command != Cmd.NAV_LAND:
            return False
        items = self._plan.mission
        after = self.nav.seq + 1
        if after < len(items) and items[after].command == Cmd.NAV_CONTINUE_AND_CHANGE_ALT and items[after].p1 in (0, 1):
            alt = items[after].alt_m
            if self.set_current(after):
                self._host.say(Severity.NOTICE, f"Restarted landing sequence. Climbing to {alt:.0f}m")
                return True
        start = self.landing_start(distance_to)
        if start is not None and self.set_current(start):
            self._host.say(Severity.NOTICE, f"Restarted landing via DO_LAND_START: {start}")
            return True
        previous = self._previous_wp_seq
        if previous is not None and self.set_current(previous):
            self._host.say(Severity.NOTICE, f"Restarted landing sequence at waypoint {previous}")
            return True
        self._host.say(Severity.WARNING, "Unable to restart landing sequence")
        return False

    # internals

    def _forget_removed(self) -> None:
        """Apply a removal of the mission (AP_Mission::clear). Landing flag and jump counters remain."""
        clears = self._plan.mission_clears
        if clears != self._clears:
            self._clears = clears
            self.nav = self._do = None
            self._nav_loaded = self._do_loaded = False
            self.state = RunState.STOPPED

    def _running(self) -> bool:
        return self.state is RunState.RUNNING

    def _start(self) -> None:
        self.state = RunState.RUNNING
        self.reset()
        if not self._advance_nav(None):
            self._complete()

    def _complete(self) -> None:
        self.state = RunState.COMPLETE
        self.in_landing_sequence = self.in_return_path = False
        self._host.mission_complete()

    def _verify(self, item: StoredItem, reached: list[int]) -> bool:
        if item.command in AT_ONCE:
            return True
        if not self._host.verify_command(item):
            return False
        reached.append(item.seq)
        return True

    def _begin(self, item: StoredItem) -> bool:
        # AP_Mission::is_landing_type_cmd counts the parachute as a landing.
        if item.command in (*_LANDINGS, Cmd.DO_PARACHUTE, Cmd.DO_LAND_START):
            self.in_landing_sequence = True
        elif item.command == Cmd.DO_RETURN_PATH_START:
            self.in_return_path = True
        elif item.command in _TAKEOFFS:
            self.in_landing_sequence = self.in_return_path = False
        text = f"Mission: {item.seq} {word(item.command)}"
        if item.command in (Cmd.JUMP_TAG, Cmd.DO_JUMP_TAG):
            text += f" {int(item.p1)}"
        self._host.say(Severity.INFO, text)
        return self._host.start_command(item)

    def _advance_nav(self, start: int | None) -> bool:
        if self.state is not RunState.RUNNING or self._nav_loaded:
            return False
        self._do = None
        self._do_loaded = self._do_all_done = False
        seq = start if start is not None else (_FIRST if self.nav is None else self.nav.seq + 1)
        for _ in range(255):
            item = self._next(seq, count=True)
            if item is None:
                return False
            if is_nav(item.command):
                if self.nav is not None:
                    self.previous_nav_command = self.nav.command
                    if self.nav.lat_deg != 0.0 or self.nav.lon_deg != 0.0:
                        self._previous_wp_seq = self.nav.seq
                self.nav = item
                if self._begin(item):
                    self._nav_loaded = True
                    self._do_all_done = not self._do_loaded
                    self._remember(item)
                    return True
                if not self._running():
                    return True
            elif not self._do_loaded:
                self._do, self._do_loaded = item, True
                self._begin(item)
            seq = item.seq + 1
        return False

    # resuming further back (AP_Mission::calc_rewind_pos)

    def _forget_way(self) -> None:
        self._way.clear()
        self._repeat_m = 0.0
        self._resume = self._left_at = None
        self._resuming = False

    def _remember(self, item: StoredItem) -> None:
        if self._repeat_m > 0 and not self._resuming and (item.lat_deg != 0.0 or item.lon_deg != 0.0):
            self._way.append(item)
        if self._resuming and self._way and item.seq == self._way[-1].seq:
            self._host.say(Severity.INFO, "Mission: Returned to interrupted WP")
            self._resuming = False

    def _rewind(self) -> bool:
        """Resume at a point back along the path flown; False without a repeat distance or a path."""
        if self._repeat_m <= 0 or len(self._way) < 2 or self._left_at is None:
            return False
        if not self._resuming:
            self._resume = self._behind(self._left_at)
        if self._resume is None or not self._begin(self._resume):
            return False
        self.nav, self._nav_loaded = self._resume, True
        self._resuming = True
        return True

    def _behind(self, here: tuple[float, float]) -> StoredItem:
        """The point one repeat distance back along the path: between two past waypoints, or the oldest one kept."""
        *passed, _ = self._way
        left_m = self._repeat_m
        following: StoredItem | None = None
        for item in reversed(passed):
            leg_m = ground_distance_m(item.lat_deg, item.lon_deg, *here)
            left_m -= leg_m
            if left_m <= 0.0:
                # On the last leg the point lies between this waypoint and the position at which the mission was left;
                # as in ArduPlane the share is that of the whole leg.
                after = self._way[-1] if following is None else following
                whole_m = ground_distance_m(item.lat_deg, item.lon_deg, after.lat_deg, after.lon_deg)
                part = -left_m / whole_m if whole_m > 0.0 else 0.0
                return replace(
                    item,
                    lat_deg=item.lat_deg + (after.lat_deg - item.lat_deg) * part,
                    lon_deg=item.lon_deg + (after.lon_deg - item.lon_deg) * part,
                    alt_m=item.alt_m + (after.alt_m - item.alt_m) * part,
                )
            here = (item.lat_deg, item.lon_deg)
            following = item
        return passed[0]

    def _advance_do(self) -> None:
        if self._do_all_done or self._do is None:
            return
        item = self._next(self._do.seq + 1, count=False)
        if item is None or is_nav(item.command):
            self._do_all_done = True
            return
        self._do, self._do_loaded = item, True
        self._begin(item)

    def _next(self, start: int, *, count: bool) -> StoredItem | None:
        """The first command at or after ``start`` that is not a jump."""
        items = self._plan.mission
        seq = start
        first_jump: int | None = None
        for _ in range(64 + len(items)):
            if not _FIRST <= seq < len(items):
                return None
            item = items[seq]
            if item.command == Cmd.DO_JUMP:
                target = int(item.p1) if math.isfinite(item.p1) else 0
            elif item.command == Cmd.DO_JUMP_TAG:
                target = self._tag(int(item.p1) if math.isfinite(item.p1) else -1)
            else:
                return item
            if not _FIRST <= target < len(items):
                return None
            if not count and first_jump == seq:
                return None
            first_jump = seq if first_jump is None else first_jump
            times = int(item.p2)
            done = self._jumps.get(seq, 0)
            if times == _FOREVER or done < times:
                if count:
                    self._jumps[seq] = done + 1
                    shown = "unlimited" if times == _FOREVER else str(times)
                    self._host.say(Severity.INFO, f"Mission: {seq} Jump {done + 1}/{shown}")
                seq = target
            else:
                seq += 1
        return None

    def _tag(self, tag: int) -> int:
        for item in self._plan.mission[_FIRST:]:
            if item.command == Cmd.JUMP_TAG and int(item.p1) == tag:
                return item.seq
        return 0
