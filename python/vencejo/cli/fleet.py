"""The commands `vencejo fleet …`: who belongs to a fleet, and why one is not there."""

from __future__ import annotations

import contextlib
import sys
import time
from dataclasses import asdict
from datetime import datetime, timezone
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.aboard import link_checks, running
from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    YesOption,
    clean,
    confirm,
    put_json,
    say,
    status,
    stdout,
    table,
    told_when_long,
)

if TYPE_CHECKING:
    from vencejo.enrolment import Check, Member, Organisation, Role
    from vencejo.fleet import FarAircraft

fleet_app = typer.Typer(
    no_args_is_help=True,
    help="Show and change the members of a fleet. Keys are never shown.\n\nExample: vencejo fleet enrol plane7 --fleet acme",
)

OrgOption = Annotated[
    str | None,
    typer.Option("--fleet", metavar="ORG", help="The fleet; by default the one whose authority is on this machine."),
]
NameArgument = Annotated[
    str, typer.Argument(metavar="NAME", help="Name of the aircraft or ground station: 1 to 32 of a-z, 0-9 and '-'.")
]


class StationRole(str, Enum):
    """What a ground station may do."""

    OBSERVER = "observer"
    OPERATOR = "operator"
    CHIEF = "chief"


LOOKS_S = 2.5
"""How long is waited for aircraft that are there to say something: they do each second, or less often where the uplink is slow."""
REJOINS_S = 0.2
"""How long a router may be gone while it reloads the roll, s."""
SILENT_S = 12.0
"""How long a ground station waits for anything at a router that is reached: one that was revoked hears nothing there."""
TRYING = "Still trying who answers: an address where nobody does is given 5 s"
COMES_S = 0.5
"""How long to wait for the router's list of members, s."""


def _organisation(org: str | None) -> Organisation:
    """The fleet that is meant.

    Raises
    ------
    Failed
        When that is not clear.
    """
    from vencejo.enrolment import Organisation, organisations

    if org is None:
        found = organisations()
        if len(found) != 1:
            there = f"{', '.join(found)} are here" if found else "none is here yet"
            raise Failed(f"say which fleet: --fleet ORG ({there})", Exit.USAGE)
        org = found[0]
    return Organisation(org)


def _existing(org: str | None) -> Organisation:
    """The fleet that is meant, which is there.

    Raises
    ------
    Failed
        When it is not.
    """
    organisation = _organisation(org)
    if not organisation.exists:
        raise Failed(
            f"there is no fleet {organisation.org} on this machine; make it with: vencejo fleet init {organisation.org}"
        )
    return organisation


@fleet_app.command()
def init(
    org: Annotated[str, typer.Argument(metavar="ORG", help="The organisation's name: 1 to 32 of a-z, 0-9 and '-'.")],
    host: Annotated[
        list[str] | None,
        typer.Option(
            "--host",
            metavar="HOST",
            help="A name or address by which aircraft reach this machine; repeatable. By default its own name and addresses.",
        ),
    ] = None,
    ca_cert: Annotated[
        Path | None,
        typer.Option("--ca-cert", metavar="FILE", help="Certificate (PEM) of an existing authority."),
    ] = None,
    ca_key: Annotated[Path | None, typer.Option("--ca-key", metavar="FILE", help="Its key (PEM, PKCS #8).")] = None,
    json: JsonOption = False,
) -> None:
    """Make a fleet's own certificate authority, and this ground station's certificate. Again, it changes nothing but --host.

    Example: vencejo fleet init acme

    Example: vencejo fleet init acme --host ground.example.org
    """
    from vencejo._files import read_small
    from vencejo.enrolment import Organisation

    if (ca_cert is None) != (ca_key is None):
        raise Failed("an authority has a certificate and a key: give --ca-cert and --ca-key", Exit.USAGE)
    organisation = Organisation(org)
    made, new = organisation.init(
        hosts=host,
        ca_certificate=None if ca_cert is None else read_small(ca_cert).decode("ascii", errors="replace"),
        ca_key=None if ca_key is None else read_small(ca_key).decode("ascii", errors="replace"),
    )
    if json:
        put_json({"org": org, "made": made, "new_hosts": new, "folder": str(organisation.folder)})
        return
    if made:
        print(
            f"The fleet {org} is made, in {organisation.folder}: ca.key there is what certificates are made with. Keep a copy safe."
        )
    else:
        print(f"The fleet {org} is there, in {organisation.folder}: {len(organisation.aircraft)} aircraft.")
    if new:
        print(f"Aircraft may reach this machine as {', '.join(new)}.")
    elif not made:
        print("Nothing was changed.")


@fleet_app.command()
def enrol(
    name: NameArgument,
    org: OrgOption = None,
    minutes: Annotated[
        int, typer.Option("--minutes", metavar="N", min=1, max=1440, help="How long the token is good, minutes.")
    ] = 60,
    station: Annotated[
        bool, typer.Option("--station", help="Enrol another ground station, which joins with `vencejo serve --join`.")
    ] = False,
    role: Annotated[
        StationRole | None,
        typer.Option(
            "--role",
            help="Its role: observer watches and reads, operator (the default) asks for control, chief takes it at once.",
        ),
    ] = None,
    router: Annotated[
        list[str] | None,
        typer.Option(
            "--router",
            metavar="ADDRESS",
            help="Address at which others reach that ground station as a router, such as tls/hill.example.org:7447. Repeatable.",
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Give out a token that brings one aircraft, or ground station, into a fleet, once; the fleet is made where it is not there.

    Example: vencejo fleet enrol plane7 --fleet acme

    Example: vencejo fleet enrol tower --station --role observer

    Example: vencejo fleet enrol hill --router tls/hill.example.org:7447
    """
    # Only a ground station is a router.
    station = station or bool(router)
    if role is not None and not station:
        raise Failed("a role is for a ground station: give --station too", Exit.USAGE)
    organisation = _organisation(org)
    given: Role | None = (role or StationRole.OPERATOR).value if station else None
    organisation.check_name(name, role=given, routers=router or ())
    if not organisation.exists:
        organisation.init()
        say(f"The fleet {organisation.org} is made, in {organisation.folder}. Keep a copy of ca.key there safe.")
    lasts_s = minutes * 60
    if given is not None:
        token = organisation.enrol_station(name, role=given, routers=router or (), lasts_s=lasts_s)
        command = f"vencejo serve --join {token.text}"
        where = f"At the ground station {name}, within {minutes} minutes; it is shown once:"
    else:
        token = organisation.enrol(name, lasts_s=lasts_s)
        command = f"vencejo onboard --join {token.text} --link /dev/serial0,921600"
        where = f"On board of {name}, within {minutes} minutes; it is shown once (another --link where the autopilot is elsewhere):"
    if json:
        put_json({"token": token.text, "command": command, "doors": list(token.doors), "ends": token.ends.isoformat()})
    else:
        say(where)
        print(command, flush=True)
    port = token.doors[0].rpartition(":")[2]
    with told_when_long(TRYING):
        is_there = not all(organisation.problem_at(f"tls/{door}") for door in (f"127.0.0.1:{port}", token.doors[0]))
    if not is_there:
        say(f"Nobody answers it yet. Start here: vencejo serve --fleet {organisation.org}")


@fleet_app.command("join")
def join_fleet(
    token: Annotated[
        str,
        typer.Argument(
            metavar="TOKEN", help="Token from `vencejo fleet enrol` on the ground; '-' reads it from standard input."
        ),
    ],
    json: JsonOption = False,
) -> None:
    """Bring this computer into a fleet, with a token: as an aircraft, or as another ground station. The same token again changes nothing.

    Example: vencejo fleet join vf1.CiBj...
    """
    found = joined(token)
    if json:
        put_json(_shown(found))
        return
    start = f"serve --fleet {found.org}" if found.is_station else "onboard --link /dev/serial0,921600"
    print(f"This is {found.name} of the fleet {found.org} now{_as_role(found)}. Start it with: vencejo {start}")


def _as_role(found: Member) -> str:
    return f", as {found.role or 'one that is listed no more'}" if found.is_station else ""


def joined(token: str, *, as_station: bool | None = None) -> Member:
    """Join the fleet of a token; gives this computer's place in it.

    Raises
    ------
    Failed
        When it is not for what is meant: a ground station, or an aircraft.
    """
    from vencejo.enrolment import is_for_station, join, member

    if token == "-":
        token = sys.stdin.readline(4096).strip()
    if as_station not in (None, is_for_station(token)):
        wanted, other = ("an aircraft", "onboard") if as_station else ("a ground station", "serve")
        raise Failed(f"this token is for {wanted}: vencejo {other} --join TOKEN", Exit.USAGE)
    before = None
    with contextlib.suppress(Exception):  # a damaged one is replaced
        before = member()
    with told_when_long(TRYING):
        found, is_new = join(token)
    if is_new and not found.is_station and before is not None and (before.org, before.name) != (found.org, found.name):
        say(f"It was {before.name} of {before.org} before.")
    return found


def _shown(found: Member) -> dict[str, Any]:
    return {
        **asdict(found),
        **{key: value.isoformat() for key, value in asdict(found).items() if isinstance(value, datetime)},
    }


@fleet_app.command()
def acl(org: OrgOption = None) -> None:
    """Print the settings of an existing zenohd: encrypted ways alone, and who may say and hear what.

    A router of your own takes them with --config, and has to be started again for each new aircraft, with
    ZENOH_RUNTIME='(rx: (handover: tx))' in its environment: over TLS Zenoh 1.10 may end without. The router in
    `vencejo serve --fleet` needs none of this.

    Example: vencejo fleet acl --fleet acme
    """
    put_json(_existing(org).router_config())


@fleet_app.command("status")
def show_status(org: OrgOption = None, json: JsonOption = False) -> None:
    """Show who is enrolled, when certificates end, who is there and who has control; elsewhere, this computer's place.

    A ground station that joined also shows whether it is connected, and the aircraft that it hears.

    Example: vencejo fleet status

    Example: vencejo fleet status --fleet acme --json
    """
    if (places := _places(org)) is not None:
        looked = [(found, _seen_from(found, quiet=json)) for found in places]
        if json:
            told = [{**_shown(found), **(there if found.is_station else _on_board())} for found, there in looked]
            put_json(told if len(told) > 1 else told[0])
            return
        for found, there in looked:
            print(
                f"{found.name} of the fleet {found.org}{_as_role(found)}; certificate until {found.certificate_ends:%Y-%m-%d}; dials {', '.join(found.routers)}"
            )
            for check in () if found.is_station else link_checks():
                print(clean(f"{check.message[:1].upper()}{check.message[1:]}"))
            if there:
                print(clean(f"Not in the fleet: {there['problem']}" if there["problem"] else "In the fleet"))
            if there and there["aircraft"]:
                shown = table("aircraft", "there", "heard", "control", right=("heard",))
                for far in there["aircraft"]:
                    heard = "–" if far["age_s"] is None else f"{far['age_s']} s ago"
                    shown.add_row(far["name"], "yes" if far["is_present"] else "no", heard, far["holder"] or "–")
                stdout().print(shown)
        return
    organisation = _existing(org)
    router, far = _look(organisation, quiet=json)
    now = datetime.now(timezone.utc)
    rows: list[dict[str, Any]] = []
    for each in organisation.aircraft:
        seen = far.get(each.name)
        is_heard = seen is not None and seen.system_id is not None
        rows.append(
            {
                "name": each.name,
                "certificate_ends": each.certificate_ends.isoformat(),
                "certificate_days": int((each.certificate_ends - now).total_seconds() // 86400),
                "revoked": None if each.revoked is None else each.revoked.isoformat(),
                "is_present": None if router is None else seen is not None and seen.is_present,
                "age_s": round(seen.age_s, 1) if seen is not None and is_heard else None,
                "autopilot_silent_s": None
                if seen is None or seen.autopilot_silent_s is None
                else round(seen.autopilot_silent_s, 1),
                "links": None if seen is None else seen.links,
                "holder": None if seen is None else seen.holder,
            }
        )
    with told_when_long(TRYING):
        stations: list[dict[str, Any]] = [
            {
                "name": each.name,
                "role": each.role,
                "routers": [{"address": router, "problem": organisation.problem_at(router)} for router in each.routers]
                if each.revoked is None
                else [],
                "certificate_ends": each.certificate_ends.isoformat(),
                "certificate_days": int((each.certificate_ends - now).total_seconds() // 86400),
                "revoked": None if each.revoked is None else each.revoked.isoformat(),
            }
            for each in organisation.stations
        ]
    tokens = {name: ends.isoformat() for name, ends in organisation.tokens.items()}
    station_tokens = {name: ends.isoformat() for name, ends in organisation.station_tokens.items()}
    if json:
        put_json(
            {
                "org": organisation.org,
                "router": router,
                "aircraft": rows,
                "stations": stations,
                "tokens": tokens,
                "station_tokens": station_tokens,
            }
        )
        return
    print(
        f"Fleet {organisation.org}: "
        + (f"router at {router}" if router else f"no router; start it: vencejo serve --fleet {organisation.org}")
    )
    shown = table("aircraft", "certificate", "there", "heard", "autopilot", "control", right=("heard",))
    for row in rows:
        present = "revoked" if row["revoked"] else {None: "–", True: "yes", False: "no"}[row["is_present"]]
        ends = f"{row['certificate_ends'][:10]}" + (" soon!" if row["certificate_days"] < 20 else "")
        heard = "–" if row["age_s"] is None else f"{row['age_s']} s ago"
        shown.add_row(row["name"], ends, present, heard, _autopilot(row), row["holder"] or "–")
    stdout().print(shown)
    for row in rows:
        if row["autopilot_silent_s"] is not None:
            print(clean(f"Nothing of the autopilot of {row['name']} is heard on board: {row['links']}"))
    if stations:
        shown = table("ground station", "certificate", "role")
        for row in stations:
            ends = f"{row['certificate_ends'][:10]}" + (" soon!" if row["certificate_days"] < 20 else "")
            shown.add_row(row["name"], ends, "revoked" if row["revoked"] else row["role"])
        stdout().print(shown)
    for row in stations:
        for router in row["routers"]:
            print(f"The router of {row['name']} at {router['address']}: {clean(router['problem'] or 'it answers')}")
    for name, ends in (*tokens.items(), *station_tokens.items()):
        print(f"A token for {name} is out until {ends[:16].replace('T', ' ')} UTC.")


def _autopilot(row: dict[str, Any]) -> str:
    """What the station on board hears of its autopilot, if it is there itself."""
    if row["autopilot_silent_s"] is not None:
        return f"silent for {row['autopilot_silent_s']:.0f} s"
    return "heard" if row["is_present"] and row["age_s"] is not None else "–"


def _places(org: str | None) -> list[Member] | None:
    """The places that this computer has in fleets by tokens; ``None`` where it has the authority of the one that is meant.

    Raises
    ------
    Failed
        When it is in no fleet at all.
    """
    from vencejo.enrolment import Organisation, member, organisations, station_file, station_places

    if org is not None and (Organisation(org).exists or not station_file(org).is_file()):
        return None
    if org is None and organisations():
        return None
    places = [member(file=station_file(each)) for each in ([org] if org else station_places())]
    if org is None:
        places.insert(0, member())
    found = [place for place in places if place is not None]
    if not found:
        raise Failed(
            "this computer is in no fleet: vencejo fleet init ORG on the ground, vencejo fleet join TOKEN elsewhere"
        )
    return found


def _on_board() -> dict[str, Any]:
    """The links of the running `vencejo onboard`."""
    planes = running()
    return {"onboard": None if planes is None else [plane.as_json() for plane in planes]}


def _seen_from(found: Member, *, quiet: bool) -> dict[str, Any]:
    """Whether a ground station that joined is connected now, and the aircraft heard there; empty for others.

    A router of the fleet is asked nothing: only `vencejo serve` there can be it.
    """
    from vencejo import Station
    from vencejo.errors import LinkError
    from vencejo.fleet import Fleet

    if not found.is_station or found.is_router:
        return {}
    waiting = contextlib.nullcontext() if quiet else status("Looking who is there")
    try:
        with (
            waiting,
            Station(record=False, heartbeat=False) as station,
            Fleet(station, org=found.org, history=False) as fleet,
        ):
            deadline = time.monotonic() + SILENT_S
            while True:
                far = fleet.aircraft
                is_missing = any(each.is_present and each.system_id is None for each in far)
                problem = fleet.status.problem
                left_s = deadline - time.monotonic()
                if problem or left_s <= 0 or (far and not is_missing and left_s <= SILENT_S - LOOKS_S):
                    break
                time.sleep(0.05)
    except LinkError as error:
        problem, far = str(error), []
    rows = [
        {
            "name": each.name,
            "is_present": each.is_present,
            "age_s": None if each.system_id is None else round(each.age_s, 1),
            "holder": each.holder,
        }
        for each in far
    ]
    return {"is_connected": problem is None, "problem": problem, "aircraft": rows}


def _look(organisation: Organisation, *, quiet: bool) -> tuple[str | None, dict[str, FarAircraft]]:
    """The router where it is reached, and what aircraft say there."""
    from vencejo.errors import LinkError

    waiting = contextlib.nullcontext() if quiet else status("Looking who is there")
    with waiting:
        # Only the second time: a router is gone for a moment while it reloads the roll.
        for _ in range(2):
            router = organisation.reachable_router()
            if router is not None:
                with contextlib.suppress(LinkError):
                    return router, _seen_at(organisation, router)
            time.sleep(REJOINS_S if organisation.routers else 0.0)
    return None, {}


def _seen_at(organisation: Organisation, router: str) -> dict[str, FarAircraft]:
    """What aircraft say at a router, by name."""
    from vencejo import Station
    from vencejo.fleet import Fleet

    expected = {each.name for each in organisation.aircraft if each.revoked is None}
    with (
        Station(record=False, heartbeat=False) as station,
        Fleet(station, org=organisation.org, router=router, history=False) as fleet,
    ):
        began = time.monotonic()
        while True:
            far = {each.name: each for each in fleet.aircraft}
            # The links of a silent autopilot come a moment after its first state.
            heard = {name for name, each in far.items() if each.system_id is not None and each.links != ""}
            there = {name for name, each in far.items() if each.is_present}
            passed_s = time.monotonic() - began
            if heard >= expected or passed_s >= LOOKS_S or (passed_s >= COMES_S and heard >= there):
                return far
            time.sleep(0.05)


@fleet_app.command()
def doctor(org: OrgOption = None, json: JsonOption = False) -> None:
    """Find what keeps an aircraft out of the list: keys, certificates, clock, addresses, TLS. Says what to do; ends with 1 if anything.

    Example: vencejo fleet doctor
    """
    with told_when_long(TRYING):
        checks = _checked(org)
    if json:
        put_json([asdict(check) for check in checks])
    else:
        for check in checks:
            print(
                clean(
                    f"{'ok   ' if check.ok else 'wrong'}  {check.message}"
                    + (f"\n       → {check.remedy}" if check.remedy else ""),
                    keep_lines=True,
                )
            )
    if not all(check.ok for check in checks):
        raise typer.Exit(1)


def _checked(org: str | None) -> list[Check]:
    from vencejo.enrolment import Check, check_board, check_ground

    checks: list[Check] = []
    if (places := _places(org)) is not None:
        for found in places:
            checks += check_board(found)
            checks += [] if found.is_station else link_checks()
    else:
        organisation = _organisation(org)
        checks += check_ground(organisation)
        if organisation.exists and any(each.revoked is None for each in organisation.aircraft):
            router, far = _look(organisation, quiet=True)
            for each in organisation.aircraft if router else ():
                if each.revoked is None and not (each.name in far and far[each.name].is_present):
                    remedy = (
                        "is `vencejo onboard` running there? On board: vencejo fleet doctor. Has a router of your own (zenohd) "
                        "the newest settings? vencejo fleet acl"
                    )
                    checks.append(
                        Check(ok=False, message=f"the router is reached, and {each.name} is not there", remedy=remedy)
                    )
                elif each.revoked is None and (silent_s := far[each.name].autopilot_silent_s) is not None:
                    message = (
                        f"{each.name} is there, and its autopilot has been silent for {silent_s:.0f} s: "
                        f"{far[each.name].links}"
                    )
                    remedy = "on board: check the cable, the baud rate, and that the autopilot is on"
                    checks.append(Check(ok=False, message=message, remedy=remedy))
    return checks


@fleet_app.command()
def revoke(
    name: NameArgument,
    station: Annotated[bool, typer.Option("--station", help="It is a ground station.")] = False,
    org: OrgOption = None,
    yes: YesOption = False,
) -> None:
    """Put an aircraft, or another ground station, out for good. A running `vencejo serve --fleet` shuts it out within seconds.

    Aircraft take no orders of such a station any more as soon as they are told. A name is free again when its last
    certificate has ended.

    Example: vencejo fleet revoke plane7

    Example: vencejo fleet revoke tower --station
    """
    organisation = _existing(org)
    if not confirm(f"Put {name} out of the fleet {organisation.org}?", yes=yes):
        raise Failed("nothing was changed")
    if station:
        organisation.revoke_station(name)
    else:
        organisation.revoke(name)
    print(f"{name} is out. A router of your own (zenohd) has to be given its new settings: vencejo fleet acl")
