"""The ArduPlane-like autopilot of the simulated plane."""

from .core import Autopilot
from .interface import SimConfig

__all__ = ["Autopilot", "SimConfig"]
