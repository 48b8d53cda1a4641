"""Rehearsals of flights, as tracks."""

from __future__ import annotations

import bisect

from vencejo.rehearsal import rehearse

from bench.flights.track import Flight, Sample, Track


def rehearsal_of(flight: Flight) -> Track:
    """Return the track of a flight's plan, rehearsed with the flight's data."""
    # The plan does not contain the runway's direction.
    heading_deg = flight.track.takeoff_course_deg
    found = rehearse(
        flight.plan,
        parameters=flight.parameters,
        wind=flight.wind,
        heading_deg=heading_deg,
        airframe=flight.airframe,
    )
    home = flight.plan.home
    assert home is not None, "a flight's plan has a home"
    # Like MISSION_CURRENT: an item is current until the next one is, including in a return and on the ground.
    begins_s = [passage.begins_s for passage in found.passages]
    samples = [
        Sample(
            time_s=moment.time_s,
            lat_deg=moment.lat_deg,
            lon_deg=moment.lon_deg,
            alt_rel_home_m=moment.alt_rel_home_m,
            climb_m_s=moment.climb_m_s,
            groundspeed_m_s=moment.groundspeed_m_s,
            bank_deg=moment.bank_deg,
            item=found.passages[max(0, bisect.bisect_right(begins_s, moment.time_s) - 1)].item,
        )
        for moment in found.track
    ]
    return Track.of(samples, home=home, name=flight.name)
