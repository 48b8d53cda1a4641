"""When pictures of a stream were taken."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

__all__ = ["CaptureClock"]

WINDOW_S: Final = 5.0
"""For so long at least, and twice as long at most, the least delayed picture counts: clocks drift apart."""
MAX_REORDER_S: Final = 1.0
"""Pictures that are shown before others that came earlier (B pictures) are no further back. Further is a stream that begins anew."""


class CaptureClock:
    """Tells the time of day at which a picture was taken, from its time in the stream and the moment when it came.

    No picture was taken after it came. So the least delayed picture of late tells how the stream's clock stands to
    ours, and a picture that the network held back is known to be older, by as much. What delays all pictures alike (the
    camera itself) stays unknown.

    Parameters
    ----------
    monotonic_s, unix_s : callable, optional
        Our clock that never jumps, and the time of day.
    """

    def __init__(
        self, *, monotonic_s: Callable[[], float] = time.monotonic, unix_s: Callable[[], float] = time.time
    ) -> None:
        self._monotonic_s = monotonic_s
        self._unix_s = unix_s
        self._last_s: float | None = None
        self._newest_s = 0.0
        self._window_begin_s = 0.0
        self._leads_s: tuple[float, float] | None = None
        """Our clock less the stream's, for the least delayed picture of the window before and of this one."""

    def captured_unix_s(self, at_s: float) -> float:
        """When a picture that came just now was taken.

        Parameters
        ----------
        at_s : float
            Its time in the stream, from any beginning. The same again and again stands for a stream that tells no
            times: then pictures are taken to be immediate.
        """
        self.came(at_s)
        return self.taken_unix_s(at_s)

    def came(self, at_s: float) -> None:
        """Learn from a picture that came just now, and has that time in the stream."""
        now = self._monotonic_s()
        is_untold = at_s == self._last_s
        self._last_s = at_s
        if is_untold:
            self._leads_s = None
            return
        lead_s = now - at_s
        if self._leads_s is None or at_s < self._newest_s - MAX_REORDER_S:
            self._leads_s, self._window_begin_s, self._newest_s = (lead_s, lead_s), now, at_s
        elif now - self._window_begin_s > WINDOW_S:
            self._leads_s, self._window_begin_s = (self._leads_s[1], lead_s), now
        else:
            self._leads_s = (self._leads_s[0], min(self._leads_s[1], lead_s))
        self._newest_s = max(self._newest_s, at_s)

    def taken_unix_s(self, at_s: float) -> float:
        """When a picture with that time in the stream was taken, as far as is known by now."""
        if self._leads_s is None:
            return self._unix_s()
        return self._unix_s() - max(self._monotonic_s() - at_s - min(self._leads_s), 0.0)
