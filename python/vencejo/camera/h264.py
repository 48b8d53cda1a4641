"""H.264 as bytes: its units (ITU-T H.264, section 7.3.1 and annex B), parameter sets, and the form that files want.

Nothing is decoded here.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import Final

__all__ = [
    "AccessUnits",
    "decoder_configuration",
    "is_key",
    "length_prefixed",
    "parameter_sets",
    "size",
    "units",
    "with_parameter_sets",
]

IDR: Final = 5
SEI: Final = 6
SPS: Final = 7
PPS: Final = 8
DELIMITER: Final = 9
SLICES: Final = frozenset({1, 2, IDR})
BEFORE_SLICES: Final = frozenset({SEI, SPS, PPS, DELIMITER, 14, 15, 16, 17, 18})
"""Types of units that begin an access unit after a slice (section 7.4.1.2.3)."""

START: Final = b"\x00\x00\x01"
RECOVERY_POINT: Final = 6
"""Type of the SEI message that says: decoding may begin here (annex D.1.8)."""
HIGH_PROFILES: Final = frozenset({100, 110, 122, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135})
"""Profiles whose parameter sets say how colours are sampled (section 7.3.2.1.1)."""
MAX_SIDE: Final = 16384
MAX_ACCESS_UNIT: Final = 16 << 20
"""Most bytes of a picture: a stream whose picture does not end is invalid."""


def units(data: bytes) -> Iterator[bytes]:
    """The units (NAL units) of a byte stream, without start codes."""
    begin = data.find(START)
    while begin >= 0:
        begin += len(START)
        end = data.find(START, begin)
        unit = data[begin:] if end < 0 else data[begin:end]
        # Zeros before the next start code belong to that one, or are filling (annex B: trailing_zero_8bits).
        unit = unit.rstrip(b"\x00")
        if unit:
            yield unit
        begin = end


def kind(unit: bytes) -> int:
    """Type of a unit (`nal_unit_type`)."""
    return unit[0] & 0x1F


def is_key(data: bytes) -> bool:
    """Whether an access unit can be decoded without those before it: it holds an IDR slice, or is a recovery point.

    Cameras that refresh the picture piece by piece (intra refresh) send no IDR pictures, and mark where decoding may
    begin.
    """
    return any(kind(unit) == IDR or (kind(unit) == SEI and _is_recovery_point(unit)) for unit in units(data))


def _is_recovery_point(sei: bytes) -> bool:
    """Whether a recovery point is among the messages of a SEI unit (section 7.3.2.3.1)."""
    at = 1
    while at + 2 < len(sei):
        numbers = []
        for _ in range(2):  # type, then size: as many 255s as fit, and the rest
            number = 0
            while at < len(sei) and sei[at] == 0xFF:
                number += 0xFF
                at += 1
            if at >= len(sei):
                return False
            numbers.append(number + sei[at])
            at += 1
        if numbers[0] == RECOVERY_POINT:
            return True
        at += numbers[1]
    return False


class _Bits:
    """Numbers in a unit, bit by bit (section 7.2)."""

    def __init__(self, data: bytes) -> None:
        self._value = int.from_bytes(data, "big")
        self._left = 8 * len(data)

    def take(self, count: int) -> int:
        """An unsigned number of this many bits."""
        if count > self._left:
            raise ValueError("it ends too soon")
        self._left -= count
        return self._value >> self._left & (1 << count) - 1

    def golomb(self) -> int:
        """A number in the exponential Golomb code without sign (section 9.1)."""
        zeros = 0
        while self.take(1) == 0:
            zeros += 1
            if zeros > 31:
                raise ValueError("no number")
        return (1 << zeros) - 1 + self.take(zeros)


def size(sps: bytes) -> tuple[int, int] | None:
    """Width and height in pixels from a sequence parameter set (section 7.3.2.1.1); ``None`` if it is invalid."""
    try:
        bits = _Bits(sps[1:].replace(b"\x00\x00\x03", b"\x00\x00"))
        profile = bits.take(8)
        bits.take(16)
        bits.golomb()  # seq_parameter_set_id
        sampling, is_separate = 1, 0
        if profile in HIGH_PROFILES:
            sampling = bits.golomb()
            if sampling == 3:
                is_separate = bits.take(1)
            bits.golomb()  # bit_depth_luma_minus8
            bits.golomb()  # bit_depth_chroma_minus8
            bits.take(1)  # qpprime_y_zero_transform_bypass_flag
            if bits.take(1):
                for index in range(8 if sampling != 3 else 12):
                    if bits.take(1):
                        _skip_scaling_list(bits, 16 if index < 6 else 64)
        bits.golomb()  # log2_max_frame_num_minus4
        order = bits.golomb()  # pic_order_cnt_type
        if order == 0:
            bits.golomb()
        elif order == 1:
            bits.take(1)
            bits.golomb()
            bits.golomb()
            for _ in range(min(bits.golomb(), 255)):
                bits.golomb()
        bits.golomb()  # max_num_ref_frames
        bits.take(1)
        columns, rows = bits.golomb() + 1, bits.golomb() + 1
        is_frames = bits.take(1)  # frame_mbs_only_flag
        if not is_frames:
            bits.take(1)
        bits.take(1)
        left = right = top = bottom = 0
        if bits.take(1):
            left, right, top, bottom = (bits.golomb() for _ in range(4))
    except ValueError:
        return None
    # Cropping counts in units of the colours' samples (equations 7-19 to 7-22).
    chroma = 0 if is_separate else sampling
    across = 2 if chroma in (1, 2) else 1
    down = (2 if chroma == 1 else 1) * (2 - is_frames)
    width = 16 * columns - across * (left + right)
    height = 16 * rows * (2 - is_frames) - down * (top + bottom)
    return (width, height) if 0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE else None


def _skip_scaling_list(bits: _Bits, count: int) -> None:
    """Pass over a scaling list (section 7.3.2.1.1.1)."""
    last, following = 8, 8
    for _ in range(count):
        if following:
            code = bits.golomb()
            following = (last + ((code + 1) // 2 if code % 2 else -(code // 2))) % 256
        last = following or last


def parameter_sets(data: bytes) -> tuple[bytes, bytes] | None:
    """The first sequence and picture parameter set in a byte stream; ``None`` when one is missing."""
    found: dict[int, bytes] = {}
    for unit in units(data):
        found.setdefault(kind(unit), unit)
    if SPS in found and PPS in found and len(found[SPS]) >= 4:
        return found[SPS], found[PPS]
    return None


def with_parameter_sets(data: bytes, sets: tuple[bytes, bytes] | None) -> bytes:
    """A key frame that brings its parameter sets, where they are known."""
    if sets is None or parameter_sets(data) is not None:
        return data
    return b"".join(b"\x00" + START + unit for unit in sets) + data


def decoder_configuration(sps: bytes, pps: bytes) -> bytes:
    """The `AVCDecoderConfigurationRecord` (ISO/IEC 14496-15, section 5.3.3.1) that files hold, for 4-byte lengths."""
    record = bytes([1, sps[1], sps[2], sps[3], 0xFC | 3, 0xE0 | 1])
    record += struct.pack(">H", len(sps)) + sps + bytes([1]) + struct.pack(">H", len(pps)) + pps
    if sps[1] in (100, 110, 122, 144):
        # The record goes on for the high profiles: 4:2:0, 8 bits, no extensions (what cameras send).
        record += bytes([0xFC | 1, 0xF8, 0xF8, 0])
    return record


def length_prefixed(data: bytes) -> bytes:
    """An access unit with a 4-byte length before each unit in place of start codes, as files hold it."""
    return b"".join(struct.pack(">I", len(unit)) + unit for unit in units(data))


class AccessUnits:
    """Cuts a byte stream that comes in pieces into access units. Bounded: a unit that does not end is dropped."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._pending: list[bytes] = []
        self._has_slice = False

    def push(self, piece: bytes) -> list[bytes]:
        """Take the next piece; give the access units that it completed."""
        self._buffer += piece
        done: list[bytes] = []
        first = self._buffer.find(START)
        if first < 0:
            # The beginning of a start code may be there.
            del self._buffer[: max(0, len(self._buffer) - 2)]
            return done
        del self._buffer[:first]
        while (end := self._buffer.find(START, len(START))) >= 0:
            unit = bytes(self._buffer[len(START) : end]).rstrip(b"\x00")
            del self._buffer[:end]
            if unit:
                done += self._before(unit)
                self._pending.append(unit)
                self._has_slice = self._has_slice or kind(unit) in SLICES
        # The beginning of a unit shows that the picture before it is complete.
        done += self._before(bytes(self._buffer[len(START) : len(START) + 2]))
        if len(self._buffer) > MAX_ACCESS_UNIT or sum(map(len, self._pending)) > MAX_ACCESS_UNIT:
            self._buffer.clear()
            self._pending.clear()
            self._has_slice = False
        return done

    def _before(self, unit: bytes) -> Iterable[bytes]:
        """The access unit that ends where this unit begins."""
        if len(unit) < 2 or not self._has_slice:
            return []
        number = kind(unit)
        # `first_mb_in_slice` is 0, whose code is a single 1, in the first slice of a picture (section 7.3.3).
        is_first_slice = number in SLICES and unit[1] & 0x80 != 0
        if number not in BEFORE_SLICES and not is_first_slice:
            return []
        done = b"".join(b"\x00" + START + pending for pending in self._pending)
        self._pending.clear()
        self._has_slice = False
        return [done]
