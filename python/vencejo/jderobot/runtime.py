"""ZeroC Ice, loaded when it is needed, with the types of the Slice files. The only file that imports it."""

from __future__ import annotations

import codecs
import contextlib
import hashlib
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias, TypeVar

from vencejo.errors import VencejoError

__all__ = ["SLICE_DIR", "Dialect", "Slices", "load", "tolerant"]

Dialect: TypeAlias = Literal["data", "sequence"]
"""How a client of Mission passes a mission: in a MissionData object, or as the bare sequence of poses."""

SLICE_DIR: Final = Path(__file__).resolve().parent / "slice"
"""The Slice files, for ``-I``."""

_T = TypeVar("_T")
_FILES: Final = ("camera", "pose3d", "navdata", "ardroneextra", "cmdvel", "mission")
_OTHER_MISSION: Final = "MissionOfPoses"
"""Name of Mission of mission_sequence.ice in this process, which serves both dialects; names are not sent over the wire."""
SLICE_DIGEST: Final = "605dac4cef9fdfdf487e5d964fed7878216c5f5cb1f12412850a8975c20b7644"
"""Of the Slice files (`digest`). Ice's compiler ends the process over some that are damaged, so it sees none of those."""
_MISSING: Final = (
    "the JdeRobot interfaces need ZeroC Ice, which is not installed: pip install 'vencejo[ice]' "
    "(it is compiled once, about five minutes; docs/jderobot.md names the system packages)"
)


@dataclass(frozen=True)
class Slices:
    """The Ice run time and the types of our Slice files.

    Attributes
    ----------
    ice : module
        Package Ice.
    jderobot, precise : module
        Slice modules ``jderobot`` and ``vencejo``. Interface ``Mission`` is that of mission.ice, ``MissionOfPoses``
        that of mission_sequence.ice.
    """

    ice: Any
    jderobot: Any
    precise: Any

    def servant(self, kind: type[_T], skeleton: Any) -> type[_T]:
        """The class that answers for a Slice interface by the methods of `kind`, named as its operations are."""
        return type(kind.__name__, (kind, skeleton), {})


class _Tolerance(threading.local):
    """Whether this thread reads texts that may be none."""

    wanted = False


_tolerance = _Tolerance()
_strict = codecs.lookup_error("strict")


def _decoding_failed(error: UnicodeError) -> tuple[str | bytes, int]:
    if _tolerance.wanted and isinstance(error, UnicodeDecodeError):
        return "\N{REPLACEMENT CHARACTER}", error.end
    return _strict(error)


@contextlib.contextmanager
def tolerant() -> Iterator[None]:
    """Read the header of a request within: bytes that are no UTF-8 come as replacement characters, in this thread alone.

    Ice for Python decodes identity, facet, operation and context when they are looked at, by Python's handler
    ``"strict"``, and where that raises ends the process with a segmentation fault (3.7.8). So that handler does not
    raise here.
    """
    _tolerance.wanted = True
    try:
        yield
    finally:
        _tolerance.wanted = False


_lock = threading.Lock()
_loaded: Slices | None = None


def load() -> Slices:
    """Load Ice and the Slice files, once in a process.

    Raises
    ------
    VencejoError
        When Ice is not installed; the text says how to install it. Or when a Slice file is damaged.
    """
    global _loaded
    with _lock:
        if _loaded is None:
            _loaded = _load()
        return _loaded


def digest(folder: Path) -> str:
    """SHA-256 of the names and texts of the Slice files in a folder.

    Raises
    ------
    OSError
    """
    found = hashlib.sha256()
    for path in sorted(folder.rglob("*.ice")):
        name = path.relative_to(folder).as_posix()
        text = path.read_bytes().replace(b"\r\n", b"\n")
        found.update(f"{name} {len(text)}\n".encode() + text)
    return found.hexdigest()


def _load() -> Slices:
    try:
        import Ice
    except ImportError as error:
        raise VencejoError(_MISSING) from error
    damaged = f"the Slice files in {SLICE_DIR} are not those of this version; install Vencejo again"
    try:
        if digest(SLICE_DIR) != SLICE_DIGEST:
            raise VencejoError(damaged)
    except OSError as error:
        raise VencejoError(f"{damaged} ({error})") from error
    folder = SLICE_DIR / "jderobot"
    files = [*(folder / f"{name}.ice" for name in _FILES), SLICE_DIR / "vencejo" / "vencejo.ice"]
    # --all: the types of included files too.
    options = ["--all", f"-I{SLICE_DIR}"]
    try:
        Ice.loadSlice("", [*options, *map(str, files)])
        codecs.register_error("strict", _decoding_failed)
        Ice.loadSlice("", [*options, f"-DMission={_OTHER_MISSION}", str(folder / "mission_sequence.ice")])
        return Slices(Ice, sys.modules["jderobot"], sys.modules["vencejo_ice.vencejo"])
    except (RuntimeError, KeyError) as error:
        raise VencejoError(damaged) from error
