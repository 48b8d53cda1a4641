"""A disk that keeps only what was synced: the writes of a traced program, cut off at any moment.

`calls` reads strace's log of a program: files opened, written, renamed, synced. `Disk` replays it on a model with
weaker guarantees than any file system in use:

- of data written to a file and not synced since (fsync, fdatasync), each 512-byte sector has its old content, its new
  content, or any in between; extended space may be zeros; the size is any of those that it had;
- of names created in a folder that was not synced since, each name has its old meaning, its new one, or any in between,
  independently: a rename may have happened at one end only, and names may appear out of order;
- syncing a file does not sync its name, and vice versa. A folder whose name is missing is lost with everything in it.

The model does not cover data lost from a drive's cache in spite of a sync, nor unreadable sectors.
"""

from __future__ import annotations

import codecs
import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

CALLS = (
    "open,openat,creat,close,dup,dup2,dup3,fcntl,lseek,read,write,pwrite64,writev,pwritev,pwritev2,truncate,ftruncate,fallocate,"
    "rename,renameat,renameat2,link,linkat,symlink,symlinkat,unlink,unlinkat,mkdir,mkdirat,rmdir,"
    "fsync,fdatasync,sync_file_range,sync,syncfs,copy_file_range,sendfile"
)
"""System calls that have to be traced."""
SECTOR = 512

_LINE = re.compile(r"^(\d+) +(\d+\.\d+) (.*)$")
_UNFINISHED = " <unfinished ...>"
_RESUMED = re.compile(r"^<\.\.\. \w+ resumed>(.*)$", re.S)
_CALL = re.compile(r"^(\w+)\((.*)\) += (-?\d+|\?)(.*)$", re.S)
_STRING = re.compile(r'"((?:\\x[0-9a-f]{2})*)"(\.\.\.)?')


def strace(log: Path) -> list[str]:
    """Return the command that traces a program into a file."""
    return [
        *("strace", "-f", "--seccomp-bpf", "-ttt", "-xx", "-s", "16777216", "-e", "signal=none"),
        *("-e", f"trace={CALLS}", "-o", str(log)),
    ]


@dataclass(frozen=True)
class Call:
    """A system call; with `is_end` false, only its beginning."""

    program: int
    at_s: float
    number: int
    name: str
    args: str
    result: int
    is_end: bool

    @property
    def strings(self) -> list[bytes]:
        """Return its strings and data."""
        found = _STRING.findall(self.args)
        assert not any(cut for _, cut in found), "strace kept all of it"
        return [codecs.decode(text.replace("\\x", ""), "hex") for text, _ in found]

    @property
    def numbers(self) -> list[int]:
        """Return its numbers, except those within strings."""
        return [int(text, 0) for text in re.findall(r"(?<![\w\"])-?\d+(?![\w\"])", _STRING.sub("", self.args))]


def calls(logs: list[Path]) -> Iterator[Call]:
    """Yield the beginnings and ends of the calls of several parallel programs, in order."""
    lines = []
    for program, log in enumerate(logs):
        for place, line in enumerate(log.read_text(encoding="ascii").splitlines()):
            if found := _LINE.match(line):
                lines.append((float(found[2]), program, place, found[1], found[3]))
    lines.sort(key=lambda line: line[:3])
    begun: dict[tuple[int, str], tuple[int, str]] = {}
    ends: dict[int, str] = {}
    for number, (_, program, _, thread, text) in enumerate(lines):
        if text.endswith(_UNFINISHED):
            begun[program, thread] = (number, text.removesuffix(_UNFINISHED))
        elif resumed := _RESUMED.match(text):
            first, head = begun.pop((program, thread))
            ends[first] = ends[number] = head + resumed[1]
    open_: dict[tuple[int, str], int] = {}
    for number, (at_s, program, _, thread, text) in enumerate(lines):
        is_begin, is_end = text.endswith(_UNFINISHED), text.startswith("<...")
        whole = ends.get(number) if is_begin or is_end else text
        found = _CALL.match(whole) if whole is not None else None
        if found is None or found[3] in {"?", "-1"}:
            continue
        if is_begin:
            open_[program, thread] = number
        first = open_.pop((program, thread)) if is_end else number
        call = (first, found[1], found[2], int(found[3]))
        if not is_end:
            yield Call(program, at_s, *call, False)
        if not is_begin:
            yield Call(program, at_s, *call, True)


@dataclass
class _Write:
    """Data at an offset, or, without `data`, a new size."""

    at: int
    data: bytes | None
    is_done: bool = False

    def apply(self, to: bytearray) -> None:
        if self.data is None:
            del to[self.at :]
            to.extend(bytes(self.at - len(to)))
            return
        to.extend(bytes(max(0, self.at + len(self.data) - len(to))))
        to[self.at : self.at + len(self.data)] = self.data

    def extent(self, size: int) -> tuple[int, int]:
        """Return the range in which it changes a file that is never longer than `size`."""
        return self.at, size if self.data is None else self.at + len(self.data)

    def part(self, begin: int, end: int) -> _Write:
        """Return the part of it in a range of the file."""
        data = self.data
        if data is not None:
            data = data[max(0, begin - self.at) : max(0, end - self.at)]
        return _Write(max(0, self.at - begin), data)


@dataclass
class File:
    """A file: its synced content, and the writes since."""

    forced: bytearray = field(default_factory=bytearray)
    writes: list[_Write] = field(default_factory=list)
    now: bytearray = field(default_factory=bytearray)

    def begin(self, at: int, data: bytes | None) -> _Write:
        """Begin a write or a truncation."""
        write = _Write(at, data)
        self.writes.append(write)
        write.apply(self.now)
        return write

    def done(self) -> int:
        """Return the number of leading completed writes, which a sync that begins now includes."""
        return next((at for at, write in enumerate(self.writes) if not write.is_done), len(self.writes))

    def force(self, writes: list[_Write]) -> None:
        """Mark these writes as synced."""
        while self.writes and any(self.writes[0] is write for write in writes):
            self.writes.pop(0).apply(self.forced)

    def survivor(self, choose: random.Random, way: str) -> bytes:
        """Return the content after a power cut."""
        if not self.writes or way == "most":
            return bytes(self.now)
        if way == "least":
            return bytes(self.forced)
        sizes = [len(self.forced)]
        for write in self.writes:
            sizes.append(write.at if write.data is None else max(sizes[-1], write.at + len(write.data)))
        size = max(sizes)
        left = self.forced + bytes(size - len(self.forced))
        # All of the sectors, none, or each independently.
        share = choose.choice((None, None, 0.0, 1.0))
        extents = [write.extent(size) for write in self.writes]
        for sector in {at for begin, end in extents for at in range(begin // SECTOR, -(-end // SECTOR))}:
            first, last = sector * SECTOR, min((sector + 1) * SECTOR, size)
            here = [w for w, (begin, end) in zip(self.writes, extents, strict=True) if begin < last and end > first]
            kept = choose.randint(0, len(here)) if share is None else round(share * len(here))
            piece = left[first:last]
            for write in here[:kept]:
                write.part(first, last).apply(piece)
                piece.extend(bytes(last - first - len(piece)))
            left[first:last] = piece
        del left[choose.choice(sizes) :]
        return bytes(left)


class Folder(dict[str, "Name"]):
    """A folder: its names."""


@dataclass
class Name:
    """The meaning of a name in a folder: the synced one, and its changes since."""

    values: list[File | Folder | None] = field(default_factory=lambda: [None])
    forced: int = 0
    """Number of values before the synced one."""

    @property
    def now(self) -> File | Folder | None:
        """Return the present value."""
        return self.values[-1]

    @property
    def count(self) -> int:
        """Return the number of values before this one."""
        return self.forced + len(self.values) - 1

    def force(self, count: int) -> None:
        """Mark the value with this number of predecessors as synced."""
        if count > self.forced:
            del self.values[: count - self.forced]
            self.forced = count


@dataclass
class _Open:
    what: File | Folder
    at: int = 0
    is_append: bool = False


class Disk:
    """A folder as written by the traced programs, and what would remain of it after a power cut."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.tree = Folder()
        self.whole: dict[str, list[bytes]] = {}
        """Every content that was given a name as a complete file, by its path in the folder."""
        self.forces = 0
        self._files: dict[tuple[int, int], _Open] = {}
        self._begun: dict[tuple[int, int], object] = {}
        for path in sorted(root.rglob("*")):
            folder, name = self._place(path)
            made: File | Folder = Folder()
            if path.is_file():
                content = path.read_bytes()
                made = File(bytearray(content), [], bytearray(content))
                self.whole.setdefault(str(path.relative_to(root)), []).append(content)
            folder[name] = Name([made])

    # Present state ----------------------------------------------------------------------------------------------------

    def _place(self, path: Path) -> tuple[Folder, str]:
        folder = self.tree
        *above, name = path.relative_to(self.root).parts
        for part in above:
            found = folder[part].now
            assert isinstance(found, Folder), path
            folder = found
        return folder, name

    def _inside(self, text: bytes) -> Path | None:
        path = Path(text.decode())
        return path if path.is_relative_to(self.root) and path != self.root else None

    def look(self, path: Path) -> File | Folder | None:
        """Return the present meaning of a path."""
        if path == self.root:
            return self.tree
        folder, name = self._place(path)
        return folder[name].now if name in folder else None

    def files(self) -> dict[str, File]:
        """Return the present files, by their path in the folder."""
        return dict(_files_in(self.tree, ""))

    def _name(self, path: Path, what: File | Folder | None) -> None:
        folder, name = self._place(path)
        folder.setdefault(name, Name()).values.append(what)
        if isinstance(what, File):
            self.whole.setdefault(str(path.relative_to(self.root)), []).append(bytes(what.now))

    # Actions of the program -------------------------------------------------------------------------------------------

    def take(self, call: Call) -> bool:
        """Process the beginning or the end of a call; return whether it changed something."""
        if call.name.endswith("at"):
            # Our programs do not open files relative to a folder's descriptor.
            assert not any(
                (call.program, int(n)) in self._files for n in re.findall(r"(?:^|, )(\d+), \"", call.args)
            ), call
        act = getattr(self, f"_on_{call.name}", None)
        return bool(act(call)) if act is not None else False

    def _on_openat(self, call: Call) -> bool:
        if not call.is_end:
            return False
        path = self.root if (text := call.strings[0]) == str(self.root).encode() else self._inside(text)
        if path is None:
            self._files.pop((call.program, call.result), None)
            return False
        what, has_changed = self.look(path), False
        if what is None:
            assert "O_CREAT" in call.args, call
            what, has_changed = File(), True
            folder, name = self._place(path)
            folder.setdefault(name, Name()).values.append(what)
        elif "O_TRUNC" in call.args and isinstance(what, File) and what.now:
            what.begin(0, None).is_done = True
            has_changed = True
        self._files[call.program, call.result] = _Open(what, is_append="O_APPEND" in call.args)
        return has_changed

    _on_open = _on_creat = _on_openat

    def _on_close(self, call: Call) -> bool:
        if call.is_end:
            self._files.pop((call.program, call.numbers[0]), None)
        return False

    def _on_dup(self, call: Call) -> bool:
        if call.is_end and (found := self._files.get((call.program, call.numbers[0]))) is not None:
            self._files[call.program, call.result] = found
        return False

    _on_dup2 = _on_dup3 = _on_dup

    def _on_fcntl(self, call: Call) -> bool:
        return self._on_dup(call) if "F_DUPFD" in call.args else False

    def _on_lseek(self, call: Call) -> bool:
        if call.is_end and (found := self._files.get((call.program, call.numbers[0]))) is not None:
            found.at = call.result
        return False

    def _on_read(self, call: Call) -> bool:
        if call.is_end and (found := self._files.get((call.program, call.numbers[0]))) is not None:
            found.at += call.result
        return False

    def _on_write(self, call: Call) -> bool:
        key = (call.program, call.number)
        if call.is_end:
            if isinstance(write := self._begun.pop(key, None), _Write):
                write.is_done = True
            return False
        found = self._files.get((call.program, call.numbers[0]))
        if found is None:
            return False
        assert isinstance(found.what, File), call
        data = b"".join(call.strings)[: call.result]
        if call.name.startswith("p"):
            at = call.numbers[-1]
        else:
            at = len(found.what.now) if found.is_append else found.at
            found.at = at + len(data)
        self._begun[key] = found.what.begin(at, data)
        return True

    _on_writev = _on_pwrite64 = _on_write

    def _on_ftruncate(self, call: Call) -> bool:
        found = self._files.get((call.program, call.numbers[0])) if call.is_end else None
        if found is None:
            return False
        assert isinstance(found.what, File), call
        found.what.begin(call.numbers[1], None).is_done = True
        return True

    def _on_fsync(self, call: Call) -> bool:
        key = (call.program, call.number)
        if not call.is_end:
            if (found := self._files.get((call.program, call.numbers[0]))) is not None:
                self._begun[key] = self._forcing(found.what)
            return False
        force = self._begun.pop(key, None)
        if not callable(force):
            return False
        force()
        self.forces += 1
        return True

    @staticmethod
    def _forcing(what: File | Folder) -> Callable[[], None]:
        """Return the sync of a call that begins now."""
        if isinstance(what, File):
            writes = what.writes[: what.done()]
            return lambda: what.force(writes)
        counts = [(name, name.count) for name in what.values()]

        def force() -> None:
            for name, count in counts:
                name.force(count)

        return force

    _on_fdatasync = _on_fsync

    def _on_rename(self, call: Call) -> bool:
        if not call.is_end:
            return False
        old, new = (self._inside(text) for text in call.strings)
        if old is None and new is None:
            return False
        assert old is not None, call
        assert new is not None, call
        what = self.look(old)
        self._name(new, what)
        self._name(old, None)
        return True

    _on_renameat = _on_renameat2 = _on_rename

    def _on_link(self, call: Call) -> bool:
        if not call.is_end:
            return False
        old, new = (self._inside(text) for text in call.strings)
        if old is None or new is None:
            return False
        self._name(new, self.look(old))
        return True

    _on_linkat = _on_link

    def _on_unlink(self, call: Call) -> bool:
        path = self._inside(call.strings[0]) if call.is_end else None
        if path is None:
            return False
        self._name(path, None)
        return True

    _on_unlinkat = _on_rmdir = _on_unlink

    def _on_mkdir(self, call: Call) -> bool:
        path = self._inside(call.strings[0]) if call.is_end else None
        if path is None:
            return False
        self._name(path, Folder())
        return True

    _on_mkdirat = _on_mkdir

    def _unknown(self, call: Call) -> bool:
        strings, numbers = call.strings, call.numbers
        ours = any(self._inside(text) for text in strings if text.startswith(b"/"))
        assert not ours, call
        assert not any((call.program, number) in self._files for number in numbers[:2]), call
        return False

    _on_truncate = _on_fallocate = _on_symlink = _on_symlinkat = _on_pwritev = _on_pwritev2 = _unknown
    _on_copy_file_range = _on_sendfile = _on_sync_file_range = _unknown

    # State after a power cut ------------------------------------------------------------------------------------------

    def survivor(self, choose: random.Random) -> dict[str, bytes]:
        """Return the files after a power cut now, by path; empty folders are omitted."""
        # The least and the most possible; new names for empty files; anything.
        way = choose.choices(("least", "most", "names", "any"), (1, 1, 3, 5))[0]
        left: dict[str, bytes] = {}
        contents: dict[int, bytes] = {}

        def walk(folder: Folder, path: str) -> None:
            for name, each in folder.items():
                if way in {"most", "names"}:
                    what = each.now
                elif way == "least":
                    what = each.values[0]
                else:
                    what = choose.choice(each.values)
                if isinstance(what, Folder):
                    walk(what, f"{path}{name}/")
                elif what is not None:
                    if id(what) not in contents:
                        contents[id(what)] = what.survivor(choose, "any" if way == "names" else way)
                    left[f"{path}{name}"] = contents[id(what)]

        walk(self.tree, "")
        return left


def _files_in(folder: Folder, path: str) -> Iterator[tuple[str, File]]:
    for name, each in folder.items():
        if isinstance(each.now, File):
            yield f"{path}{name}", each.now
        elif isinstance(each.now, Folder):
            yield from _files_in(each.now, f"{path}{name}/")
