"""The system's Chromium: where it is and how it is started. Playwright's own is never downloaded."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import AsyncIterator

from playwright.async_api import Browser, async_playwright

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome-stable", "google-chrome")
ARGUMENTS = [
    *("--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
    # Several pages are open at once, and one that is covered is tested like any other.
    *("--disable-renderer-backgrounding", "--disable-backgrounding-occluded-windows"),
    "--disable-background-timer-throttling",
]
SLOW_DISPLAY = """
(() => {
  const display = window.requestAnimationFrame.bind(window);
  const waiting = new Map();
  let handle = 0, last_ms = -Infinity, isDue = false;
  const draw = (now_ms) => {
    [isDue, last_ms] = [false, now_ms];
    for (const one of [...waiting.keys()]) {
      const callback = waiting.get(one);
      if (waiting.delete(one)) callback(now_ms);
    }
  };
  window.requestAnimationFrame = (callback) => {
    waiting.set(++handle, callback);
    if (!isDue) setTimeout(() => display(draw), last_ms + 200 - performance.now());
    isDue = true;
    return handle;
  };
  window.cancelAnimationFrame = (one) => void waiting.delete(one);
})();
"""
"""To be run in a page: a display of five frames a second, as often as the plane is heard. At sixty, without a graphics card, the horizon
alone takes a third of a core; at ten, page and compositor take half as much again as at five."""
WIDE = (1440, 900)
PHONE = (390, 844)


def chromium() -> str:
    """Where it is: the one without windows costs these tests a quarter less than a whole one that shows none."""
    for name in filter(None, (os.environ.get("VENCEJO_CHROMIUM"), *NAMES)):
        if found := shutil.which(name):
            return found
    raise RuntimeError("no Chromium: sudo apt-get install -y chromium, or say where one is with VENCEJO_CHROMIUM")


@contextlib.asynccontextmanager
async def running() -> AsyncIterator[Browser]:
    """Chromium without a window; as root, as in a container, also without its sandbox."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=chromium(), args=ARGUMENTS, chromium_sandbox=os.geteuid() != 0
        )
        try:
            yield browser
        finally:
            await browser.close()
