"""The benchmark tasks of remote aircraft with Zenoh's own wheel alone.

Usage: ``zenoh_peer.py TASK NAME=VALUE…``; ends with one line of JSON. See bench/README.md.
"""

from __future__ import annotations

import json
import math
import struct
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh


def opened(**settings: Any) -> zenoh.Session:
    """Open a session without scouting."""
    config = zenoh.Config()
    for key, value in {"scouting/multicast/enabled": False, **settings}.items():
        config.insert_json5(key.replace("__", "/"), json.dumps(value))
    return zenoh.open(config)


def router(port: str) -> zenoh.Session:
    """Open a router for any number of sessions."""
    return opened(
        mode="router",
        listen__endpoints=[f"tcp/127.0.0.1:{port}"],
        transport__unicast__max_sessions=10_000,
        transport__unicast__accept_pending=10_000,
    )


def far(port: str, org: str, aircraft: str, seconds: str) -> dict[str, Any]:
    """Run the router, with callbacks for every state of all aircraft; record the age of each."""
    ages_us: list[int] = []
    seen: set[str] = set()
    counts_from = math.inf

    def on_state(sample: zenoh.Sample) -> None:
        now_us = time.time_ns() // 1000
        if now_us < counts_from:
            seen.add(str(sample.key_expr))
        elif sample.attachment is not None:
            ages_us.append(now_us - struct.unpack("<QQ", sample.attachment.to_bytes())[1])

    with router(port) as session:
        session.declare_subscriber(f"vencejo/1/{org}/*/state", on_state)
        print("READY", flush=True)
        while len(seen) < int(aircraft):
            time.sleep(0.1)
        time.sleep(2.0)
        print("ALL", flush=True)
        counts_from = time.time_ns() // 1000
        time.sleep(float(seconds))
        counted = list(ages_us)
    return {"messages": len(counted), "ages_us": counted}


def serve(port: str, others: str = "") -> dict[str, Any]:
    """Run a router like `zenohd`, linked with those at other ports, until standard input ends."""
    with opened(
        mode="router",
        listen__endpoints=[f"tcp/127.0.0.1:{port}"],
        connect__endpoints=[f"tcp/127.0.0.1:{other}" for other in others.split(",") if other],
        connect__timeout_ms=-1,
        connect__exit_on_failure=False,
        connect__retry={"period_init_ms": 200, "period_max_ms": 1000},
        scouting__delay=0,
    ):
        print("READY", flush=True)
        sys.stdin.read()
    return {}


def plane(port: str, hz: str, bytes: str) -> dict[str, Any]:
    """Publish a state at a rate, and answer orders, until standard input ends."""
    with opened(mode="client", connect__endpoints=[f"tcp/127.0.0.1:{port}"], connect__timeout_ms=10_000) as session:
        _orders = session.declare_queryable("bare/order", lambda query: query.reply("bare/order", b"done"))
        is_over = threading.Event()

        def wait_for_end() -> None:
            sys.stdin.read()
            is_over.set()

        threading.Thread(target=wait_for_end, daemon=True).start()
        while not is_over.wait(1 / float(hz)):
            session.put("bare/state", b"\0" * int(bytes), congestion_control=zenoh.CongestionControl.DROP)
    return {}


def orders(port: str, seconds: str) -> dict[str, Any]:
    """Run the router, and give an order every quarter of a second once states arrive; return times and counts."""
    heard: list[float] = []
    took_ms: list[float] = []
    with router(port) as session:
        session.declare_subscriber("bare/state", lambda _sample: heard.append(time.monotonic()))
        print("READY", flush=True)
        while len(heard) < 20:
            time.sleep(0.1)
        began = time.monotonic()
        while time.monotonic() < began + float(seconds):
            asked = time.monotonic()
            replies = session.get("bare/order", priority=zenoh.Priority.REAL_TIME, express=True, timeout=20.0)
            if any(reply.ok for reply in replies):
                took_ms.append((time.monotonic() - asked) * 1e3)
            time.sleep(0.25)
        lasted_s = time.monotonic() - began
    return {"took_ms": took_ms, "states_hz": sum(at >= began for at in heard) / lasted_s}


TASKS: dict[str, Callable[..., dict[str, Any]]] = {"far": far, "serve": serve, "plane": plane, "orders": orders}

if __name__ == "__main__":
    result = TASKS[sys.argv[1]](**dict(option.split("=", 1) for option in sys.argv[2:]))
    print(json.dumps(result), flush=True)
