"""Signing: how vehicles sign, and the keys of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

__all__ = ["SigningInfo", "SigningKeyInfo"]


@dataclass(frozen=True, kw_only=True)
class SigningInfo:
    """How a vehicle signs. Counts are since the station was opened.

    Attributes
    ----------
    must_sign : bool
        Whether what it does not sign is refused.
    key : str or None
        Name of the key that it is talked to with.
    key_missing : bool
        Whether that key is gone from this machine: nothing of the vehicle is believed then.
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
        """All frames that were refused."""
        return (
            self.refused_unsigned
            + self.refused_wrong_key
            + self.refused_replayed
            + self.refused_old
            + self.refused_future
        )


@dataclass(frozen=True, kw_only=True)
class SigningKeyInfo:
    """A key of this machine, without what is secret of it.

    Attributes
    ----------
    name : str
    made : datetime
        When, by this machine's clock, UTC.
    vehicles : tuple of int
        System ids of the vehicles that have it, or may.
    """

    name: str
    made: datetime
    vehicles: tuple[int, ...]
