"""Fleet membership: the certificate authority and roll of a fleet on the ground, and the membership of other computers.

`Organisation` creates the authority, issues tokens and revokes members. `join` enrols this computer with a token; from
then on `vencejo.fleet.Aircraft`, or `vencejo.fleet.Fleet` at another ground station, needs none. `check_ground` and
`check_board` find out why an aircraft is missing from the list.

Keys are stored in files that only their owner can read, and never returned. A token is returned by `Organisation.enrol`
once, and stored nowhere.
"""

from __future__ import annotations

import json
import os
import re
import socket
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Literal, TypeAlias

from vencejo import _native
from vencejo.errors import NotPossibleNow, VencejoError
from vencejo.serve import own_addresses
from vencejo.station import default_record_dir

__all__ = [
    "Check",
    "Enrolled",
    "EnrolledStation",
    "Member",
    "Organisation",
    "Token",
    "check_board",
    "check_ground",
    "default_hosts",
    "default_key_file",
    "fleet_folder",
    "is_for_station",
    "join",
    "member",
    "member_file",
    "organisations",
    "station_file",
    "station_places",
]

Role: TypeAlias = Literal["observer", "operator", "chief"]
"""Permissions of a ground station: watch and read; act while it has control, for which it asks; take control from operators at once."""

TOKEN_LASTS_S = 3600
"""Default validity of a token, s."""


def native(name: str) -> Any:
    """An attribute of the native module that builds without fleets lack.

    Raises
    ------
    VencejoError
        In such a build.
    """
    if not hasattr(_native, name):
        raise VencejoError(
            "this build of Vencejo has no fleets: in a checkout run `make native`, elsewhere install a wheel"
        )
    return getattr(_native, name)


def fleet_folder() -> Path:
    """Folder of the fleets: ``fleet`` in the data folder."""
    return default_record_dir().parent / "fleet"


def member_file() -> Path:
    """File of the membership of the aircraft that carries this computer: ``fleet/aboard.json`` in the data folder."""
    return fleet_folder() / "aboard.json"


def station_file(org: str) -> Path:
    """File of this ground station's membership in another station's fleet: ``fleet/ORG.json`` in the data folder."""
    return fleet_folder() / f"{org}.json"


def default_key_file(org: str) -> Path:
    """File of a ground station's own key: ``fleet/ORG.key`` in the data folder, readable by its owner alone."""
    return fleet_folder() / f"{org}.key"


def station_places() -> list[str]:
    """Names of the fleets that this machine has joined as a ground station."""
    return sorted(path.stem for path in fleet_folder().glob("*.json") if path != member_file())


def organisations() -> list[str]:
    """Names of the fleets whose authority is on this machine."""
    return sorted(path.parent.name for path in fleet_folder().glob("*/roll.json"))


def default_hosts() -> list[str]:
    """Names and addresses of this machine for others: its name in the local network, its addresses, its bare name."""
    name = socket.gethostname()
    found = [f"{name}.local", *own_addresses(), name] if "." not in name else [name, *own_addresses()]
    return [host for host in found if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]{0,252}", host)]


def _moment(unix_s: int) -> datetime:
    return datetime.fromtimestamp(unix_s, timezone.utc)


def _maybe(unix_s: int | None) -> datetime | None:
    return None if unix_s is None else _moment(unix_s)


@dataclass(frozen=True, kw_only=True)
class Token:
    """A token that enrols one aircraft or ground station, once.

    Attributes
    ----------
    text : str
        The token, a secret: whoever has it can join under that name.
    doors : tuple of str
        Addresses where it is accepted, ``HOST:PORT``.
    ends : datetime
        When it expires (UTC).
    """

    text: str
    doors: tuple[str, ...]
    ends: datetime

    def __repr__(self) -> str:
        return f"Token(doors={self.doors!r}, ends={self.ends.isoformat()!r})"


@dataclass(frozen=True, kw_only=True)
class Enrolled:
    """An aircraft on the roll.

    Attributes
    ----------
    name : str
        Its name.
    enrolled, certificate_ends : datetime
        When it was enrolled, and when its newest certificate expires (UTC).
    revoked : datetime or None
        When it was revoked.
    """

    name: str
    enrolled: datetime
    certificate_ends: datetime
    revoked: datetime | None


@dataclass(frozen=True, kw_only=True)
class EnrolledStation:
    """Another ground station on the roll.

    Attributes
    ----------
    name : str
        Its name.
    role : str
        ``"observer"``, ``"operator"`` or ``"chief"``.
    routers : tuple of str
        Its addresses as a router of the fleet, as others reach it; empty if it is not a router.
    enrolled, certificate_ends : datetime
        When it was enrolled, and when its newest certificate expires (UTC).
    revoked : datetime or None
        When it was revoked.
    """

    name: str
    role: Role
    routers: tuple[str, ...]
    enrolled: datetime
    certificate_ends: datetime
    revoked: datetime | None


@dataclass(frozen=True, kw_only=True)
class Member:
    """The membership of an aircraft, or of another ground station, in a fleet.

    Attributes
    ----------
    org, name : str
        The organisation, and its name there.
    is_station : bool
        Whether it is a ground station.
    role : str or None
        Role of a ground station by its newest list: ``"observer"``, ``"operator"`` or ``"chief"``; ``None`` for an
        aircraft, and for a station that is no longer on the list.
    is_router : bool
        Whether it is a router of the fleet, too.
    certificate_begins, certificate_ends : datetime
        Validity of its certificate (UTC).
    routers, doors : tuple of str
        Addresses of the fleet's routers, and those where its certificate is renewed.
    """

    org: str
    name: str
    is_station: bool
    role: Role | None
    is_router: bool
    certificate_begins: datetime
    certificate_ends: datetime
    routers: tuple[str, ...]
    doors: tuple[str, ...]


class Organisation:
    """A fleet's authority and roll, on the ground.

    Parameters
    ----------
    org : str
        Its name: 1 to 32 of ``a-z``, ``0-9`` and ``-``.
    folder : path, optional
        Folder of the fleets; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For an invalid name.
    """

    def __init__(self, org: str, *, folder: str | Path | None = None) -> None:
        self.org = org
        self.folder = (fleet_folder() if folder is None else Path(folder)) / org
        self._native = native("FleetOrganisation")(self.folder.parent, org)

    @property
    def exists(self) -> bool:
        """Whether it has been created."""
        return bool(self._native.exists())

    def init(
        self, *, hosts: Iterable[str] | None = None, ca_certificate: str | None = None, ca_key: str | None = None
    ) -> tuple[bool, list[str]]:
        """Create the authority, if it does not exist, and the ground station's own certificate. Repeating it changes nothing.

        Parameters
        ----------
        hosts : iterable of str, optional
            Names and addresses by which aircraft reach this machine; for a new authority by default `default_hosts`.
            New ones are added to an existing authority.
        ca_certificate, ca_key : str, optional
            An existing authority of the organisation, as PEM, instead of a new one.

        Returns
        -------
        tuple of bool and list of str
            Whether the authority was created now, and the new hosts.

        Raises
        ------
        InvalidRequest
            For an invalid host, or an authority that cannot sign.
        VencejoError
            When the files cannot be read or written, or a different authority exists.
        """
        if hosts is None:
            hosts = [] if self.exists else default_hosts()
        given = None if ca_certificate is None or ca_key is None else (ca_certificate, ca_key)
        made, new = self._native.init(list(hosts), given)
        return bool(made), list(new)

    def check_name(self, name: str, *, role: Role | None = None, routers: Iterable[str] = ()) -> None:
        """Check a name for an aircraft, or with a role a name and addresses for a ground station. Nothing is changed.

        Parameters
        ----------
        name : str
            As in `enrol` and `enrol_station`.
        role : str, optional
            As in `enrol_station`.
        routers : iterable of str
            As in `enrol_station`.

        Raises
        ------
        InvalidRequest
            For an invalid name, role or address.
        NotPossibleNow
            For the name of the ground station that has the authority.
        """
        self._native.check_newcomer(name, role, list(routers))

    def enrol(self, name: str, *, lasts_s: int = TOKEN_LASTS_S) -> Token:
        """Issue a token for an aircraft. An older one for it becomes void.

        Parameters
        ----------
        name : str
            The aircraft's name: 1 to 32 of ``a-z``, ``0-9`` and ``-``.
        lasts_s : int
            Validity, s.

        Raises
        ------
        InvalidRequest
            For an invalid name.
        NotPossibleNow
            When an aircraft of that name was revoked, and its old certificate has not expired.
        """
        return self._token(name, lasts_s, None)

    def enrol_station(
        self, name: str, *, role: Role = "operator", routers: Iterable[str] = (), lasts_s: int = TOKEN_LASTS_S
    ) -> Token:
        """Issue a token for another ground station. An older one for it becomes void.

        Aircraft receive its key and role in a list that the authority signs, within seconds if they are connected.

        Parameters
        ----------
        name : str
            The station's name: 1 to 32 of ``a-z``, ``0-9`` and ``-``; not ``ground``, the station with the authority.
        role : str
            ``"observer"``, which watches and reads; ``"operator"``, which asks for control; or ``"chief"``, which takes
            it from operators at once.
        routers : iterable of str
            Its addresses as a router of the fleet, as others reach it, such as ``"tls/hill.example.org:7447"``. They
            are published to aircraft and stations, and its certificate is valid for these names. Default: none.
        lasts_s : int
            Validity, s.

        Raises
        ------
        InvalidRequest
            For an invalid name, role or address.
        NotPossibleNow
            When a station of that name was revoked, and its old certificate has not expired.
        """
        return self._token(name, lasts_s, role, routers)

    def _token(self, name: str, lasts_s: int, role: Role | None, routers: Iterable[str] = ()) -> Token:
        text, doors, ends = self._native.enrol(name, lasts_s, role, list(routers))
        return Token(text=text, doors=tuple(doors), ends=_moment(ends))

    def revoke(self, name: str) -> None:
        """Revoke an aircraft. A running ground station disconnects it within seconds.

        Raises
        ------
        NotPossibleNow
            When no member of that name is enrolled.
        """
        self._native.revoke(name, False)

    def revoke_station(self, name: str) -> None:
        """Revoke another ground station. Within seconds the router disconnects it, and aircraft no longer accept its orders.

        Raises
        ------
        NotPossibleNow
            When no member of that name is enrolled.
        """
        self._native.revoke(name, True)

    def router_config(self) -> dict[str, Any]:
        """Settings for an existing ``zenohd``: encrypted transports only, and access control for the present members."""
        settings: dict[str, Any] = json.loads(self._native.router_config())
        return settings

    @property
    def aircraft(self) -> list[Enrolled]:
        """The aircraft on the roll, by name."""
        return [
            Enrolled(name=name, enrolled=_moment(since), certificate_ends=_moment(ends), revoked=_maybe(revoked))
            for name, since, ends, revoked, post in self._native.members()
            if post is None
        ]

    @property
    def stations(self) -> list[EnrolledStation]:
        """The other ground stations on the roll, by name."""
        return [
            EnrolledStation(
                name=name,
                role=post[0],
                routers=tuple(post[1]),
                enrolled=_moment(since),
                certificate_ends=_moment(ends),
                revoked=_maybe(revoked),
            )
            for name, since, ends, revoked, post in self._native.members()
            if post is not None
        ]

    @property
    def tokens(self) -> dict[str, datetime]:
        """Aircraft with an unused token, and when it expires (UTC)."""
        return {name: _moment(ends) for name, ends, role in self._native.tokens() if role is None}

    @property
    def station_tokens(self) -> dict[str, datetime]:
        """Ground stations with an unused token, and when it expires (UTC)."""
        return {name: _moment(ends) for name, ends, role in self._native.tokens() if role is not None}

    @property
    def routers(self) -> list[str]:
        """Addresses at which its ground station last was the router, as aircraft dial them; empty before that."""
        return list(self._native.addresses()[0])

    @property
    def doors(self) -> list[str]:
        """Addresses at which it last enrolled aircraft, ``HOST:PORT``."""
        return list(self._native.addresses()[1])

    def problem_at(self, address: str) -> str | None:
        """What is wrong with the router or enrolment at an address, such as ``"tls/127.0.0.1:7447"``; ``None`` if nothing is."""
        problem: str | None = self._native.try_address(address)
        return problem

    def reachable_router(self) -> str | None:
        """The address at which its router answers this machine; ``None`` if it does not run."""
        routers = self.routers
        here = [re.sub(r"/.*:", "/127.0.0.1:", router) for router in routers[:1]]
        return next((router for router in [*here, *routers] if self.problem_at(router) is None), None)


def _member(found: dict[str, Any]) -> Member:
    return Member(
        org=found["org"],
        name=found["name"],
        is_station=found["is_station"],
        role=found["role"],
        is_router=found["is_router"],
        certificate_begins=_moment(found["begins"]),
        certificate_ends=_moment(found["ends"]),
        routers=tuple(found["routers"]),
        doors=tuple(found["doors"]),
    )


def is_for_station(token: str) -> bool:
    """Whether a token is for a ground station.

    Raises
    ------
    InvalidRequest
        For a text that is not a token.
    """
    return bool(native("fleet_token")(token)[1])


def join(token: str, *, file: str | Path | None = None) -> tuple[Member, bool]:
    """Enrol this computer in a fleet, in the role of the token. It creates its own keys, which never leave it.

    Parameters
    ----------
    token : str
        From `Organisation.enrol` or `Organisation.enrol_station`. One with which this computer has joined already
        changes nothing.
    file : path, optional
        File of the membership; by default `member_file` for an aircraft, `station_file` for a ground station, with its
        key beside it.

    Returns
    -------
    tuple of Member and bool
        The membership, and whether it is new.

    Raises
    ------
    InvalidRequest
        For a text that is not a token.
    NotPossibleNow
        When the ground station refuses: the token has expired, was used, or is unknown; or this machine has the
        authority itself.
    LinkError
        When no ground station is reached, or one with a wrong certificate; it was sent nothing.
    """
    org, is_station = native("fleet_token")(token)
    if is_station and file is None and Organisation(org).exists:
        raise NotPossibleNow(
            f"this machine has the authority of {org} itself, and needs no token: vencejo serve --fleet {org}"
        )
    path = Path(file) if file is not None else station_file(org) if is_station else member_file()
    found, is_new = native("fleet_join")(token, path, path.with_suffix(".key") if is_station else None)
    return _member(found), bool(is_new)


def member(*, file: str | Path | None = None) -> Member | None:
    """The fleet membership of this computer, if it has one; by default as an aircraft.

    Raises
    ------
    VencejoError
        When its file is damaged.
    """
    found = native("fleet_member")(member_file() if file is None else Path(file))
    return None if found is None else _member(found)


@dataclass(frozen=True, kw_only=True)
class Check:
    """The result of one check.

    Attributes
    ----------
    ok : bool
        Whether it passed.
    message : str
        What was found.
    remedy : str
        What to do about it; empty where it is well.
    """

    ok: bool
    message: str
    remedy: str = ""


def _validity(what: str, begins: datetime, ends: datetime, now: datetime, remedy: str) -> Check:
    """Check the validity of a certificate, and that enough of it is left."""
    left_s = (ends - now).total_seconds()
    if now < begins:
        message = f"{what} begins on {begins:%Y-%m-%d}, and the clock here says {now:%Y-%m-%d %H:%M} UTC"
        return Check(ok=False, message=message, remedy="set the clock: timedatectl set-ntp true")
    if left_s <= 0:
        message = f"{what} ended on {ends:%Y-%m-%d}; the clock here says {now:%Y-%m-%d %H:%M} UTC"
        return Check(ok=False, message=message, remedy=f"where the clock is right: {remedy}")
    if left_s < native("FLEET_WARN_BEFORE_S"):
        return Check(ok=False, message=f"{what} ends on {ends:%Y-%m-%d}, in {left_s / 86400:.0f} days", remedy=remedy)
    return Check(ok=True, message=f"{what} is good until {ends:%Y-%m-%d}")


def _reached(addresses: Iterable[str], problem_at: Callable[[str], str | None], remedy: str) -> Iterator[Check]:
    """Check that one of the addresses answers. The others only have to show no wrong certificate."""
    problems = {address: problem_at(address) for address in addresses}
    answers = any(problem is None for problem in problems.values())
    for address, problem in problems.items():
        if problem is not None:
            ok = answers and "certificate" not in problem
            message = f"{address}: {problem}" + ("; another address answers" if ok else "")
            yield Check(ok=ok, message=message, remedy="" if ok else remedy)
        else:
            yield Check(ok=True, message=f"{address} answers")


def _private(path: Path) -> Iterator[Check]:
    """Check that only its owner can read a file."""
    if os.name != "posix" or not path.exists():
        return
    if path.stat().st_mode & 0o077:
        yield Check(ok=False, message=f"others on this machine may read {path}", remedy=f"chmod 600 {path}")


def check_ground(organisation: Organisation, *, now: datetime | None = None) -> list[Check]:
    """Find out, on the ground, why aircraft are missing from the list.

    Parameters
    ----------
    organisation : Organisation
        Which fleet.
    now : datetime, optional
        The present time; by default that of the clock.
    """
    org = organisation.org
    now = now or datetime.fromtimestamp(time.time(), timezone.utc)
    if not organisation.exists:
        return [Check(ok=False, message=f"there is no fleet {org} here", remedy=f"vencejo fleet init {org}")]
    folder = organisation.folder
    names = ("ca.key", "station.key", "roll.json")
    files = [*(folder / name for name in names), folder.with_suffix(".key")]
    checks = [check for path in files for check in _private(path)]
    if not checks:
        checks.append(Check(ok=True, message=f"keys are for their owner alone, in {folder}"))
    (ca_begins, ca_ends, _), (begins, ends, hosts) = organisation._native.certificates()
    checks += [
        _validity("the authority (CA)", _moment(ca_begins), _moment(ca_ends), now, f"remove {folder}, and begin anew"),
        _validity(
            "the ground station's certificate",
            _moment(begins),
            _moment(ends),
            now,
            f"vencejo serve --fleet {org} renews it",
        ),
    ]
    own = own_addresses()
    numbers = [host for host in hosts if re.fullmatch(r"[0-9.]+", host) and not host.startswith("127.")]
    named = [host for host in hosts if re.search(r"[a-z]", host) and host != "localhost"]
    # A machine that others know by name alone, behind a router of the net, has no address of its own to be named.
    if own and not set(own) & set(numbers) and (numbers or not named):
        message = f"this machine is at {', '.join(own)} now, which its certificate does not name"
        checks.append(Check(ok=False, message=message, remedy=f"vencejo fleet init {org} --host {own[0]}"))
    if not organisation.routers:
        checks.append(
            Check(ok=False, message="no ground station was ever started", remedy=f"vencejo serve --fleet {org}")
        )
    for addresses in (organisation.routers, [f"tls/{door}" for door in organisation.doors]):
        checks += _reached(addresses, organisation.problem_at, f"vencejo serve --fleet {org}")
    for station in organisation.stations:
        if station.revoked is None:
            checks += _reached(
                station.routers, organisation.problem_at, f"at {station.name}: vencejo serve --fleet {org}"
            )
    members: list[Enrolled | EnrolledStation] = [*organisation.aircraft, *organisation.stations]
    for each in members:
        if each.revoked is None:
            remedy = f"it renews it by itself while it reaches the door; else: {_again(each)}"
            checks.append(
                _validity(f"the certificate of {each.name}", each.enrolled, each.certificate_ends, now, remedy)
            )
    return checks


def _again(each: Enrolled | EnrolledStation | Member) -> str:
    """The command that enrols a member again."""
    role = getattr(each, "role", None)
    is_station = isinstance(each, EnrolledStation) or (isinstance(each, Member) and each.is_station)
    options = f"--station {'' if role in (None, 'operator') else f'--role {role} '}" if is_station else ""
    if isinstance(each, EnrolledStation):
        options += "".join(f"--router {router} " for router in each.routers)
    return f"vencejo fleet enrol {options}{each.name}"


def check_board(found: Member, *, file: str | Path | None = None, now: datetime | None = None) -> list[Check]:
    """Look for what keeps this computer out of its fleet: an aircraft, on board, or a ground station without the authority.

    Parameters
    ----------
    found : Member
        Its place in its fleet.
    file : path, optional
        Where that is kept; by default `member_file`, or `station_file` for a ground station.
    now : datetime, optional
        The present time; by default that of the clock.
    """
    default = station_file(found.org) if found.is_station else member_file()
    path = default if file is None else Path(file)
    now = now or datetime.fromtimestamp(time.time(), timezone.utc)
    checks = list(_private(path)) or [Check(ok=True, message=f"the key is for its owner alone, in {path}")]
    again = f"on the ground: {_again(found)}; then here, with the token: vencejo fleet join TOKEN"
    checks.append(
        _validity(f"the certificate of {found.name}", found.certificate_begins, found.certificate_ends, now, again)
    )
    checks += _reached(
        found.routers, lambda address: native("fleet_try")(address, path), "on the ground: vencejo fleet doctor"
    )
    problem = native("fleet_standing")(path)
    if problem is None:
        checks.append(
            Check(
                ok=True,
                message="the ground station that has the authority knows this computer, and would renew its certificate",
            )
        )
    else:
        checks.append(Check(ok=False, message=problem, remedy="on the ground: vencejo fleet status"))
    return checks
