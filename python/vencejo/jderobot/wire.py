"""What a request may hold: parameters with Slice classes in them are checked byte by byte before Ice decodes them.

Ice for Python ends the process when a reference to an object leads nowhere, and a client of the other Mission dialect
sends just that. So nothing but complete, well-formed objects of the types in our Slice files is let through, in
encoding 1.0 or 1.1, in the compact or the sliced format. No type here holds itself, so the depth is bounded by the
types; sizes and counts are compared with what is there before anything is made.

The encoding is that of "The Ice Protocol", Ice manual 3.7, sections "Data Encoding for Classes" and "Optional Values".
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

__all__ = [
    "CAMERA",
    "CMDVEL",
    "INT",
    "MAX_PARTS",
    "MISSION",
    "PLAN",
    "PLAN_KIND",
    "POSE",
    "POSES",
    "Malformed",
    "Shape",
    "check",
]

MAX_PARTS: Final = 16_384
"""Most sequence elements and objects in one request: more than a vehicle's mission items, and few enough to check quickly."""


class Malformed(Exception):
    """Bytes that no client of our Slice files would send."""


@dataclass(frozen=True)
class Plain:
    """So many bytes, whatever they are."""

    size: int


@dataclass(frozen=True)
class Bool:
    """0 or 1."""


@dataclass(frozen=True)
class Text:
    """A string."""


@dataclass(frozen=True)
class Enum:
    """An enumerator of an enumeration with this many, fewer than 127."""

    count: int


@dataclass(frozen=True)
class Many:
    """A sequence."""

    of: Shape


@dataclass(frozen=True)
class Struct:
    """Members one after the other."""

    members: tuple[Shape, ...]


@dataclass(frozen=True)
class Object:
    """A Slice class without a base, or null in its place.

    Attributes
    ----------
    type_id : str
    members : tuple of Shape
    optional : mapping of int to Shape
        Optional members by their tags.
    """

    type_id: str
    members: tuple[Shape, ...]
    optional: Mapping[int, Shape] = field(default_factory=dict)


Shape: TypeAlias = "Plain | Bool | Text | Enum | Many | Struct | Object"

INT: Final = Plain(4)
_DOUBLE: Final = Plain(8)

POSE: Final = Object("::jderobot::Pose3DData", (Plain(8 * 4),))
POSES: Final = Many(POSE)
MISSION: Final = Object("::jderobot::MissionData", (POSES,))
CMDVEL: Final = Object("::jderobot::CMDVelData", (Plain(6 * 4),))
CAMERA: Final = Object("::jderobot::CameraDescription", (Text(), Text(), Text(), Plain(12 * 4)))
# Members that are optional come after the others, wherever they are declared.
_ITEM: Final = Object("::vencejo::MissionItem", (INT, INT, Bool()), dict.fromkeys(range(1, 8), _DOUBLE))
_ZONE: Final = Object("::vencejo::Zone", (Bool(), Many(Plain(2 * 8))), {1: _DOUBLE})
_RALLY: Final = Object("::vencejo::RallyPoint", (Plain(3 * 8), INT))
_HOME: Final = Object("::vencejo::Home", (Plain(3 * 8),))
PLAN_KIND: Final = Enum(3)
PLAN: Final = Object("::vencejo::Plan", (Many(_ITEM), Many(_ZONE), Many(_RALLY)), {1: _HOME, 2: _RALLY})

# Formats of optional members (Ice manual, "Optional Values").
_F8: Final = 3
_CLASS: Final = 7
_END: Final = 0xFF

# Flags of a slice in encoding 1.1.
_TYPE_MASK: Final = 0x03
_TYPE_STRING: Final = 0x01
_TYPE_INDEX: Final = 0x02
_HAS_OPTIONALS: Final = 0x04
_HAS_TABLE: Final = 0x08
_HAS_SIZE: Final = 0x10
_IS_LAST: Final = 0x20
_KNOWN_FLAGS: Final = 0x3F

_BASE: Final = "::Ice::Object"


def check(data: bytes, *shapes: Shape) -> None:
    """Check the parameters of a request: an encapsulation with these, and nothing else.

    Raises
    ------
    Malformed
    """
    if len(data) < 6:
        raise Malformed("the parameters have no header")
    size, major, minor = struct.unpack_from("<iBB", data)
    if size != len(data):
        raise Malformed(f"the parameters say {size} bytes and have {len(data)}")
    reader = {(1, 0): _Reader10, (1, 1): _Reader11}.get((major, minor))
    if reader is None:
        raise Malformed(f"encoding {major}.{minor} is not known here; use 1.0 or 1.1")
    reader(data, 6).parameters(shapes)


def _least(shape: Shape) -> int:
    """The fewest bytes that a shape takes, in either encoding."""
    match shape:
        case Plain(size):
            return size
        case Struct(members):
            return sum(map(_least, members))
        case _:
            return 1


class _Reader:
    """Goes through the bytes; what is common to both encodings."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data = data
        self._at = at
        self._parts = 0
        self._type_ids: list[str] = []

    def parameters(self, shapes: tuple[Shape, ...]) -> None:
        for shape in shapes:
            self._read(shape)
        self._finish()
        if self._at != len(self._data):
            raise Malformed(f"{len(self._data) - self._at} bytes too many")

    def _finish(self) -> None:
        """What follows the parameters."""

    def _object(self, expected: Object) -> None:
        raise NotImplementedError

    def _enum(self, count: int) -> None:
        if self._size() >= count:
            raise Malformed("an enumerator that does not exist")

    def _read(self, shape: Shape) -> None:
        match shape:
            case Plain(size):
                self._skip(size)
            case Bool():
                if self._byte() > 1:
                    raise Malformed("a bool is neither 0 nor 1")
            case Text():
                self._text()
            case Enum(count):
                self._enum(count)
            case Many(of):
                count = self._size()
                self._count(count)
                if count * _least(of) > len(self._data) - self._at:
                    raise Malformed(f"a sequence of {count} is longer than what is left")
                if isinstance(of, Plain):
                    self._skip(count * of.size)
                else:
                    for _ in range(count):
                        self._read(of)
            case Struct(members):
                for member in members:
                    self._read(member)
            case Object():
                self._object(shape)

    def _count(self, parts: int) -> None:
        self._parts += parts
        if self._parts > MAX_PARTS:
            raise Malformed(f"more than {MAX_PARTS} parts")

    def _skip(self, size: int) -> int:
        """Pass over bytes; where they begin."""
        start = self._at
        if size > len(self._data) - start:
            raise Malformed("it ends too early")
        self._at = start + size
        return start

    def _byte(self) -> int:
        return self._data[self._skip(1)]

    def _int(self) -> int:
        value: int = struct.unpack_from("<i", self._data, self._skip(4))[0]
        return value

    def _size(self) -> int:
        size = self._byte()
        if size == 0xFF:
            size = self._int()
            if size < 0:
                raise Malformed("a size is below 0")
        return size

    def _text(self) -> str:
        size = self._size()
        start = self._skip(size)
        try:
            return self._data[start : self._at].decode()
        except UnicodeDecodeError:
            raise Malformed("a text is no UTF-8") from None

    def _new_type_id(self) -> str:
        type_id = self._text()
        self._type_ids.append(type_id)
        return type_id

    def _known_type_id(self) -> str:
        index = self._size()
        if not 1 <= index <= len(self._type_ids):
            raise Malformed("a type that was not named before")
        return self._type_ids[index - 1]


class _Reader10(_Reader):
    """Encoding 1.0: objects are numbered; they follow the parameters in groups, until an empty one."""

    def __init__(self, data: bytes, at: int) -> None:
        super().__init__(data, at)
        self._wanted: dict[int, Object] = {}
        self._shapes: dict[str, Object] = {}
        self._present: dict[int, str] = {}

    def _object(self, expected: Object) -> None:
        number = -self._int()
        if number == 0:
            return
        if number < 0:
            raise Malformed("the number of an object has the wrong sign")
        if self._wanted.setdefault(number, expected) is not expected:
            raise Malformed("an object is of two types")
        self._shapes[expected.type_id] = expected

    def _finish(self) -> None:
        while count := self._size():
            self._count(count)
            for _ in range(count):
                self._instance()
        for number in self._wanted:
            if number not in self._present:
                raise Malformed(f"object {number} is missing")

    def _instance(self) -> None:
        number = self._int()
        if number <= 0 or number in self._present:
            raise Malformed("the number of an object is wrong, or twice there")
        # A reference precedes its object: unreferenced objects are never sent.
        expected = self._wanted.get(number)
        if expected is None:
            raise Malformed(f"nothing refers to object {number}")
        self._slice(expected.type_id, expected.members)
        self._present[number] = expected.type_id
        # The end of every object: no facets.
        self._slice(_BASE, (Enum(1),))

    def _slice(self, type_id: str, members: tuple[Shape, ...]) -> None:
        flag = self._byte()
        if flag > 1:
            raise Malformed("a bool is neither 0 nor 1")
        named = self._known_type_id() if flag else self._new_type_id()
        if named != type_id:
            raise Malformed(f"{named[:80]!r} in place of {type_id}")
        start = self._at
        size = self._int()
        for member in members:
            self._read(member)
        if self._at - start != size:
            raise Malformed(f"{type_id} says {size} bytes and has {self._at - start}")

    def _enum(self, count: int) -> None:
        if self._byte() >= count:  # a byte, with fewer than 127 enumerators
            raise Malformed("an enumerator that does not exist")


class _Reader11(_Reader):
    """Encoding 1.1: an object stands where it is first referred to, or in the table behind the slice that refers to it."""

    def __init__(self, data: bytes, at: int) -> None:
        super().__init__(data, at)
        self._seen: list[Object] = []
        """Objects in the order of their numbers, which begin at 2."""
        self._table: list[tuple[int, Object]] | None = None
        """References of the current slice to the table behind it; ``None`` without a table."""

    def _object(self, expected: Object) -> None:
        index = self._size()
        if index == 0:
            return
        if self._table is not None:
            self._table.append((index, expected))
        else:
            self._reference(index, expected)

    def _reference(self, index: int, expected: Object) -> None:
        if index == 1:
            self._instance(expected)
        elif index - 2 >= len(self._seen):
            raise Malformed(f"object {index} is missing")
        elif self._seen[index - 2] is not expected:
            raise Malformed(f"{self._seen[index - 2].type_id} in place of {expected.type_id}")

    def _instance(self, expected: Object) -> None:
        self._count(1)
        self._seen.append(expected)
        flags = self._byte()
        if flags & ~_KNOWN_FLAGS or not flags & _IS_LAST:
            raise Malformed(f"{expected.type_id} has slices that it has not in our Slice files")
        kind = flags & _TYPE_MASK
        if kind not in (_TYPE_STRING, _TYPE_INDEX):
            raise Malformed("an object without the name of its type")
        named = self._new_type_id() if kind == _TYPE_STRING else self._known_type_id()
        if named != expected.type_id:
            raise Malformed(f"{named[:80]!r} in place of {expected.type_id}")
        start = self._at
        size = self._int() if flags & _HAS_SIZE else None
        outer, self._table = self._table, [] if flags & _HAS_TABLE else None
        for member in expected.members:
            self._read(member)
        if flags & _HAS_OPTIONALS:
            self._optionals(expected)
        if size is not None and self._at - start != size:
            raise Malformed(f"{expected.type_id} says {size} bytes and has {self._at - start}")
        references, self._table = self._table, outer
        if references is not None:
            self._behind(references, outer)

    def _behind(self, references: list[tuple[int, Object]], outer: list[tuple[int, Object]] | None) -> None:
        """The objects of a table, in the order in which their slice refers to them."""
        count = self._size()
        wanted: dict[int, Object] = {}
        for index, expected in references:
            if index > count or wanted.setdefault(index, expected) is not expected:
                raise Malformed("a reference into a table leads nowhere")
        if count == 0 or len(wanted) != count:
            raise Malformed("a table holds what nothing refers to")
        self._table = None
        for index in range(1, count + 1):
            reference = self._size()
            if reference == 0:
                raise Malformed("null in a table")
            self._reference(reference, wanted[index])
        self._table = outer

    def _optionals(self, expected: Object) -> None:
        last = 0
        while (head := self._byte()) != _END:
            tag, kind = head >> 3, head & 0x07
            shape = expected.optional.get(tag)
            if shape is None or tag <= last:
                raise Malformed(f"{expected.type_id} has no such optional member")
            if kind != (_CLASS if isinstance(shape, Object) else _F8):
                raise Malformed(f"optional member {tag} of {expected.type_id} is of another type")
            last = tag
            self._read(shape)
