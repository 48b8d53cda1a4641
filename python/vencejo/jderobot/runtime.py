"""ZeroC Ice, loaded when it is needed, with the types of the Slice files. The only file that imports it."""

from __future__ import annotations

import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias, TypeVar

from vencejo.errors import InvalidRequest, VencejoError

__all__ = ["SLICE_DIR", "Dialect", "Slices", "load"]

Dialect: TypeAlias = Literal["data", "sequence"]
"""How the Mission interface passes a mission: in a MissionData object, or as the bare sequence of poses."""

SLICE_DIR: Final = Path(__file__).resolve().parent / "slice"
"""The Slice files, for ``-I``."""

_T = TypeVar("_T")
_FILES: Final = ("camera", "pose3d", "navdata", "ardroneextra", "cmdvel")
_MISSION: Final[dict[str, str]] = {"data": "mission", "sequence": "mission_sequence"}
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
        Slice modules ``jderobot`` and ``vencejo``.
    dialect : {"data", "sequence"}
        Of Mission.
    """

    ice: Any
    jderobot: Any
    precise: Any
    dialect: Dialect

    def servant(self, kind: type[_T], skeleton: Any) -> type[_T]:
        """The class that answers for a Slice interface by the methods of `kind`, named as its operations are."""
        return type(kind.__name__, (kind, skeleton), {})


_lock = threading.Lock()
_loaded: Slices | None = None


def load(dialect: Dialect = "data") -> Slices:
    """Load Ice and the Slice files, once in a process.

    Raises
    ------
    VencejoError
        When Ice is not installed; the text says how to install it.
    InvalidRequest
        When the other dialect is loaded already: both give the same name to different types.
    """
    global _loaded
    with _lock:
        if _loaded is None:
            _loaded = _load(dialect)
        if _loaded.dialect != dialect:
            raise InvalidRequest(
                f"this process serves the dialect {_loaded.dialect!r} of Mission; serve {dialect!r} from another one"
            )
        return _loaded


def _load(dialect: Dialect) -> Slices:
    try:
        import Ice
    except ImportError as error:
        raise VencejoError(_MISSING) from error
    files = [SLICE_DIR / "jderobot" / f"{name}.ice" for name in (*_FILES, _MISSION[dialect])]
    files.append(SLICE_DIR / "vencejo" / "vencejo.ice")
    # --all: the types of included files too.
    Ice.loadSlice("", ["--all", f"-I{SLICE_DIR}", *map(str, files)])
    return Slices(Ice, sys.modules["jderobot"], sys.modules["vencejo_ice.vencejo"], dialect)
