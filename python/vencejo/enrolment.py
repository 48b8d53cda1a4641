"""Who belongs to a fleet: on the ground its certificate authority and the roll of aircraft and ground stations; elsewhere a place in it.

`Organisation` makes the authority, gives out tokens and puts members out; `join` brings this computer in with a token, and from
then on `vencejo.fleet.Aircraft`, or `vencejo.fleet.Fleet` at another ground station, needs none. `check_ground` and `check_board` look for what keeps an aircraft out of the list.

Keys are in files that their owner alone reads, and in nothing that is given here. A token is in what `Organisation.enrol` gives,
once, and nowhere else.
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
"""What a ground station may do: look and read; act while it has control, for which it asks; take control from operators at once."""

TOKEN_LASTS_S = 3600
"""How long a token is good unless said otherwise, s."""


def native(name: str) -> Any:
    """Something of the native module that a build without fleets has not.

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
    """Where fleets are: ``fleet`` in the data folder."""
    return default_record_dir().parent / "fleet"


def member_file() -> Path:
    """Where the place of the aircraft that this computer is on board of is kept: ``fleet/aboard.json`` in the data folder."""
    return fleet_folder() / "aboard.json"


def station_file(org: str) -> Path:
    """Where the place of this ground station in somebody else's fleet is kept: ``fleet/ORG.json`` in the data folder."""
    return fleet_folder() / f"{org}.json"


def default_key_file(org: str) -> Path:
    """Where a ground station's own key is: ``fleet/ORG.key`` in the data folder, readable by its owner alone."""
    return fleet_folder() / f"{org}.key"


def station_places() -> list[str]:
    """The fleets in which this machine is a ground station by a token, by name."""
    return sorted(path.stem for path in fleet_folder().glob("*.json") if path != member_file())


def organisations() -> list[str]:
    """The fleets whose authority is on this machine, by name."""
    return sorted(path.parent.name for path in fleet_folder().glob("*/roll.json"))


def default_hosts() -> list[str]:
    """Names and addresses by which others may reach this machine: its name in the local network, its addresses, its name alone."""
    name = socket.gethostname()
    found = [f"{name}.local", *own_addresses(), name] if "." not in name else [name, *own_addresses()]
    return [host for host in found if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.-]{0,252}", host)]


def _moment(unix_s: int) -> datetime:
    return datetime.fromtimestamp(unix_s, timezone.utc)


def _maybe(unix_s: int | None) -> datetime | None:
    return None if unix_s is None else _moment(unix_s)


@dataclass(frozen=True, kw_only=True)
class Token:
    """What brings one aircraft or ground station into a fleet, once.

    Attributes
    ----------
    text : str
        The token: whoever has it joins under that name.
    doors : tuple of str
        Where it is good, ``HOST:PORT``.
    ends : datetime
        Until when (UTC).
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
        Since when it is there, and when the newest certificate that it got ends (UTC).
    revoked : datetime or None
        When it was put out.
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
        Where it is a router of the fleet as well, as others reach it; empty where it is none.
    enrolled, certificate_ends : datetime
        Since when it is there, and when the newest certificate that it got ends (UTC).
    revoked : datetime or None
        When it was put out.
    """

    name: str
    role: Role
    routers: tuple[str, ...]
    enrolled: datetime
    certificate_ends: datetime
    revoked: datetime | None


@dataclass(frozen=True, kw_only=True)
class Member:
    """An aircraft's, or another ground station's, place in a fleet.

    Attributes
    ----------
    org, name : str
        The organisation, and its name there.
    is_station : bool
        Whether it is a ground station.
    role : str or None
        What a ground station may do, as its newest list says: ``"observer"``, ``"operator"`` or ``"chief"``; ``None`` for an aircraft, and for one
        that is not on the list any more.
    certificate_begins, certificate_ends : datetime
        From when to when its certificate is good (UTC).
    routers, doors : tuple of str
        Where the fleet's routers are, and where its certificate is renewed.
    """

    org: str
    name: str
    is_station: bool
    role: Role | None
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
        Where fleets are; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For a name that cannot be one.
    """

    def __init__(self, org: str, *, folder: str | Path | None = None) -> None:
        self.org = org
        self.folder = (fleet_folder() if folder is None else Path(folder)) / org
        self._native = native("FleetOrganisation")(self.folder.parent, org)

    @property
    def exists(self) -> bool:
        """Whether it has been made."""
        return bool(self._native.exists())

    def init(
        self, *, hosts: Iterable[str] | None = None, ca_certificate: str | None = None, ca_key: str | None = None
    ) -> tuple[bool, list[str]]:
        """Make the authority where there is none, and the ground station's own certificate; again, it changes nothing.

        Parameters
        ----------
        hosts : iterable of str, optional
            Names and addresses by which aircraft reach this machine; by default `default_hosts`, where it is made. Where it is there,
            those that are new are added.
        ca_certificate, ca_key : str, optional
            An authority that the organisation has already, as PEM, in place of a new one.

        Returns
        -------
        tuple of bool and list of str
            Whether the authority was made now, and which hosts are new.

        Raises
        ------
        InvalidRequest
            For a host that cannot be one, or an authority that cannot sign.
        VencejoError
            When the files cannot be read or written, or another authority is there.
        """
        if hosts is None:
            hosts = [] if self.exists else default_hosts()
        given = None if ca_certificate is None or ca_key is None else (ca_certificate, ca_key)
        made, new = self._native.init(list(hosts), given)
        return bool(made), list(new)

    def check_name(self, name: str, *, role: Role | None = None, routers: Iterable[str] = ()) -> None:
        """Say whether an aircraft, or with a role a ground station, can have a name and those addresses. Nothing is looked at or changed.

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
            For a name, a role or an address that cannot be one.
        NotPossibleNow
            For the name of the ground station that has the authority.
        """
        self._native.check_newcomer(name, role, list(routers))

    def enrol(self, name: str, *, lasts_s: int = TOKEN_LASTS_S) -> Token:
        """A token for an aircraft. An older one for it is void from now on.

        Parameters
        ----------
        name : str
            The aircraft's name: 1 to 32 of ``a-z``, ``0-9`` and ``-``.
        lasts_s : int
            How long it is good, s.

        Raises
        ------
        InvalidRequest
            For a name that cannot be one.
        NotPossibleNow
            When an aircraft of that name was revoked, and its old certificate has not ended.
        """
        return self._token(name, lasts_s, None)

    def enrol_station(
        self, name: str, *, role: Role = "operator", routers: Iterable[str] = (), lasts_s: int = TOKEN_LASTS_S
    ) -> Token:
        """A token for another ground station. An older one for it is void from now on.

        Aircraft learn its key and role by a list that the authority signs, within seconds where they are reached.

        Parameters
        ----------
        name : str
            The station's name: 1 to 32 of ``a-z``, ``0-9`` and ``-``; not ``ground``, which is the one that has the authority.
        role : str
            ``"observer"``, which looks and reads; ``"operator"``, which asks for control; or ``"chief"``, which takes it from operators at once.
        routers : iterable of str
            Where it is a router of the fleet as well, as others reach it, such as ``"tls/hill.example.org:7447"``: aircraft and
            stations are told of them, and its certificate is good for these names. None by default.
        lasts_s : int
            How long it is good, s.

        Raises
        ------
        InvalidRequest
            For a name, a role or an address that cannot be one.
        NotPossibleNow
            When a station of that name was revoked, and its old certificate has not ended.
        """
        return self._token(name, lasts_s, role, routers)

    def _token(self, name: str, lasts_s: int, role: Role | None, routers: Iterable[str] = ()) -> Token:
        text, doors, ends = self._native.enrol(name, lasts_s, role, list(routers))
        return Token(text=text, doors=tuple(doors), ends=_moment(ends))

    def revoke(self, name: str) -> None:
        """Put an aircraft out. A running ground station shuts it out within seconds.

        Raises
        ------
        NotPossibleNow
            When none of that name is enrolled.
        """
        self._native.revoke(name, False)

    def revoke_station(self, name: str) -> None:
        """Put another ground station out. The router shuts it out, and aircraft take no orders of it any more, within seconds.

        Raises
        ------
        NotPossibleNow
            When none of that name is enrolled.
        """
        self._native.revoke(name, True)

    def router_config(self) -> dict[str, Any]:
        """The settings of an existing ``zenohd``: encrypted ways alone, and its access control with who is enrolled now."""
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
        """For which aircraft a token is out, and until when (UTC)."""
        return {name: _moment(ends) for name, ends, role in self._native.tokens() if role is None}

    @property
    def station_tokens(self) -> dict[str, datetime]:
        """The same of ground stations."""
        return {name: _moment(ends) for name, ends, role in self._native.tokens() if role is not None}

    @property
    def routers(self) -> list[str]:
        """Where its ground station last was the router, as aircraft dial it; empty before it ever was."""
        return list(self._native.addresses()[0])

    @property
    def doors(self) -> list[str]:
        """Where it last enrolled aircraft, ``HOST:PORT``."""
        return list(self._native.addresses()[1])

    def problem_at(self, address: str) -> str | None:
        """What is wrong with a router or door, such as ``"tls/127.0.0.1:7447"``; ``None`` where nothing is."""
        problem: str | None = self._native.try_address(address)
        return problem

    def reachable_router(self) -> str | None:
        """Where its router answers this machine, if it runs."""
        routers = self.routers
        here = [re.sub(r"/.*:", "/127.0.0.1:", router) for router in routers[:1]]
        return next((router for router in [*here, *routers] if self.problem_at(router) is None), None)


def _member(found: dict[str, Any]) -> Member:
    return Member(
        org=found["org"],
        name=found["name"],
        is_station=found["is_station"],
        role=found["role"],
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
        For a text that is no token.
    """
    return bool(native("fleet_token")(token)[1])


def join(token: str, *, file: str | Path | None = None) -> tuple[Member, bool]:
    """Bring this computer into a fleet, as what a token is for. It makes its own keys, which never leave it.

    Parameters
    ----------
    token : str
        What `Organisation.enrol` or `Organisation.enrol_station` gave. The one that brought it in already is good for nothing more, and
        changes nothing.
    file : path, optional
        Where its place is kept; by default `member_file` for an aircraft, `station_file` for a ground station, whose key is beside it.

    Returns
    -------
    tuple of Member and bool
        Its place, and whether it has it from now.

    Raises
    ------
    InvalidRequest
        For a text that is no token.
    NotPossibleNow
        When the ground station refuses: the token has expired, was used, or is not known there; or this one has the authority itself.
    LinkError
        When nobody is reached, or somebody else answers; nothing was told to them.
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
    """The place of this computer in a fleet, if it has one; by default as an aircraft.

    Raises
    ------
    VencejoError
        When its file is damaged.
    """
    found = native("fleet_member")(member_file() if file is None else Path(file))
    return None if found is None else _member(found)


@dataclass(frozen=True, kw_only=True)
class Check:
    """One thing that was looked at.

    Attributes
    ----------
    ok : bool
        Whether it is as it should be.
    message : str
        What was found.
    remedy : str
        What to do about it; empty where it is well.
    """

    ok: bool
    message: str
    remedy: str = ""


def _validity(what: str, begins: datetime, ends: datetime, now: datetime, remedy: str) -> Check:
    """Whether a certificate is good, and for long enough."""
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
    """Whether one of these addresses answers; that others do not is only said, but not of whoever shows a wrong certificate."""
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
    """Whether a file is its owner's alone."""
    if os.name != "posix" or not path.exists():
        return
    if path.stat().st_mode & 0o077:
        yield Check(ok=False, message=f"others on this machine may read {path}", remedy=f"chmod 600 {path}")


def check_ground(organisation: Organisation, *, now: datetime | None = None) -> list[Check]:
    """Look for what keeps aircraft out, on the ground.

    Parameters
    ----------
    organisation : Organisation
        Which fleet.
    now : datetime, optional
        The time; by default that of the clock.
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
    """The command that enrols one again."""
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
        The time; by default that of the clock.
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
