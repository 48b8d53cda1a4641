"""A fake wall clock for child processes, controlled by the test (libfaketime)."""

from __future__ import annotations

from pathlib import Path

import pytest

__all__ = ["Clock"]

LIBRARIES = ("/usr/lib/*/faketime/libfaketime.so.1", "/usr/lib*/faketime/libfaketime.so.1")


def library() -> Path:
    """Path of libfaketime (Debian's package of this name)."""
    for pattern in LIBRARIES:
        for path in sorted(Path("/").glob(pattern[1:])):
            return path
    pytest.fail("no libfaketime: sudo apt-get install -y libfaketime")


class Clock:
    """The wall clock of processes started with `env`."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "faketime"
        self.set(0)
        self.env = {
            "LD_PRELOAD": str(library()),
            "FAKETIME_TIMESTAMP_FILE": str(self._file),
            "FAKETIME_NO_CACHE": "1",
            "DONT_FAKE_MONOTONIC": "1",
            # File times are set by the kernel and do not jump with a process's clock.
            "NO_FAKE_STAT": "1",
            "TZ": "Europe/Madrid",
        }

    def set(self, offset_s: int) -> None:
        """Set the clock ahead by an offset, at once."""
        beside = self._file.with_suffix(".new")
        beside.write_text(f"{offset_s:+d}\n", encoding="ascii")
        beside.replace(self._file)
