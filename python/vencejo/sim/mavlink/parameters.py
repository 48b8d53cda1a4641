"""The parameter protocol: PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET as ArduPlane answers them."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable

from vencejo.sim.autopilot.interface import Severity
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.link import Link, Peer
from vencejo.sim.params import Parameter, ParamStore, ParamValueError

__all__ = ["ParameterProtocol"]

_PER_TICK = 64
"""Values of a list sent per tick; the whole list takes about a fifth of a simulated second."""
_QUEUE_ROOM = 512
"""A list pauses while its link has more queued answers than this."""
_UNSPECIFIED = 65535
_DOES_NOT_EXIST = 1
_VALUE_OUT_OF_RANGE = 2
_PERMISSION_DENIED = 3
_INTERNAL = re.compile(r"MIS_TOTAL|(ARSPD\d?|MNT\d)_DEVID|BARO\d_(DEVID|GND_PRESS)")
"""Parameters that a station may not set (AP_PARAM_FLAG_INTERNAL_USE_ONLY)."""


class ParameterProtocol:
    """Answers the parameter messages of all links of one plane.

    Parameters
    ----------
    params : ParamStore
    reply : callable
        Sends a message to one peer.
    announce : callable
        Sends a message to every link.
    changed : callable
        Receives each parameter that a station changed.
    say : callable
        Sends a text to every link.
    """

    def __init__(
        self,
        params: ParamStore,
        *,
        reply: Callable[[Peer, MavMessage], None],
        announce: Callable[[MavMessage], None],
        changed: Callable[[Parameter], None],
        say: Callable[[Severity, str], None],
    ) -> None:
        self._params = params
        self._reply = reply
        self._announce = announce
        self._changed = changed
        self._say = say
        self._lists: deque[tuple[Peer, int]] = deque(maxlen=16)
        """Lists in progress: peer and next index. One per link; the oldest is dropped when there are too many."""

    def value(self, parameter: Parameter, *, index: int = _UNSPECIFIED) -> MavMessage:
        """PARAM_VALUE of a parameter."""
        return dialect.MAVLink_param_value_message(
            parameter.name.encode("ascii"), parameter.value, int(parameter.type), len(self._params), index
        )

    def on_request_list(self, peer: Peer, _message: MavMessage) -> None:
        """Start sending all parameters to a link, from the first again if a list is in progress."""
        self.forget(peer.link)
        self._lists.append((peer, 0))

    def on_request_read(self, peer: Peer, message: MavMessage) -> None:
        """Send one parameter, by index or by name."""
        index = int(message.param_index)
        name = _name(message)
        if index >= 0:
            if index >= len(self._params):
                self._error(peer, name, index, _DOES_NOT_EXIST)
                return
            self._reply(peer, self.value(self._params.at(index), index=index))
            return
        parameter = self._params.find(name)
        if parameter is None:
            self._error(peer, name, index, _DOES_NOT_EXIST)
            return
        self._reply(peer, self.value(parameter))

    def on_set(self, peer: Peer, message: MavMessage) -> None:
        """Set a parameter; the stored value is announced on every link."""
        name = _name(message)
        before = self._params.find(name)
        if before is None:
            self._error(peer, name, -1, _DOES_NOT_EXIST)
            return
        if math.isfinite(message.param_value) and _INTERNAL.fullmatch(name):
            self._say(Severity.WARNING, f"Param write denied ({name})")
            self._error(peer, name, -1, _PERMISSION_DENIED)
            self._announce(self.value(before))
            return
        try:
            after = self._params.set(name, float(message.param_value))
        except ParamValueError:
            self._error(peer, name, -1, _VALUE_OUT_OF_RANGE)
            return
        self._announce(self.value(after))
        if after.value != before.value:
            self._changed(after)

    def tick(self) -> None:
        """Send the next part of each list, while the station keeps up."""
        for _ in range(len(self._lists)):
            peer, index = self._lists.popleft()
            stop = min(index + _PER_TICK, len(self._params))
            if peer.link.waiting_replies < _QUEUE_ROOM:
                for number in range(index, stop):
                    self._reply(peer, self.value(self._params.at(number), index=number))
                index = stop
            if index < len(self._params):
                self._lists.append((peer, index))

    def forget(self, link: Link) -> None:
        """Drop the list of a link that is gone."""
        kept = [entry for entry in self._lists if entry[0].link is not link]
        self._lists.clear()
        self._lists.extend(kept)

    def _error(self, peer: Peer, name: str, index: int, error: int) -> None:
        self._reply(
            peer,
            dialect.MAVLink_param_error_message(
                peer.system, peer.component, name.encode("ascii", "replace")[:16], index, error
            ),
        )


def _name(message: MavMessage) -> str:
    return str(message.param_id).split("\0", 1)[0]
