"""The simulated plane answers a station as a recorded ArduPlane did, message by message."""

from __future__ import annotations

from typing import Any

import pytest
from vencejo.sim.world import World

from tests.sim.transcripts import HOME, Entry, double, outline, read, recorded, replay, settled_world

ITEM = ("seq", "frame", "command", "current", "autocontinue", "param1", "param2", "param3", "param4", "x", "y", "z",
        "mission_type", "target_system", "target_component")  # fmt: skip
MISSION: dict[str, tuple[str, ...]] = {
    "MISSION_REQUEST": ("seq", "mission_type", "target_system", "target_component"),
    "MISSION_ACK": ("type", "mission_type", "target_system", "target_component"),
    "MISSION_COUNT": ("count", "mission_type", "target_system", "target_component"),
    "MISSION_ITEM_INT": ITEM,
    "STATUSTEXT": ("severity", "text"),
}


def upload_first(name: str = "mission-upload-items.tlog") -> tuple[Any, Any]:
    """A plane that holds the recorded mission."""
    world, station = settled_world()
    replay(read(name), world, station)
    return world, station


@pytest.mark.parametrize(
    "name",
    [
        "mission-upload-items.tlog",
        "mission-upload-unsupported-command.tlog",
        "mission-upload-too-many.tlog",
        "fence-and-rally-upload.tlog",
        "mission-clear.tlog",
    ],
)
def test_plan_conversation_is_the_recorded_one(name: str) -> None:
    entries = read(name)
    world, station = settled_world()
    answers = outline(replay(entries, world, station), MISSION)
    expected = outline(recorded(entries), MISSION)
    assert len(expected) >= 1
    assert answers == expected


def test_stray_item_is_refused_and_the_upload_goes_on() -> None:
    entries = read("mission-upload-out-of-sequence-item.tlog")
    world, station = settled_world()
    answers = outline(replay(entries, world, station, tail_s=1.2), MISSION)
    expected = outline(recorded(entries), MISSION)
    assert ("MISSION_ACK", 13, 0, 255, 190) in expected
    assert answers == expected


def test_download_reads_back_what_was_uploaded() -> None:
    world, station = upload_first()
    entries = read("mission-download-items.tlog")
    answers = outline(replay(entries, world, station), MISSION)
    expected = outline(recorded(entries), MISSION)
    assert len(expected) == 13
    assert [answer for answer in answers if answer[0] != "STATUSTEXT"] == expected


def test_abandoned_upload_is_asked_for_again_then_cancelled() -> None:
    entries = read("mission-upload-abandoned.tlog")
    world, station = settled_world()
    start_s = world.planes[0].autopilot.time_s
    answers = replay(entries, world, station, tail_s=11.0)
    # The text and the acknowledgement leave together; their order is the queue's, not the protocol's.
    assert sorted(outline(answers, MISSION), key=str) == sorted(outline(recorded(entries), MISSION), key=str)
    assert world.planes[0].autopilot.time_s - start_s == pytest.approx(11.0, abs=0.1)


def test_upload_tells_the_total_as_it_grows() -> None:
    world, station = settled_world()
    answers = replay(read("mission-upload-items.tlog"), world, station)
    totals = [m.param_value for m in answers if m.get_type() == "PARAM_VALUE" and m.param_id == "MIS_TOTAL"]
    assert totals == sorted(totals)
    assert totals[-1] == 12.0


def ftp_frames(messages: list[Any]) -> list[bytes]:
    return [bytes(m.payload) for m in messages if m.get_type() == "FILE_TRANSFER_PROTOCOL"]


def head(payload: bytes) -> bytes:
    """A MAVFTP payload without what follows its data (the recorded vehicle leaves old bytes there)."""
    return payload[:12] + payload[12 : 12 + payload[4]]


def test_ftp_download_of_the_mission_is_byte_for_byte_the_recorded_one() -> None:
    world, station = upload_first()
    entries = read("mission-download-ftp.tlog")
    answers = ftp_frames(replay(entries, world, station))
    expected = ftp_frames(recorded(entries))
    assert len(expected) >= 8
    assert sorted(map(head, answers)) == sorted(map(head, expected))


def test_ftp_upload_becomes_the_mission_when_the_session_ends() -> None:
    world, station = settled_world()
    entries = read("mission-upload-ftp.tlog")
    answers = [head(f) for f in ftp_frames(replay(entries, world, station))]
    assert {p[:12] for p in answers} == {head(p)[:12] for p in ftp_frames(recorded(entries))}
    assert len(world.planes[0].plans.mission_store) == 12
    download = read("mission-download-items.tlog")
    items = outline(replay(download, world, station), {"MISSION_ITEM_INT": ITEM})
    assert items == outline(recorded(download), {"MISSION_ITEM_INT": ITEM})


def test_ftp_parameters_are_byte_for_byte_the_recorded_ones() -> None:
    world, station = settled_world()
    params = world.planes[0].params
    for name, value in (
        ("RTL_AUTOLAND", 2),
        ("BARO1_GND_PRESS", 101323.171875),
        ("BARO2_GND_PRESS", 101323.515625),
        ("MIS_TOTAL", 3),
    ):
        params.set(name, value)
    entries = read("param-ftp.tlog")
    answers = sorted(head(f) for f in ftp_frames(replay(entries, world, station)))
    expected = sorted(head(f) for f in ftp_frames(recorded(entries)))
    assert len(expected) > 190
    assert answers == expected


def test_parameter_list_is_the_recorded_one() -> None:
    entries = read("param-list.tlog")
    world, station = settled_world()
    fields = {"PARAM_VALUE": ("param_index", "param_id", "param_type", "param_count")}
    answers = outline(replay(entries, world, station, tail_s=3.0), fields)
    indexed = [row for row in outline(recorded(entries), fields) if row[1] != 65535]
    assert len(indexed) == 1399
    assert [row for row in answers if row[1] != 65535] == indexed


def test_parameter_set_read_and_unknown_name() -> None:
    entries = read("param-set.tlog")
    world, station = settled_world()
    fields = {
        "PARAM_VALUE": ("param_id", "param_value", "param_type", "param_count", "param_index"),
        "PARAM_ERROR": ("param_id", "param_index", "error", "target_system", "target_component"),
    }

    def outlined(messages: list[Any]) -> list[tuple[Any, ...]]:
        return [row for row in outline(messages, fields) if not str(row[1]).startswith("BARO")]

    expected = outlined(recorded(entries))
    assert len(expected) == 3
    assert outlined(replay(entries, world, station)) == expected


COMMANDS: dict[str, tuple[str, ...]] = {
    "COMMAND_ACK": ("command", "result", "target_system", "target_component"),
    "AUTOPILOT_VERSION": ("capabilities",),
}


def test_stream_and_message_requests() -> None:
    entries = read("connect-and-stream-requests.tlog")
    world, station = settled_world()
    answers = replay(entries, world, station)
    assert outline(answers, COMMANDS) == outline(recorded(entries), COMMANDS)
    texts = {"STATUSTEXT": ("severity", "text", "id", "chunk_seq")}
    assert outline(answers, texts) == outline(recorded(entries), texts)

    def rates(messages: list[Any]) -> set[str]:
        return {m.param_id for m in messages if m.get_type() == "PARAM_VALUE" and m.param_id.startswith("MAV1_")}

    told = rates(recorded(entries)) - {"MAV1_ADSB"}
    assert len(told) == 8
    world.planes[0].params.set("MAV1_EXTRA1", 1)
    assert rates(answers) <= told


def test_modes_arming_and_refusals() -> None:
    entries = read("arm-refused-and-modes.tlog")
    world, station = settled_world()
    answers = replay(entries, world, station)
    assert outline(answers, COMMANDS) == outline(recorded(entries), COMMANDS)
    texts = [row[1:] for row in outline(answers, {"STATUSTEXT": ("severity", "text")})]
    assert (4, "No such mode 99") in texts
    assert (6, "Throttle armed") in texts
    modes = [(m.custom_mode, m.base_mode) for m in answers if m.get_type() == "HEARTBEAT"]
    assert modes[0] == (10, 89)
    assert modes[-1] == (10, 217)


def test_guided_commands() -> None:
    entries = [entry for entry in read("guided-flight.tlog") if entry.message.get_type() != "HEARTBEAT"]
    world, station = settled_world()
    answers = replay(entries, world, station)
    assert outline(answers, COMMANDS) == outline(recorded(entries), COMMANDS)
    reposition = next(call[1] for call in double(world).calls if call[0] == "reposition")
    assert reposition.lat_deg == pytest.approx(40.3385898)  # type: ignore[attr-defined]
    assert reposition.alt_m == 90.0  # type: ignore[attr-defined]
    assert reposition.frame == 3  # type: ignore[attr-defined]
    assert reposition.radius_m == 80.0  # type: ignore[attr-defined]
    assert ("change_speed", 0, 18.0, -1.0) in double(world).calls


def state_of(message: Any) -> object:
    """The fields of a message that are the same in every start; None for other messages."""
    match message.get_type():
        case "HEARTBEAT":
            return message.custom_mode, message.base_mode, message.system_status
        case "GLOBAL_POSITION_INT":
            is_somewhere = abs(message.lat) > 1_000_000
            return is_somewhere, message.lat == 0 == message.lon, message.alt > 500_000, message.hdg == 0
        case "SYS_STATUS":
            return message.voltage_battery > 0, message.battery_remaining >= 0
        case "BATTERY_STATUS":
            return message.voltages[0] == 65535, message.battery_remaining >= 0, message.charge_state
        case "GPS_RAW_INT":
            return message.fix_type, message.satellites_visible, message.time_usec > 0
        case "EKF_STATUS_REPORT":
            return message.flags
        case "SYSTEM_TIME":
            return message.time_unix_usec > 0
        case "HOME_POSITION" | "GPS_GLOBAL_ORIGIN":
            return message.altitude > 500_000
    return None


def changes(timed: list[tuple[float, Any]]) -> dict[str, list[tuple[float, object]]]:
    """The changes of each kind of message: time and new content."""
    told: dict[str, list[tuple[float, object]]] = {}
    for time_s, message in timed:
        state = state_of(message)
        before = told.setdefault(message.get_type(), [])
        if state is not None and (not before or before[-1][1] != state):
            before.append((time_s, state))
    return {kind: found for kind, found in told.items() if found}


def test_a_start_is_the_recorded_one() -> None:
    """First the heartbeat, then an invalid position, then one without its altitude, each at its time."""
    start_s = 12.5
    theirs = changes([(entry.time_s, entry.message) for entry in read("arduplane-takeoff-to-landing.tlog", start_s)])
    world = World(HOME)
    station = world.connect()
    heard: list[tuple[float, Any]] = []
    for _ in range(round(start_s * 100)):
        world.tick()
        heard += [(world.planes[0].autopilot.time_s, message) for message in station.receive()]
    assert {message.get_type() for time_s, message in heard if time_s < 1.5} <= {"HEARTBEAT", "PARAM_VALUE"}
    ours = changes(heard)
    assert len(theirs) == 8
    assert theirs.keys() == ours.keys()
    for kind, told in theirs.items():
        assert [state for _, state in ours[kind]] == [state for _, state in told], kind
        # The first messages of two kinds are sent without delay here.
        later = slice(1 if kind in {"HEARTBEAT", "EKF_STATUS_REPORT"} else 0, None)
        times = [[time_s for time_s, _ in side[kind]][later] for side in (ours, theirs)]
        assert times[0] == pytest.approx(times[1], abs=0.3), kind


def test_recordings_are_read_whole() -> None:
    entries: list[Entry] = read("mission-upload-items.tlog")
    assert sum(entry.from_station for entry in entries) == 13
    assert HOME.home_alt_amsl_m == 600.09
