"""The package against a simulated plane over a real link: one plane serves the tests of this file in turn."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
import vencejo
from vencejo import MissionItem, Plan, aio
from vencejo.vehicle import Danger

from tests.support import HOME, reserved_ports, simulated_plane, wait_for

pytestmark = pytest.mark.e2e
LAT, LON, _ = HOME

MISSION = Plan(
    items=(
        MissionItem.takeoff(LAT, LON, alt_rel_home_m=50.0),
        MissionItem.waypoint(LAT + 0.004, LON, alt_rel_home_m=80.0),
        MissionItem.loiter_turns(LAT + 0.004, LON + 0.004, alt_rel_home_m=80.0, turns=1, radius_m=-70.0),
        MissionItem.change_airspeed(18.0),
        MissionItem.jump(2, repeats=2),
        MissionItem.return_to_launch(),
    )
)


@pytest.fixture(scope="module")
def link() -> Iterator[str]:
    with simulated_plane() as link:
        with vencejo.connect(link, record=False) as plane:
            plane.wait_until(lambda telemetry: telemetry.home is not None, timeout_s=60.0, what="having a home")
        yield link


@pytest.fixture
def plane(link: str) -> Iterator[vencejo.Vehicle]:
    with vencejo.connect(link, record=False) as vehicle:
        yield vehicle


def test_the_mode_is_shown_and_changed_by_name(plane: vencejo.Vehicle) -> None:
    seen = []
    subscription = plane.on_event(lambda event: seen.append((event.kind, dict(event.detail))))
    plane.set_mode("fbwa")
    assert plane.telemetry.mode == "FBWA"
    plane.set_mode("MANUAL")
    wait_for(lambda: ("mode", {"from": "FBWA", "mode": "MANUAL"}) in seen, "the event")
    subscription.close()
    assert "TAKEOFF" in plane.mode_names
    with pytest.raises(vencejo.InvalidRequest, match="AUTO"):
        plane.set_mode("AUTOO")


def test_a_mission_is_uploaded_verified_read_and_cleared(plane: vencejo.Vehicle) -> None:
    progress: list[tuple[int, int]] = []
    mode, armed = plane.telemetry.mode, plane.telemetry.is_armed
    state = plane.upload(MISSION, progress=lambda done, total: progress.append((done, total)))
    assert (state.state, state.count) == ("verified", len(MISSION))
    assert progress
    assert progress == sorted(progress)
    assert progress[-1][0] <= progress[-1][1]
    known = plane.plan_on_board()
    assert known is not None
    read = plane.download()
    assert known.items == read.items
    assert [item.name for item in read] == [item.name for item in MISSION]
    assert read.items[2].params[2] == -70.0
    assert read.home is not None
    assert plane.plan_state().hash == state.hash
    assert plane.compare_plan(MISSION) == ()
    first, second, *rest = MISSION.items
    higher = Plan(items=(first, second.with_altitude(97.0), *rest))
    assert plane.compare_plan(higher) == (vencejo.PlanChange("changed", 2, 2, ("height",)),)
    assert plane.compare_plan(Plan(items=MISSION.items[1:])) == (vencejo.PlanChange("removed", None, 1),)
    plane.clear(confirm="clear-mission")
    assert plane.plan_state().state == "empty"
    assert plane.download().items == ()
    assert (plane.telemetry.mode, plane.telemetry.is_armed) == (mode, armed), "nothing else happened"


def test_fence_and_rally(plane: vencejo.Vehicle) -> None:
    corners = tuple(vencejo.GeoPoint(LAT + a, LON + b) for a, b in ((-0.02, -0.02), (0.02, -0.02), (0.02, 0.02)))
    plan = Plan(
        fence=vencejo.Fence((vencejo.Polygon(corners), vencejo.Circle(vencejo.GeoPoint(LAT, LON), 900.0))),
        rally=(vencejo.RallyPoint(LAT + 0.002, LON, 90.0),),
    )
    for kind in ("fence", "rally"):
        assert plane.upload(plan, kind=kind).state == "verified"
    swapped = Plan(rally=(vencejo.RallyPoint(LON, LAT, 90.0),))
    with pytest.raises(vencejo.PlanRefused, match="swapped"):
        plane.upload(swapped, kind="rally")
    read = plane.download(kinds=("fence", "rally"))
    assert (len(read.fence.zones), len(read.rally)) == (2, 1)
    zone = read.fence.zones[0]
    assert isinstance(zone, vencejo.Polygon)
    assert [round(point.lat_deg, 7) for point in zone.points] == [round(point.lat_deg, 7) for point in corners]
    for kind in ("fence", "rally"):
        plane.clear(kind=kind, confirm=f"clear-{kind}")  # type: ignore[arg-type]
    assert plane.download(kinds=("fence", "rally")) == Plan()


def test_one_operator_acts_and_the_others_are_told_who(plane: vencejo.Vehicle) -> None:
    ours = plane.station.operator
    with plane.station.add_operator("Luis") as luis:
        theirs = luis.vehicle(plane)
        plane.set_mode("MANUAL")
        assert (ours.has_control, luis.holder) == (True, ours.name), "the first who acts has it"
        with pytest.raises(vencejo.ControlHeld, match=ours.name) as refused:
            theirs.set_mode("FBWA")
        assert refused.value.holder == ours.name
        assert theirs.telemetry.mode == "MANUAL"
        assert theirs.params["WP_RADIUS"] > 0, "to read needs no control"
        with pytest.raises(vencejo.ControlHeld):
            luis.take(over="nobody of that name")
        assert luis.take(over=ours.name)
        with pytest.raises(vencejo.ControlHeld, match="Luis"):
            plane.arm()
        theirs.set_mode("FBWA")
        with plane.station.add_operator("Eva", transient=True) as eva:
            acts = eva.vehicle(plane)
            asked = []
            for declined in ("Ana", None, "Eva"):
                with pytest.raises(vencejo.ControlHeld, match="Luis"):
                    acts.set_mode("MANUAL")
                ours.keep()
                luis.keep(requested_by=declined)
                asked.append(luis.requested_by)
            assert asked == ["Eva", None, None], "declined once, it does not ask again"
        # Asked for by the vehicle: withdrawn, declined, given; a program gives it to whoever asks.
        assert (plane.request_control(), luis.requested_by) == (False, ours.name)
        plane.release_control()
        assert [luis.requested_by] == [None]
        assert (plane.request_control(), plane.control.requested_by) == (False, ours.name)
        theirs.keep_control(requested_by="Eva")
        assert luis.requested_by == ours.name
        theirs.keep_control()
        assert [luis.requested_by] == [None]
        assert not plane.request_control()
        theirs.release_control()
        assert (plane.control.holder, luis.has_control) == (ours.name, False)
        assert (theirs.request_control(), ours.has_control) == (True, False)

        async def the_same_awaited() -> None:
            awaited = await aio.wait_vehicle(plane.station)
            assert (await awaited.request_control(), luis.requested_by) == (False, ours.name)
            await awaited.release_control()
            assert [luis.requested_by] == [None]
            luis.release()
            assert (await awaited.request_control(), ours.has_control) == (True, True)
            await awaited.keep_control()

        asyncio.run(the_same_awaited())
    plane.set_mode("MANUAL")
    # Of two who send at once one is told, and the vehicle has one whole plan.
    plans = {name: Plan(items=MISSION.items[:count]) for name, count in (("Ana", 2), ("Eva", 3))}
    ours.release()
    for _ in range(5):
        people = [plane.station.add_operator(name) for name in plans]
        ends: dict[str, object] = {}

        def send(operator: vencejo.Operator, ends: dict[str, object] = ends) -> None:
            try:
                ends[operator.name] = operator.vehicle(plane).upload(plans[operator.name]).count
            except vencejo.VencejoError as error:
                ends[operator.name] = error

        senders = [threading.Thread(target=send, args=(operator,)) for operator in people]
        for sender in senders:
            sender.start()
        for sender in senders:
            sender.join(30)
        (told,) = [end for end in ends.values() if isinstance(end, vencejo.ControlHeld)]
        assert ends[told.holder] == len(plans[told.holder]) == len(plane.download())
        for operator in people:
            operator.close()


def test_what_is_dangerous_is_confirmed_by_name(plane: vencejo.Vehicle) -> None:
    assert plane.upload(MISSION).state == "verified"
    acts: list[tuple[str, Callable[[Any], object]]] = [
        ("force-arm", lambda confirm: plane.arm(force=True, confirm=confirm)),
        ("force-arm", lambda confirm: plane.command(400, 1, 21196, confirm=confirm)),
        ("force-disarm", lambda confirm: plane.disarm(force=True, confirm=confirm)),
        ("terminate", lambda confirm: plane.command_int("DO_FLIGHTTERMINATION", 1, frame=0, confirm=confirm)),
        ("clear-mission", lambda confirm: plane.clear(confirm=confirm)),
        ("clear-mission", lambda confirm: plane.send_message("MISSION_CLEAR_ALL", confirm=confirm)),
        ("reboot", lambda confirm: plane.reboot(confirm=confirm)),
        ("fence-off", lambda confirm: plane.params.set("FENCE_ENABLE", 0, confirm=confirm)),
        ("fence-off", lambda confirm: plane.switch_fence(False, confirm=confirm)),
    ]
    for act, call in acts:
        for other in (None, "erase"):
            with pytest.raises(vencejo.ConfirmationNeeded, match=f"confirm='{act}'") as needed:
                call(other)
            assert needed.value.act == act
        with pytest.raises(vencejo.InvalidRequest, match="what can be confirmed is " + ", ".join(get_args(Danger))):
            call("yes")
    assert plane.telemetry.is_armed is False
    assert len(plane.download()) == len(MISSION), "nothing was sent"
    with pytest.raises(vencejo.InvalidRequest, match="clear"):
        plane.upload(Plan(), check=False)
    assert plane.params.set("FENCE_ENABLE", 0, confirm="fence-off").value == 0.0
    plane.arm(force=True, confirm="force-arm")
    plane.disarm(force=True, confirm="force-disarm")
    plane.clear(confirm="clear-mission")


def test_a_refused_item_says_which(plane: vencejo.Vehicle) -> None:
    # NAV_LAND_LOCAL is no command that ArduPlane takes; unchecked, the vehicle itself says so.
    bad = Plan(items=(MISSION.items[1], MissionItem.at(23, LAT, LON, alt_rel_home_m=10.0)))
    with pytest.raises(vencejo.PlanRefused):
        plane.upload(bad)
    with pytest.raises(vencejo.TransferError, match="UNSUPPORTED"):
        plane.upload(bad, check=False)
    assert plane.plan_state().state == "unknown"
    plane.clear(confirm="clear-mission")


def test_parameters_are_read_written_and_refused(plane: vencejo.Vehicle, tmp_path: Path) -> None:
    assert plane.params["WP_RADIUS"] == 50.0
    plane.params["WP_RADIUS"] = 45
    assert plane.params["WP_RADIUS"] == 45.0
    plane.params["WP_RADIUS"] = 50
    everything = plane.params.all()
    assert len(everything) > 1_000
    assert everything["AIRSPEED_CRUISE"].value == 22.0
    assert (everything["WP_RADIUS"].value, everything["WP_RADIUS"].default) == (50.0, 50.0)
    assert plane.params.get("WP_RADIUS").default is None, "only a list has default values"
    seen: list[dict[str, object]] = []
    subscription = plane.on_event(lambda event: seen.append(dict(event.detail)) if event.kind == "param" else None)
    plane.params["WP_RADIUS"] = 47
    wait_for(lambda: {"name": "WP_RADIUS", "value": 47.0} in seen, "the event")
    subscription.close()
    known = plane.params.all()["WP_RADIUS"]
    assert (known.value, known.default) == (47.0, 50.0)
    plane.params["WP_RADIUS"] = 50
    with pytest.raises(vencejo.ParameterError, match="NO_SUCH_PARAM"):
        plane.params.get("NO_SUCH_PARAM")
    for wrong in ("AIRSPEED_CRUIS", "airspeed_cruise"):
        with pytest.raises(vencejo.ParameterError, match=f"{wrong}.*it has AIRSPEED_CRUISE"):
            plane.params.get(wrong)
    with pytest.raises(vencejo.VencejoError, match=r"nan|finite"):
        plane.params.set("WP_RADIUS", float("nan"))
    file = tmp_path / "all.param"
    vencejo.save_params(file, everything)
    assert len(vencejo.load_params(file)) == len(everything) == plane.params.save(file)
    plane.params["WP_RADIUS"] = 45
    vencejo.save_params(file, {**everything, "NO_SUCH_PARAM": 1.0, "STAT_BOOTCNT": 1_000})
    written, unknown = plane.params.load(file)
    assert ({name: param.value for name, param in written.items()}, unknown) == (
        {"WP_RADIUS": 50.0},
        ("NO_SUCH_PARAM",),
    )
    assert ("WP_RADIUS" in plane.params, "NO_SUCH_PARAM" in plane.params, 1 in plane.params) == (True, False, False)
    assert list(plane.params) == list(everything)
    # Now that it is known how the plane flies, what a rehearsal shows stops a sending too: here its turn reaches into a zone.
    turns = [(LAT + 0.009, LON), (LAT + 0.0045, LON + 0.0008)]
    waypoints = (MissionItem.waypoint(*place, alt_rel_home_m=60.0) for place in turns)
    narrow = Plan(
        items=(MissionItem.takeoff(LAT, LON, alt_rel_home_m=50.0), *waypoints),
        fence=vencejo.Fence((vencejo.Circle(vencejo.GeoPoint(LAT + 0.0086, LON + 0.00094), 30.0, inclusion=False),)),
    )
    with pytest.raises(vencejo.PlanRefused, match="leaves the fence"):
        plane.upload(narrow)


def test_arming_without_a_mission_in_auto_is_refused_with_the_reason(plane: vencejo.Vehicle) -> None:
    plane.clear(confirm="clear-mission")
    plane.set_mode("RTL")
    with pytest.raises(vencejo.CommandRefused) as caught:
        plane.arm()
    assert caught.value.result
    assert any("not armable" in reason for reason in caught.value.reasons)
    assert plane.telemetry.is_armed is False
    plane.set_mode("MANUAL")


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 91.0, -200.0])
def test_positions_that_cannot_be_are_not_sent(plane: vencejo.Vehicle, bad: float) -> None:
    with pytest.raises(vencejo.InvalidRequest):
        plane.goto(bad, LON, alt_rel_home_m=50.0)
    with pytest.raises(vencejo.InvalidRequest, match="once"):
        plane.goto(LAT, LON)


def test_what_no_flight_means_is_not_sent_and_what_is_doubtful_is_told(plane: vencejo.Vehicle) -> None:
    plane.wait_until(lambda now: now.home and now.position, timeout_s=60.0, what="having a home and a position")
    swapped = Plan(
        items=(
            MissionItem.takeoff(LON, LAT, alt_rel_home_m=50.0),
            MissionItem.waypoint(LON + 0.01, LAT, alt_rel_home_m=50.0),
            MissionItem.return_to_launch(),
        )
    )
    with pytest.raises(vencejo.PlanRefused, match="latitude and longitude are swapped") as caught:
        plane.send_and_fly(swapped)
    assert {finding.code for finding in caught.value.findings if finding.severity == "error"} == {"out-of-reach"}
    with pytest.raises(vencejo.InvalidRequest, match="are latitude and longitude swapped"):
        plane.goto(LON, LAT, alt_rel_home_m=50.0)
    with pytest.raises(vencejo.InvalidRequest, match="swapped"):
        plane.set_home(vencejo.Home(LON, LAT, 600.0))
    with pytest.raises(vencejo.InvalidRequest, match=r"500 m below .*below_home"):
        plane.goto(LAT, LON, alt_amsl_m=100.0)
    with pytest.raises(vencejo.InvalidRequest, match=r"50 m below .*below_home"):
        plane.goto(LAT, LON, alt_rel_home_m=-50.0)
    with pytest.raises(vencejo.InvalidRequest, match=r"30 m below .*below_home"):
        plane.set_altitude(alt_rel_home_m=-30.0)
    plane.set_altitude(alt_rel_home_m=-30.0, below_home=True)
    valley = Plan(items=(*MISSION.items[:1], MissionItem.waypoint(LAT + 0.004, LON, alt_rel_home_m=-40.0)))
    state = plane.upload(valley)
    assert {finding.code for finding in state.findings} == {"below-home", "no-landing"}
    assert state == plane.plan_state(), "findings do not make another plan"
    plane.clear(confirm="clear-mission")


def test_raw_messages_both_ways(plane: vencejo.Vehicle) -> None:
    intervals: list[int] = []
    with plane.on_message(lambda message: intervals.append(message.fields["interval_us"]), names=["MESSAGE_INTERVAL"]):
        for rate_hz in (None, 8.0, "stop", 0, "default"):
            plane.set_message_rate(30, rate_hz)
            plane.command("GET_MESSAGE_INTERVAL", 30)
        wait_for(lambda: len(intervals) == 5, "five answers")
    assert intervals[:3] == [-1, 125_000, -1]
    assert intervals[3] == intervals[4], "the plane's own"
    plane.set_message_rate("ATTITUDE", 10.0)
    message = plane.request_message("AUTOPILOT_VERSION")
    assert (message.name, message.system_id) == ("AUTOPILOT_VERSION", 1)
    assert message.fields["flight_sw_version"] > 0
    received: list[vencejo.MavlinkMessage] = []
    subscription = plane.on_message(received.append, names=["PARAM_VALUE"])
    plane.send_message("PARAM_REQUEST_READ", param_id="WP_RADIUS", param_index=-1)
    wait_for(lambda: bool(received), "the answer")
    subscription.close()
    assert received[0].fields["param_id"] == "WP_RADIUS"
    with pytest.raises(vencejo.InvalidRequest, match="NO_SUCH_MESSAGE"):
        plane.send_message("NO_SUCH_MESSAGE")
    with pytest.raises(vencejo.InvalidRequest, match="nothing"):
        plane.send_message("HEARTBEAT", nothing=1)
    with pytest.raises(vencejo.CommandRefused):
        plane.command("DO_MOTOR_TEST")


def test_the_link_is_measured(plane: vencejo.Vehicle) -> None:
    wait_for(lambda: plane.station.links[0].round_trip_ms is not None, "a round trip")
    link = plane.station.links[0]
    assert link.state == "up"
    assert link.frames_received > 0
    assert link.loss_pct == 0.0
    assert link.age_s is not None
    assert plane.link is not None
    assert plane.link.frames_lost == 0


def test_a_stream_gives_fresh_snapshots(plane: vencejo.Vehicle) -> None:
    times = []
    for telemetry in plane.stream(rate_hz=50.0, timeout_s=120.0):
        if telemetry.attitude is not None:
            assert telemetry.attitude.freshness == "fresh"
            times.append(telemetry.time_s)
        if len(times) == 5:
            break
    assert times == sorted(set(times))


def test_heights_above_the_sea_and_above_the_ellipsoid_are_told_apart(plane: vencejo.Vehicle) -> None:
    plane.wait_until(
        lambda now: now.gps is not None and now.position is not None, timeout_s=60.0, what="being somewhere"
    )
    gps, position = plane.telemetry.gps, plane.telemetry.position
    assert gps is not None
    assert gps.alt_ellipsoid_m == pytest.approx(HOME[2] + 51.0, abs=5.0)
    assert (gps.alt_amsl_m, position and position.alt_amsl_m) == pytest.approx((HOME[2], HOME[2]), abs=5.0)


def test_two_stations_watch_one_plane(link: str, plane: vencejo.Vehicle) -> None:
    with vencejo.connect(link, record=False, own_system_id=254) as other:
        other.set_mode("STABILIZE")
        plane.wait_until(lambda telemetry: telemetry.mode == "STABILIZE", timeout_s=120.0)
        other.upload(MISSION)
        wait_for(lambda: plane.plan_state().state == "unknown", "noticing the other station's upload")
        other.clear(confirm="clear-mission")
        other.set_mode("MANUAL")


def test_everything_is_recorded(link: str, tmp_path: Path) -> None:
    with vencejo.connect(link, record=tmp_path) as plane:
        plane.params.get("WP_RADIUS")
        recorder = plane.station.recorder
        assert recorder is not None
        assert recorder.problem is None
    (log,) = tmp_path.glob("*.tlog")
    with vencejo.Station(f"tlog:{log}?speed=1000", record=False) as replay:
        again = replay.wait_vehicle()
        wait_for(lambda: replay.links[0].state == "ended", "the end of the recording")
        assert again.telemetry.heartbeat is not None


def test_closing_ends_what_is_under_way(link: str) -> None:
    plane = vencejo.connect(link, record=False)
    closer = threading.Thread(target=plane.close)
    closer.start()
    with pytest.raises((vencejo.ClosedError, vencejo.CommandTimeout)):
        plane.wait_until(lambda _: plane.params["WP_RADIUS"] < 0, timeout_s=30.0)
    closer.join(30)
    assert not closer.is_alive()


async def test_asyncio_does_the_same(link: str) -> None:
    async with await aio.connect(link, record=False, signing=False) as plane:
        with pytest.raises(vencejo.VencejoError, match="folder"):
            _ = plane.station.signing_keys
        await plane.set_mode("CRUISE")
        assert plane.telemetry.mode == "CRUISE"
        state = await plane.upload(MISSION, progress=lambda done, total: None)
        assert state.state == "verified"
        assert [item.name for item in await plane.download()] == [item.name for item in MISSION]
        assert (await plane.params.get("WP_RADIUS")).value == await plane.params["WP_RADIUS"] == 50.0
        with pytest.raises(TypeError, match=r"not iterable|not a container|not callable"):
            _ = "WP_RADIUS" in plane.params  # type: ignore[misc]
        values = await asyncio.gather(*(plane.params.get(name) for name in ("WP_RADIUS", "AIRSPEED_CRUISE")))
        assert [param.value for param in values] == [50.0, 22.0]
        async for telemetry in plane.stream(rate_hz=50.0):
            if telemetry.position is not None:
                break
        with pytest.raises(vencejo.CommandRefused):
            await plane.command("DO_MOTOR_TEST")
        await plane.switch_fence(False, confirm="fence-off")
        await plane.clear(confirm="clear-mission")
        await plane.set_mode("MANUAL")


async def test_a_cancelled_task_cancels_its_work(link: str) -> None:
    async with await aio.connect(link, record=False) as plane:
        many = Plan(items=tuple(MissionItem.waypoint(LAT, LON, alt_rel_home_m=50.0 + k / 10) for k in range(600)))
        task = asyncio.create_task(plane.upload(many))
        while plane.plan_state().detail.count("transfer") == 0 and not task.done():
            await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert plane.plan_state().state == "unknown"
        await plane.clear(confirm="clear-mission")


def test_a_vehicle_that_falls_silent_is_noticed_and_comes_back() -> None:
    """The simulator is stopped and started again on the same port: telemetry ages, then goes on by itself."""
    with vencejo.Station(record=False) as station, reserved_ports() as (port,):
        with simulated_plane(link=f"tcp:127.0.0.1:{port}") as link:
            station.open_link(link)
            plane = station.wait_vehicle()
            events: list[str] = []
            subscription = plane.on_event(lambda event: events.append(event.kind))
            wait_for(lambda: plane.telemetry.attitude is not None, "telemetry")
        wait_for(lambda: "lost" in events, "noticing the loss")
        heartbeat = plane.telemetry.heartbeat
        assert heartbeat is not None
        assert heartbeat.freshness != "fresh"
        assert station.links[0].state == "connecting"
        with simulated_plane(link=link):
            wait_for(lambda: "regained" in events, "coming back")
            wait_for(lambda: plane.telemetry.attitude is not None, "streams asked again")
            assert plane.plan_state().state == "unknown"
        subscription.close()
