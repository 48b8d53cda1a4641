"""The simulated plane for tests: on a real link, with its true state available and its time under control.

While a test communicates with it, it flies in real time, so that no state passes unseen by a page on a busy machine.
Parts of a flight that need not be seen are flown fast (`hurry`) up to a permanent state, landed or in the last circle,
or skipped (`skip_to`). Momentary states are frozen (`frozen`).
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
"""Simulated seconds per second in a hurry."""
FLIGHT_S = 600.0
"""Simulated time limit of a condition."""


def offset(north_m: float, east_m: float) -> tuple[float, float]:
    """Return the degrees of a point at an offset from home, at a vehicle's precision; exact enough for plans."""
    return round(LAT + north_m / 111_050.0, 7), round(LON + east_m / 84_980.0, 7)


@dataclass(frozen=True)
class Truth:
    """Position and attitude of the airframe by the flight dynamics model, not by the autopilot's estimate."""

    lat_deg: float
    lon_deg: float
    alt_rel_home_m: float
    roll_deg: float
    pitch_deg: float
    heading_deg: float


class Plane:
    """Simulated planes in this process, on a link of their own, ready to arm.

    `speedup` is the normal pace. More than real time is suitable only for permanent states.
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
        """Link string of the planes."""
        return self._sim.link

    @property
    def port(self) -> int:
        """TCP port of the planes."""
        return self._sim.port

    @property
    def camera(self) -> str:
        """Address of the first plane's nose camera, if it has one."""
        address = self._sim.camera
        assert address is not None, "Plane(camera=…) makes one"
        return address

    def hold(self, roll_deg: float, pitch_deg: float, yaw_deg: float) -> None:
        """Hold the first plane by hand: right wing down, nose up, degrees true."""
        self._sim.hold(roll_deg, pitch_deg, yaw_deg)

    def release(self) -> None:
        """Put it back on its wheels."""
        self._sim.release()

    def truth(self, number: int = 0) -> Truth:
        """Return the true state of a plane, the first by default."""
        return self._call(lambda world: _truth(world, number))

    def _call(self, function: Callable[[World], _T]) -> _T:
        return self._sim.call(function, timeout_s=PATIENCE_S)

    def time_s(self) -> float:
        """Return the simulated time since power-on."""
        return self._call(_time_s)

    def mode(self) -> str:
        """Return its flight mode."""
        return self._call(lambda world: world.planes[0].snapshot().mode.name)

    def has_heard_a_station(self) -> bool:
        """Return whether a ground station's heartbeat was heard, which enables the GCS failsafe."""
        return self._call(lambda world: world.planes[0].station.seen_s is not None)

    def fly(self, seconds: float) -> None:
        """Advance simulated time, for tests that sample at intervals, however long each sample takes."""
        self._call(lambda world: world.advance(seconds))

    def skip_to(self, when: Callable[[Truth], bool]) -> None:
        """Advance simulated time until a condition holds; it has been sent on the links when this returns."""
        then_s = self._jump(lambda world: when(_truth(world, 0)), FLIGHT_S)
        # Links are served between two bursts of ticks.
        wait_for(lambda: self.time_s() > then_s, "the tick after it")

    def _jump(self, holds: Callable[[World], bool], most_s: float) -> float:
        def jump(world: World) -> float:
            assert world.advance(most_s, until=lambda: holds(world)), f"not within {most_s:g} s of simulated time"
            return _time_s(world)

        return self._call(jump)

    @contextlib.contextmanager
    def frozen(self, when: Callable[[Truth], bool] | None = None) -> Iterator[Truth]:
        """Freeze simulated time between two ticks, with everything sent; yield the true state.

        With a condition, time is frozen exactly when it becomes true, however late this is called.
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
        """Hold it by hand with an attitude."""
        angles_rad = [math.radians(angle) for angle in (roll_deg, pitch_deg, heading_deg)]
        self._call(lambda world: world.planes[0].autopilot.move_by_hand(*angles_rad))

    def calm(self) -> None:
        """Return to the normal pace, for communicating with it."""
        self._pace(self._speedup)

    def hurry(self) -> None:
        """Run fast from now on: for a flight without communication, since timeouts run on its own clock."""
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
