"""The simulated plane as the tests see it: on a real link, with the truth at hand, its time in their hands.

While somebody talks with it, it flies in real time: no state passes before a page on a busy machine has seen it. What nobody has to
see is flown fast (`hurry`) to where it stays, landed or in its last circle, or left out (`skip_to`). What lasts a moment is
stopped there (`frozen`).
"""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import TypeVar

from vencejo.sim.config import SimOptions
from vencejo.sim.server import SimulatedPlane
from vencejo.sim.world import World

from tests.booted import boot
from tests.support import HOME, wait_for

_T = TypeVar("_T")

LAT, LON, _ = HOME
PATIENCE_S = 120.0
HURRY = 60.0
"""Simulated seconds per second when nobody talks with it."""
FLIGHT_S = 600.0
"""Simulated time in which what is waited for happens, at most."""


def offset(north_m: float, east_m: float) -> tuple[float, float]:
    """Degrees of a point that lies so far from home, as fine as a vehicle keeps them. Exact enough to lay out a plan."""
    return round(LAT + north_m / 111_050.0, 7), round(LON + east_m / 84_980.0, 7)


@dataclass(frozen=True)
class Truth:
    """Where the airframe is and how it lies in the air, by the flight dynamics model, not by what the autopilot believes."""

    lat_deg: float
    lon_deg: float
    alt_rel_home_m: float
    roll_deg: float
    pitch_deg: float
    heading_deg: float


class Plane:
    """Simulated planes in this process, on a link of their own, which have been on for long enough to be ready to arm.

    `speedup` is the pace while somebody talks with it. More than real time is for what stays as it is.
    """

    def __init__(self, *, link: str = "tcp:127.0.0.1:0", speedup: float = 1.0, **options: object) -> None:
        self._speedup = speedup
        self._sim = SimulatedPlane(SimOptions(**{"links": (link,), "seed": 7, "speedup": speedup, **options}))  # type: ignore[arg-type]
        self._call(boot)

    def __enter__(self) -> Plane:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._sim.close()

    @property
    def link(self) -> str:
        """Link string to reach it."""
        return self._sim.link

    @property
    def port(self) -> int:
        """TCP port to reach it."""
        return self._sim.port

    @property
    def camera(self) -> str:
        """Address of the first plane's nose camera, when there is one."""
        address = self._sim.camera
        assert address is not None, "Plane(camera=…) makes one"
        return address

    def hold(self, roll_deg: float, pitch_deg: float, yaw_deg: float) -> None:
        """Take the first plane in the hand: right wing down, nose up, degrees true."""
        self._sim.hold(roll_deg, pitch_deg, yaw_deg)

    def release(self) -> None:
        """Put it on its wheels again."""
        self._sim.release()

    def truth(self, number: int = 0) -> Truth:
        """The truth of this instant about a plane, the first by default."""
        return self._call(lambda world: _truth(world, number))

    def _call(self, function: Callable[[World], _T]) -> _T:
        return self._sim.call(function, timeout_s=PATIENCE_S)

    def time_s(self) -> float:
        """Simulated time since it was switched on."""
        return self._call(_time_s)

    def mode(self) -> str:
        """The mode that it flies in."""
        return self._call(lambda world: world.planes[0].snapshot().mode.name)

    def has_heard_a_station(self) -> bool:
        """Whether a ground station's heartbeat was heard, without which no failsafe waits for the next."""
        return self._call(lambda world: world.planes[0].gcs_seen_s is not None)

    def fly(self, seconds: float) -> None:
        """Simulated time jumps ahead, for those who want to look so often, however long each look takes them."""
        self._call(lambda world: world.advance(seconds))

    def skip_to(self, when: Callable[[Truth], bool]) -> None:
        """Simulated time jumps to where a condition holds; that is said on the links when this returns."""
        then_s = self._jump(lambda world: when(_truth(world, 0)), FLIGHT_S)
        # The links have their turn between two bursts of ticks.
        wait_for(lambda: self.time_s() > then_s, "the tick after it")

    def _jump(self, holds: Callable[[World], bool], most_s: float) -> float:
        def jump(world: World) -> float:
            assert world.advance(most_s, until=lambda: holds(world)), f"not within {most_s:g} s of simulated time"
            return _time_s(world)

        return self._call(jump)

    @contextlib.contextmanager
    def frozen(self, when: Callable[[Truth], bool] | None = None) -> Iterator[Truth]:
        """Simulated time stands still, between two ticks and with everything said; gives the truth of that instant.

        With a condition it stands where that comes to hold, however late this is asked.
        """
        if when is not None:
            self.skip_to(when)
        stands, goes_on = threading.Event(), threading.Event()
        seen: list[Truth] = []

        def stand_still(world: World) -> None:
            seen.append(_truth(world, 0))
            stands.set()
            goes_on.wait()

        holder = threading.Thread(target=self._sim.call, args=(stand_still,), kwargs={"timeout_s": None})
        holder.start()
        try:
            assert stands.wait(PATIENCE_S), "the simulator is busy"
            yield seen[0]
        finally:
            goes_on.set()
            holder.join()

    def move_by_hand(self, *, roll_deg: float, pitch_deg: float, heading_deg: float) -> None:
        """Hold it in the hand with an attitude."""
        angles_rad = [math.radians(angle) for angle in (roll_deg, pitch_deg, heading_deg)]
        self._call(lambda world: world.planes[0].autopilot.move_by_hand(*angles_rad))

    def calm(self) -> None:
        """Simulated time goes as it did at first, for those who talk with it."""
        self._pace(self._speedup)

    def hurry(self) -> None:
        """Simulated time goes fast from now on: for a flight in which nobody talks with it, as its patience is by its own clock."""
        self._pace(HURRY)

    def _pace(self, speedup: float) -> None:
        self._call(lambda world: [plane.params.set("SIM_SPEEDUP", speedup) for plane in world.planes])


def _time_s(world: World) -> float:
    return world.planes[0].autopilot.time_s


def _truth(world: World, number: int) -> Truth:
    autopilot = world.planes[number].autopilot
    body = autopilot.body  # type: ignore[attr-defined]
    return Truth(
        lat_deg=body.lat_deg,
        lon_deg=body.lon_deg,
        alt_rel_home_m=body.height_m,
        roll_deg=math.degrees(body.roll_rad),
        pitch_deg=math.degrees(body.pitch_rad),
        heading_deg=math.degrees(body.yaw_rad) % 360.0,
    )
