"""A Matroska file (RFC 9559) with one track of video, written as it comes.

Segment and clusters have no size at first, as live streams have none, and each picture is one write: whatever ends the
writing, a crash or an empty battery, the file plays up to there. A file that is ended in order gets sizes, its length,
and an index by which players jump. Code is passed through, never encoded anew.
"""

from __future__ import annotations

import struct
from typing import Final

from vencejo.camera import h264
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame

__all__ = ["MatroskaWriter"]

UNKNOWN_SIZE: Final = b"\x01\xff\xff\xff\xff\xff\xff\xff"
TICKS_PER_S: Final = 1000
"""Times are in milliseconds: the usual `TimestampScale`."""
MAX_CLUSTER_MS: Final = 5000
"""A picture's time in its cluster is 16 bits; a new cluster begins at a key frame after this, or before it runs over."""
MAX_REORDER_MS: Final = 2000
"""Pictures that are shown before others that were coded earlier (B pictures) are no further back. Further is a clock set back."""
MAX_PAUSE_MS: Final = 3_600_000
"""No pause between pictures is longer; longer is a clock set forward, as on a computer without one that learns the time."""
SEEK_BYTES: Final = 160
"""Left free for where the parts of the file are."""
INFO: Final = 0x1549A966
TRACKS: Final = 0x1654AE6B
CUES: Final = 0x1C53BB6B
EPOCH_2001_UNIX_S: Final = 978_307_200
"""Matroska counts its date from the beginning of 2001 (RFC 9559, section 5.1.2.9)."""


def element(identity: int, payload: bytes) -> bytes:
    """An EBML element (RFC 8794): identity, size in eight bytes, payload."""
    return _identity(identity) + struct.pack(">Q", len(payload) | 1 << 56) + payload


def unsigned(identity: int, value: int) -> bytes:
    """An element that holds a number."""
    return element(identity, value.to_bytes(max(1, (value.bit_length() + 7) // 8), "big"))


def void(size: int) -> bytes:
    """An element of that many bytes that says nothing: 9 at least."""
    return element(0xEC, bytes(size - 9))


def _identity(identity: int) -> bytes:
    return identity.to_bytes((identity.bit_length() + 7) // 8, "big")


class MatroskaWriter:
    """Turns pictures into the bytes of a file.

    Parameters
    ----------
    first : EncodedFrame
        The first picture, a key frame: the file's codec, size and beginning are its own.
    title : str, optional
        What players show: the camera's name.

    Raises
    ------
    CameraError
        For a first picture that is no key frame, or is H.264 without parameter sets.
    """

    def __init__(self, first: EncodedFrame, *, title: str = "") -> None:
        if not first.is_key:
            raise CameraError("a recording begins with a key frame")
        self._codec = first.codec
        self._size = (first.width, first.height)
        self._begin_unix_s = first.captured_unix_s
        self._cluster_ms: int | None = None
        self._newest_ms = 0
        self._clocks = [(0, self._begin_unix_s)]
        """Where the time of day was another than before, and which the file's beginning has by it."""
        self._clusters: list[tuple[int, int, bool]] = []
        """Where clusters are in the file, their time, and whether they begin with a key frame."""
        self._header = self._make_header(first, title)
        self._bytes = len(self._header)

    def header(self) -> bytes:
        """What the file begins with."""
        return self._header

    @property
    def duration_s(self) -> float:
        """How long what was written is."""
        return self._newest_ms / TICKS_PER_S

    def unix_s(self, at_s: float) -> float:
        """When a picture of that time in the file was taken, by the clock of then: it may have been set since the beginning."""
        at_ms = round(at_s * TICKS_PER_S)
        return next(begin for since_ms, begin in reversed(self._clocks) if since_ms <= at_ms) + at_s

    def fits(self, frame: EncodedFrame) -> bool:
        """Whether a picture can go into this file: same codec, same size."""
        return frame.codec == self._codec and (frame.width, frame.height) == self._size

    def block(self, frame: EncodedFrame) -> bytes:
        """The bytes of one picture, with a new cluster before it where one is due."""
        at_ms = round((frame.captured_unix_s - self._begin_unix_s) * TICKS_PER_S)
        if not -MAX_REORDER_MS <= at_ms - self._newest_ms <= MAX_PAUSE_MS:
            # A clock that was set does not turn the file around, nor make a hole in it: it goes on from here.
            self._begin_unix_s += (at_ms - self._newest_ms) / TICKS_PER_S
            at_ms = self._newest_ms
            self._clocks.append((at_ms, self._begin_unix_s))
        at_ms = max(at_ms, 0)
        self._newest_ms = max(self._newest_ms, at_ms)
        head = b""
        since_ms = None if self._cluster_ms is None else at_ms - self._cluster_ms
        if since_ms is None or since_ms > 30_000 or (frame.is_key and since_ms >= MAX_CLUSTER_MS):
            self._clusters.append((self._bytes, at_ms, frame.is_key))
            head = _identity(0x1F43B675) + UNKNOWN_SIZE + unsigned(0xE7, at_ms)  # Cluster, Timestamp
            self._cluster_ms = at_ms
            since_ms = 0
        data = h264.length_prefixed(frame.data) if frame.codec == "h264" else frame.data
        flags = 0x80 if frame.is_key else 0
        block = head + element(0xA3, b"\x81" + struct.pack(">hB", since_ms, flags) + data)  # SimpleBlock of track 1
        self._bytes += len(block)
        return block

    def end(self) -> tuple[bytes, list[tuple[int, bytes]]]:
        """What a file that is ended in order gets: bytes for its end, and bytes in place of others with where they go."""
        points, sizes = b"", []
        ends = [position for position, _, _ in self._clusters[1:]] + [self._bytes]
        for (position, at_ms, is_key), end in zip(self._clusters, ends, strict=True):
            # After the cluster's identity, in place of a size that was not known: only then may the segment have one.
            sizes.append((position + 4, struct.pack(">Q", end - position - 12 | 1 << 56)))
            if is_key:
                where = unsigned(0xF7, 1) + unsigned(0xF1, position - self._segment)  # CueTrack, CueClusterPosition
                points += element(
                    0xBB, unsigned(0xB3, at_ms) + element(0xB7, where)
                )  # CuePoint: CueTime, CueTrackPositions
        cues = element(CUES, points)
        seeks = b""
        for identity, position in ((INFO, self._info), (TRACKS, self._tracks), (CUES, self._bytes)):
            seeks += element(
                0x4DBB, element(0x53AB, _identity(identity)) + unsigned(0x53AC, position - self._segment)
            )  # Seek: SeekID, SeekPosition
        seek_head = element(0x114D9B74, seeks)
        size = self._bytes + len(cues) - self._segment
        return cues, [
            *sizes,
            (self._segment, seek_head + void(SEEK_BYTES - len(seek_head))),
            (self._duration, element(0x4489, struct.pack(">d", float(self._newest_ms)))),
            # The segment's size last: without it the rest is not looked for.
            (self._segment - 8, struct.pack(">Q", size | 1 << 56)),
        ]

    def _make_header(self, first: EncodedFrame, title: str) -> bytes:
        ebml = element(
            0x1A45DFA3,
            unsigned(0x4286, 1)  # EBMLVersion
            + unsigned(0x42F7, 1)  # EBMLReadVersion
            + unsigned(0x42F2, 4)  # EBMLMaxIDLength
            + unsigned(0x42F3, 8)  # EBMLMaxSizeLength
            + element(0x4282, b"matroska")  # DocType
            + unsigned(0x4287, 4)  # DocTypeVersion
            + unsigned(0x4285, 2),  # DocTypeReadVersion
        )
        date_ns = round((self._begin_unix_s - EPOCH_2001_UNIX_S) * 1e9)
        duration = void(18)  # until it is known
        info = element(
            INFO,
            duration
            + unsigned(0x2AD7B1, 1_000_000_000 // TICKS_PER_S)  # TimestampScale
            + element(0x7BA9, title.encode())  # Title
            + element(0x4461, struct.pack(">q", date_ns))  # DateUTC
            + element(0x4D80, b"vencejo")  # MuxingApp
            + element(0x5741, b"vencejo"),  # WritingApp
        )
        codec = element(0x86, b"V_MJPEG")  # CodecID
        if self._codec == "h264":
            sets = h264.parameter_sets(first.data)
            if sets is None:
                raise CameraError("the video's key frame has no parameter sets: its camera does not send them")
            codec = element(0x86, b"V_MPEG4/ISO/AVC") + element(0x63A2, h264.decoder_configuration(*sets))
        width, height = self._size
        track = element(
            0xAE,
            unsigned(0xD7, 1)  # TrackNumber
            + unsigned(0x73C5, 1)  # TrackUID
            + unsigned(0x83, 1)  # TrackType: video
            + unsigned(0x9C, 0)  # FlagLacing
            + codec
            + element(0xE0, unsigned(0xB0, width) + unsigned(0xBA, height)),  # Video: PixelWidth, PixelHeight
        )
        head = ebml + _identity(0x18538067) + UNKNOWN_SIZE  # Segment
        self._segment = len(head)
        self._info = self._segment + SEEK_BYTES
        self._duration = self._info + len(_identity(INFO)) + 8
        self._tracks = self._info + len(info)
        return head + void(SEEK_BYTES) + info + element(TRACKS, track)
