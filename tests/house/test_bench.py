"""Parts of the benchmarks: the load's frames, reading /proc, and the report."""

from __future__ import annotations

import itertools
import os
import struct
from pathlib import Path

import pytest

from bench import harness, prepare, report


def test_prepared_frames_are_mavlink_and_the_clock_goes_on(tmp_path: Path) -> None:
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    file = tmp_path / "frames.bin"
    frames = prepare.prepare(file, laps=2)
    data = file.read_bytes()
    assert frames == prepare.count(data) > 40_000
    at, stream, stamps = 0, bytearray(), 0
    while at < len(data):
        length, _crc_extra, stamp_at = struct.unpack_from("<HBH", data, at)
        stream += data[at + 5 : at + 5 + length]
        stamps += stamp_at != prepare.NO_STAMP
        at += 5 + length
    parser = dialect.MAVLink(None)
    messages = parser.parse_buffer(bytes(stream))
    assert len(messages) == frames
    boots = [message.time_boot_ms for message in messages if message.get_type() == "GLOBAL_POSITION_INT"]
    assert len(boots) == 2 * 771
    assert boots == sorted(boots), "the plane must not seem to reboot between two laps"
    assert stamps == 2 * 771
    written = file.stat().st_mtime_ns
    assert prepare.prepare(file) == frames
    assert file.stat().st_mtime_ns == written, "made again although nothing changed"


def test_a_vehicle_of_a_fleet_has_its_heartbeat_each_second(tmp_path: Path) -> None:
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    file = tmp_path / "fleet.bin"
    frames = prepare.prepare(file, laps=1, fleet=True)
    data = file.read_bytes()
    at, stream = 0, bytearray()
    while at < len(data):
        length = struct.unpack_from("<H", data, at)[0]
        stream += data[at + 5 : at + 5 + length]
        at += 5 + length
    names = [message.get_type() for message in dialect.MAVLink(None).parse_buffer(bytes(stream))]
    assert len(names) == frames == 5 * 771 + names.count("HEARTBEAT")
    beats = [index for index, name in enumerate(names) if name == "HEARTBEAT"]
    assert beats[0] == 0
    assert len(beats) >= 19
    assert {later - sooner for sooner, later in itertools.pairwise(beats)} <= {200, 201}


def test_usage_of_this_process() -> None:
    assert harness.cpu_seconds(os.getpid()) > 0
    assert harness.rss_mb(os.getpid()) > 5


def test_quantile_and_repeat() -> None:
    assert harness.quantile([3, 1, 2], 0.5) == 2
    assert harness.quantile([3, 1, 2], 0.99) == 3
    with pytest.raises(harness.NotMeasured):
        harness.quantile([], 0.5)
    values = iter([5.0, 1.0, 3.0])

    def absent() -> dict[str, float]:
        raise harness.NotMeasured("not built")

    found = harness.repeat(3, {"a": lambda: {"seconds": next(values)}, "b": absent})
    assert found == {"a": {"seconds": 3.0}, "b": "not built"}


def test_report_shows_ratios_and_reasons() -> None:
    machine = dict.fromkeys(("cores", "system", "architecture", "python", "pymavlink", "mavsdk", "MAVProxy"), "x")
    figures = {"vencejo": {"seconds": 0.1}, "pymavlink": {"seconds": 0.25}, "mavsdk": "not there"}
    page = report.render({"machine": machine, "first_position": {"runs": 5, "date": "2026-11-21", "figures": figures}})
    assert "| pymavlink | 0.250 s | — | 2.50 × |" in page
    assert "| mavsdk | not measured: not there |" in page
    again = report.render({"machine": machine}, page)
    assert "| pymavlink | 0.250 s | — | 2.50 × |" in again, "what is not measured keeps its figures"
    rows = [line for line in page.splitlines() if line.startswith("|")]
    assert len({row.count("|") for row in rows}) == 1, "a row with another number of cells"


def test_a_figure_of_the_station_replaces_its_own_row_and_nothing_else(tmp_path: Path) -> None:
    page = tmp_path / "RESULTS.md"
    decode = next(iter(report.SECTIONS.values())).title
    page.write_text(f"# Results\n\n## {decode}\n\nfirst\n\n## Others\n\nkept\n", encoding="utf-8")
    machine = {"cores": "2", "system": "Debian"}
    figures = {"runs": 3.0, "paint_s": 0.5, "map_s": 0.75, "transferred_kb": 287.0}
    for paint_s in (0.5, 0.25):
        found = {"figures": {**figures, "paint_s": paint_s}, "detail": ", load 1", "date": "2026-11-21"}
        report.write_station(page, "paint", found, machine)
    frames = {"empty_per_s": 60.0, "frames_per_s": 30.0, "dragged_per_s": 25.0, "longest_ms": 50.0}
    report.write_station(page, "frames", {"figures": frames, "detail": "", "date": "2026-11-21"}, machine)
    text = page.read_text(encoding="utf-8")
    assert "first" in text
    assert "kept" in text
    assert "0.25 s, map" in text
    assert "0.50 s" not in text
    assert text.count(report.STATION_TITLE) == 1
    assert "30.0 frames/s" in text
    assert [part.partition("\n")[0] for part in report.other_parts(text)] == ["## Others", report.STATION_TITLE]
