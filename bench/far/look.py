"""What an operator sees and does meanwhile: how often a plane's state is new, and how long its orders take."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from bench.far.field import Ground
from bench.harness import NotMeasured, quantile

#: Modes that a plane on the ground takes at once, in turn.
MODES = ("FBWA", "MANUAL")


class Watch(threading.Thread):
    """Looks at a plane twenty times a second, as a page that shows it alone does."""

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
        """States that were new, a second."""
        return self._states / self._lasted_s

    def run(self) -> None:
        """Look until it is over."""
        newest = -1.0
        while not self._is_over.wait(self.LOOK_S):
            asked = time.monotonic()
            attitude = self._ground.telemetry(self._at).get("attitude")
            said = newest if attitude is None else asked - attitude["age_s"]
            # The same one is counted back to within what an answer takes.
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
    """Keeps an operator's control of a ground station, as a page that is open does."""

    EVERY_S = 2.0

    def __init__(self, ground: Ground) -> None:
        super().__init__(daemon=True)
        self._ground = ground
        self._is_over = threading.Event()

    def run(self) -> None:
        """Take it again and again until it is over."""
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
    """How orders went: how long those took that were done, ms, and how many were not."""

    took_ms: list[float] = field(default_factory=list)
    failed: int = 0

    @property
    def figures(self) -> dict[str, float]:
        """Median, 99 %, worst, and how many were not done."""
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
    """Have a plane change its mode; whether it was done."""
    return ground.client.ask("POST", f"{at}/mode", {"mode": MODES[number % len(MODES)]}).status < 300


def orders_for(ground: Ground, planes: Sequence[str], seconds: float, orders: Orders | None = None) -> Orders:
    """Give orders to planes in turn, with a quarter of a second between, for so long."""
    orders = orders or Orders()
    until, number = time.monotonic() + seconds, 0
    while time.monotonic() < until:
        began = time.monotonic()
        if order(ground, planes[number % len(planes)], number // len(planes)):
            orders.took_ms.append((time.monotonic() - began) * 1e3)
        else:
            orders.failed += 1
        number += 1
        time.sleep(0.25)
    return orders
