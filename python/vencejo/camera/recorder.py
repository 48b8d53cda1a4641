"""Recordings of cameras, and the still pictures that are kept: files in one folder.

Recordings are Matroska files, written by a thread of their own, crash-safe. Files are named by us alone (time and
camera; the server reads its list from the names), never overwritten. Below a floor of free space nothing is written; a
file that has grown too large is closed and the next begun. What the disk does reaches nobody but the recording:
pictures that it is too slow for are dropped up to the next key frame, and counted.
"""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import BinaryIO, Final

from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame
from vencejo.camera.matroska import MatroskaWriter
from vencejo.storage import Floors, create_file, make_folder, sync_folder
from vencejo.video import default_video_dir

__all__ = ["RecorderLimits", "Recording", "VideoRecorder", "default_video_dir", "keep_still"]

QUEUE: Final = 300
"""Pictures that wait for the disk at most: ten seconds at 30 a second."""
SYNC_INTERVAL_S: Final = 1.0
"""How often what was written is forced to the disk, and free space looked at."""


@dataclass(frozen=True, kw_only=True)
class RecorderLimits:
    """Limits of a recording.

    Attributes
    ----------
    max_file_bytes : int
        A file that has grown to this size is closed and the next begun; default 2 GiB.
    quota_bytes : int
        What all recordings and pictures in the folder may take together; default 32 GiB. Nothing is deleted: recording
        ends.
    free_floor_bytes : int
        Free space of the disk below which nothing is written; default 1 GB, as `vencejo.Floors` has it.
    """

    max_file_bytes: int = 2 << 30
    quota_bytes: int = 32 << 30
    free_floor_bytes: int = Floors().video_mb * 1_000_000


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A recording as it stands.

    Attributes
    ----------
    path : Path
        The file that is being written.
    duration_s : float
        How long it is.
    bytes : int
        How large it is.
    dropped : int
        Pictures that the disk was too slow for, and those that build on one that never came.
    problem : str or None
        Why it ended before it was told to.
    """

    path: Path
    duration_s: float
    bytes: int
    dropped: int
    problem: str | None


class VideoRecorder:
    """Writes pictures to files until it is closed.

    Parameters
    ----------
    folder : Path
        Where to; made when it is not there.
    name : str
        The camera's name, for the files' names: letters, digits, ``-`` and ``_``.
    group : sequence of EncodedFrame, optional
        What to begin with: a key frame and what followed it.
    limits : RecorderLimits, optional
    free_bytes : callable, optional
        Free space of the disk that a folder is on.

    Raises
    ------
    CameraError
        When nothing can be written there.
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        *,
        group: Sequence[EncodedFrame] = (),
        limits: RecorderLimits | None = None,
        free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        unix_s: Callable[[], float] = time.time,
    ) -> None:
        self._folder = folder
        self._name = name
        self._limits = limits or RecorderLimits()
        self._free_bytes = free_bytes
        self._unix_s = unix_s
        self._waiting: queue.Queue[EncodedFrame | None] = queue.Queue()
        self._room = QUEUE
        self._lock = threading.Lock()
        self._needs_key = True
        self._dropped = 0
        self._problem: str | None = None
        self._duration_s = 0.0
        self._bytes = 0
        self._writer: MatroskaWriter | None = None
        self._older_bytes = _prepare(folder, self._limits, free_bytes)
        self._path, self._file = self._new_file()
        self.begin(group)
        self._thread = threading.Thread(target=self._run, name="video recorder", daemon=True)
        self._thread.start()

    def begin(self, group: Sequence[EncodedFrame]) -> None:
        """Hand on a key frame and what followed it, to begin with: they have room of their own. Never waits."""
        with self._lock:
            self._room += len(group)
            for frame in group:
                self._waiting.put(frame)
                self._needs_key = False

    def add(self, frame: EncodedFrame) -> None:
        """Hand on a picture; never waits."""
        with self._lock:
            if self._problem is not None:
                return
            if self._needs_key and not frame.is_key:
                self._dropped += 1
                return
            self._needs_key = self._waiting.qsize() >= self._room
            if self._needs_key:
                self._dropped += 1
            else:
                self._waiting.put(frame)

    def interrupt(self) -> None:
        """What comes next builds on nothing that came before: it is written from the next key frame on."""
        with self._lock:
            self._needs_key = True

    def status(self) -> Recording:
        """The recording as it stands."""
        with self._lock:
            return Recording(
                path=self._path,
                duration_s=self._duration_s,
                bytes=self._bytes,
                dropped=self._dropped,
                problem=self._problem,
            )

    def close(self) -> Recording:
        """Write what waits, and end. May be called again."""
        self._waiting.put(None)
        self._thread.join(10.0)
        return self.status()

    def _new_file(self) -> tuple[Path, BinaryIO]:
        return _new_file(self._folder, self._name, "mkv", self._unix_s())

    def _no_room(self) -> str | None:
        return _no_room(self._folder, self._limits, self._free_bytes, self._older_bytes + self._bytes)

    def _run(self) -> None:
        synced = time.monotonic()
        try:
            while (frame := self._waiting.get()) is not None:
                self._write(frame)
                if time.monotonic() - synced >= SYNC_INTERVAL_S:
                    synced = time.monotonic()
                    os.fsync(self._file.fileno())
                    problem = self._no_room()
                    if problem is not None:
                        raise CameraError(problem)
        except (OSError, CameraError) as error:
            text = str(error) if isinstance(error, CameraError) else f"{self._path}: {error.strerror or error}"
            with self._lock:
                self._problem = text
        finally:
            with contextlib.suppress(OSError):
                self._end_file()
            with contextlib.suppress(OSError):
                self._file.close()
            if self._bytes == 0:
                # Nothing came: an empty file is of no use.
                with contextlib.suppress(OSError):
                    self._path.unlink()

    def _write(self, frame: EncodedFrame) -> None:
        is_full = self._bytes >= self._limits.max_file_bytes
        if self._writer is not None and (not self._writer.fits(frame) or is_full):
            if not frame.is_key:
                if is_full:
                    self._append(self._writer.block(frame))
                return
            self._end_file()
            self._file.close()
            path, self._file = self._new_file()
            with self._lock:
                self._path, self._older_bytes, self._bytes, self._writer = (
                    path,
                    self._older_bytes + self._bytes,
                    0,
                    None,
                )
        if self._writer is None:
            if not frame.is_key:
                return
            self._writer = MatroskaWriter(frame, title=self._name)
            self._append(self._writer.header())
        self._append(self._writer.block(frame))

    def _append(self, data: bytes) -> None:
        written = self._file.write(data)
        if written != len(data):
            raise OSError(errno.ENOSPC, "the disk is full")
        with self._lock:
            self._bytes += len(data)
            self._duration_s = 0.0 if self._writer is None else self._writer.duration_s

    def _end_file(self) -> None:
        """Give the file its length and index, and force it to the disk."""
        if self._writer is not None:
            tail, patches = self._writer.end()
            self._append(tail)
            os.fsync(self._file.fileno())
            for position, data in patches:
                self._file.seek(position)
                self._file.write(data)
        os.fsync(self._file.fileno())


def keep_still(
    folder: Path,
    name: str,
    data: bytes,
    *,
    limits: RecorderLimits | None = None,
    free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
    unix_s: float | None = None,
) -> Path:
    """Write a still picture (JPEG) beside the recordings.

    Parameters
    ----------
    folder : Path
        Where to; made when it is not there.
    name : str
        The camera's name.
    data : bytes
        The file.
    limits : RecorderLimits, optional
    free_bytes : callable, optional
        Free space of the disk that a folder is on.
    unix_s : float, optional
        The time of day.

    Raises
    ------
    CameraError
        When nothing can be written there.
    """
    _prepare(folder, limits or RecorderLimits(), free_bytes)
    path = folder
    try:
        for path in _names(folder, name, "jpg", time.time() if unix_s is None else unix_s):
            if create_file(path, data):
                return path
    except OSError as error:
        raise CameraError(f"{path}: {error.strerror or error}") from error
    raise CameraError(f"nothing can be recorded in {folder}: all names of this second are taken")


def _prepare(folder: Path, limits: RecorderLimits, free_bytes: Callable[[Path], int]) -> int:
    """Make the folder; bytes of what is in it."""
    try:
        make_folder(folder)
        used = sum(path.stat().st_size for path in folder.iterdir() if path.suffix in (".mkv", ".jpg"))
    except OSError as error:
        raise CameraError(f"nothing can be recorded in {folder}: {error.strerror}") from error
    problem = _no_room(folder, limits, free_bytes, used)
    if problem is not None:
        raise CameraError(problem)
    return used


def _no_room(folder: Path, limits: RecorderLimits, free_bytes: Callable[[Path], int], used: int) -> str | None:
    if free_bytes(folder) < limits.free_floor_bytes:
        return f"less than {limits.free_floor_bytes / 1e6:.0f} MB are free on the disk of {folder}"
    if used >= limits.quota_bytes:
        return f"the recordings in {folder} take {used / 1e9:.1f} GB, which is all they may; delete some"
    return None


def _names(folder: Path, name: str, kind: str, unix_s: float) -> Iterator[Path]:
    """What a file of this moment may be called."""
    at = datetime.fromtimestamp(0, timezone.utc) + timedelta(seconds=unix_s)
    for attempt in range(100):
        # No camera's name has a dot.
        more = "" if attempt == 0 else f".{attempt + 1}"
        yield folder / f"{at:%Y-%m-%d_%H-%M-%S}_{name}{more}.{kind}"


def _new_file(folder: Path, name: str, kind: str, unix_s: float) -> tuple[Path, BinaryIO]:
    for path in _names(folder, name, kind, unix_s):
        try:
            file = path.open("xb", buffering=0)
            sync_folder(folder)
            return path, file
        except FileExistsError:
            continue
        except OSError as error:
            raise CameraError(f"nothing can be recorded in {folder}: {error.strerror}") from error
    raise CameraError(f"nothing can be recorded in {folder}: all names of this second are taken")
