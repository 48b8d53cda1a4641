"""Formats comparisons of flights with their rehearsals, as a table and as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from statistics import median
from typing import Any

from bench.flights.compare import KINDS, Comparison, Figures, figures
from bench.flights.track import Flight

HEAD = ("time", "RMS across", "worst", "RMS height", "worst", "RMS late", "worst", "worst", "missed")


def row(name: str, found: Figures) -> str:
    """Return one row of the table."""
    cells = (
        f"{found.seconds:.0f} s",
        f"{found.cross_rms_m:.1f} m",
        f"{found.cross_worst_m:.1f} m",
        f"{found.height_rms_m:.1f} m",
        f"{found.height_worst_m:.1f} m",
        f"{found.time_rms_percent:.1f} %",
        f"{found.time_worst_percent:.1f} %",
        f"{found.time_worst_s:.1f} s",
        f"{found.missed} of {found.arrivals}",
    )
    more = f"  not compared: {found.not_compared_s:.0f} s" if found.not_compared_s >= 1.0 else ""
    return f"{name:<38}" + "".join(f"{cell:>11}" for cell in cells) + more


def landing(found: Comparison) -> str:
    """Return where the rehearsal lands, compared with the flight."""
    if found.touchdown_m is None or found.rest_m is None:
        return "lands in one of both only" if any(a.kind == "landing" for a in found.arrivals) else ""
    return f"touch-down {found.touchdown_m:.1f} m apart, rest {found.rest_m:.1f} m apart"


def table(title: str, flights: Sequence[Flight], comparisons: Sequence[Comparison]) -> str:
    """Return the table of a group of flights: each flight, then each kind of leg over all of them."""
    lines = [title, f"{'':<38}" + "".join(f"{head:>11}" for head in HEAD)]
    for flight, found in zip(flights, comparisons, strict=True):
        whole = figures([found])
        assert whole is not None, "a flight has samples"
        lines.append(row(f"{flight.name}, {flight.wind.speed_m_s:.1f} m/s", whole) + f"  {landing(found)}")
    for kind in (*KINDS, None):
        of_kind = figures(comparisons, kind)
        if of_kind is not None:
            lines.append(row(f"  {kind or 'all'}", of_kind))
    down = [found.touchdown_m for found in comparisons if found.touchdown_m is not None]
    if down:
        lines.append(f"  touch-down: median {median(down):.1f} m apart, worst {max(down):.1f} m")
    return "\n".join(lines)


def numbers(flights: Sequence[Flight], comparisons: Sequence[Comparison]) -> dict[str, Any]:
    """Return the same as JSON."""

    def by_kind(some: Sequence[Comparison]) -> dict[str, Any]:
        found = {kind or "all": figures(some, kind) for kind in (None, *KINDS)}
        return {kind: asdict(one) for kind, one in found.items() if one is not None}

    return {
        "kinds": by_kind(comparisons),
        "flights": [
            {
                "name": flight.name,
                "wind": asdict(flight.wind),
                "kinds": by_kind([found]),
                "touchdown_m": found.touchdown_m,
                "rest_m": found.rest_m,
                "arrivals": [asdict(arrival) for arrival in found.arrivals],
            }
            for flight, found in zip(flights, comparisons, strict=True)
        ],
    }
