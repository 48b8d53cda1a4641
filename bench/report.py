"""Writes the measured figures as the tables of bench/RESULTS.md, with their ratio to ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Column:
    """One figure of a table: its key in the results, its title, and the format of its values."""

    key: str
    title: str
    write: Callable[[float], str]


@dataclass(frozen=True)
class Section:
    """One table: its title, its target, and its columns; the first column is the one compared."""

    title: str
    aim: str
    columns: tuple[Column, ...]
    more_is_better: bool = False
    has_plane: bool = False
    #: Section of bench/run.py that measured it, if its name differs.
    measured_by: str = ""


def _big(value: float) -> str:
    return f"{value / 1e6:.2f} M" if value >= 1e6 else f"{value:,.0f}"


def _tenths(value: float) -> str:
    return f"{value:.1f}"


def _us(value: float) -> str:
    return f"{value:.0f} µs"


def _percent(value: float) -> str:
    return f"{value:.1f} %"


def _mb(value: float) -> str:
    return f"{value:.0f} MB"


def _s(value: float) -> str:
    return f"{value:.3f} s"


def _ms(value: float) -> str:
    return f"{value:.1f} ms"


_LATENCY = (
    Column("median_us", "median", _us),
    Column("p99_us", "99 %", _us),
    Column("worst_ms", "worst", _ms),
)
_COST = (Column("cpu_percent", "CPU of a core", _percent), Column("rss_mb", "memory", _mb))
_HANDED = Column("messages_per_s", "handed to Python /s", _big)

_MISSION = (Column("seconds", "time", _s),)
_PARAMS = (*_MISSION, Column("count", "parameters", _big))
_ORDERS = (
    Column("command_p99_ms", "order: 99 %", _ms),
    Column("command_median_ms", "median", _ms),
    Column("worst_command_ms", "worst", _ms),
    Column("commands", "orders done", _big),
    Column("worst_failed", "not done", _big),
)

SECTIONS: dict[str, Section] = {
    "decode": Section(
        "Decode a recorded stream (20,511 messages), one core",
        "≥ 5 M messages/s through the whole receive path",
        (
            Column("messages_per_s", "bytes → messages /s", _big),
            Column("through_socket_per_s", "TCP socket → router → listener /s", _big),
        ),
        more_is_better=True,
    ),
    "follow": Section(
        "Follow one plane, 1,000 messages/s: frame at a UDP socket → Python callback, and what it costs",
        "≤ 32 / 90 µs, worst in a minute ≤ 5 ms; ≤ 2 % of a core, ≤ 25 MB",
        (*_LATENCY, *_COST, _HANDED),
    ),
    "snapshots": Section(
        "Follow the same plane by its newest values, ten times a second",
        "≤ 1 % of a core, ≤ 25 MB",
        (*_COST, Column("messages_per_s", "looks /s", _big)),
    ),
    "vehicles": Section(
        "50 vehicles × 200 messages/s on one port",
        "no loss, ≤ 8 % of a core",
        (*_COST, *_LATENCY, _HANDED, Column("lost", "lost", _big)),
    ),
    "first_position": Section(
        "Process start → first position",
        "≤ 0.08 s",
        (Column("seconds", "bytecode kept", _s), Column("unkept_seconds", "not kept", _s)),
    ),
    "forward": Section(
        "Forward one UDP link to four, 1,000 messages/s; the most without loss",
        "≤ 2.3 %, ≤ 39 µs, ≥ 60,000 messages/s",
        (
            Column("median_us", "median", _us),
            Column("p99_us", "99 %", _us),
            Column("cpu_percent", "CPU of a core", _percent),
            Column("rss_mb", "memory", _mb),
            Column("lost_percent", "lost", _percent),
            Column("most_per_s", "most without loss /s", _big),
        ),
    ),
    "rehearse": Section(
        "Rehearse a mission of half an hour",
        "≤ 50 ms on one core; 1,000 flights ≤ 20 s on all",
        (
            Column("once_ms", "one flight, one core", _ms),
            Column("checked_ms", "with 24 returns, go-arounds and findings", _ms),
            Column("one_what_if_ms", "what if, at its middle", _ms),
            Column("what_ifs_ms", "all seven what-ifs at each minute", _ms),
            Column("many_s", "1,000 flights, all cores", _s),
        ),
    ),
    "mission": Section(
        "650-item mission sent and read back, no delay",
        "≤ 0.5 s",
        _MISSION,
        has_plane=True,
    ),
    "params": Section(
        "All parameters, no delay",
        "≤ 0.1 s for 1,399",
        _PARAMS,
        has_plane=True,
    ),
    "mission_other": Section(
        "The same mission to a real autopilot",
        "≤ 2 s; an autopilot reads its links 50 times a second, which the simulated plane does for files alone",
        _MISSION,
        has_plane=True,
    ),
    "params_other": Section(
        "All parameters of a real autopilot",
        "≤ 1 s for 1,400",
        _PARAMS,
        has_plane=True,
    ),
    "far": Section(
        "1,000 aircraft far away, 10 states/s each, at a ground station that is the router",
        "≤ 30 % of a core, ≤ 250 MB; a command ≤ 150 ms at 99 %",
        (
            *_COST,
            Column("list_cpu_percent", "CPU with a list looked at", _percent),
            Column("list_kb_s", "list, kB/s", _big),
            Column("command_median_ms", "command: median", _ms),
            Column("command_p99_ms", "99 %", _ms),
        ),
    ),
    "far_spread": Section(
        "The same with 20 stations more that hear all through it",
        "router ≤ 40 % of a core, ≤ 150 MB, none lost",
        (
            Column("spread_cpu_percent", "CPU of a core", _percent),
            Column("spread_rss_mb", "memory", _mb),
            Column("states_per_s", "states handed on /s", _big),
            Column("worst_lost", "lost", _big),
            *_LATENCY,
        ),
        measured_by="far",
    ),
    "far_age": Section(
        "1,000 aircraft far away, 10 states/s each: a state put → Python callback",
        "≤ 2 ms, 99 % ≤ 20 ms",
        (*_LATENCY, *_COST, _HANDED),
    ),
    "far_restart": Section(
        "A router killed and started again, with 1,000 aircraft and a ground station on it",
        "all heard again within 6 s; none shown as lost whose silence was shorter than 5 s",
        (
            Column("seconds", "longest silence of an aircraft", _s),
            Column("started_s", "of it until the router is there", _s),
            Column("shown_s", "longest silence in the station's list", _s),
            Column("worst_shown_lost", "aircraft shown as lost", _big),
        ),
    ),
    "far_narrow": Section(
        "Orders on an uplink of 256 kbit/s that telemetry would fill (eight planes, ten states/s each), 100 ms there and back",
        "an order ≤ round trip + 250 ms at 99 %; ≥ 2 states/s",
        (*_ORDERS, Column("states_hz", "states/s of a plane", _tenths), Column("up_kbit_s", "uplink, kbit/s", _big)),
    ),
    "far_poor": Section(
        "Orders over 64 kbit/s, 600 ms there and back, 5 % of the segments lost",
        "an order ≤ 3 s at 99 %; ≥ 0.5 states/s",
        (*_ORDERS, Column("states_hz", "states/s", _tenths), Column("up_kbit_s", "uplink, kbit/s", _big)),
    ),
    "far_bytes": Section(
        "What one aircraft sends, with the headers of TCP and IP (40 bytes a segment)",
        "≤ 20 kbit/s at 10 states/s, ≤ 2.5 at 1 state/s, ≤ 0.7 heard by nobody",
        (
            Column("held_kbit_s", "in control, kbit/s", _tenths),
            Column("held_hz", "states/s of that", _tenths),
            Column("listed_kbit_s", "in a list, kbit/s", _tenths),
            Column("unheard_kbit_s", "heard by nobody, kbit/s", _tenths),
            Column("held_down_kbit_s", "to it: in control", _tenths),
            Column("listed_down_kbit_s", "in a list", _tenths),
            Column("unheard_down_kbit_s", "heard by nobody", _tenths),
        ),
    ),
    "far_cut": Section(
        "What goes wrong in the field, 100 ms there and back: from its begin to grey, from its end to heard and commanded again; worst of the runs",
        "grey ≤ 3 s, commanded ≤ 5 s; nobody shown as lost because of a router",
        (
            Column("worst_commanding_s", "an order is done again", _s),
            Column("worst_back_s", "heard again", _s),
            Column("worst_grey_s", "shown grey", _s),
            Column("worst_oldest_s", "oldest of ten planes", _s),
            Column("worst_lost", "planes shown as lost", _big),
        ),
    ),
    "far_fifty": Section(
        "Fifty planes in the air: one simulator, three stations on board, two routers and two ground stations, 100 ms there and back",
        "all fly, none shown as lost when a router is killed",
        (
            Column("sent_s", "a plan sent to each and verified", _s),
            Column("started_s", "each armed and started", _s),
            Column("flying", "in AUTO at the end", _big),
            Column("age_s", "what is shown is so old", _s),
            Column("age_p99_s", "99 %", _s),
            Column("worst_age_s", "worst", _s),
            Column("ground_percent", "a ground station, % of a core", _tenths),
            Column("board_percent", "a station on board, %", _tenths),
            Column("worst_back_s", "all heard again without the router", _s),
            Column("worst_lost", "shown as lost meanwhile", _big),
        ),
    ),
    "far_takeover": Section(
        "Control from one to another, 100 ms there and back, until an order of the new one is done",
        "on board ≤ 1 s; from far away ≤ 1 s after yes; ≤ lease (10 s) + 1 s after the holder vanished",
        (
            Column("local_s", "on board", _s),
            Column("consent_s", "from far away, after yes", _s),
            Column("vanished_s", "after the holder vanished", _s),
        ),
    ),
    "far_plan": Section(
        "650-item plan sent, checked and read back, 200 ms there and back",
        "≤ at a link + 2 round trips",
        (Column("seconds", "time", _s),),
    ),
    "far_plan_cut": Section(
        "The same, cut for 3 s at moments spread over the transfer",
        "old or new, never mixed; known ≤ 2 s after healing",
        (
            Column("learnt_s", "from healing until it is known", _s),
            Column("worst_learnt_s", "worst", _s),
            Column("worst_mixed", "mixed, or told wrongly", _big),
            Column("cuts", "cuts", _big),
            Column("done", "of them the new one", _big),
        ),
    ),
    "far_gap": Section(
        "A cut way of 256 kbit/s, then the gap in the history filled while orders are given",
        "all records, byte for byte; an order ≤ round trip + 250 ms at 99 %, ≥ 2 states/s meanwhile",
        (
            Column("filled_s", "from healing until it is whole", _s),
            Column("missing", "records missing then", _big),
            Column("worst_wrong", "missing or other at the end", _big),
            *_ORDERS,
            Column("states_hz", "states/s", _tenths),
        ),
    ),
}

_OURS = "vencejo"


@dataclass(frozen=True)
class Figure:
    """One row of the station's table: its title, its target, and the format of its figures."""

    title: str
    aim: str
    write: Callable[[dict[str, float]], str]


STATION_TITLE = "## Ground station in the browser"
STATION: dict[str, Figure] = {
    "browsers": Figure(
        "20 WebSockets at 10 Hz beside a plane of 1,000 messages/s: a command from HTTP request to answer",
        "99 % ≤ 50 ms; the server's memory does not grow in 10 min",
        lambda f: (
            f"median {f['median_ms']:.1f} ms, 99 % {f['p99_ms']:.1f} ms of {f['commands']:,.0f}; "
            f"memory {f['first_mb']:.1f} → {f['last_mb']:.1f} MB in {f['minutes']:.0f} min; "
            f"{f['telemetry_hz']:.1f} Hz each, {f['cpu_percent']:.0f} % of a core"
        ),
    ),
    "paint": Figure(
        "First paint from localhost, and the app's first load",
        "≤ 1.5 s; ≤ 400 kB compressed",
        lambda f: (
            f"painted after {f['paint_s']:.2f} s, map drawn after {f['map_s']:.2f} s (median of {f['runs']:.0f}); "
            f"{f['transferred_kb']:.0f} kB"
        ),
    ),
    "frames": Figure(
        "Map with a trail of 50,000 points and 20 Hz telemetry, software rendering",
        "≥ 20 frames/s",
        lambda f: (
            f"{f['frames_per_s']:.1f} frames/s, {f['dragged_per_s']:.1f} while the map is dragged "
            f"({f['empty_per_s']:.1f} without trail); longest frame {f['longest_ms']:.0f} ms"
        ),
    ),
    "dragging": Figure(
        "A point of a plan of 100 items dragged with the rehearsal following, software rendering",
        "≥ 20 frames/s",
        lambda f: (
            f"{f['frames_per_s']:.1f} frames/s, longest frame {f['longest_ms']:.0f} ms, "
            f"{f['rehearsals_per_s']:.1f} rehearsals/s"
            + (
                f"; from a move to the core's lines painted {f['drawn_ms']:.1f} ms, 99 % within {f['drawn_p99_ms']:.0f} ms, "
                f"{f['ways_per_s']:.1f} a second; processor time of a frame: {f['task_ms']:.1f} ms of the page's main thread "
                f"({f['script_layout_ms']:.1f} scripts and layout), {f['server_ms']:.1f} ms of the server"
                if "drawn_ms" in f
                else ""
            )
        ),
    ),
    "panning": Figure(
        "Map dragged over an area that is kept, software rendering: what is blank, and for how long",
        "no frame and no blank place longer than 200 ms",
        lambda f: (
            f"longest frame {f['longest_frame_ms']:.0f} ms, longest blank place {f['longest_gap_ms']:.0f} ms ({f['gaps']:.0f} in all); "
            f"{f['frames_per_s']:.1f} frames/s at {f['px_per_s']:.0f} px/s for {f['seconds']:.0f} s"
        ),
    ),
    "heap": Figure(
        "The page's heap over a run with 20 Hz telemetry, after forced collections",
        "< 20 MB of growth in an hour",
        lambda f: (
            f"{f['first_mb']:.1f} → {f['last_mb']:.1f} MB in {f['minutes']:.0f} min "
            f"({f['growth_mb']:+.1f} MB, most {f['most_mb']:.1f} MB) at {f['messages_per_s']:.0f} messages/s; "
            f"server {f['server_growth_mb']:+.1f} MB"
        ),
    ),
}


def render(results: dict[str, Any], page: str = "") -> str:
    """Return the whole content of RESULTS.md.

    Parameters
    ----------
    results
        Results of bench/run.py: ``machine`` and, per section, ``runs``, ``date`` and ``figures``.
    page
        Present content of RESULTS.md: sections that were not measured keep their figures.
    """
    machine = results["machine"]
    lines = [
        "# Results",
        "",
        "Written by `make bench`; do not edit. What each row measures and how: [README.md](README.md).",
        "Everything ran on one machine, contestants in turn; each figure is the median of the runs.",
        "The ratio is what counts: absolute figures belong to the machine.",
        "",
        (
            f"Machine: {machine['cores']} cores, {machine['system']}, {machine['architecture']}; "
            f"Python {machine['python']}, pymavlink {machine['pymavlink']}, mavsdk {machine['mavsdk']}, "
            f"MAVProxy {machine['MAVProxy']}."
        ),
    ]
    kept = {part.partition("\n")[0]: part.strip() for part in page.split("\n## ")[1:]}
    for key, section in SECTIONS.items():
        if (measured := section.measured_by or key) in results:
            lines += ["", *_table(section, results[measured])]
        elif section.title in kept:
            lines += ["", f"## {kept[section.title]}"]
    return "\n".join(lines) + "\n"


def other_parts(page: str) -> list[str]:
    """Return the parts of a page that `render` does not write: figures measured by other programs, one at a time."""
    known = {section.title for section in SECTIONS.values()}
    parts = page.split("\n## ")[1:]
    return [f"## {part.strip()}\n" for part in parts if part.partition("\n")[0] not in known]


def write_station(path: Path, name: str, found: dict[str, Any], machine: dict[str, str]) -> None:
    """Write one figure of the station into the page, in place of its previous value."""
    page = path.read_text(encoding="utf-8") if path.exists() else "# Results\n"
    before = next((part for part in other_parts(page) if part.startswith(STATION_TITLE)), "")
    rows = {row.partition(" | ")[0].removeprefix("| "): row for row in before.splitlines() if row.startswith("| ")}
    figure = STATION[name]
    where = f"{found['date']}, {machine['cores']} cores, {machine['system']}{found['detail']}"
    rows[figure.title] = f"| {figure.title} | {figure.write(found['figures'])} | {figure.aim} | {where} |"
    lines = [
        STATION_TITLE,
        "",
        "Written by the programs in `bench/station`, one row each ([README.md](README.md)). The load is that of the whole machine.",
        "",
        "| what | measured | aim | when and where |",
        "|---|---|---|---|",
        *(rows[figure.title] for figure in STATION.values() if figure.title in rows),
    ]
    part = "\n".join(lines) + "\n"
    page = page.replace(before, part) if before else page.rstrip("\n") + "\n\n" + part
    path.write_text(page, encoding="utf-8")


def _against(section: Section, result: dict[str, Any]) -> str:
    return f", against {result.get('plane', 'the simulated plane')}" if section.has_plane else ""


def _loaded(result: dict[str, Any]) -> str:
    return f", load {result['load']} a core before" if "load" in result else ""


def _table(section: Section, result: dict[str, Any]) -> list[str]:
    figures: dict[str, dict[str, float] | str] = result["figures"]
    first = section.columns[0]
    ours = figures.get(_OURS)
    base = ours[first.key] if isinstance(ours, dict) else None
    lines = [
        f"## {section.title}",
        "",
        f"Aim: {section.aim}. {result['runs']} runs, {result['date']}{_loaded(result)}{_against(section, result)}.",
        "",
        f"| | {' | '.join(column.title for column in section.columns)} | {first.title}, ours = 1 |",
        "|---" * (len(section.columns) + 2) + "|",
    ]
    for name, found in figures.items():
        if isinstance(found, str):
            reason = found.replace("|", "/").replace("\n", " ")[:100]
            lines.append(f"| {name} | not measured: {reason} |" + " |" * len(section.columns))
            continue
        ratio = "" if not base else f"{found[first.key] / base:.2f} ×"
        cells = [column.write(found[column.key]) if column.key in found else "—" for column in section.columns]
        lines.append(f"| {name} | {' | '.join(cells)} | {ratio} |")
    return lines
