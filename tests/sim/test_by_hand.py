"""A plane moved by hand: all messages agree on its attitude, in all three axes, at rest and during a turn."""

from __future__ import annotations

import math
from typing import Any

import pytest
from vencejo.sim import SimOptions, SimulatedPlane
from vencejo.sim.autopilot.interface import DT_S, MavResult, Mode
from vencejo.sim.hand import BY_HAND
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.sensors import _dipole_field_mgauss
from vencejo.sim.world import MemoryLink, World

from tests.sim.flying import make

ATTITUDE, POSITION, HUD, RAW_IMU, SCALED_IMU2 = 30, 33, 74, 27, 116


def messages(link: MemoryLink, world: World, *numbers: int) -> list[Any]:
    """One message of each type, all of one instant."""
    link.receive()
    for number in numbers:
        link.send(dialect.MAVLink_command_long_message(1, 1, 512, 0, number, 0, 0, 0, 0, 0, 0))
    wanted = {dialect.mavlink_map[number].msgname: None for number in numbers}
    for message in link.receive():
        if message.get_type() in wanted:
            wanted[message.get_type()] = message
    assert None not in wanted.values(), wanted
    return list(wanted.values())


def off_deg(a_deg: float, b_deg: float) -> float:
    return abs((a_deg - b_deg + 180.0) % 360.0 - 180.0)


def attitude_of(imu: Any, declination_deg: float) -> tuple[float, float, float]:
    """Roll, pitch and true heading from gravity and the magnetic field alone (M. Caruso 2000, tilt-compensated compass)."""
    roll = math.atan2(-imu.yacc, -imu.zacc)
    pitch = math.atan2(imu.xacc, math.hypot(imu.yacc, imu.zacc))
    x, y, z = imu.xmag, imu.ymag, imu.zmag
    level_y = y * math.cos(roll) - z * math.sin(roll)
    lower = y * math.sin(roll) + z * math.cos(roll)
    level_x = x * math.cos(pitch) + lower * math.sin(pitch)
    heading = math.degrees(math.atan2(-level_y, level_x)) + declination_deg
    return math.degrees(roll), math.degrees(pitch), heading % 360.0


@pytest.fixture
def world() -> World:
    world = World(SimOptions(seed=4))
    world.advance(22.0)
    return world


def test_gravity_field_attitude_and_headings_agree(world: World) -> None:
    link = world.connect()
    north, east, _ = _dipole_field_mgauss(40.3332, -3.7978)
    declination_deg = math.degrees(math.atan2(east, north))
    for roll_deg, pitch_deg, yaw_deg in (
        (0, 0, 0), (60, 0, 90), (-60, 0, 200), (0, 45, 300), (0, -45, 10), (45, -30, 123), (-120, 20, 250), (180, 0, 5),
    ):  # fmt: skip
        world.hold(roll_deg, pitch_deg, yaw_deg)
        world.advance(0.2)
        attitude, position, hud, *imus = messages(link, world, ATTITUDE, POSITION, HUD, RAW_IMU, SCALED_IMU2)
        assert off_deg(math.degrees(attitude.roll), roll_deg) < 1.0
        assert off_deg(math.degrees(attitude.pitch), pitch_deg) < 1.0
        yaw = math.degrees(attitude.yaw)
        assert off_deg(yaw, yaw_deg) < 2.0
        assert off_deg(position.hdg / 100.0, yaw) < 0.01
        assert off_deg(hud.heading, yaw) <= 1.0
        for imu in imus:
            assert math.hypot(imu.xacc, imu.yacc, imu.zacc) == pytest.approx(1000, abs=25)
            felt = attitude_of(imu, declination_deg)
            for is_deg, true_deg in zip(felt, (roll_deg, pitch_deg, yaw_deg), strict=True):
                assert off_deg(is_deg, true_deg) < 2.5, (felt, roll_deg, pitch_deg, yaw_deg)


def test_the_gyroscopes_feel_the_turn_and_only_the_turn() -> None:
    flight = make(heading_deg=80)
    plane = flight.plane
    plane.move_by_hand(0.0, 0.0, math.radians(80), seconds=0.0)
    plane.step()
    plane.move_by_hand(0.0, 0.0, math.radians(170), seconds=2.0)
    turned = 0.0
    for _ in range(200):
        plane.step()
        p, q, r = plane.snapshot().gyro_rad_s
        assert abs(p) < 0.02
        assert abs(q) < 0.02
        turned += r * DT_S
    assert math.degrees(turned) == pytest.approx(90, abs=0.7)
    assert plane.snapshot().heading_deg == pytest.approx(170, abs=2)
    # At rest in a new attitude, each axis measures its own component.
    for axis, target in enumerate(((0.9, 0.0), (0.0, 0.9))):
        plane.move_by_hand(0.0, 0.0, math.radians(170))
        plane.step()
        plane.move_by_hand(*target, math.radians(170), seconds=1.0)
        angle = [0.0, 0.0, 0.0]
        for _ in range(100):
            plane.step()
            for k, rate in enumerate(plane.snapshot().gyro_rad_s):
                angle[k] += rate * DT_S
        assert angle[axis] == pytest.approx(0.9, abs=0.01)
        assert abs(angle[2]) < 0.01


def test_a_carried_plane_moves_on_the_map_and_is_put_down_there() -> None:
    flight = make()
    plane = flight.plane
    plane.move_by_hand(0.0, 0.0, 0.0, seconds=10.0, offset_ned_m=(30.0, -40.0, -1.5))
    fastest = 0.0
    for _ in range(1000):
        plane.step()
        fastest = max(fastest, plane.est.groundspeed_m_s)
    north, east = flight.position()
    assert (north, east) == pytest.approx((30, -40), abs=0.3)
    assert plane.body.height_m == pytest.approx(1.5, abs=0.01)
    assert 5.0 < fastest < 10.0
    assert not plane.is_flying
    plane.put_down()
    flight.run(1)
    assert flight.position() == pytest.approx((30, -40), abs=0.5)
    assert abs(plane.body.height_m) < 0.05


def test_only_a_disarmed_plane_on_the_ground_is_taken_in_the_hand() -> None:
    flight = make()
    assert flight.plane.arm() is MavResult.ACCEPTED
    with pytest.raises(RuntimeError, match="armed"):
        flight.plane.move_by_hand(0.0, 0.0, 0.0)
    assert flight.plane.set_mode(Mode.TAKEOFF) is MavResult.ACCEPTED
    assert flight.run(30, lambda: flight.plane.body.height_m > 20)
    flight.plane.disarm(force=True)
    with pytest.raises(RuntimeError, match="on the ground"):
        flight.plane.move_by_hand(0.0, 0.0, 0.0)


def test_numbers_that_are_none_are_refused(world: World) -> None:
    with pytest.raises(ValueError, match="finite"):
        world.hold(float("nan"), 0.0, 0.0)


def test_the_command_line_shows_every_attitude_in_turn() -> None:
    world = World(SimOptions(by_hand=True, heading_deg=350.0))
    plane = world.planes[0]
    world.advance(4.9)
    assert abs(math.degrees(plane.snapshot().roll_rad)) < 2
    shown = 0
    for pose in BY_HAND:
        # Half a second before the next one begins.
        world.advance(3.6)
        now = plane.snapshot()
        assert off_deg(math.degrees(now.roll_rad), pose.roll_deg) < 1.5, pose
        assert off_deg(math.degrees(now.pitch_rad), pose.pitch_deg) < 1.5, pose
        assert off_deg(now.heading_deg, 350.0 + pose.turned_deg) < 2.5, pose
        world.advance(0.4)
        shown += 1
    assert shown == len(BY_HAND) >= 12


def test_the_running_simulator_hands_it_over() -> None:
    with SimulatedPlane(SimOptions(links=("tcp:127.0.0.1:0",), speedup=float("inf"))) as sim:
        sim.hold(30.0, -10.0, 120.0)

        def shown(world: World) -> tuple[float, float]:
            world.advance(2.0)  # however early in its start: the heading is shown from 1.6 s on
            now = world.planes[0].snapshot()
            return math.degrees(now.roll_rad), now.heading_deg

        roll_deg, heading_deg = sim.call(shown)
        assert roll_deg == pytest.approx(30, abs=1)
        assert heading_deg == pytest.approx(120, abs=2)
        sim.release()
        assert sim.call(lambda world: not world.planes[0].autopilot.body.held)  # type: ignore[attr-defined]
