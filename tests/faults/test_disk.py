"""The model of a disk that loses unsynced data: it must find the faults known from real file systems."""

from __future__ import annotations

import random
from collections.abc import Iterable
from pathlib import Path

import pytest

from tests.faults.disk import Disk, calls

OLD, NEW = b"old" * 500, b"new" * 700
STEPS = {
    "open": 'openat(AT_FDCWD, "{root}/.a.tmp", O_WRONLY|O_CREAT|O_EXCL|O_CLOEXEC, 0600) = 9',
    "write": 'write(9, "{new}", 2100) = 2100',
    "force": "fsync(9) = 0",
    "close": "close(9) = 0",
    "rename": 'rename("{root}/.a.tmp", "{root}/a") = 0',
    "folder": 'openat(AT_FDCWD, "{root}", O_RDONLY|O_CLOEXEC) = 9',
    "force folder": "fsync(9) = 0",
    "in place": 'openat(AT_FDCWD, "{root}/a", O_WRONLY|O_CREAT|O_TRUNC|O_CLOEXEC, 0666) = 9',
}


def hexadecimal(data: bytes) -> str:
    return "".join(f"\\x{byte:02x}" for byte in data)


def left_after(folder: Path, steps: Iterable[str]) -> tuple[set[bytes | None], set[bytes | None]]:
    """Return the possible contents of file ``a`` after a power cut at any moment, and at the end."""
    root = folder / "data"
    root.mkdir()
    (root / "a").write_bytes(OLD)
    text = "".join(f"7 100.{number:06} {STEPS[step]}\n" for number, step in enumerate(steps))
    # strace writes names as escaped bytes, too.
    log = folder / "log"
    for path in (f"{{root}}/{name}" for name in (".a.tmp", "a")):
        text = text.replace(f'"{path}"', f'"{hexadecimal(path.format(root=root).encode())}"')
    log.write_text(text.replace('"{root}"', f'"{hexadecimal(str(root).encode())}"').replace("{new}", hexadecimal(NEW)))
    disk, found, last = Disk(root), set(), set()
    for call in calls([log]):
        disk.take(call)
        last = {disk.survivor(random.Random(seed)).get("a") for seed in range(200)}
        found |= last
    return found, last


def test_a_file_that_is_replaced_in_the_right_order_is_always_whole(tmp_path: Path) -> None:
    order = ("open", "write", "force", "close", "rename", "folder", "force folder")
    assert left_after(tmp_path, order) == ({OLD, NEW}, {NEW})


@pytest.mark.parametrize(
    ("order", "lost"),
    [
        (("open", "write", "close", "rename", "folder", "force folder"), b""),
        (("open", "write", "close", "rename", "folder", "force folder"), bytes(len(NEW))),
        (("in place", "write", "force", "close"), b""),
        (("open", "close", "rename", "folder", "force folder"), b""),
    ],
)
def test_what_is_written_in_the_wrong_order_is_found_empty_or_half(
    order: tuple[str, ...], lost: bytes, tmp_path: Path
) -> None:
    assert lost in left_after(tmp_path, order)[0]


def test_what_is_overwritten_is_found_mixed(tmp_path: Path) -> None:
    found = left_after(tmp_path, ("in place", "write", "force", "close"))[0]
    assert any(left is not None and left.startswith(b"old") and b"new" in left for left in found)


def test_a_name_that_was_not_forced_may_be_the_old_one_for_ever(tmp_path: Path) -> None:
    assert left_after(tmp_path, ("open", "write", "force", "close", "rename"))[1] == {OLD, NEW}
