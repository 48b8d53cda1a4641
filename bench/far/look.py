"""An operator's view during a benchmark: rate of new states, and duration of commands."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from bench.far.field import Ground
from bench.harness import NotMeasured, quantile

#: Modes that a plane on the ground accepts at once, in turn.
MODES = ("FBWA", "MANUAL")


class Watch(threading.Thread):
    """Polls a plane twenty times a second, like a page that shows this plane only."""

    LOOK_S = 0.05

    def __init__(self, ground: Ground, at: str) -> None:
        super().__init__(daemon=True)
        self._ground, self._at = ground, at
        self._is_over = threading.Event()
        self._began = time.monotonic()
        self._lasted_s = 0.0
        self._states = 0

    @property
    def states_hz(self) -> float:
        """Return the rate of new states, per second."""
        return self._states / self._lasted_s

    def run(self) -> None:
        """Poll until stopped."""
        newest = -1.0
        while not self._is_over.wait(self.LOOK_S):
            asked = time.monotonic()
            attitude = self._ground.telemetry(self._at).get("attitude")
            said = newest if attitude is None else asked - attitude["age_s"]
            # Ages of the same state agree only within the duration of an answer.
            if said > newest + self.LOOK_S:
                newest, self._states = said, self._states + 1
            self._lasted_s = time.monotonic() - self._began

    def __enter__(self) -> Watch:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self.join()


class Manned(threading.Thread):
    """Keeps an operator's control of a ground station, as an open page does."""

    EVERY_S = 2.0

    def __init__(self, ground: Ground) -> None:
        super().__init__(daemon=True)
        self._ground = ground
        self._is_over = threading.Event()

    def run(self) -> None:
        """Take control again and again until stopped."""
        while not self._is_over.wait(self.EVERY_S):
            self._ground.client.done("POST", "control/take")

    def __enter__(self) -> Manned:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self.join()


@dataclass
class Orders:
    """Results of commands: durations of successful ones, ms, and number of failures."""

    took_ms: list[float] = field(default_factory=list)
    failed: int = 0
    first: int = 0
    """Number of the first of these commands."""

    @property
    def next(self) -> int:
        """Return the number of the next command."""
        return self.first + len(self.took_ms) + self.failed

    @property
    def figures(self) -> dict[str, float]:
        """Return median, 99 %, worst, and number of failures."""
        if not self.took_ms:
            raise NotMeasured(f"none of {self.failed} orders was done")
        return {
            "command_median_ms": quantile(self.took_ms, 0.5),
            "command_p99_ms": quantile(self.took_ms, 0.99),
            "worst_command_ms": max(self.took_ms),
            "commands": float(len(self.took_ms)),
            "worst_failed": float(self.failed),
        }


def order(ground: Ground, at: str, number: int = 0) -> bool:
    """Change a plane's mode; return whether it succeeded."""
    return ground.client.ask("POST", f"{at}/mode", {"mode": MODES[number % len(MODES)]}).status < 300


def orders_for(ground: Ground, planes: Sequence[str], seconds: float, orders: Orders | None = None) -> Orders:
    """Command planes in turn for a time, with a quarter of a second between commands.

    The numbers go on from earlier ``orders``: a plane that is commanded into the mode that it is in shows that with its
    next heartbeat only, up to a second later.
    """
    orders = orders or Orders()
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        began, number = time.monotonic(), orders.next
        if order(ground, planes[number % len(planes)], number // len(planes)):
            orders.took_ms.append((time.monotonic() - began) * 1e3)
        else:
            orders.failed += 1
        time.sleep(0.25)
    return orders
