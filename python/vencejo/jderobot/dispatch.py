"""Dispatch of requests to servants, after authorisation and, for Slice classes, a check of their bytes.

Ice for Python does not survive every body that a request can have, so operations that take Slice classes are taken as
bytes and checked (`vencejo.jderobot.wire`) before Ice decodes them (docs/adr/0011-ice-decodes-what-was-checked.md).
"""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

from vencejo.jderobot.access import READS, Gate, Peer, Presence, peer_of, remote_address
from vencejo.jderobot.runtime import Dialect, Slices, tolerant
from vencejo.jderobot.subject import LOG
from vencejo.jderobot.wire import CAMERA, CMDVEL, INT, MISSION, PLAN, PLAN_KIND, POSE, POSES, Malformed, Shape, check

__all__ = ["FACETS", "SHAPES", "Answering", "Checked", "Dialects", "Locator"]

FACETS: Final[tuple[Dialect, ...]] = ("data", "sequence")
"""Facets of Mission: a proxy with one says which dialect its client speaks."""
Shapes: TypeAlias = Mapping[Dialect, tuple[Shape, ...]]
SHAPES: Final[Mapping[str, Mapping[str, Shapes]]] = {
    "Pose3D": {"setPose3DData": {"data": (POSE,)}},
    "CMDVel": {"setCMDVelData": {"data": (CMDVEL,)}},
    "Camera": {"setCameraDescription": {"data": (CAMERA,)}},
    "Mission": {"setMissionData": {"data": (MISSION,), "sequence": (POSES,)}},
    "Missions": {"check": {"data": (INT, PLAN)}, "upload": {"data": (INT, PLAN_KIND, PLAN)}},
}
"""Parameters of every operation that takes an object, in each dialect, by interface and operation; a test compares them with the
Slice files."""
_REMEMBERED: Final = 256
"""Most clients whose dialect is remembered; the least recent is forgotten."""
_TELL_EVERY_S: Final = 5.0


class Dialects:
    """Dialects of Mission by client, so that each client is answered in its own.

    A client shows its dialect by what it sends, on that connection and, because connections come and go, at its
    address. An address that sent both, or nothing yet, gets the configured one. Thread-safe.

    Parameters
    ----------
    otherwise : {"data", "sequence"}
        For clients that have not shown it.
    """

    def __init__(self, otherwise: Dialect) -> None:
        self._otherwise = otherwise
        self._lock = threading.Lock()
        self._shown: OrderedDict[Peer | str, set[Dialect]] = OrderedDict()

    def show(self, peer: Peer | None, dialect: Dialect) -> None:
        """A client has sent a mission in a dialect."""
        if peer is None:
            return
        with self._lock:
            self._shown[peer] = {dialect}
            self._shown.setdefault(peer.address, set()).add(dialect)
            for key in (peer, peer.address):
                self._shown.move_to_end(key)
            while len(self._shown) > _REMEMBERED:
                self._shown.popitem(last=False)

    def of(self, peer: Peer | None) -> Dialect:
        """The dialect of a client."""
        with self._lock:
            for key in () if peer is None else (peer, peer.address):
                shown = self._shown.get(key, set())
                if len(shown) == 1:
                    return next(iter(shown))
        return self._otherwise


class Answering:
    """The servants of one public object.

    Parameters
    ----------
    servants : mapping of dialect to object
        The servant for each dialect; but for Mission there is one, ``"data"``.
    dialects : Dialects
    checked : object, optional
        Takes the operations of `shapes` in their place (`Checked`).
    shapes : mapping of str to Shapes, optional
        Operations that objects come in with.
    """

    def __init__(
        self,
        servants: Mapping[Dialect, object],
        dialects: Dialects,
        checked: object = None,
        shapes: Mapping[str, Shapes] = {},
    ) -> None:
        self._servants = servants
        self._dialects = dialects
        self._checked = checked
        self._shapes = shapes

    def has_facet(self, facet: str) -> bool:
        """Whether a client may name a facet."""
        return not facet or (len(self._servants) > 1 and facet in FACETS)

    def servant(self, operation: str, facet: str, peer: Callable[[], Peer | None]) -> object:
        """The servant for an operation."""
        if operation in self._shapes:
            return self._checked
        if operation != "getMissionData" or len(self._servants) == 1:
            return self._servants["data"]
        named: Dialect | None = next((dialect for dialect in FACETS if dialect == facet), None)
        return self._servants[named or self._dialects.of(peer())]


class Checked:
    """Takes operations as bytes, checks them, and hands them on to the servants behind (Ice's BlobjectAsync).

    Parameters
    ----------
    slices : Slices
    shapes : mapping of str to Shapes
        The operations, and what they take.
    behind : mapping of dialect to proxy
        Proxies of the servants, which are reachable only from here.
    dialects : Dialects
        Records what clients show.
    clock : function, optional
        Monotonic seconds.
    """

    def __init__(
        self,
        slices: Slices,
        shapes: Mapping[str, Shapes],
        behind: Mapping[Dialect, Any],
        dialects: Dialects,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._ice = slices.ice
        self._shapes = shapes
        self._behind = behind
        self._dialects = dialects
        self._clock = clock
        self._told_s = -_TELL_EVERY_S

    def ice_invoke(self, data: bytes, current: Any) -> Any:
        """Answer an operation; a future of whether it succeeded, and its results as bytes."""
        dialect = self._dialect(data, current)
        with tolerant():
            context = dict(current.ctx)
        return self._behind[dialect].ice_invokeAsync(current.operation, current.mode, data, context)

    def _dialect(self, data: bytes, current: Any) -> Dialect:
        """The dialect that the parameters are of.

        Raises
        ------
        Ice.UnknownLocalException
            Which clients get for parameters that cannot be read.
        """
        found: list[Dialect] = []
        faults: list[str] = []
        for dialect, shapes in self._shapes[current.operation].items():
            try:
                check(data, *shapes)
            except Malformed as error:
                faults.append(str(error))
            else:
                found.append(dialect)
        if not found:
            reason = f"{current.operation}: its parameters are none of our Slice files: {'; '.join(faults)}"
            now = self._clock()
            if now - self._told_s >= _TELL_EVERY_S:
                self._told_s = now
                LOG.warning("%s, from %s", reason, remote_address(current.con))
            raise self._ice.UnknownLocalException(reason)
        # Null and the empty sequence are the same bytes in encoding 1.1: neither shows a dialect, and neither is a
        # mission.
        if len(found) == 1 < len(self._behind):
            self._dialects.show(peer_of(current.con), found[0])
        return found[0]


class Locator:
    """Authorises each request and finds its servant (Ice's ServantLocator)."""

    def __init__(self, slices: Slices, gate: Gate, objects: Mapping[str, Answering], presence: Presence) -> None:
        self._ice = slices.ice
        self._presence = presence
        self._gate = gate
        self._objects = objects

    def locate(self, current: Any) -> tuple[object | None, None]:
        """The servant; ``None`` for an object that is not here."""
        with tolerant():
            identity, facet, operation, context = current.id, current.facet, current.operation, current.ctx
        self._let_through(current.con, operation, context.get("token", ""))
        found = None if identity.category else self._objects.get(identity.name)
        if not (found.has_facet(facet) if found else not facet):
            # An object without the facet is not the one requested.
            raise self._ice.FacetNotExistException(identity, facet, operation)
        if found is None:
            return None, None
        return found.servant(operation, facet, lambda: peer_of(current.con)), None

    def _let_through(self, connection: Any, operation: str, token: str) -> None:
        """Refuse unauthorised requests. Every request passes here, before any of its parameters is decoded, and nowhere else.

        Raises
        ------
        Ice.UnknownException
            With the reason.
        """
        standing = self._gate.standing(connection, operation, token)
        refusal = standing()
        if refusal is not None:
            raise self._ice.UnknownException(refusal)
        if operation not in READS:
            self._presence.acts(connection, standing)

    def finished(self, current: Any, servant: object, cookie: None) -> None:
        """Nothing is held for a request."""

    def deactivate(self, category: str) -> None:
        """Nothing is held."""
