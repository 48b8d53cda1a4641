"""A report of a plan and its rehearsed flight: one HTML file for the screen and A4 paper, without network or scripts.

Examples
--------
>>> from vencejo import Home, MissionItem, Plan
>>> from vencejo.rehearsal import rehearse
>>> from vencejo.report import plan_report
>>> home = Home(40.3332, -3.7978, alt_amsl_m=600.0)
>>> out, back = MissionItem.waypoint(40.3432, -3.7978, alt_rel_home_m=80.0), MissionItem.return_to_launch()
>>> plan = Plan(home=home, items=(MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0), out, back))
>>> page = plan_report(plan, rehearse(plan), title="Round the field")
>>> page.startswith("<!doctype html>"), "https://" in page
(True, False)
"""

from __future__ import annotations

import datetime
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

from vencejo import __version__
from vencejo._report_drawings import Words, map_drawing, profile_drawing
from vencejo._report_texts import Language, Texts
from vencejo.findings import Finding, with_flown
from vencejo.geodesy import distance_m
from vencejo.landing import Wind
from vencejo.plan import GeoPoint, MissionItem, Plan
from vencejo.rehearsal import Airframe, Moment, Passage, Rehearsal
from vencejo.what_if import WhatIf

__all__ = ["Language", "plan_report"]

GOOD = frozenset({"landed", "returned", "unlimited"})
BAD = frozenset({"ground", "held", "grounded"})
SHOWN_PARAMETERS = (
    "AIRSPEED_CRUISE",
    "AIRSPEED_MIN",
    "AIRSPEED_MAX",
    "ROLL_LIMIT_DEG",
    "NAVL1_PERIOD",
    "WP_RADIUS",
    "WP_LOITER_RAD",
    "TECS_CLMB_MAX",
    "TECS_SINK_MIN",
    "TECS_SINK_MAX",
    "TECS_LAND_ARSPD",
    "LAND_FLARE_SEC",
    "LAND_FLARE_ALT",
    "RTL_ALTITUDE",
    "RTL_AUTOLAND",
)
"""Parameters that say most about how a plane flies; those that are given are printed."""


@dataclass(frozen=True)
class _Subject:
    """The subject of a report, and its texts."""

    plan: Plan
    flown: Rehearsal
    wind: Wind
    parameters: Mapping[str, float] | None
    airframe: Airframe | None
    what_ifs: Sequence[WhatIf]
    texts: Texts

    def say(self, key: str, **values: object) -> str:
        return escape(self.texts.say(key, **values))

    def number(self, value: float, digits: int = 0) -> str:
        return self.texts.number(value, digits)


def plan_report(
    plan: Plan,
    flown: Rehearsal,
    *,
    title: str,
    wind: Wind | None = None,
    language: Language = "en",
    parameters: Mapping[str, float] | None = None,
    airframe: Airframe | None = None,
    what_ifs: Sequence[WhatIf] = (),
    made: datetime.datetime | None = None,
) -> str:
    """Write a report.

    Parameters
    ----------
    plan : Plan
    flown : Rehearsal
        The rehearsal of this plan, from :func:`vencejo.rehearsal.rehearse`.
    title : str
        Title, any text.
    wind, parameters, airframe : optional
        What it was rehearsed with.
    language : {"en", "es"}, optional
    what_ifs : sequence of WhatIf, optional
        As :func:`vencejo.what_if.what_if` gives them for some moments of the flight; without them their section is left
        out.
    made : datetime, optional
        A moment to print; none by default.

    Returns
    -------
    str
        The page, whole: styles and drawings are in it.
    """
    subject = _Subject(plan, flown, wind or Wind(0.0, 0.0), parameters, airframe, what_ifs, Texts(language))
    # Each section is a function of the subject; an empty one returns no text.
    sections = (
        _header(subject, title, made),
        _summary(subject),
        _map(subject),
        _profile(subject),
        _findings(subject),
        _items(subject),
        _what_if(subject),
        _plane(subject),
        _footer(subject),
    )
    style = (files("vencejo") / "data" / "report.css").read_text(encoding="utf-8")
    return (
        f'<!doctype html>\n<html lang="{language}">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        + "\n".join(section for section in sections if section)
        + "\n</body>\n</html>\n"
    )


def _header(subject: _Subject, title: str, made: datetime.datetime | None) -> str:
    ending = subject.flown.ending
    kind = "good" if ending in GOOD else "bad" if ending in BAD else "doubt"
    if any(finding.severity == "error" for finding in _all_findings(subject)) and kind == "good":
        kind = "doubt"
    moment = "" if made is None else f" · {made:%Y-%m-%d %H:%M %Z}"
    return (
        f'<header><div><p class="kind">{subject.say("kind")}{escape(moment)}</p><h1>{escape(title)}</h1>'
        f"<p>{_wind(subject)}</p></div>"
        f'<p class="verdict {kind}">{subject.say(f"ending.{ending}")}</p></header>'
    )


def _wind(subject: _Subject) -> str:
    if subject.wind.is_calm:
        return subject.say("calm")
    speed = subject.number(subject.wind.speed_m_s, 0 if subject.wind.speed_m_s.is_integer() else 1)
    return subject.say("wind", speed=speed, degrees=f"{subject.wind.from_deg % 360.0:.0f}")


def _summary(subject: _Subject) -> str:
    flown, plan = subject.flown, subject.plan
    in_air = [moment for moment in flown.track if moment.alt_rel_home_m > 10.0] or list(flown.track)
    airspeeds = [moment.airspeed_m_s for moment in in_air]
    groundspeeds = [moment.groundspeed_m_s for moment in in_air]

    def extent(values: list[float]) -> str:
        return f"{subject.number(min(values))} – {subject.number(max(values))} m/s"

    figures = [
        ("duration", _clock(flown.duration_s)),
        ("distance", f"{subject.number(flown.distance_m / 1000.0, 1)} km"),
        (
            "energy",
            subject.say("unknown") if flown.energy_wh is None else f"{subject.number(flown.energy_wh, 1)} Wh",
        ),
        (
            "battery",
            subject.say("unknown") if flown.battery is None else f"{subject.number(flown.battery.left * 100.0)} %",
        ),
        ("highest", f"{subject.number(max(moment.alt_rel_home_m for moment in flown.track))} m"),
        ("airspeeds", extent(airspeeds)),
        ("groundspeeds", extent(groundspeeds)),
    ]
    if plan.home is not None:
        home = GeoPoint(plan.home.lat_deg, plan.home.lon_deg)
        # a tenth of the moments is enough for a figure of whole metres of a plane that turns
        far_m = max(distance_m(home, GeoPoint(at.lat_deg, at.lon_deg)) for at in flown.track[::5])
        figures.insert(4, ("farthest", f"{subject.number(far_m)} m"))
    down = subject.say("none")
    if flown.touch_down is not None:
        off_m, speed = flown.touch_down_off_m(plan), subject.number(flown.touch_down.groundspeed_m_s)
        known = off_m is not None
        down = subject.say(
            "touch-down-off" if known else "touch-down-at", off=subject.number(off_m or 0.0), speed=speed
        )
    figures.append(("touch-down", down))
    cells = "".join(f"<div><dt>{subject.say(key)}</dt><dd>{value}</dd></div>" for key, value in figures)
    return f'<dl class="figures">{cells}</dl>'


def _map(subject: _Subject) -> str:
    plan = subject.plan
    shown = ["track", "route"]
    shown += ["inside"] if any(zone.inclusion for zone in plan.fence.zones) else []
    shown += ["outside"] if any(not zone.inclusion for zone in plan.fence.zones) else []
    shown += ["rally"] if plan.rally else []
    shown += ["down"] if subject.flown.touch_down is not None else []
    drawing = map_drawing(plan, subject.flown, subject.wind, _words(subject))
    return f"<section><h2>{subject.say('map')}</h2>{drawing}{_key(subject, shown)}</section>"


def _profile(subject: _Subject) -> str:
    drawing = profile_drawing(subject.plan, subject.flown, _words(subject))
    return f"<section><h2>{subject.say('profile')}</h2>{drawing}{_key(subject, ['track', 'asked'])}</section>"


def _words(subject: _Subject) -> Words:
    return Words(subject.say, subject.number)


def _key(subject: _Subject, shown: Iterable[str]) -> str:
    signs = "".join(f'<li><i class="{name}"></i>{subject.say(f"key.{name}")}</li>' for name in shown)
    return f'<ul class="key">{signs}</ul>'


def _all_findings(subject: _Subject) -> tuple[Finding, ...]:
    return with_flown(subject.plan.check(parameters=subject.parameters), subject.flown.findings)


def _findings(subject: _Subject) -> str:
    findings = sorted(_all_findings(subject), key=lambda finding: finding.severity != "error")
    rows = []
    for finding in findings:
        text, remedy = subject.texts.finding(finding, subject.plan)
        said = f"<p>{escape(text)}</p>" + (f'<p class="remedy">{escape(remedy)}</p>' if remedy else "")
        rows.append(f'<li class="{finding.severity}"><b>{subject.say(finding.severity)}</b><div>{said}</div></li>')
    body = f'<ul class="findings">{"".join(rows)}</ul>' if rows else f"<p>{subject.say('no-findings')}</p>"
    return f"<section><h2>{subject.say('findings')}</h2>{body}</section>"


def _items(subject: _Subject) -> str:
    names = ("item", "command", "planned", "reached", "flown", "nearest")
    head = "".join(f"<th>{subject.say(f'column.{name}')}</th>" for name in names)
    passages: dict[int, list[Passage]] = {}
    for passage in subject.flown.passages:
        passages.setdefault(passage.item, []).append(passage)
    rows = "".join(
        _row(subject, number, item, passages.get(number, [])) for number, item in enumerate(subject.plan.items, 1)
    )
    return (
        f"<section class='long'><h2>{subject.say('items')}</h2><table><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table></section>"
    )


def _row(subject: _Subject, number: int, item: MissionItem, passages: list[Passage]) -> str:
    planned = reached = flown = nearest = ""
    if item.alt_m is not None and item.lat_deg:
        frame = subject.say(f"frame.{item.frame}") if item.frame in (0, 3, 10) else f"MAV_FRAME {item.frame:d}"
        planned = f"{subject.number(item.alt_m)} m <small>{frame}</small>"
    if passages and item.is_nav:
        first = passages[0]
        if first.reached_s is None:
            reached = f'<strong class="never">{subject.say("never")}</strong>'
        else:
            reached = _clock(first.reached_s)
            flown = f"{subject.number(_moment(subject.flown.track, first.reached_s).alt_rel_home_m)} m"
        if len(passages) > 1:
            reached += f" <small>{subject.say('times', count=len(passages))}</small>"
        if first.nearest_m is not None:
            nearest = f"{subject.number(first.nearest_m)} m"
    kind = "nav" if item.is_nav else "do"
    cells = (f"{number}", escape(subject.texts.command(item)), planned, reached, flown, nearest)
    return f'<tr class="{kind}">' + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _moment(track: Sequence[Moment], time_s: float) -> Moment:
    """The moment of a track that is nearest to a time; a track is in order of time, and long."""
    after = bisect_left(track, time_s, key=lambda moment: moment.time_s)
    return min(track[max(0, after - 1) : after + 1], key=lambda moment: abs(moment.time_s - time_s))


def _what_if(subject: _Subject) -> str:
    """A row per trigger, a column per moment."""
    moments = list(dict.fromkeys(found.at.time_s for found in subject.what_ifs))
    if not moments:
        return ""
    head = "".join(f"<th>{_clock(time_s)}</th>" for time_s in moments)
    rows = ""
    for trigger in dict.fromkeys(found.trigger for found in subject.what_ifs):
        cells = {
            found.at.time_s: _consequence(subject, found) for found in subject.what_ifs if found.trigger == trigger
        }
        columns = "".join(f"<td>{cells.get(time_s, '')}</td>" for time_s in moments)
        rows += f"<tr><td>{subject.say(f'trigger.{trigger}')}</td>{columns}</tr>"
    table = f'<table class="what-if"><thead><tr><th></th>{head}</tr></thead><tbody>{rows}</tbody></table>'
    return f"<section><h2>{subject.say('what-if')}</h2>{table}</section>"


def _consequence(subject: _Subject, found: WhatIf) -> str:
    does = subject.say(f"reaction.{found.reaction}")
    if found.flown is None:
        return does
    # without its engine it comes down somewhere
    kind = "never" if found.flown.ending in BAD and found.trigger != "engine-stopped" else ""
    ends = f'<span class="{kind}">{subject.say(f"short.{found.flown.ending}")}</span>'
    return f"{does}<small>{ends} {_clock(found.flown.duration_s)}</small>"


def _plane(subject: _Subject) -> str:
    said = [subject.say(f"airframe.{subject.flown.airframe}")]
    frame = subject.airframe
    if frame is not None:
        speed, throttle = subject.number(frame.cruise_m_s, 1), subject.number(frame.throttle_cruise * 100.0)
        said.append(subject.say("cruise", speed=speed, throttle=throttle))
        if frame.power_cruise_w is not None:
            said.append(subject.say("power", power=subject.number(frame.power_cruise_w)))
    given = subject.parameters or {}
    shown = [(name, given[name]) for name in SHOWN_PARAMETERS if name in given]
    said.append(subject.say("parameters" if shown else "no-parameters"))
    listed = "".join(f"<li><code>{name}</code> {value:g}</li>" for name, value in shown)
    text = f"<p>{' '.join(said)}</p>" + (f'<ul class="parameters">{listed}</ul>' if shown else "")
    wind = "" if subject.wind.is_calm else f"<p>{_wind(subject)}. {subject.say('wind-fades')}</p>"
    home = ""
    if subject.plan.home is not None:
        at = subject.plan.home
        where = subject.say(
            "home-at", lat=f"{at.lat_deg:.6f}", lon=f"{at.lon_deg:.6f}", alt=subject.number(at.alt_amsl_m)
        )
        home = f"<p>{subject.say('home')}: {where}</p>"
    notes = "".join(f"<li>{escape(subject.texts.note(note))}</li>" for note in subject.plan.notes)
    source = f"<p>{subject.say('source-notes')}:</p><ul>{notes}</ul>" if notes else ""
    return f"<section><h2>{subject.say('plane')}</h2>{text}{wind}{home}{source}</section>"


def _footer(subject: _Subject) -> str:
    return f"<footer><p>{subject.say('limits')}</p><p>{subject.say('made', version=__version__)}</p></footer>"


def _clock(seconds: float) -> str:
    whole = round(seconds)
    hours, rest = divmod(whole, 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}" if hours else f"{rest // 60}:{rest % 60:02}"
