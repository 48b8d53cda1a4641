"""Fixed parameters and a fixed plan, for tests, examples and measurements without a link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .interface import RallyPoint, StoredItem

__all__ = ["FixedParameters", "FixedPlan", "home_item", "item"]


class FixedParameters:
    """Parameters from a mapping; other names have the autopilot's defaults."""

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self._values = dict(values or {})
        self._saved: dict[str, float | None] = {}
        self.revision = 0

    def get(self, name: str) -> float:
        """Value of a parameter; KeyError when the mapping lacks it."""
        return self._values[name]

    def set(self, name: str, value: float) -> None:
        """Set a parameter."""
        self._values[name] = value
        self.revision += 1

    def set_unsaved(self, name: str, value: float) -> None:
        """Set a parameter without saving it, until :meth:`load`."""
        self._saved.setdefault(name, self._values.get(name))
        self.set(name, value)

    def load(self, name: str) -> None:
        """Restore the saved value, or the autopilot's default."""
        if name not in self._saved:
            return
        saved = self._saved.pop(name)
        if saved is None:
            del self._values[name]
            self.revision += 1
        else:
            self.set(name, saved)


class FixedPlan:
    """A mission and rally points from sequences; ``mission`` includes home."""

    def __init__(self, mission: Sequence[StoredItem] = (), rally: Sequence[RallyPoint] = ()) -> None:
        self.mission: Sequence[StoredItem] = tuple(mission)
        self.rally: Sequence[RallyPoint] = tuple(rally)
        self.mission_revision = 0
        self.mission_clears = 0


def item(
    seq: int,
    command: int,
    lat_deg: float = 0.0,
    lon_deg: float = 0.0,
    alt_m: float = 0.0,
    *,
    params: Sequence[float] = (),
    frame: int = 3,
) -> StoredItem:
    """A stored mission item."""
    p1, p2, p3, p4 = (*params, 0.0, 0.0, 0.0, 0.0)[:4]
    return StoredItem(seq, command, frame, p1, p2, p3, p4, lat_deg, lon_deg, alt_m)


def home_item(lat_deg: float, lon_deg: float, alt_amsl_m: float) -> StoredItem:
    """Item 0."""
    return item(0, 16, lat_deg, lon_deg, alt_amsl_m, frame=0)
