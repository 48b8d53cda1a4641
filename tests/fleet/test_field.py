"""Several planes behind each of several stations on board, two ground stations and two routers of Zenoh's own, with what goes wrong in the field."""

from __future__ import annotations

import pytest
from vencejo.fleet import has_fleet

from bench.far.field import Ground, field_of
from tests.support import Metronome, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")

LOST_S = 5.0
"""Silence after which a vehicle is shown as lost."""


def are_heard(ground: Ground, names: list[str]) -> bool:
    """Whether all are shown as there."""
    vehicles = ground.vehicles()
    return all(ground.age_s(f"vehicles/{vehicles[name]['system_id']}") < 2.0 for name in names)


@pytest.mark.e2e
def test_planes_go_to_the_other_router_and_a_frozen_station_is_missed_and_comes_back() -> None:
    with field_of(planes=3, boards=2, grounds=2, routers=2) as field:
        ana, luis = field.grounds
        assert [board.planes for board in field.boards] == [["plane1", "plane3"], ["plane2"]]
        ana.client.done("POST", "control/take")
        ana.client.done("POST", f"{ana.at('plane1')}/mode", {"mode": "FBWA"})
        wait_for(lambda: luis.vehicles()["plane1"]["mode"] == "FBWA", "the mode, at the other one too")

        # All aircraft and one ground station are at the first router.
        with Metronome() as clock:
            field.routers[0].kill()
            silence = {id(ground): 0.0 for ground in field.grounds}
            killed_s = clock.now_s

            def both_hear() -> bool:
                for ground in field.grounds:
                    ages = [ground.age_s(ground.at(name)) for name in field.planes]
                    silence[id(ground)] = max(silence[id(ground)], *ages)
                # Nothing that was heard before counts.
                return clock.now_s > killed_s + 3.0 and all(are_heard(ground, field.planes) for ground in field.grounds)

            wait_for(both_hear, "all planes over the other router")
            late_s = max(0.0, clock.longest_s - Metronome.TICK_S)
            assert max(silence.values()) < LOST_S + 4 * late_s, "nobody is shown as lost"
        ana.client.done("POST", f"{ana.at('plane3')}/mode", {"mode": "MANUAL"})
        wait_for(lambda: luis.vehicles()["plane3"]["mode"] == "MANUAL", "the mode")

        # Behind one that hangs nobody is heard, and behind the other everybody is.
        field.boards[0].freeze()
        wait_for(lambda: ana.age_s(ana.at("plane1")) > LOST_S, "the frozen one's silence")
        assert are_heard(ana, ["plane2"])
        with Metronome() as clock:
            field.boards[0].thaw()
            wait_for(lambda: are_heard(ana, field.planes), "all of them")
            assert clock.now_s < 5.0
        ana.client.done("POST", f"{ana.at('plane1')}/mode", {"mode": "FBWA"})
