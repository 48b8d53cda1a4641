"""State and counters of a link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["LinkInfo"]


@dataclass(frozen=True, kw_only=True)
class LinkInfo:
    """State and counters of a link.

    Attributes
    ----------
    id : int
    name, address : str
        The name given to it, and its link string in canonical form.
    local_address : str or None
        Address and port of its own socket while it is up, such as the port chosen for port 0.
    state : str
        ``"connecting"``, ``"up"``, ``"down"`` or ``"ended"``.
    detail : str or None
        Why it is not up: the last error.
    frames_received, frames_sent, bytes_received, bytes_sent : int
    bad_crc, garbage_bytes : int
        Frames with a wrong checksum, and bytes that belonged to no frame.
    accepts_unsigned : bool
        Whether a vehicle that has to sign is believed there without.
    frames_refused : int
        Frames that went nowhere because their signature was missing, wrong or not new.
    frames_lost : int
        Missing by the senders' frame counters.
    loss_pct : float or None
        Lost frames of all that should have come.
    round_trip_ms : float or None
        Of the newest TIMESYNC exchange.
    age_s : float or None
        Since the newest frame.
    """

    id: int
    name: str
    address: str
    local_address: str | None
    state: Literal["connecting", "up", "down", "ended"]
    detail: str | None
    frames_received: int
    frames_sent: int
    bytes_received: int
    bytes_sent: int
    bad_crc: int
    garbage_bytes: int
    accepts_unsigned: bool
    frames_refused: int
    frames_lost: int
    loss_pct: float | None
    round_trip_ms: float | None
    age_s: float | None
