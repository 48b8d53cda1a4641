"""A simulated plane that is ready to arm; `python -m tests.booted` is `python -m vencejo.sim` with such planes.

Tests do not wait until a receiver has found its satellites. `--speedup` applies in flight; on the ground, where
programs talk to it, it runs in real time.
"""

from __future__ import annotations

from vencejo.sim import __main__ as program
from vencejo.sim import server
from vencejo.sim.autopilot import Autopilot
from vencejo.sim.config import SimOptions
from vencejo.sim.mavlink.component import AutopilotFactory, PlaneComponent
from vencejo.sim.world import World

BOOT_S = 60.0
"""Simulated time until a plane is ready, at most; a faulty one never is."""
LOOK_S = 0.1
"""Interval of checking whether it is ready: the plane's own interval."""


def boot(world: World) -> None:
    """Run all planes until they are ready to arm."""
    for _ in range(round(BOOT_S / LOOK_S)):
        if not any(_autopilot(plane).prearm() for plane in world.planes):
            return
        world.advance(LOOK_S)


def _autopilot(plane: PlaneComponent) -> Autopilot:
    assert isinstance(plane.autopilot, Autopilot)
    return plane.autopilot


class BootedWorld(World):
    """A world one minute after its start, which runs fast while a plane is armed."""

    def __init__(self, options: SimOptions, *, autopilot: AutopilotFactory | None = None) -> None:
        super().__init__(options, autopilot=autopilot)
        self._in_flight = options.speedup
        self._are_armed: list[bool] = []
        boot(self)
        self._are_armed = []

    def tick(self) -> None:
        """Advance every plane by 10 ms."""
        super().tick()
        are_armed = [_autopilot(plane).armed for plane in self.planes]
        if are_armed != self._are_armed:
            self._are_armed = are_armed
            for plane in self.planes:
                plane.params.set("SIM_SPEEDUP", self._in_flight if any(are_armed) else 1.0)


if __name__ == "__main__":
    # Before its links are open, so that no earlier messages are queued there.
    server.World = BootedWorld  # type: ignore[attr-defined]
    program.main()
