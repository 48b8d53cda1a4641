"""Recordings: the contents of a ``.tlog`` file.

Examples
--------
>>> from vencejo.recording import summarize, telemetry
>>> summary = summarize("flight.tlog")  # doctest: +SKIP
>>> [event.text for event in summary.events if event.kind == "mode"]  # doctest: +SKIP
['mode MANUAL', 'mode AUTO']
>>> for then in telemetry("flight.tlog", rate_hz=1):  # doctest: +SKIP
...     print(then.time_s, then.position)
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vencejo import _native
from vencejo.errors import InvalidRequest

if TYPE_CHECKING:
    from vencejo.telemetry import Telemetry

__all__ = ["RecordedEvent", "RecordingSummary", "Sender", "summarize", "telemetry"]


@dataclass(frozen=True)
class Sender:
    """A sender in a recording.

    Attributes
    ----------
    system_id, component_id : int
    frames : int
    mav_type, autopilot : int or None
        MAV_TYPE and MAV_AUTOPILOT of its heartbeats, ``None`` without heartbeats.
    """

    system_id: int
    component_id: int
    frames: int
    mav_type: int | None
    autopilot: int | None

    @property
    def what(self) -> str:
        """What it is, in words."""
        if self.autopilot is None or self.mav_type is None:
            return "no heartbeat"
        if self.mav_type == 6:
            return "ground station"
        name = {3: "ArduPilot", 12: "PX4"}.get(self.autopilot)
        kind = {1: "plane", 2: "copter", 3: "coaxial copter", 4: "helicopter", 10: "rover", 11: "boat", 12: "submarine"}
        what = kind.get(self.mav_type, f"type {self.mav_type}")
        return what if name is None else f"{name} {what}"


@dataclass(frozen=True)
class RecordedEvent:
    """Something that happened to a vehicle.

    Attributes
    ----------
    time_s : float
        Time since the first frame, seconds.
    system_id : int
        The vehicle.
    kind : str
        Such as ``"mode"``, ``"armed"``, ``"disarmed"``, ``"text"``, ``"item_reached"``, ``"lost"``.
    text : str
        In words; for ``"text"`` the vehicle's own, which is not to be trusted as markup.
    """

    time_s: float
    system_id: int
    kind: str
    text: str


@dataclass(frozen=True, kw_only=True)
class RecordingSummary:
    """Contents of a recording.

    Attributes
    ----------
    frames : int
        Number of complete frames.
    skipped_bytes : int
        Bytes outside complete frames: damage, or a truncated end.
    start_unix_s : float or None
        Time of the first frame, seconds since 1970; ``None`` without frames.
    duration_s : float
        From the first frame to the last.
    senders : tuple of Sender
    messages : dict of str to int
        Frames of each message, the most frequent first.
    events : tuple of RecordedEvent
        In order.
    events_left_out : int
        Later events for which there was no room.
    """

    frames: int
    skipped_bytes: int
    start_unix_s: float | None
    duration_s: float
    senders: tuple[Sender, ...]
    messages: dict[str, int]
    events: tuple[RecordedEvent, ...]
    events_left_out: int


def summarize(path: str | os.PathLike[str]) -> RecordingSummary:
    """Read a whole ``.tlog`` file, in any condition, and tell what is in it.

    Raises
    ------
    FileFormatError
        When the file cannot be read. A file without frames is no error.
    """
    found = _native.summarize_recording(os.fspath(path))
    senders = tuple(
        Sender(system_id, component_id, frames, *(kind or (None, None)))
        for system_id, component_id, frames, kind in found["senders"]
    )
    messages = dict(sorted(found["messages"].items(), key=lambda entry: (-entry[1], entry[0])))
    events = tuple(RecordedEvent(*event) for event in found["events"])
    return RecordingSummary(**{**found, "senders": senders, "messages": messages, "events": events})


def telemetry(
    path: str | os.PathLike[str], *, system_id: int | None = None, rate_hz: float = 10.0
) -> Iterator[Telemetry]:
    """Read the telemetry of a vehicle from a ``.tlog`` file, as `Vehicle.stream` gives it in flight.

    Each snapshot is taken when something new was recorded, at `rate_hz` at most, and the last one at the end. Its ``time_s`` counts from the first
    frame of the file, which was at `RecordingSummary.start_unix_s`. The file is read while it is iterated.

    Parameters
    ----------
    path : path
        The file; damaged parts are skipped.
    system_id : int, optional
        Which vehicle; by default the first that is heard in it.
    rate_hz : float, optional
        From 0.1 to 50.

    Raises
    ------
    FileFormatError
        When the file cannot be read.
    InvalidRequest
        For a rate out of its range.
    """
    from vencejo.telemetry import Telemetry

    if not 0.1 <= rate_hz <= 50.0:
        raise InvalidRequest(f"rate_hz is {rate_hz}, should be 0.1 to 50")
    return map(Telemetry, _native.RecordedTelemetry(os.fspath(path), system_id=system_id, period_s=1.0 / rate_hz))
