"""MAVLink signing: signing state of vehicles, and the keys of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

__all__ = ["SigningInfo", "SigningKeyInfo"]


@dataclass(frozen=True, kw_only=True)
class SigningInfo:
    """Signing state of a vehicle. Counters start when the station is opened.

    Attributes
    ----------
    must_sign : bool
        Whether its unsigned messages are refused.
    key : str or None
        Name of the key with which messages to it are signed.
    key_missing : bool
        Whether that key is missing on this machine: then none of the vehicle's messages are accepted.
    unproven : tuple of str
        Names of keys that were sent to it and that it has not shown.
    verified : int
        Frames with a right and new signature.
    unsigned_accepted : int
        Frames without one that were accepted: it need not sign, its link is believed, or a radio reported.
    refused_unsigned, refused_wrong_key, refused_replayed, refused_old, refused_future : int
        Frames that went nowhere: not signed; signed with another key, or changed on the way; not later than one before;
        the first of its stream and older than a minute; from the future.
    verified_age_s, refused_age_s : float or None
        Since the newest verified and the newest refused frame.
    """

    must_sign: bool
    key: str | None
    key_missing: bool
    unproven: tuple[str, ...]
    verified: int
    unsigned_accepted: int
    refused_unsigned: int
    refused_wrong_key: int
    refused_replayed: int
    refused_old: int
    refused_future: int
    verified_age_s: float | None
    refused_age_s: float | None

    @property
    def refused(self) -> int:
        """Total number of refused frames."""
        return (
            self.refused_unsigned
            + self.refused_wrong_key
            + self.refused_replayed
            + self.refused_old
            + self.refused_future
        )


@dataclass(frozen=True, kw_only=True)
class SigningKeyInfo:
    """A key of this machine, without its secret.

    Attributes
    ----------
    name : str
    made : datetime
        When it was made, by this machine's clock, UTC.
    vehicles : tuple of int
        System ids of the vehicles that have it, or may have it.
    """

    name: str
    made: datetime
    vehicles: tuple[int, ...]
