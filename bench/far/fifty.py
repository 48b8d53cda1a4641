"""Fifty planes in the air: a simulator, three onboard stations, two routers and two ground stations, in processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from bench.far.faults import LOST_S, WAY
from bench.far.field import Field, Ground, field_of, until
from bench.far.look import Manned
from bench.far.narrow import Figures, Table
from bench.far.settings import SETTINGS
from bench.harness import NotMeasured, cpu_seconds, quantile, repeat

PLANES, BOARDS = 50, 3
#: Concurrent commands, as many as a page sends for marked vehicles.
AT_ONCE = 8
#: A square to the north, in flying order, followed by an endless circle: degrees.
SQUARE_DEG = ((0.004, 0.0), (0.004, 0.005), (0.008, 0.005), (0.008, 0.0))


def _mission(lat_deg: float, lon_deg: float) -> dict[str, Any]:
    """Return a plan that keeps a plane in the air, beginning at its position."""
    take_off = {"command": 22, "frame": 3, "params": [12.0, 0, 0, 0, lat_deg + 0.002, lon_deg, 50.0]}
    square = [
        {"command": 16, "frame": 3, "params": [0, 0, 0, 0, lat_deg + north, lon_deg + east, 80.0]}
        for north, east in SQUARE_DEG
    ]
    circle = {"command": 17, "frame": 3, "params": [0, 0, 80.0, 0, lat_deg + 0.006, lon_deg, 80.0]}
    return {"items": [take_off, *square, circle]}


def _of_all(places: Iterable[str], act: Callable[[str], str]) -> float:
    """Apply a command to all planes, some at a time; return the time taken, seconds. A command returns its failure."""
    began = time.monotonic()
    with ThreadPoolExecutor(AT_ONCE) as pool:
        refusals = [why for why in pool.map(act, places) if why]
    if refusals:
        raise NotMeasured(f"{len(refusals)} did not do it, one because {refusals[0]}")
    return time.monotonic() - began


def _fly(ground: Ground, places: list[str]) -> Figures:
    """Upload each plan, arm and start the planes."""

    def send(at: str) -> str:
        position = ground.telemetry(at)["position"]
        plan = _mission(position["lat_deg"], position["lon_deg"])
        ground.client.operation("PUT", f"{at}/plan/mission", plan)
        state = ground.client.done("GET", f"{at}/plan/mission")["state"]["state"]
        return "" if state == "verified" else f"its plan is {state}"

    def start(at: str) -> str:
        # A plane that was started seconds ago has no fix yet.
        until(lambda: ground.client.ask("POST", f"{at}/arm", {}).status < 300)
        answer = ground.client.ask("POST", f"{at}/mission/start", {})
        return "" if answer.status < 300 else str(answer.json["detail"])

    return {"sent_s": _of_all(places, send), "started_s": _of_all(places, start)}


def _ages(field: Field, seconds: float) -> Figures:
    """Measure the age of each plane's data at each ground station, and the costs."""
    programs = {
        "ground": [each.program.process.pid for each in field.grounds],
        "board": [each.program.process.pid for each in field.boards],
    }
    used = {name: sum(map(cpu_seconds, pids)) for name, pids in programs.items()}
    began = time.monotonic()
    ages: list[float] = []
    while time.monotonic() - began < seconds:
        for ground in field.grounds:
            ages += [each["age_s"] for each in ground.vehicles().values()]
        time.sleep(0.5)
    lasted_s = time.monotonic() - began
    shares = {
        f"{name}_percent": (sum(map(cpu_seconds, pids)) - used[name]) / lasted_s / len(pids) * 100
        for name, pids in programs.items()
    }
    return {"age_s": quantile(ages, 0.5), "age_p99_s": quantile(ages, 0.99), "worst_age_s": max(ages), **shares}


def _without_router(field: Field, ground: Ground) -> Figures:
    """Kill the router to which all planes are connected, while there is another one."""
    began, lost = time.monotonic(), set[str]()
    field.routers[0].kill()

    def are_back() -> bool:
        ages = {name: each["age_s"] for name, each in ground.vehicles().items()}
        lost.update(name for name, age_s in ages.items() if age_s > LOST_S)
        return bool(max(ages.values()) < min(2.0, time.monotonic() - began))

    until(are_back)
    return {"worst_back_s": time.monotonic() - began, "worst_lost": float(len(lost))}


def far_fifty(runs: int, _seconds: float) -> Table:
    """Fly fifty planes, watch them from two ground stations, and kill their router."""

    def once() -> Figures:
        with field_of(planes=PLANES, boards=BOARDS, grounds=2, routers=2, up=WAY, down=WAY) as field:
            ground, other = field.grounds
            with Manned(ground):
                ground.client.done("POST", "control/take")
                places = [ground.at(name) for name in field.planes]
                figures = _fly(ground, places)

                def are_flying() -> bool:
                    return all(each["mode"] == "AUTO" and each["is_armed"] for each in other.vehicles().values())

                figures["seen_s"] = until(are_flying)
                figures |= _ages(field, SETTINGS.narrow_s)
                figures |= _without_router(field, ground)
                figures["flying"] = float(sum(each["mode"] == "AUTO" for each in ground.vehicles().values()))
                return figures

    return repeat(runs, {"vencejo": once})
