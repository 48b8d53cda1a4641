"""Converts the recorded stream to the frames file that bench/load plays (the format is documented there).

The recording lasts 20 s. It is repeated with continuing boot times, so that it shows a plane that flies for minutes
rather than one that reboots every 20 s. RAW_IMU carries the time of sending.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

CAPTURE = Path(__file__).parents[1] / "tests/fixtures/captures/arduplane-50hz-20s.mavlink"
RAW_IMU = 27
HEADER_BYTES = 10
NO_STAMP = 0xFFFF
LAP_MS = 20_000
#: Messages of a vehicle in a fleet: five streams at 40 Hz and a heartbeat, 200 messages a second.
FLEET = ("ATTITUDE", "GLOBAL_POSITION_INT", "VFR_HUD", "RAW_IMU", "GPS_RAW_INT")
FLEET_RATE = 200
#: A heartbeat immediately available to each contestant, so that waiting for one is not measured.
HEARTBEAT_EVERY = 10
#: The recorder's own conversation, which a plane that is only followed does not send.
LEFT_OUT = frozenset({"PARAM_VALUE", "TIMESYNC", "TERRAIN_REQUEST", "STATUSTEXT"})


def prepare(output: Path, laps: int = 3, *, fleet: bool = False, heartbeat_every: int = 0) -> int:
    """Write the frames file, unless it exists and is newer than its sources.

    Parameters
    ----------
    output
        The file to write.
    laps
        Number of times that the recording is repeated.
    fleet
        Omit messages that a vehicle in a fleet does not send, and add its heartbeat once a second.
    heartbeat_every
        Add a heartbeat every this many frames, beside the recorded ones; 0 for none.

    Returns
    -------
    int
        The number of frames in the file.
    """
    newest = max(CAPTURE.stat().st_mtime, Path(__file__).stat().st_mtime)
    if output.exists() and output.stat().st_mtime > newest:
        return count(output.read_bytes())

    from pymavlink.dialects.v20 import ardupilotmega as dialect

    reader: Any = dialect.MAVLink(None)
    reader.robust_parsing = True
    messages = reader.parse_buffer(CAPTURE.read_bytes())
    writer: Any = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    records: list[bytes] = []
    heartbeat = next(message for message in messages if message.get_type() == "HEARTBEAT")
    every = FLEET_RATE if fleet else heartbeat_every
    for lap in range(laps):
        for message in messages:
            if message.get_type() in LEFT_OUT or (fleet and message.get_type() not in FLEET):
                continue
            if every and len(records) % every == 0:
                records.append(_record(heartbeat, writer))
            for field, per_ms in (
                ("time_boot_ms", 1),
                ("time_usec", 1000),
                ("time_unix_usec", 1000),
            ):
                value = getattr(message, field, 0)
                if value:
                    setattr(message, field, value + (LAP_MS * per_ms if lap else 0))
            if message.get_msgId() == RAW_IMU:
                # Prevents truncation of the timestamp's eight bytes as trailing zeros.
                message.temperature = message.temperature or 1
            records.append(_record(message, writer))
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(b"".join(records))
    return len(records)


def _record(message: Any, writer: Any) -> bytes:
    frame = bytes(message.pack(writer))
    stamp_at = HEADER_BYTES if message.get_msgId() == RAW_IMU else NO_STAMP
    return struct.pack("<HBH", len(frame), message.crc_extra, stamp_at) + frame


def count(data: bytes) -> int:
    """Return the number of frames in a frames file."""
    frames = at = 0
    while at < len(data):
        at += 5 + struct.unpack_from("<H", data, at)[0]
        frames += 1
    return frames


if __name__ == "__main__":
    print(prepare(Path(__file__).parent / "out/frames.bin"))
