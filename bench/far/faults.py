"""Faults in the field: time to detection, time to recovery, and who has control in between."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.far.field import Board, Field, field_of, planes_on, until
from bench.far.look import Orders, Watch, order, orders_for
from bench.far.narrow import UPLINK, Figures, Table
from bench.far.settings import SETTINGS
from bench.harness import NotMeasured, repeat
from tests.fleet.proxy import Line, open_way
from tests.fleet.records import numbered
from tests.fleet.test_transfers import plan_of
from tests.server.client import serving

#: Age at which a page shows a value in grey, and age at which a vehicle counts as lost.
STALE_S, LOST_S = 3.5, 5.0
#: Round trips of 100 ms and of 200 ms.
WAY, LONG_WAY = Line(delay_s=0.05), Line(delay_s=0.1)
#: How long a path stays cut, or a program frozen, beyond the time needed to detect it.
STAYS_S = 10.0
#: Plus home.
ITEMS = 649


def _seen(field: Field, begin: Callable[[Board], None], end: Callable[[Board], None]) -> Figures:
    """Break something at an onboard station, and repair it."""
    ground, board = field.grounds[0], field.boards[0]
    ground.client.done("POST", "control/take")
    at = ground.at("plane1")
    until(lambda: order(ground, at))
    until(lambda: ground.age_s(at) < 0.5)
    began = time.monotonic()
    begin(board)
    until(lambda: ground.age_s(at) > STALE_S)
    grey_s = time.monotonic() - began
    time.sleep(STAYS_S - grey_s)
    healed = time.monotonic()
    end(board)
    until(lambda: ground.age_s(at) < min(STALE_S, time.monotonic() - healed))
    back_s = time.monotonic() - healed
    until(lambda: order(ground, at, 1))
    return {"worst_grey_s": grey_s, "worst_back_s": back_s, "worst_commanding_s": time.monotonic() - healed}


def _with_router(what: Callable[[Field], object]) -> Figures:
    """Do something to the router to which all planes are connected."""
    with field_of(planes=10, boards=3, grounds=2, routers=2, up=WAY, down=WAY) as field:
        ground = field.grounds[0]
        ground.client.done("POST", "control/take")
        places = [ground.at(name) for name in field.planes]
        until(lambda: order(ground, places[0]))
        until(lambda: all(ground.age_s(at) < 1.5 for at in places))
        began, oldest_s = time.monotonic(), 0.0
        field.routers[0].kill()
        what(field)
        lost: set[str] = set()

        def are_back() -> bool:
            nonlocal oldest_s
            ages = {at: ground.age_s(at) for at in places}
            oldest_s = max(oldest_s, *ages.values())
            lost.update(at for at, age_s in ages.items() if age_s > LOST_S)
            return max(ages.values()) < min(2.0, time.monotonic() - began)

        until(are_back)
        back_s = time.monotonic() - began
        until(lambda: order(ground, places[0], 1))
        return {
            "worst_back_s": back_s,
            "worst_commanding_s": time.monotonic() - began,
            "worst_oldest_s": oldest_s,
            "worst_lost": float(len(lost)),
        }


def far_cut(runs: int, _seconds: float) -> Table:
    """Cut the path, in both directions and in one; freeze an onboard station; kill and restart one of several routers."""

    def cut(**which: bool) -> Callable[[], Figures]:
        def once() -> Figures:
            with field_of(up=WAY, down=WAY) as field:
                return _seen(field, lambda board: board.cut(**which), Board.heal)

        return once

    def frozen() -> Figures:
        with field_of(up=WAY, down=WAY) as field:
            return _seen(field, Board.freeze, Board.thaw)

    return repeat(
        runs,
        {
            "vencejo": cut(),
            "vencejo, cut from the aircraft alone": cut(down=False),
            "vencejo, cut to the aircraft alone": cut(up=False),
            "vencejo, the station on board frozen": frozen,
            "vencejo, the router killed, another there": lambda: _with_router(lambda _: None),
            "vencejo, the router killed and started": lambda: _with_router(lambda field: field.routers[0].start()),
        },
    )


def far_takeover(runs: int, _seconds: float) -> Table:
    """Transfer control: on board, remotely after the holder's consent, and after the holder has vanished."""

    def once() -> Figures:
        with field_of(grounds=2, routers=1, up=WAY, down=WAY) as field:
            ana, luis = field.grounds
            for ground in field.grounds:
                ground.client.done("POST", "control/take")
            at = ana.at("plane1")
            until(lambda: order(ana, at))
            if luis.client.ask("POST", f"{at}/mode", {"mode": "FBWA"}).status != 423:
                raise NotMeasured("another one was let act without being asked for")
            agreed = time.monotonic()
            ana.client.done("POST", "control/release")
            until(lambda: order(luis, at))
            consent_s = time.monotonic() - agreed
            ana.client.done("POST", "control/take")
            vanished = time.monotonic()
            luis.program.process.kill()
            luis.program.process.wait()
            until(lambda: order(ana, at))
            return {"consent_s": consent_s, "vanished_s": time.monotonic() - vanished, "local_s": _local()}

    return repeat(runs, {"vencejo": once})


def _local() -> float:
    """Return how long an operator on board takes to gain control from a remote one, with a command carried out."""
    from vencejo import Station
    from vencejo.fleet import Aircraft, Fleet

    quiet: dict[str, Any] = {"record": False, "signing": False}
    with (
        tempfile.TemporaryDirectory() as folder,
        planes_on(1) as links,
        Station(operator="far", **quiet) as far,
        Fleet(far, org="acme", listen="tcp/127.0.0.1:0", key_file=Path(folder) / "key", history=False) as fleet,
        Station(*links, system_id=1, component_id=191, heartbeat=False, operator="board", **quiet) as board,
        open_way(int(fleet.endpoint.rpartition(":")[2]), up=WAY, down=WAY) as way,
        Aircraft(
            board, org="acme", name="plane1", dial=f"tcp/127.0.0.1:{way.port}", trust=[fleet.key], history=False
        ) as aircraft,
    ):
        far.wait_vehicle().set_mode("FBWA")
        until(lambda: aircraft.status.holder == "far")
        began = time.monotonic()
        board.operator.request()
        until(lambda: aircraft.status.holder == "board")
        board.wait_vehicle().set_mode("MANUAL")
        return time.monotonic() - began


def far_plan(runs: int, _seconds: float) -> Table:
    """Upload a plan of 650 items over 200 ms round trip, verified on board; compare with a link without delay."""

    def ours() -> Figures:
        with field_of(up=LONG_WAY, down=LONG_WAY) as field:
            ground = field.grounds[0]
            ground.client.done("POST", "control/take")
            at = ground.at("plane1")
            until(lambda: order(ground, at))
            return {"seconds": _sent(ground.client, at)}

    def direct() -> Figures:
        with (
            planes_on(1) as links,
            tempfile.TemporaryDirectory() as data,
            serving("--link", links[0], data=Path(data)) as served,
        ):
            client = served.client(name="Ana")
            until(lambda: any(each["mode"] for each in client.done("GET", "vehicles")))
            client.done("POST", "control/take")
            (vehicle,) = client.done("GET", "vehicles")
            return {"seconds": _sent(client, f"vehicles/{vehicle['system_id']}")}

    return repeat(runs, {"vencejo": ours, "vencejo, at a link without delay": direct})


def _sent(client: Any, at: str) -> float:
    # The first upload after a start waits until the simulated plane accepts missions.
    client.operation("PUT", f"{at}/plan/mission", plan_of(ITEMS, 80.0))
    began = time.monotonic()
    client.operation("PUT", f"{at}/plan/mission", plan_of(ITEMS, 90.0))
    return time.monotonic() - began


def far_plan_cut(runs: int, _seconds: float) -> Table:
    """Cut the path at times spread over that upload: either the old or the new plan is then known to be on board."""

    def once() -> Figures:
        with field_of(up=LONG_WAY, down=LONG_WAY) as field:
            ground, board = field.grounds[0], field.boards[0]
            client = ground.client
            client.done("POST", "control/take")
            at = ground.at("plane1")
            until(lambda: order(ground, at))
            takes_s = _sent(client, at)
            learnt_s: list[float] = []
            mixed = done = 0
            alt_m = 90.0
            for number in range(SETTINGS.cuts):
                # The previous cut has ended: commands work.
                until(lambda: ground.age_s(at) < STALE_S and order(ground, at))
                old_m, alt_m = alt_m, 100.0 + number
                operation = client.done("PUT", f"{at}/plan/mission", plan_of(ITEMS, alt_m))
                time.sleep(takes_s * number / SETTINGS.cuts)
                board.cut()
                time.sleep(3.0)
                healed = time.monotonic()
                board.heal()
                path = f"operations/{operation['id']}"
                until(lambda path=path: client.done("GET", path)["state"] != "running")  # type: ignore[misc]
                until(lambda: client.done("GET", f"{at}/plan/mission")["state"]["state"] == "verified")
                learnt_s.append(time.monotonic() - healed)
                ended = client.done("GET", path)
                is_done = ended["state"] == "done"
                if not is_done:
                    print(f"      {ended.get('problem')}", flush=True)
                heights = {item["params"][6] for item in client.done("GET", f"{at}/plan/mission")["plan"]["items"][1:]}
                done += is_done
                mixed += heights not in ({alt_m}, {old_m}) or (is_done and heights != {alt_m})
                (alt_m,) = heights if len(heights) == 1 else (alt_m,)
            learnt_s.sort()
            return {
                "learnt_s": learnt_s[len(learnt_s) // 2],
                "worst_learnt_s": learnt_s[-1],
                "worst_mixed": float(mixed),
                "cuts": float(SETTINGS.cuts),
                "done": float(done),
            }

    return repeat(runs, {"vencejo": once})


def far_gap(runs: int, _seconds: float) -> Table:
    """Cut a path of 256 kbit/s for minutes, and fill the gap in the history while commands are given."""

    def once() -> Figures:
        with field_of(up=UPLINK, down=UPLINK, on_board=("--uplink=256",)) as field:
            ground, board = field.grounds[0], field.boards[0]
            ground.client.done("POST", "control/take")
            at = ground.at("plane1")
            until(lambda: order(ground, at))
            on_board = board.data / "history/board/plane1"
            (archive,) = (board.data.parent / "ground0/history/ground").iterdir()
            board.cut()
            time.sleep(SETTINGS.cut_s)
            kept = numbered(on_board, "plane1")
            board.heal()
            healed = time.monotonic()
            until(lambda: ground.age_s(at) < STALE_S)
            missing = len(kept.keys() - numbered(archive, "plane1").keys())
            orders = Orders(first=1)
            with Watch(ground, at) as watch:
                while kept.keys() - numbered(archive, "plane1").keys():
                    if time.monotonic() - healed > 2 * SETTINGS.cut_s + 60:
                        break
                    orders_for(ground, [at], 5.0, orders)
            filled_s = time.monotonic() - healed
            archived = numbered(archive, "plane1")
            wrong = sum(archived.get(key) != data for key, data in kept.items())
            return {
                "filled_s": filled_s,
                "missing": float(missing),
                "worst_wrong": float(wrong),
                **orders.figures,
                "states_hz": watch.states_hz,
            }

    return repeat(runs, {"vencejo": once})
