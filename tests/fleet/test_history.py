"""A history: written on board and on the ground, with a cut that is filled, a program that is killed, and readers that are not ours."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.reader import SeekingReader
from vencejo.fleet import has_fleet

from tests.fleet.programs import far_plane
from tests.fleet.records import STREAMS, messages, numbered
from tests.support import HOME, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")


@pytest.mark.e2e
def test_a_cut_is_filled_byte_for_byte_and_others_read_it(tmp_path: Path) -> None:
    from vencejo import Station
    from vencejo.errors import NotPossibleNow
    from vencejo.history import contents, kept
    from vencejo.replay import Replay

    ground_folder = tmp_path / "ground/history/ground/acme"
    board_folder = tmp_path / "board/history/board"
    with far_plane(tmp_path, "--history-frames") as plane:
        ana, at = plane.ana, plane.at

        def age_s() -> float:
            return float(ana.done("GET", at)["telemetry"]["heartbeat"]["age_s"])

        wait_for(lambda: bool(plane.summary.get("mode")), "the plane")
        ana.done("POST", "control/take")
        ana.done("POST", f"{at}/mode", {"mode": "FBWA"})
        before = len(numbered(ground_folder))
        plane.way.cut()
        wait_for(lambda: age_s() > 5.0, "its silence")
        cut = numbered(board_folder)
        plane.way.heal()
        wait_for(lambda: cut.keys() <= numbered(ground_folder).keys(), "what was said in the cut, and all orders")
        ana.done("POST", "control/release")
        # Killed: what it had written is there, and no more than a second is not.
        wait_for(lambda: numbered(board_folder).keys() > cut.keys(), "more")
        plane.board.process.kill()
        plane.board.process.wait()
        plane.ground.process.terminate()
        plane.ground.process.wait(20)

    on_board, archived = numbered(board_folder), numbered(ground_folder)
    assert len(cut) > before
    both = on_board.keys() & archived.keys()
    assert cut.keys() <= both
    assert all(on_board[each] == archived[each] for each in both)
    (boot,) = {boot for _, boot, _ in on_board}
    for topic in STREAMS:
        count = sum(1 for each in on_board if each[0] == topic)
        assert {number for of, _, number in on_board if of == topic} == set(range(1, count + 1)), topic

    # What others see in it, by the descriptors in the file alone.
    decoded = [(topic, message) for topic, _, message in messages(ground_folder)]
    fixes = [message for topic, message in decoded if topic == "/location"]
    assert fixes[-1].latitude == pytest.approx(HOME[0], abs=0.01)
    assert fixes[-1].longitude == pytest.approx(HOME[1], abs=0.01)
    assert fixes[-1].frame_id == "plane7"
    audits = [message for topic, message in decoded if topic == "/audit"]
    (change,) = [audit for audit in audits if audit.order.WhichOneof("want") == "act"]
    assert (change.order.operator, change.order.act.mode, change.answer.end) == ("Ana", "FBWA", 1)
    assert (change.key.hex(), change.order.epoch) == (plane.told["fleet"]["key"], audits[0].answer.epoch)
    assert any(topic == "/mavlink" for topic, _, _ in messages(board_folder))
    with next(ground_folder.glob("*.mcap")).open("rb") as stream:
        reader = SeekingReader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(decoded), "one that was ended has a summary"
        assert {schema.name for schema in summary.schemas.values()} >= {"vencejo.v1.State", "foxglove.LocationFix"}

    # What we say of it.
    assert contents(next(ground_folder.glob("*.mcap"))).skipped_bytes == 0
    (here,) = kept(ground_folder)
    assert (here.name, here.records["state"]) == ("plane7", sum(1 for each in archived if each[0] == "/state"))
    last = {topic: max(number for of, _, number in cut if of == topic) for topic in STREAMS}
    assert not [gap for gap in here.gaps if gap.first <= last[f"/{gap.stream}"]]
    found = contents(next(board_folder.glob("*.mcap")))
    assert found.aircraft == "plane7"
    assert {each.boot for each in found.streams} == {boot}
    assert all(each.missing == 0 for each in found.streams)

    # And it flies again, and takes no orders.
    with (
        Station(record=False, signing=False, heartbeat=False) as station,
        Replay(station, next(ground_folder.glob("*.mcap")), speed=100.0) as replay,
    ):
        again = station.wait_vehicle()
        assert (again.remote_name, replay.name) == ("plane7 (replay)", "plane7")
        wait_for(lambda: replay.status.is_over, "its end")
        position = again.telemetry.position
        assert position is not None
        assert position.lat_deg == pytest.approx(HOME[0], abs=0.01)
        with pytest.raises(NotPossibleNow, match="recording"):
            again.set_mode("FBWA")
        replay.seek(0.0)
        wait_for(lambda: not replay.status.is_over, "it to go on")
