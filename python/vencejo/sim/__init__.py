"""The simulated plane: a JSBSim foam pusher flown by an ArduPlane-like autopilot that speaks MAVLink.

An independent peer on a real link: it shares no protocol code with the driver and never imports it.

>>> from vencejo.sim import SimOptions, SimulatedPlane
>>> with SimulatedPlane(SimOptions(links=("tcp:127.0.0.1:0",))) as sim:  # doctest: +SKIP
...     ...  # connect to sim.link
"""

from __future__ import annotations

from vencejo.sim.config import SimOptions
from vencejo.sim.server import Listening, SimulatedPlane, run

__all__ = ["Listening", "SimOptions", "SimulatedPlane", "main", "run"]


def main(argv: list[str] | None = None) -> int:
    """``python -m vencejo.sim``: see :func:`vencejo.sim.__main__.main`."""
    from vencejo.sim.__main__ import main as entry

    return entry(argv)
