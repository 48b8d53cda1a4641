"""A router of Zenoh, and somebody of ROS 2 at it, by Zenoh's own Python wheel: `python -m tests.fleet.ros2_witness PORT TLS_PORT CERT KEY`.

The router speaks in the clear at the one port, and TLS at the other. It is asked by lines (ros2_lines.py).
"""

from __future__ import annotations

import json
import queue
import sys
import threading
from functools import partial
from typing import Any

import zenoh

from tests.fleet.ros2_lines import answer_all

PATIENCE_S = 60.0


def config(mode: str, **settings: object) -> zenoh.Config:
    """Settings of a session that looks for nobody else."""
    made = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False, **settings}.items():
        made.insert_json5(key.replace("__", "/"), json.dumps(value))
    return made


def sample(found: zenoh.Sample) -> dict[str, Any]:
    """A message as text."""
    attachment = found.attachment
    return {
        "key": str(found.key_expr),
        "payload": found.payload.to_bytes().hex(),
        "attachment": None if attachment is None else attachment.to_bytes().hex(),
    }


class Heard:
    """All that was said under some keys."""

    def __init__(self) -> None:
        self._samples: dict[str, list[dict[str, Any]]] = {}
        self._more = threading.Condition()

    def put(self, found: zenoh.Sample) -> None:
        """One more."""
        with self._more:
            self._samples.setdefault(str(found.key_expr), []).append(sample(found))
            self._more.notify_all()

    def of(self, keys: list[str], count: int) -> list[list[dict[str, Any]]]:
        """Waits for so many of each key, and gives what was heard of each."""
        with self._more:
            wanted = lambda: all(len(self._samples.get(key, ())) >= count for key in keys)  # noqa: E731
            assert self._more.wait_for(wanted, PATIENCE_S), sorted(set(keys) - self._samples.keys())
            return [self._samples[key][:] for key in keys]

    def keys(self) -> list[str]:
        """All of them."""
        with self._more:
            return sorted(self._samples)


HEARD = Heard()


def answer(session: zenoh.Session, kept: list[object], do: str, **of: Any) -> Any:
    """Does one thing."""
    if do == "listen":
        kept.append(session.declare_subscriber(of["key"], HEARD.put))
        return None
    if do == "heard":
        return HEARD.of(of["keys"], of["count"])
    if do == "keys":
        return HEARD.keys()
    if do == "tokens":
        replies = session.liveliness().get("@ros2_lv/**", timeout=3.0)
        return sorted({str(reply.ok.key_expr) for reply in replies if reply.ok is not None})
    if do == "declare":
        kept.append(session.liveliness().declare_token(of["token"]))
        return None
    if do == "hear":
        heard: queue.Queue[zenoh.Sample] = queue.Queue()
        subscriber = session.declare_subscriber(of["key"], heard.put)
        found = [sample(heard.get(timeout=PATIENCE_S)) for _ in range(of["count"])]
        subscriber.undeclare()  # type: ignore[no-untyped-call]
        return found
    assert do == "call"
    replies = session.get(
        of["key"],
        payload=bytes.fromhex(of["payload"]),
        attachment=bytes.fromhex(of["attachment"]),
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=PATIENCE_S,
    )
    return [sample(reply.ok) for reply in replies if reply.ok is not None]


def main() -> None:
    """Answers until standard input ends."""
    port, tls_port, certificate, key = sys.argv[1:]
    plain = f"tcp/127.0.0.1:{port}"
    tls = {"listen_certificate": certificate, "listen_private_key": key}
    router = config("router", listen__endpoints=[plain, f"tls/127.0.0.1:{tls_port}"], transport__link__tls=tls)
    kept: list[object] = []
    with zenoh.open(router), zenoh.open(config("client", connect__endpoints=[plain])) as session:
        answer_all(partial(answer, session, kept))


if __name__ == "__main__":
    main()
