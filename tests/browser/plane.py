"""The simulated plane as the tests see it: on a real link, with the truth at hand, and able to stand still in time."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType

from vencejo.sim.config import SimOptions
from vencejo.sim.server import SimulatedPlane
from vencejo.sim.world import World

from tests.support import HOME

LAT, LON, _ = HOME
PATIENCE_S = 60.0


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
    """Simulated planes in this process, on a link of their own."""

    def __init__(self, *, link: str = "tcp:127.0.0.1:0", **options: object) -> None:
        self._speedup = float(options.get("speedup", 1.0))  # type: ignore[arg-type]
        self._sim = SimulatedPlane(SimOptions(**{"links": (link,), "seed": 7, **options}))  # type: ignore[arg-type]

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

    def truth(self, number: int = 0) -> Truth:
        """The truth of this instant about a plane, the first by default."""
        return self._sim.call(lambda world: _truth(world, number))

    @contextlib.contextmanager
    def frozen(self) -> Iterator[Truth]:
        """Simulated time stands still, between two ticks and with everything said; gives the truth of that instant."""
        stands, goes_on = threading.Event(), threading.Event()
        seen: list[Truth] = []

        def stand_still(world: World) -> None:
            seen.append(_truth(world, 0))
            stands.set()
            assert goes_on.wait(PATIENCE_S), "the plane was left frozen"

        holder = threading.Thread(target=self._sim.call, args=(stand_still,))
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
        self._sim.call(lambda world: world.planes[0].autopilot.move_by_hand(*angles_rad))

    def calm(self) -> None:
        """Simulated time goes as it did at first, for those who talk with it."""
        self._sim.call(lambda world: [plane.params.set("SIM_SPEEDUP", self._speedup) for plane in world.planes])

    def hurry(self) -> None:
        """Simulated time goes faster from now on: for a flight in which nobody talks with it, as its patience is by its own clock."""
        self._sim.call(lambda world: [plane.params.set("SIM_SPEEDUP", 60.0) for plane in world.planes])

    def reboot(self) -> None:
        """The autopilot starts anew."""
        self._sim.call(lambda world: world.planes[0].autopilot.reboot())


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
