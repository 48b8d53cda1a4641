"""Links: their state and counters, and the serial ports that they can be opened on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["LinkInfo", "SerialPort", "serial_ports"]


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


@dataclass(frozen=True, kw_only=True)
class SerialPort:
    """A serial port of this machine.

    Attributes
    ----------
    device : str
        Its device: ``/dev/ttyUSB0``, ``COM3``.
    lasting_path : str or None
        A name that stays when the number of the device changes: in ``/dev/serial/by-id``, or ``/dev/serial0`` on a
        Raspberry Pi.
    description : str or None
        Manufacturer and product, as a USB device says.
    usual_baud : int
        115200 for an autopilot's own USB, 57600 for an adapter, behind which is mostly a radio, 921600 for a port of
        the machine's own.
    is_in_use : bool
        Whether a program has locked it, this one included. Only Linux tells, and not every program locks.
    is_allowed : bool
        Whether this program may open it: on Linux, its user must be in the port's group, mostly ``dialout``.
    """

    device: str
    lasting_path: str | None
    description: str | None
    usual_baud: int
    is_in_use: bool
    is_allowed: bool

    @property
    def link(self) -> str:
        """The link string of the port at its usual rate."""
        return f"{self.lasting_path or self.device},{self.usual_baud}"


def serial_ports() -> list[SerialPort]:
    """Return the serial ports of this machine: autopilots on USB first, then adapters, then the others.

    Examples
    --------
    Connect to the first one:

    >>> for port in serial_ports():
    ...     plane = vencejo.connect(port.link)  # doctest: +SKIP
    ...     break
    """
    from vencejo import _native

    return [SerialPort(**port) for port in _native.serial_ports()]
