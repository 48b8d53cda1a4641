"""Connects a command to an aircraft of a fleet, through the fleet's router."""

from __future__ import annotations

import contextlib
import difflib
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from vencejo.cli.common import Exit, Failed, status, told_when_long
from vencejo.cli.fleet import COMES_S, REJOINS_S, TRYING

if TYPE_CHECKING:
    from vencejo.fleet import FarAircraft, Fleet
    from vencejo.vehicle import Vehicle

__all__ = ["far_vehicle"]


@contextlib.contextmanager
def far_vehicle(
    org: str | None, plane: str | None, *, router: str | None, timeout_s: float, take_control: bool
) -> Iterator[Vehicle]:
    """An aircraft of a fleet, as long as the block runs.

    Raises
    ------
    Failed
        When the fleet or the aircraft is unknown or not reached, and when somebody else has control.
    LinkError
    """
    from vencejo import Station
    from vencejo.errors import ControlHeld, NoVehicleError
    from vencejo.fleet import Fleet

    org = _fleet(org)
    _check_enrolled(org, plane)
    with told_when_long(TRYING):
        routers = [router] if router else _routers(org)
    with (
        Station(record=False, heartbeat=False) as station,
        Fleet(station, org=org, router=routers, overrules=take_control, history=False) as fleet,
    ):
        if plane is None:
            time.sleep(COMES_S)
            raise _unnamed([far.name for far in fleet.aircraft])
        try:
            with status(f"Waiting for {plane} of the fleet {org} …"):
                vehicle = station.wait_vehicle(name=plane, timeout_s=timeout_s)
        except NoVehicleError as error:
            if (far := _seen(fleet, plane)) is not None and far.is_present:
                message = f"{plane} is connected, but its autopilot was not heard within {timeout_s:g} s"
                raise Failed(f"{message}; on board: vencejo fleet doctor") from error
            if (problem := fleet.status.problem) is not None:
                raise Failed(f"{plane} was not heard within {timeout_s:g} s: {problem}") from error
            raise
        try:
            yield vehicle
        except ControlHeld as held:
            # Told at the first order that it refuses: what came before is done.
            advice = (
                "it was taken back, or this station does not overrule that one"
                if take_control
                else "--take-control takes it from anybody at this same station and, as a chief, from an operator of another"
            )
            raise Failed(f"{held.holder} has control of {plane}: wait until it is given up; {advice}") from held


def _seen(fleet: Fleet, plane: str) -> FarAircraft | None:
    return next((far for far in fleet.aircraft if far.name == plane), None)


def _fleet(org: str | None) -> str:
    """The fleet that is meant, which this computer is in."""
    from vencejo.enrolment import default_key_file, organisations, station_places

    here = sorted({*organisations(), *station_places()})
    listed = f"{', '.join(here)} {'is' if len(here) == 1 else 'are'} here" if here else "none is here yet"
    if org is None:
        if len(here) != 1:
            raise Failed(f"say which fleet: --fleet ORG ({listed})", Exit.USAGE)
        return here[0]
    # Without encryption a ground station has nothing but its key.
    if org not in here and not default_key_file(org).is_file():
        raise Failed(f"this computer is not a ground station of a fleet {org} ({listed})")
    return org


def _check_enrolled(org: str, plane: str | None) -> None:
    """Refuse a name that the fleet's authority has not enrolled, if that is on this machine."""
    from vencejo.enrolment import Organisation

    organisation = Organisation(org)
    if not organisation.exists:
        return
    enrolled = {each.name: each for each in organisation.aircraft}
    if plane is None:
        raise _unnamed([name for name, each in enrolled.items() if each.revoked is None])
    if plane not in enrolled:
        near = difflib.get_close_matches(plane, enrolled, n=3) or sorted(enrolled)
        raise Failed(f"there is no {plane} in the fleet {org}; enrolled: {_listed(near)}")
    if enrolled[plane].revoked is not None:
        raise Failed(f"{plane} was revoked, and is no longer in the fleet {org}")


def _unnamed(names: Sequence[str]) -> Failed:
    return Failed(f"say which aircraft: --plane NAME ({_listed(names)})", Exit.USAGE)


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:20])
    return (shown + (" …" if len(names) > 20 else "")) or "none"


def _routers(org: str) -> list[str]:
    """Addresses to dial: the router on this machine, else those of the fleet that are known here."""
    from vencejo.enrolment import Organisation, member, station_file
    from vencejo.fleet import router_here

    organisation = Organisation(org)
    # Only the second time: a router is gone for a moment while it reloads the roll.
    for pause_s in (REJOINS_S, 0.0):
        if (here := router_here(org)) is not None:
            return [here]
        if organisation.exists:
            if (router := organisation.reachable_router()) is not None:
                return [router]
        elif (place := member(file=station_file(org))) is not None:
            return list(place.routers)
        time.sleep(pause_s)
    raise Failed(f"no router of the fleet {org} answers; start one with: vencejo serve --fleet {org}")
