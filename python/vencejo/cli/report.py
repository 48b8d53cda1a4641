"""Output of a flight: a live view on a terminal, plain lines elsewhere, or JSON lines."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final

from vencejo.cli.common import clean, put_json, stdout
from vencejo.cli.follow import Note, View, line, render

if TYPE_CHECKING:
    from rich.live import Live

LINE_EVERY_S: Final = 10.0
"""How often a picture is written where there is no terminal to redraw it on."""
JSON_EVERY_S: Final = 1.0


class Reporter:
    """Tells what happens, in the one of the three ways that fits."""

    def __init__(self, *, json: bool) -> None:
        self.json = json
        self._console = stdout()
        self._is_live = not json and self._console.is_terminal
        self._live: Live | None = None
        self._next_s = 0.0

    def step(self, event: str, text: str, /, **values: Any) -> None:
        """Tell that something was done or found."""
        if self.json:
            put_json({"event": event, "text": text, **values})
        elif self._live is not None:
            self._live.console.print(clean(text))
        else:
            print(clean(text, keep_lines=True), flush=True)

    def note(self, note: Note) -> None:
        """Tell what happened in flight. Texts of the vehicle stand in the live picture already."""
        if self._live is None or note.kind != "text":
            self.step(note.kind, note.text, **note.values)

    def view(self, view: View) -> None:
        """Show a picture."""
        if self._live is not None:
            self._live.update(render(view), refresh=True)
        elif view.elapsed_s >= self._next_s:
            self._next_s = view.elapsed_s + (JSON_EVERY_S if self.json else LINE_EVERY_S)
            if self.json:
                put_json({"event": "progress", **view.as_json()})
            else:
                print(line(view), flush=True)

    @contextlib.contextmanager
    def pictures(self) -> Iterator[None]:
        """While pictures are shown."""
        self._next_s = 0.0
        if not self._is_live:
            yield
            return
        from rich.live import Live

        with Live(console=self._console, auto_refresh=False) as live:
            self._live = live
            try:
                yield
            finally:
                self._live = None

    def __enter__(self) -> Reporter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        sys.stdout.flush()
