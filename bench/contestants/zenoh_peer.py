"""The tasks of the benchmarks of aircraft far away with Zenoh's own wheel and nothing else.

Usage: ``zenoh_peer.py TASK NAME=VALUE…``; ends with one line of JSON. See bench/README.md.
"""

from __future__ import annotations

import json
import math
import struct
import sys
import time
from collections.abc import Callable
from typing import Any

import zenoh


def opened(**settings: Any) -> zenoh.Session:
    """Open a session that looks for nobody."""
    config = zenoh.Config()
    for key, value in {"scouting/multicast/enabled": False, **settings}.items():
        config.insert_json5(key.replace("__", "/"), json.dumps(value))
    return zenoh.open(config)


def router(port: str) -> zenoh.Session:
    """Open a router that takes as many sessions as come."""
    return opened(
        mode="router",
        listen__endpoints=[f"tcp/127.0.0.1:{port}"],
        transport__unicast__max_sessions=10_000,
        transport__unicast__accept_pending=10_000,
    )


def far(port: str, org: str, aircraft: str, seconds: str) -> dict[str, Any]:
    """Be the router, and have every state of all aircraft called back; note how old it was."""
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


TASKS: dict[str, Callable[..., dict[str, Any]]] = {"far": far}

if __name__ == "__main__":
    result = TASKS[sys.argv[1]](**dict(option.split("=", 1) for option in sys.argv[2:]))
    print(json.dumps(result), flush=True)
