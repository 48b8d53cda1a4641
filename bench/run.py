"""Runs every benchmark for all contestants and writes bench/RESULTS.md.

``python bench/run.py [--runs N] [--only decode,follow,…] [--seconds S]``; `make bench` does that with everything built.
Omitted sections keep their last figures.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shlex
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench import prepare, report
from bench.far import faults, fifty, many, narrow
from bench.far.settings import SETTINGS
from bench.harness import (
    BYTECODE_KEPT,
    BYTECODE_UNKEPT,
    EAGER_FRAMES,
    FLEET_FRAMES,
    FRAMES,
    LOAD,
    MOST_LOAD,
    OUT,
    ROOT,
    NotMeasured,
    contestant,
    free_port,
    load,
    play,
    quantile,
    repeat,
    result_of,
    running,
    usage_over,
    wait_line,
)

Figures = dict[str, float]
Table = dict[str, "Figures | str"]

PLANE_RATE = 1000.0
#: Item 0 is home, as on a real ArduPlane.
MISSION_ITEMS = 650
EXAMPLES = ROOT / "target/release/examples"
WARM_UP_S = 2.0


def output_of(command: list[str], timeout_s: float = 120) -> dict[str, Any]:
    """Run a program to its end and return its line of JSON."""
    with running(command) as process:
        return result_of(process, timeout_s)


def built(path: Path) -> str:
    """Return a program's path, or raise when it was not built."""
    if not path.exists():
        raise NotMeasured(f"{path.relative_to(ROOT)} is not built")
    return str(path)


# --- decode -------------------------------------------------------------------------------------


def decode(runs: int, _seconds: float) -> Table:
    """Measure how many recorded messages each contestant decodes per second on one core."""

    def ours() -> Figures:
        found = output_of([built(EXAMPLES / "decode"), str(prepare.CAPTURE)])
        return {"messages_per_s": found["decode_hz"], "through_socket_per_s": found["socket_to_listener_hz"]}

    def pymavlink() -> Figures:
        found = output_of(contestant("pymavlink_peer", "decode", file=prepare.CAPTURE, laps=3))
        return {"messages_per_s": found["messages"] / found["seconds"]}

    return repeat(runs, {"vencejo": ours, "pymavlink": pymavlink})


# --- rehearsal ----------------------------------------------------------------------------------


def rehearse(runs: int, _seconds: float) -> Table:
    """Measure rehearsals of a mission of half an hour; no other tool has any."""

    def ours() -> Figures:
        return {name: float(value) for name, value in output_of([built(EXAMPLES / "rehearse")], 300).items()}

    return repeat(runs, {"vencejo": ours})


# --- following ----------------------------------------------------------------------------------


def follow_once(name: str, seconds: float, rate: float, systems: int, task: str = "follow") -> Figures:
    """Let one contestant follow the load; measure latency inside it and resources from outside."""
    port = free_port()
    command = contestant(name, task, port=port, seconds=seconds, warm_up=WARM_UP_S, systems=systems)
    with running(command) as process:
        wait_line(process, "READY", 20)
        with running(play(port, rate=rate, seconds=seconds + 3 * WARM_UP_S, systems=systems)):
            time.sleep(1.5 * WARM_UP_S)
            usage = usage_over(process.pid, seconds - WARM_UP_S)
            found = result_of(process, seconds + 20)
    figures = {
        "cpu_percent": usage.cpu * 100,
        "rss_mb": usage.rss_mb,
        "messages_per_s": found["messages"] / seconds,
    }
    if "lost" in found:
        figures["lost"] = float(found["lost"] + found["dropped"])
    if ages_us := found.get("ages_us"):
        figures |= {
            "median_us": quantile(ages_us, 0.5),
            "p99_us": quantile(ages_us, 0.99),
            "worst_ms": max(ages_us) / 1000,
        }
    return figures


def follow(runs: int, seconds: float) -> Table:
    """Follow one plane of 1,000 messages a second, for at least a minute in total, since the worst latency counts."""
    seconds = max(seconds, 60 / runs)
    return repeat(
        runs,
        {
            label: lambda name=name: follow_once(name, seconds, PLANE_RATE, 1)  # type: ignore[misc]
            for label, name in PEERS.items()
        },
    )


def snapshots(runs: int, seconds: float) -> Table:
    """Follow the same plane by reading its newest values ten times a second."""
    return repeat(
        runs,
        {
            label: lambda name=name: follow_once(name, seconds, PLANE_RATE, 1, "snapshots")  # type: ignore[misc]
            for label, name in PEERS.items()
        },
    )


def vehicles(runs: int, seconds: float) -> Table:
    """Follow 50 vehicles of 200 messages a second each on one port."""
    return repeat(
        runs,
        {
            label: lambda name=name: follow_once(name, seconds, 50 * 200.0, 50)  # type: ignore[misc]
            for label, name in PEERS.items()
        },
    )


def first_position(runs: int, _seconds: float) -> Table:
    """Measure the time from process start to the first position, with and without existing bytecode."""

    def seconds_of(name: str, environment: dict[str, str] = BYTECODE_KEPT) -> float:
        port = free_port()
        with running(play(port, rate=PLANE_RATE, seconds=20, frames=EAGER_FRAMES)):
            time.sleep(0.2)
            began = time.monotonic()
            with running(contestant(name, "first_position", port=port), environment) as process:
                result_of(process, 15)
                return time.monotonic() - began

    def once(name: str) -> Figures:
        seconds_of(name)  # creates the bytecode
        return {"seconds": seconds_of(name), "unkept_seconds": seconds_of(name, BYTECODE_UNKEPT)}

    return repeat(
        runs,
        {label: lambda name=name: once(name) for label, name in PEERS.items()},  # type: ignore[misc]
    )


# --- forwarding ---------------------------------------------------------------------------------


def forwarders() -> dict[str, Callable[[int, list[int]], list[str]]]:
    """Return each forwarder's command line, for a port to listen on and the ports to send to."""

    def ours(port: int, outs: list[int]) -> list[str]:
        links = [f"udpin:127.0.0.1:{port}", *(f"udpout:127.0.0.1:{out}" for out in outs)]
        return [built(EXAMPLES / "forward"), *links]

    def bare(port: int, outs: list[int]) -> list[str]:
        program = OUT / "bare"
        source = ROOT / "bench/forwarders/bare.c"
        subprocess.run(["cc", "-O2", "-o", str(program), str(source)], check=True)
        return [str(program), str(port), *map(str, outs)]

    def mavproxy(port: int, outs: list[int]) -> list[str]:
        program = Path(sys.executable).parent / "mavproxy.py"
        if not program.exists():
            raise NotMeasured("MAVProxy is not installed")
        return [
            sys.executable, str(program), f"--master=udpin:127.0.0.1:{port}", "--non-interactive",
            "--daemon", "--default-modules=link", f"--state-basedir={OUT}",
            *(f"--out=udpout:127.0.0.1:{out}" for out in outs),
        ]  # fmt: skip

    return {"vencejo": ours, "bare kernel calls (C)": bare, "MAVProxy": mavproxy}


def forward_command(port: int, outs: list[int], rate: float, seconds: float) -> list[str]:
    """Return the command that plays through a forwarder and listens at its outputs."""
    return [
        str(LOAD), "forward", "--frames", str(FRAMES), "--to", f"127.0.0.1:{port}",
        "--rate", str(rate), "--seconds", str(seconds), "--sinks", ",".join(map(str, outs)),
    ]  # fmt: skip


def forward_load(port: int, outs: list[int], rate: float, seconds: float) -> dict[str, Any]:
    """Play through a running forwarder; return received frames and latencies."""
    # A router discards a frame that it saw less than a second ago as a loop, and every play begins with the same
    # frames.
    time.sleep(1.2)
    return output_of(forward_command(port, outs, rate, seconds))


def forward(runs: int, seconds: float) -> Table:
    """Forward one plane of 1,000 messages a second to four listeners; then find the highest rate."""

    def once(make: Callable[[int, list[int]], list[str]]) -> Figures:
        port, *outs = (free_port() for _ in range(5))
        with running(make(port, outs)) as process:
            time.sleep(WARM_UP_S)
            forward_load(port, outs, PLANE_RATE, 1.0)
            time.sleep(1.2)  # as in `forward_load`
            with running(forward_command(port, outs, PLANE_RATE, seconds)) as player:
                usage = usage_over(process.pid, seconds - 1)
                found = result_of(player, seconds + 10)
            if found["median_us"] is None:
                raise NotMeasured("nothing came out")
            expected = 4 * found["sent"]
            return {
                "cpu_percent": usage.cpu * 100,
                "rss_mb": usage.rss_mb,
                "median_us": found["median_us"],
                "p99_us": found["p99_us"],
                "lost_percent": 100 * (1 - sum(found["received"]) / expected),
                "most_per_s": most_without_loss(port, outs),
            }

    return repeat(
        runs,
        {label: lambda make=make: once(make) for label, make in forwarders().items()},  # type: ignore[misc]
    )


def most_without_loss(port: int, outs: list[int]) -> float:
    """Return the highest rate, in steps of × 1.15, at which one second is forwarded completely to all four outputs.

    A rate with losses is tried once more: a single late wake-up of a busy machine is not the forwarder's limit.
    """
    rate, best = 2000.0, 0.0
    while rate < 200_000:
        for _ in range(2):
            found = forward_load(port, outs, rate, 1.0)
            if sum(found["received"]) >= 4 * found["sent"]:
                # The rate actually sent, since the load generator itself may be the bottleneck.
                best = max(best, float(found["sent"]))
                break
        else:
            return best
        rate *= 1.5 if rate < 15_000 else 1.15
    return best


# --- transfers ----------------------------------------------------------------------------------


def with_plane(task: Callable[[str], Figures]) -> Figures:
    """Run a task with a fresh plane: the simulated one, or the program given with ``--plane``."""
    command = PLANE.command or [sys.executable, "-m", "vencejo.sim", "--link", "tcp:127.0.0.1:0"]
    with running(command) as plane:
        port = str(PLANE.port) if PLANE.command else result_of(plane, 20)["listening"].rpartition(":")[2]
        return task(port)


def mission(runs: int, _seconds: float) -> Table:
    """Upload a long mission and read it back, item by item where the library has nothing better."""

    def once(name: str, scheme: str) -> Figures:
        def task(port: str) -> Figures:
            command = contestant(
                name, "mission", link=f"{scheme}127.0.0.1:{port}", items=MISSION_ITEMS, verify="yes", settle=SETTLE_S
            )
            return {"seconds": float(output_of(command, 180)["seconds"])}

        return with_plane(task)

    return repeat(runs, {label: lambda a=a: once(*a) for label, a in TCP_PEERS.items()})  # type: ignore[misc]


def params(runs: int, _seconds: float) -> Table:
    """Read every parameter of the simulated plane."""

    def once(name: str, scheme: str) -> Figures:
        def task(port: str) -> Figures:
            found = output_of(contestant(name, "params", link=f"{scheme}127.0.0.1:{port}", settle=SETTLE_S), 120)
            return {"seconds": float(found["seconds"]), "count": float(found["count"])}

        return with_plane(task)

    return repeat(runs, {label: lambda a=a: once(*a) for label, a in TCP_PEERS.items()})  # type: ignore[misc]


@dataclass
class OtherPlane:
    """A plane to measure: its command line (empty for the simulated one), its TCP port and its name."""

    command: list[str]
    port: int = 5760
    name: str = "another plane"


PLANE = OtherPlane([])
#: ArduPlane, hence also the simulated one, refuses missions in its first seconds; its simulator boots when a station
#: connects.
SETTLE_S = 8
PEERS = {"vencejo": "vencejo_peer", "pymavlink": "pymavlink_peer", "mavsdk": "mavsdk_peer"}
TCP_PEERS = {
    "vencejo": ("vencejo_peer", "tcp:"),
    "pymavlink": ("pymavlink_peer", "tcp:"),
    "mavsdk": ("mavsdk_peer", "tcpout://"),
}
#: Sections that use the recorded stream.
PLAYED = frozenset({"decode", "follow", "snapshots", "vehicles", "first_position", "forward"})
#: Sections that also measure another plane; those figures have a separate table.
TRANSFERS = frozenset({"mission", "params"})
#: Sections that are run once, since a run takes minutes and has many events.
ONCE = frozenset(
    {
        "far_narrow",
        "far_poor",
        "far_bytes",
        "far_cut",
        "far_fifty",
        "far_takeover",
        "far_plan",
        "far_plan_cut",
        "far_gap",
    }
)
SECTIONS: dict[str, Callable[[int, float], Table]] = {
    "decode": decode,
    "follow": follow,
    "snapshots": snapshots,
    "vehicles": vehicles,
    "first_position": first_position,
    "forward": forward,
    "rehearse": rehearse,
    "mission": mission,
    "params": params,
    "far": many.far,
    "far_age": many.far_age,
    "far_restart": many.far_restart,
    "far_narrow": narrow.far_narrow,
    "far_poor": narrow.far_poor,
    "far_bytes": narrow.far_bytes,
    "far_cut": faults.far_cut,
    "far_fifty": fifty.far_fifty,
    "far_takeover": faults.far_takeover,
    "far_plan": faults.far_plan,
    "far_plan_cut": faults.far_plan_cut,
    "far_gap": faults.far_gap,
}


def machine() -> dict[str, str]:
    """Return the relevant properties of the machine, without identifying it."""
    versions = {}
    for package in ("pymavlink", "mavsdk", "MAVProxy"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    os_name = "Linux"
    release = Path("/etc/os-release")
    if release.exists():
        for line in release.read_text().splitlines():
            if line.startswith("PRETTY_NAME="):
                os_name = line.partition("=")[2].strip('"')
    return {
        "cores": str(os.cpu_count()),
        "system": os_name,
        "architecture": platform.machine(),
        "python": platform.python_version(),
        **versions,
    }


def main() -> int:
    """Run the requested sections and write the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5, help="runs of each contestant (median is kept)")
    parser.add_argument("--seconds", type=float, default=8.0, help="length of a run that follows or forwards")
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, with commas between")
    parser.add_argument(
        "--most-load", type=float, default=MOST_LOAD, help="load of each core beyond which nothing is recorded"
    )
    parser.add_argument(
        "--plane", default="", help="command line of another plane for the transfers, such as ArduPilot's"
    )
    parser.add_argument("--plane-port", type=int, default=PLANE.port, help="TCP port that it listens on")
    parser.add_argument("--plane-name", default=PLANE.name, help="what it is, for the report: ArduPlane 4.6.3")
    parser.add_argument("--narrow-s", type=float, default=SETTINGS.narrow_s, help="seconds of orders on a narrow way")
    parser.add_argument("--cuts", type=int, default=SETTINGS.cuts, help="moments of a plan's transfer that are cut")
    parser.add_argument("--cut-s", type=float, default=SETTINGS.cut_s, help="seconds of the cut whose gap is filled")
    options = parser.parse_args()
    SETTINGS.narrow_s, SETTINGS.cuts, SETTINGS.cut_s = options.narrow_s, options.cuts, options.cut_s
    PLANE.command[:], PLANE.port, PLANE.name = shlex.split(options.plane), options.plane_port, options.plane_name
    OUT.mkdir(parents=True, exist_ok=True)
    if (before := load()) > options.most_load:
        sys.exit(
            f"bench: the load is {before:.2f} a core, beyond {options.most_load}: end what else runs, or say --most-load"
        )
    names = options.only.split(",")
    if not PLAYED.isdisjoint(names):
        if not LOAD.exists():
            sys.exit("bench: the load generator is not built: cargo build --release --locked -p vencejo-bench-load")
        prepare.prepare(FRAMES)
        prepare.prepare(EAGER_FRAMES, heartbeat_every=prepare.HEARTBEAT_EVERY)
        prepare.prepare(FLEET_FRAMES, fleet=True)
    store = OUT / "results.json"
    results: dict[str, Any] = json.loads(store.read_text()) if store.exists() else {}
    for name in names:
        if name not in SECTIONS:
            sys.exit(f"bench: no section {name!r}; there are {', '.join(SECTIONS)}")
        print(f"{name}:", flush=True)
        runs = 1 if name in ONCE else options.runs
        is_other = bool(PLANE.command) and name in TRANSFERS
        results[f"{name}_other" if is_other else name] = {
            "runs": runs,
            "load": round(before, 2),
            "plane": PLANE.name if is_other else "the simulated plane",
            "date": datetime.now(timezone.utc).date().isoformat(),
            "figures": SECTIONS[name](runs, options.seconds),
        }
        results["machine"] = machine()
        store.write_text(json.dumps(results, indent=1))
        page = ROOT / "bench/RESULTS.md"
        before_this = page.read_text(encoding="utf-8") if page.exists() else ""
        text = "\n".join([report.render(results, before_this), *report.other_parts(before_this)])
        page.write_text(text, encoding="utf-8")
    print("wrote bench/RESULTS.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
