"""Runs the steps of scripts/setup.sh for `make demo` or `make native`, in parallel where possible, and shows progress.

    scripts/get_ready.py demo      the package as built by `make demo`: quick to compile, without fleets
    scripts/get_ready.py native    the optimised package

On a terminal, one line is kept up to date; elsewhere (a log, TERM=dumb), a plain line is printed now and then. A step
with nothing to do prints nothing. When one fails, its log is printed and the others are ended. Each step writes a log
in .cache, from which its progress is read.
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, TextIO

ROOT: Final = Path(__file__).resolve().parent.parent
LOOK_S: Final = 0.2
"""Polling interval of the steps."""
PLAIN_S: Final = 20.0
"""Interval of progress lines in a log."""
QUIET_S: Final = 1.0
"""A step that takes no longer than this had nothing to do."""
TAIL_BYTES: Final = 4096
REST_S: Final = 5.0
"""Time to wait for the remaining output of an ended step, since its child processes may keep the pipe open forever."""

Progress = Callable[[str], str]
"""Progress of a step according to its log so far, such as ``143 of 297, mavlink``; empty when unknown."""


def cargo_progress(log: str) -> str:
    """Return the newest of cargo's progress bars: units of work, and the current crate."""
    bars = re.findall(r"(?:Building|Downloading) \[[=> ]*\] (\d+)/(\d+)(?:: ([\w-]+))?", log[-TAIL_BYTES:])
    if not bars:
        return "fetching crates" if re.search(r"Downloading|Updating|Locking", log) else ""
    done, count, crate = bars[-1]
    return f"{done} of {count}" + (f", {crate.removesuffix('(build)')}" if crate else "")


def pip_progress(log: str, lock: Path) -> str:
    """Return the number of packages fetched by pip, of those in the lock."""
    if "Installing collected packages" in log:
        return "installing"
    count = len(re.findall(r"^[\w.-]+==", lock.read_text(encoding="utf-8"), re.MULTILINE))
    return _of(len(re.findall(r"^Collecting ", log, re.MULTILINE)), count)


def npm_progress(log: str, lock: Path) -> str:
    """Return the number of packages fetched by npm, of those in the lock for this platform."""
    mine = {
        "os": sys.platform,
        "cpu": {"x86_64": "x64", "aarch64": "arm64"}.get(platform.machine(), platform.machine()),
    }
    packages = json.loads(lock.read_text(encoding="utf-8"))["packages"]
    count = sum(
        bool(name) and all(one in package.get(key, [one]) for key, one in mine.items()) and "musl" not in name
        for name, package in packages.items()
    )
    return _of(len(set(re.findall(r"fetch GET 200 (\S+\.tgz)", log))), count)


def _of(done: int, count: int) -> str:
    return f"{min(done, count)} of {count}" if done else ""


@dataclass
class Step:
    """One call of setup.sh."""

    title: str
    words: tuple[str, ...]
    log: str = ""
    """Name of its log in .cache."""
    progress: Progress = lambda _: ""
    after: tuple[str, ...] = ()
    """Titles of the steps that must be done before."""
    process: subprocess.Popen[str] | None = field(default=None, init=False)
    began_s: float = field(default=0.0, init=False)
    is_done: bool = field(default=False, init=False)
    reader: threading.Thread | None = field(default=None, init=False)
    lines: queue.SimpleQueue[str] = field(default_factory=queue.SimpleQueue, init=False)

    def tell(self, display: Display) -> None:
        """Print its new output."""
        while not self.lines.empty():
            display.say(self.lines.get())

    def how_far(self) -> str:
        """Return its progress, if its log was written by this run."""
        path = ROOT / ".cache" / self.log
        try:
            # The file system's clock may be slightly behind.
            if not self.log or path.stat().st_mtime < self.began_s - 1.0:
                return ""
            return self.progress(path.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            return ""


def steps_of(wanted: str) -> list[Step]:
    """Return the steps of `make demo` or `make native`.

    The demo's module reads the page's files from gcs/dist, so the page is built in parallel; the other module embeds
    them, and is compiled afterwards.
    """
    python = Step(
        "Python packages", ("demo",), "pip-demo.log", lambda log: pip_progress(log, ROOT / "requirements/demo.lock")
    )
    packages = Step(
        "web packages", ("app-packages",), "npm-gcs.log", lambda log: npm_progress(log, ROOT / "gcs/package-lock.json")
    )
    page = Step("web page", ("app",), after=(packages.title,))
    how, needs = (
        (("native", "demo"), (python.title,)) if wanted == "demo" else (("native",), (python.title, page.title))
    )
    return [Step("Rust core", how, "native.log", cargo_progress, after=needs), python, packages, page]


class Display:
    """The progress line, or plain lines in its place."""

    def __init__(self, to: TextIO, now_s: float) -> None:
        self._to = to
        self.is_live = to.isatty() and os.environ.get("TERM", "dumb") != "dumb"
        self._began_s = self._told_s = now_s
        self._shown = ""

    def say(self, line: str) -> None:
        """Print a permanent line."""
        self._clear()
        print(line, file=self._to, flush=True)

    def show(self, steps: Iterable[Step], now_s: float, *, total: int, done: int) -> None:
        """Show the progress of the running steps."""
        every_s = LOOK_S if self.is_live else PLAIN_S
        running = [step for step in steps if step.process is not None and not step.is_done]
        if not running or now_s - self._began_s < QUIET_S or now_s - self._told_s < every_s:
            return
        self._told_s = now_s
        parts = [" ".join(filter(None, (step.title, step.how_far()))) for step in running]
        line = f"· {clock(now_s - self._began_s)}  step {done + 1} of {total}: " + " | ".join(parts)
        if not self.is_live:
            self.say(line)
            return
        width = shutil.get_terminal_size().columns - 1
        line = line if len(line) <= width else line[: width - 1] + "…"
        if line != self._shown:
            self._clear()
            self._to.write(line)
            self._to.flush()
            self._shown = line

    def _clear(self) -> None:
        if self._shown:
            self._to.write("\r\x1b[K")
            self._shown = ""

    def end(self) -> None:
        """Restore the terminal."""
        self._clear()
        self._to.flush()


def clock(seconds: float) -> str:
    """Return minutes and seconds."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def run(steps: list[Step], command: list[str], to: TextIO, *, look_s: float = LOOK_S) -> int:
    """Run all steps, each as soon as its predecessors are done.

    Returns
    -------
    int
        0, or the exit code of the step that failed.
    """
    display = Display(to, time.monotonic())
    began_s = time.monotonic()
    woken = threading.Event()
    try:
        while not all(step.is_done for step in steps):
            done = {step.title for step in steps if step.is_done}
            for step in steps:
                if step.process is None and done.issuperset(step.after):
                    _start(step, [*command, *step.words], woken)
            display.show(steps, time.monotonic(), total=len(steps), done=len(done))
            woken.wait(look_s)
            woken.clear()
            for step in steps:
                step.tell(display)
                if step.process is None or step.is_done or (code := step.process.poll()) is None:
                    continue
                step.is_done = True
                took_s = time.time() - step.began_s
                # It may have ended before all of its output was read.
                if step.reader is not None:
                    step.reader.join(REST_S)
                step.tell(display)
                if code:
                    display.say(f"· {step.title}: failed after {clock(took_s)}")
                    return code
                if took_s > QUIET_S:
                    display.say(f"· {step.title}: done in {clock(took_s)}")
        if time.monotonic() - began_s > QUIET_S:
            display.say(f"· ready after {clock(time.monotonic() - began_s)}")
        return 0
    finally:
        display.end()
        for step in steps:
            if step.process is not None and step.process.poll() is None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(step.process.pid, signal.SIGTERM)
                step.process.wait()


def _start(step: Step, command: list[str], woken: threading.Event) -> None:
    step.began_s = time.time()
    # A process group of its own, so that child processes of a step end with it.
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    step.process = process

    def read() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            step.lines.put(line.rstrip("\n"))
        process.wait()
        woken.set()

    step.reader = threading.Thread(target=read, daemon=True)
    step.reader.start()


def main(words: list[str]) -> int:
    """Run the program with these arguments."""
    if words not in (["demo"], ["native"]):
        print("say what: scripts/get_ready.py demo, or native", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        return run(steps_of(words[0]), ["scripts/setup.sh"], sys.stderr)
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
