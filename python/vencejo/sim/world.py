"""All simulated planes of one process, without clock or sockets: deterministic, advanced by calls."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable

from vencejo.sim.autopilot.interface import DT_S
from vencejo.sim.config import SimOptions
from vencejo.sim.hand import CARRY_HEIGHT_M, HandSequence
from vencejo.sim.mavlink.codec import Decoder, MavMessage, dialect
from vencejo.sim.mavlink.component import AutopilotFactory, PlaneComponent
from vencejo.sim.mavlink.link import Link
from vencejo.sim.params import ParamStore

__all__ = ["MemoryLink", "World"]


class World:
    """The planes, and the links that carry them.

    Parameters
    ----------
    options : SimOptions
        ``links`` and ``speedup`` are ignored here.
    autopilot : callable, optional
        Factory of the flying half of each plane; the real one when omitted.

    Examples
    --------
    >>> world = World(SimOptions(seed=7))  # doctest: +SKIP
    >>> world.advance(30.0)  # doctest: +SKIP
    >>> world.planes[0].snapshot().gps_fix_type  # doctest: +SKIP
    6
    """

    def __init__(self, options: SimOptions, *, autopilot: AutopilotFactory | None = None) -> None:
        self.planes = [
            PlaneComponent(
                options.plane(number),
                params=ParamStore.arduplane(options.params),
                autopilot=autopilot,
                unix_s_at_boot=options.start_unix_s,
            )
            for number in range(options.planes)
        ]
        self._carried: dict[Link, list[PlaneComponent]] = {}
        self._shown_by_hand = [HandSequence(options.heading_deg) for _ in self.planes] if options.by_hand else []

    def attach(self, link: Link, planes: list[PlaneComponent] | None = None) -> None:
        """Add a link; it carries all planes by default."""
        self._carried[link] = list(planes if planes is not None else self.planes)
        for plane in self._carried[link]:
            plane.attach(link)

    def detach(self, link: Link) -> None:
        """Remove a link."""
        for plane in self._carried.pop(link, []):
            plane.detach(link)

    def receive(self, link: Link, data: bytes) -> None:
        """Handle bytes received on a link."""
        for message in link.receive(data):
            for plane in self._carried.get(link, ()):
                plane.on_message(link, message)

    def tick(self) -> None:
        """Advance every plane by 10 ms."""
        for plane, sequence in zip(self.planes, self._shown_by_hand, strict=False):
            self._show_by_hand(plane, sequence)
        for plane in self.planes:
            plane.tick()

    def hold(
        self,
        roll_deg: float,
        pitch_deg: float,
        yaw_deg: float,
        *,
        seconds: float = 0.0,
        north_m: float = 0.0,
        east_m: float = 0.0,
        up_m: float = CARRY_HEIGHT_M,
        plane: int = 0,
    ) -> None:
        """Hold a plane by hand: see :meth:`vencejo.sim.SimulatedPlane.hold`."""
        values = (roll_deg, pitch_deg, yaw_deg, seconds, north_m, east_m, up_m)
        if not all(map(math.isfinite, values)):
            raise ValueError(f"hold{values}: every number must be finite")
        self.planes[plane].autopilot.move_by_hand(
            math.radians(roll_deg),
            math.radians(pitch_deg),
            math.radians(yaw_deg),
            seconds=seconds,
            offset_ned_m=(north_m, east_m, -up_m),
        )

    def release(self, *, plane: int = 0) -> None:
        """Put a held plane down, in place and with its heading."""
        self.planes[plane].autopilot.put_down()

    @staticmethod
    def _show_by_hand(plane: PlaneComponent, sequence: HandSequence) -> None:
        due = sequence.due(plane.autopilot.time_s)
        if due is None or plane.snapshot().armed:
            return
        (roll_deg, pitch_deg, heading_deg, _), seconds = due
        # A plane that falls after a forced disarming cannot be held.
        with contextlib.suppress(RuntimeError):
            plane.autopilot.move_by_hand(
                math.radians(roll_deg), math.radians(pitch_deg), math.radians(heading_deg), seconds=seconds
            )

    def advance(self, seconds: float, *, until: Callable[[], bool] | None = None) -> bool:
        """Advance simulated time, at most until a condition holds; True when it holds, or without one."""
        for _ in range(round(seconds / DT_S)):
            if until is not None and until():
                return True
            self.tick()
        return until is None or until()

    def connect(self, *, system: int = 255, component: int = 190) -> MemoryLink:
        """Connect a station in memory, for tests."""
        return MemoryLink(self, system=system, component=component)


class MemoryLink:
    """A station connected without a socket: sends messages and keeps the received ones, in order."""

    def __init__(self, world: World, *, system: int, component: int) -> None:
        self.link = Link("memory")
        self._world = world
        self._packer = dialect.MAVLink(None, srcSystem=system, srcComponent=component)
        self._decoder = Decoder()
        world.attach(self.link)

    def send(self, message: MavMessage, *, mavlink1: bool = False) -> None:
        """Frame a message and hand it to the planes."""
        self.send_bytes(message.pack(self._packer, force_mavlink1=mavlink1))
        self._packer.seq = (self._packer.seq + 1) % 256

    def send_bytes(self, data: bytes) -> None:
        """Hand raw bytes to the planes."""
        self._world.receive(self.link, data)

    def receive(self) -> list[MavMessage]:
        """All queued messages, in sending order."""
        return self._decoder.feed(b"".join(self.link.take(1 << 30)))

    def close(self) -> None:
        """Disconnect."""
        self._world.detach(self.link)
