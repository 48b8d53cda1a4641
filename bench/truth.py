"""Accuracy of rehearsals: each flight is compared with its rehearsal, cross-track, in altitude and in time.

``python bench/truth.py [--recordings DIR]… [--simulated N] [--landings N] [--json FILE]``; `make truth` does that with
everything built. The flights are those of a real ArduPlane among the fixtures, those of the given folders, and random
missions of the simulated plane. Then designed landings are flown by the simulated plane, and the distance of its final
position from the landing point is measured.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from vencejo.rehearsal import Airframe

from bench.flights import landings, recorded, simulated
from bench.flights.compare import Comparison, compare
from bench.flights.rehearsed import rehearsal_of
from bench.flights.table import numbers, table
from bench.flights.track import Flight

GROUPS = {"recorded": "Recorded flights of ArduPlane", "simulated": "Flights of the simulated plane"}


def judged(flight: Flight) -> tuple[Flight, Comparison]:
    """Return a flight with the comparison to its rehearsal."""
    return flight, compare(flight, rehearsal_of(flight))


def flown(seed: int, airframe: Airframe) -> tuple[Flight, Comparison]:
    """Fly a random mission with the simulated plane, and compare it with its rehearsal."""
    return judged(simulated.fly(seed, airframe))


def main() -> None:
    """Compare the flights, and print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "--recordings", type=Path, action="append", default=[], metavar="DIR", help="flights of your own"
    )
    parser.add_argument("--only-these", action="store_true", help="leave out the recordings among the fixtures")
    parser.add_argument("--simulated", type=int, default=20, metavar="N", help="random missions, 20 by default")
    parser.add_argument("--landings", type=int, default=30, metavar="N", help="designed landings, 30 by default")
    parser.add_argument("--seed", type=int, default=0, help="of the first random mission and landing")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the numbers go too")
    given = parser.parse_args()
    own = [flight for folder in given.recordings for flight in recorded.recordings(folder)]
    fixtures = [] if given.only_these else [*recorded.captured(), *recorded.recordings(recorded.RECORDINGS)]
    groups = {"recorded": [judged(flight) for flight in (*fixtures, *own)]}
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        # Without a flight, a plane is assumed to be a foam pusher, which this one is not: so it is learned first, from
        # another flight.
        plane = simulated.learned()
        seeds = range(given.seed, given.seed + given.simulated)
        groups["simulated"] = list(pool.map(partial(flown, airframe=plane), seeds))
        landed = list(pool.map(landings.land, range(given.seed, given.seed + given.landings)))
    found: dict[str, Any] = {}
    for group, pairs in groups.items():
        if pairs:
            flights, comparisons = [flight for flight, _ in pairs], [one for _, one in pairs]
            print(table(GROUPS[group], flights, comparisons), end="\n\n")
            found[group] = numbers(flights, comparisons)
    if landed:
        print(landings.table(landed))
        found["landings"] = landings.numbers(landed)
    if given.json:
        given.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
