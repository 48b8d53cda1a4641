"""``python -m vencejo.sim``: simulated planes on real links. ``vencejo sim`` offers the same options."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence

from vencejo.sim.config import SimOptions
from vencejo.sim.server import Listening, run

__all__ = ["main"]


def _announce(listening: Listening) -> None:
    line = json.dumps({"listening": listening.link, "system_ids": list(listening.system_ids)})
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _announce_camera(system_id: int, stream: str, snapshot: str) -> None:
    line = json.dumps({"camera": stream, "snapshot": snapshot, "system_id": system_id})
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _stdin_ends() -> None:
    # Not through sys.stdin, whose lock Python takes at exit.
    while os.read(0, 4096):
        pass


def _home(text: str) -> tuple[float, float, float, float]:
    parts = [float(part) for part in text.split(",")]
    if len(parts) not in (3, 4):
        raise argparse.ArgumentTypeError(f"{text!r}: write LAT,LON,ALT_AMSL_M or LAT,LON,ALT_AMSL_M,HEADING_DEG")
    return parts[0], parts[1], parts[2], parts[3] if len(parts) == 4 else 270.0


def _parameter(text: str) -> tuple[str, float]:
    name, separator, value = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text!r}: write NAME=VALUE")
    return name, float(value)


def _parser(prog: str) -> argparse.ArgumentParser:
    default = SimOptions()
    parser = argparse.ArgumentParser(
        prog=prog,
        description="Simulated foam planes with an ArduPlane-like autopilot, speaking MAVLink 2.",
        epilog=f"Example: {prog} --wind 5 --wind-from 240 --speedup 5 --link tcp:127.0.0.1:5760. "
        "Each open link is printed on standard output as a line of JSON.",
    )
    add = parser.add_argument
    add(
        "--home",
        type=_home,
        default=(default.home_lat_deg, default.home_lon_deg, default.home_alt_amsl_m, default.heading_deg),
        metavar="LAT,LON,ALT[,HEADING]",
        help="start position (degrees, degrees, m above sea level) and heading (degrees true)",
    )
    add(
        "--geoid",
        type=float,
        default=default.geoid_m,
        metavar="M",
        help="height of the geoid above the ellipsoid there (default 51, as around Madrid)",
    )
    add("--wind", type=float, default=0.0, metavar="M_S", help="wind speed (default 0)")
    add("--wind-from", type=float, default=default.wind_from_deg, metavar="DEG", help="direction the wind comes from")
    add("--gust", type=float, default=0.0, metavar="M_S", help="scale of the turbulence (default 0, smooth air)")
    add("--seed", type=int, default=0, help="seed of gusts and sensor noise (default 0)")
    add("--speedup", type=float, default=1.0, help="simulated seconds per second (default 1; inf: as fast as possible)")
    add("--planes", type=int, default=1, help="number of planes (default 1), system ids from 1")
    add("--ports", choices=("shared", "consecutive"), default="shared", help="all planes on each link, or one a port")
    add(
        "--link",
        action="append",
        metavar="LINK",
        help="tcp:HOST:PORT (a server, default tcp:127.0.0.1:5760; port 0: a free one) or udpout:HOST:PORT; repeatable",
    )
    add("--launch", choices=("runway", "hand"), default="runway", help="kind of take-off (default runway)")
    add(
        "--by-hand",
        action="store_true",
        help="hold the plane by hand and turn it, repeatedly: level, wings, nose, full circle, on its back",
    )
    add(
        "--camera",
        nargs="?",
        const="127.0.0.1:8554",
        metavar="HOST:PORT",
        help="serve the nose camera as a network camera on this machine: Motion JPEG at /stream.mjpg, single pictures "
        "at /snapshot.jpg (default 127.0.0.1:8554; port 0: a free one); needs the extra vencejo[camera]",
    )
    add(
        "--camera-rate", type=float, default=default.camera_rate_hz, metavar="HZ", help="pictures a second (default 15)"
    )
    add(
        "--end-with-stdin",
        action="store_true",
        help="end when standard input ends, with the program that started this one",
    )
    add("--param", action="append", type=_parameter, metavar="NAME=VALUE", help="set a parameter; repeatable")
    return parser


def main(argv: Sequence[str] | None = None, *, prog: str = "python -m vencejo.sim") -> int:
    """Run the simulator until interrupted.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program name; those of the process when omitted.
    prog : str, optional
        Program name in the help.

    Returns
    -------
    int
        Exit status: 0 after an interrupt, 2 when the options or a link are wrong.
    """
    args = _parser(prog).parse_args(argv)
    try:
        options = SimOptions(
            home_lat_deg=args.home[0],
            home_lon_deg=args.home[1],
            home_alt_amsl_m=args.home[2],
            heading_deg=args.home[3],
            wind_m_s=args.wind,
            wind_from_deg=args.wind_from,
            gust_m_s=args.gust,
            seed=args.seed,
            speedup=args.speedup,
            planes=args.planes,
            ports=args.ports,
            geoid_m=args.geoid,
            links=tuple(args.link or SimOptions().links),
            launch=args.launch,
            params=dict(args.param or ()),
            by_hand=args.by_hand,
            camera=args.camera,
            camera_rate_hz=args.camera_rate,
        )
        run(
            options,
            on_listening=_announce,
            on_camera=_announce_camera,
            until=_stdin_ends if args.end_with_stdin else None,
        )
    except KeyError as error:
        sys.stderr.write(f"vencejo.sim: ArduPlane has no parameter {error}\n")
        return 2
    except (ValueError, OSError) as error:
        sys.stderr.write(f"vencejo.sim: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
