"""The end of a ``with`` statement: what is opened is closed there."""

from __future__ import annotations

from typing import TypeVar

_C = TypeVar("_C", bound="Closing")


class Closing:
    """Closed at the end of its ``with`` statement, whatever happened in it."""

    def close(self) -> None:
        """End it. Can be called again."""
        raise NotImplementedError

    def __enter__(self: _C) -> _C:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
