"""Flight modes by what they do, of every kind of vehicle that the core knows."""

from __future__ import annotations

from typing import Final

from vencejo import _native

__all__ = ["GUIDED", "LOITER", "MISSION", "RETURN", "TAKEOFF"]

MISSION: Final = frozenset(_native.modes_for("mission"))
"""Follows the mission: AUTO, on a PX4 AUTO_MISSION."""
LOITER: Final = frozenset(_native.modes_for("loiter"))
RETURN: Final = frozenset(_native.modes_for("return"))
TAKEOFF: Final = frozenset(_native.modes_for("takeoff"))
GUIDED: Final = frozenset(_native.modes_for("guided"))
