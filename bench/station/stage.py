"""Setup of the station's benchmarks: a server with a plane, a Chromium, and storage of results."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.harness import OUT, ROOT, NotMeasured, free_port, result_of, running

if TYPE_CHECKING:
    from playwright.sync_api import Browser, CDPSession, Page

CHROMIUM = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")
ARGUMENTS = (
    "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync", "--disable-background-networking",
    "--disable-component-update", "--disable-renderer-backgrounding", "--disable-background-timer-throttling",
    "--enable-precise-memory-info",
)  # fmt: skip
"""``--disable-gpu`` renders in software, like a machine without a graphics card."""


@dataclass(frozen=True)
class Served:
    """A running station: its address and its server's process id."""

    url: str
    pid: int


@contextlib.contextmanager
def station(hz: int) -> Iterator[Served]:
    """Run a server on a free port that follows the endless plane, with streams of `hz`."""
    OUT.mkdir(parents=True, exist_ok=True)
    port = free_port()
    serve = [
        sys.executable, "-m", "vencejo.cli", "serve", "--port=0", "--json", "--no-record",
        f"--link=udpin:127.0.0.1:{port}", f"--rate={min(hz, 50)}",
    ]  # fmt: skip
    plane = [sys.executable, str(ROOT / "bench/station/plane.py"), str(port), f"--hz={hz}"]
    with running(serve) as server:
        found = result_of(server, 30.0)
        with running(plane):
            yield Served(found["url"], server.pid)


@contextlib.contextmanager
def chromium() -> Iterator[Browser]:
    """Run the system's Chromium, headless."""
    import shutil

    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise NotMeasured("playwright is not installed") from None
    names = filter(None, (os.environ.get("VENCEJO_CHROMIUM"), *CHROMIUM))
    path = next((found for name in names if (found := shutil.which(name))), None)
    if path is None:
        raise NotMeasured("no Chromium: sudo apt-get install -y chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=path, args=list(ARGUMENTS), chromium_sandbox=os.geteuid() != 0
        )
        try:
            yield browser
        finally:
            browser.close()


def metering(page: Page) -> CDPSession:
    """Start counting the CPU time of a page's main thread."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    return session


def costs_ms(session: CDPSession) -> dict[str, float]:
    """Return the CPU time of the page's main thread so far: for scripts, styles and layout, and for all its tasks."""
    metrics = {one["name"]: 1000 * one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
    scripted = metrics["ScriptDuration"] + metrics["LayoutDuration"] + metrics["RecalcStyleDuration"]
    return {"script_layout_ms": scripted, "task_ms": metrics["TaskDuration"]}


def keep(name: str, figures: dict[str, float]) -> None:
    """Write one figure to bench/RESULTS.md, and with all digits to ``bench/out``.

    The machine's load in the last quarter of an hour is recorded too, which matters on a shared machine.
    """
    from bench import report
    from bench.run import machine

    detail = f", load {os.getloadavg()[2]:.0f}"
    found = {"figures": figures, "detail": detail, "date": datetime.now(timezone.utc).date().isoformat()}
    (OUT / f"station-{name}.json").write_text(json.dumps(found, indent=1))
    print(json.dumps({name: found}), flush=True)
    report.write_station(ROOT / "bench/RESULTS.md", name, found, machine())
