"""Narrow, long and lossy uplinks: duration of commands and rate of states; and an aircraft's traffic in bytes."""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.far.field import Field, field_of, until
from bench.far.look import Manned, Orders, Watch, order, orders_for
from bench.far.rig import free_tcp_port
from bench.far.settings import SETTINGS
from bench.harness import NotMeasured, contestant, quantile, repeat, result_of, running, wait_line
from tests.fleet.proxy import Line, open_way

Figures = dict[str, float]
Table = dict[str, "Figures | str"]

#: 256 kbit/s each way, 100 ms round trip.
UPLINK = Line(delay_s=0.05, kbit_s=256)
#: 64 kbit/s, 600 ms round trip, one segment of twenty lost.
POOR = Line(delay_s=0.3, jitter_s=0.05, loss=0.05, kbit_s=64)
#: Planes that share an uplink, which their ten states a second each would fill.
PLANES = 8
#: Time until the adaptive rate has settled: ten good seconds per step.
SETTLES_S = 35.0
#: One of our states with the network's overhead (FLEET: 500 bytes of messages as encoded).
STATE_BYTES = 500


def _flown(field: Field, seconds: float, settles_s: float) -> Figures:
    ground = field.grounds[0]
    ground.client.done("POST", "control/take")
    places = [ground.at(name) for name in field.planes]
    for at in places:
        # The holder of control receives ten states a second, as far as the path allows.
        until(lambda at=at: order(ground, at))  # type: ignore[misc]
    way = field.boards[0].ways[0]
    began, before = time.monotonic(), way.up.on_the_line
    with Watch(ground, places[0]):
        settled = orders_for(ground, places, settles_s)
    with Watch(ground, places[0]) as watch:
        orders = orders_for(ground, places, seconds, Orders(first=settled.next))
    lasted_s = time.monotonic() - began
    return {
        **orders.figures,
        "states_hz": watch.states_hz,
        "up_kbit_s": (way.up.on_the_line - before) * 8 / 1000 / lasted_s,
    }


def _ours(line: Line, planes: int, *on_board: str) -> Callable[[], Figures]:
    def once() -> Figures:
        with field_of(planes=planes, up=line, down=line, on_board=on_board) as field:
            return _flown(field, SETTINGS.narrow_s, SETTLES_S)

    return once


def _bare(line: Line, planes: int) -> Callable[[], Figures]:
    """Measure bare Zenoh, whose single aircraft sends as much as all of ours."""

    def once() -> Figures:
        port = free_tcp_port()
        with (
            running(contestant("zenoh_peer", "orders", port=port, seconds=SETTINGS.narrow_s)) as ground,
            open_way(port, up=line, down=line) as way,
        ):
            wait_line(ground, "READY", 20)
            with running(contestant("zenoh_peer", "plane", port=way.port, hz=10 * planes, bytes=STATE_BYTES)):
                found = result_of(ground, SETTINGS.narrow_s + 90)
        took_ms = found["took_ms"]
        if not took_ms:
            raise NotMeasured("no order was answered")
        return {
            "command_median_ms": quantile(took_ms, 0.5),
            "command_p99_ms": quantile(took_ms, 0.99),
            "worst_command_ms": max(took_ms),
            "commands": float(len(took_ms)),
            "states_hz": found["states_hz"] / planes,
        }

    return once


def far_narrow(runs: int, _seconds: float) -> Table:
    """Measure commands on an uplink of 256 kbit/s that eight planes of ten states a second would fill."""
    return repeat(
        runs,
        {
            "vencejo": _ours(UPLINK, PLANES),
            "vencejo, told of its uplink": _ours(UPLINK, PLANES, f"--uplink={256 // PLANES}"),
            "Zenoh's own wheel": _bare(UPLINK, PLANES),
        },
    )


def far_poor(runs: int, _seconds: float) -> Table:
    """Measure commands over 64 kbit/s, 600 ms round trip and 5 % loss."""
    return repeat(
        runs,
        {
            "vencejo": _ours(POOR, 1),
            "vencejo, told of its uplink": _ours(POOR, 1, "--uplink=64"),
            "Zenoh's own wheel": _bare(POOR, 2),
        },
    )


def far_bytes(runs: int, seconds: float) -> Table:
    """Measure an aircraft's traffic: under control, in a list, and without listeners."""

    def once() -> Figures:
        with field_of(routers=1) as field:
            ground, way = field.grounds[0], field.boards[0].ways[0]

            def kbit_s() -> tuple[float, float]:
                before, began = (way.up, way.down), time.monotonic()
                time.sleep(seconds)
                lasted_s = time.monotonic() - began
                up, down = (
                    (now.on_the_line - then.on_the_line) * 8 / 1000 / lasted_s
                    for now, then in zip((way.up, way.down), before, strict=True)
                )
                return up, down

            listed, listed_down = kbit_s()
            ground.client.done("POST", "control/take")
            at = ground.at("plane1")
            order(ground, at)
            # An operator without a page has to keep its session alive.
            with Manned(ground):
                time.sleep(SETTLES_S)
                with Watch(ground, at) as watch:
                    held, held_down = kbit_s()
            ground.program.process.kill()
            ground.program.process.wait()
            # The lease expires, and the router notices.
            time.sleep(12.0)
            unheard, unheard_down = kbit_s()
            return {
                "held_kbit_s": held,
                "held_hz": watch.states_hz,
                "listed_kbit_s": listed,
                "unheard_kbit_s": unheard,
                "held_down_kbit_s": held_down,
                "listed_down_kbit_s": listed_down,
                "unheard_down_kbit_s": unheard_down,
            }

    return repeat(runs, {"vencejo": once})
