"""What a history has of an aircraft, by a reader that is not ours."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from mcap_protobuf.decoder import DecoderFactory

__all__ = ["STREAMS", "messages", "numbered"]

STREAMS = {"/state": "sequence", "/event": "number", "/audit": "number"}


def messages(folder: Path, name: str = "plane7") -> Iterator[tuple[str, bytes, Any]]:
    """Topic, bytes and decoded message of all that is kept in a folder, as far as it was written; by Foxglove's own reader."""
    for path in sorted(folder.glob(f"{name}_*.mcap")):
        with path.open("rb") as stream:
            reader = NonSeekingReader(stream, decoder_factories=[DecoderFactory()])
            try:
                for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
                    yield channel.topic, message.data, decoded
            except EndOfFile:
                pass  # it is being written, or its program was killed


def numbered(folder: Path, name: str = "plane7") -> dict[tuple[str, int, int], bytes]:
    """The records of a folder by topic, boot and number."""
    found: dict[tuple[str, int, int], bytes] = {}
    for topic, data, decoded in messages(folder, name):
        if topic in STREAMS:
            key = (topic, decoded.boot, getattr(decoded, STREAMS[topic]))
            assert key not in found, "nothing is kept twice"
            found[key] = data
    return found
