"""Speed of the simulated plane without a link: ``python -m vencejo.sim.bench``.

Flies a plane in circles and prints simulated seconds per second of one core, and the cost of a step and of a telemetry
snapshot.
"""

from __future__ import annotations

import statistics
import sys
import time

from vencejo.sim.autopilot import Autopilot, SimConfig
from vencejo.sim.autopilot.interface import DT_S, Mode
from vencejo.sim.autopilot.testing import FixedParameters, FixedPlan

__all__ = ["main", "measure"]


def measure(*, gust_m_s: float, seconds: float = 60.0, rounds: int = 3) -> tuple[float, float]:
    """Median real-time factor over some rounds, and microseconds per snapshot.

    Parameters
    ----------
    gust_m_s : float
        Turbulence scale; 0 is smooth air.
    seconds : float
        Simulated seconds of one round.
    rounds : int
        Number of rounds.
    """
    plane = Autopilot(config=SimConfig(gust_m_s=gust_m_s), params=FixedParameters(), plan=FixedPlan())
    plane.set_mode(Mode.TAKEOFF)
    plane.arm()
    for _ in range(round(30.0 / DT_S)):
        plane.step()
    factors = []
    for _ in range(rounds):
        start = time.process_time()
        for _ in range(round(seconds / DT_S)):
            plane.step()
        factors.append(seconds / (time.process_time() - start))
        plane.events()
    count = 2000
    start = time.process_time()
    for _ in range(count):
        plane.snapshot()
    return statistics.median(factors), 1e6 * (time.process_time() - start) / count


def main() -> None:
    """Print the figures."""
    for name, gust in (("smooth air", 0.0), ("gusts of 5 m/s", 5.0)):
        factor, snapshot_us = measure(gust_m_s=gust)
        sys.stdout.write(
            f"{name}: {factor:.0f} times real time, {1e6 * DT_S / factor:.1f} us per step, {snapshot_us:.0f} us per snapshot\n"
        )


if __name__ == "__main__":
    main()
