"""What a printed plan says, in English and Spanish; findings and commands in Spanish are those of the page (data/texts.es.json)."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any, Final, Literal

from vencejo import _native
from vencejo.findings import Finding
from vencejo.plan import MissionItem, Plan, PlanNote

__all__ = ["Language", "Texts"]

Language = Literal["en", "es"]

TEXTS: Final[Mapping[str, tuple[str, str]]] = {
    "kind": ("Flight plan, rehearsed", "Plan de vuelo, ensayado"),
    "wind": ("Wind {speed} m/s from {degrees}°", "Viento de {speed} m/s desde {degrees}°"),
    "calm": ("No wind", "Sin viento"),
    "map": ("Map", "Mapa"),
    "profile": ("Height above home, m", "Altura sobre casa, m"),
    "findings": ("What the checks find", "Lo que ven las comprobaciones"),
    "items": ("Items", "Puntos"),
    "plane": ("Plane and wind", "Avión y viento"),
    "duration": ("Duration", "Duración"),
    "distance": ("Over ground", "Sobre el terreno"),
    "energy": ("Energy", "Energía"),
    "battery": ("Battery left", "Batería restante"),
    "highest": ("Highest", "Altura máxima"),
    "farthest": ("Farthest from home", "Más lejos de casa"),
    "airspeeds": ("Airspeed in flight", "Velocidad aerodinámica"),
    "groundspeeds": ("Ground speed in flight", "Velocidad suelo"),
    "touch-down": ("Touch-down", "Toma"),
    "touch-down-off": ("{off} m off, {speed} m/s", "a {off} m, {speed} m/s"),
    "touch-down-at": ("at {speed} m/s", "a {speed} m/s"),
    "unknown": ("not known", "no se sabe"),
    "none": ("none", "ninguna"),
    "ending.landed": ("Lands, and comes to rest", "Aterriza y se detiene"),
    "ending.returned": (
        "Ends in a circle over home or a rally point",
        "Acaba en círculo sobre casa o un punto de reunión",
    ),
    "ending.unlimited": ("Ends in a circle without end", "Acaba en un círculo sin fin"),
    "ending.endless": ("Repeats for ever; one round is shown", "Se repite siempre; se muestra una vuelta"),
    "ending.ground": ("Hits the ground", "Choca con el terreno"),
    "ending.held": ("Is held by the wind", "El viento no lo deja avanzar"),
    "ending.grounded": ("Does not leave the ground", "No despega"),
    "ending.not-rehearsed": ("Comes to an item that is not rehearsed", "Llega a un punto que no se ensaya"),
    "ending.too-long": ("Flies on after what was rehearsed", "Sigue volando después de lo ensayado"),
    "home-letter": ("H", "C"),
    "key.track": ("rehearsed", "ensayado"),
    "key.route": ("planned", "planeado"),
    "key.inside": ("stay inside", "quedarse dentro"),
    "key.outside": ("stay outside", "quedarse fuera"),
    "key.rally": ("rally point", "punto de reunión"),
    "key.down": ("touch-down", "toma"),
    "key.asked": ("asked for", "pedida"),
    "column.item": ("Item", "Punto"),
    "column.command": ("What", "Qué"),
    "column.planned": ("Planned height", "Altura del plan"),
    "column.reached": ("Reached", "Llega"),
    "column.flown": ("Flown, above home", "Volada, sobre casa"),
    "column.nearest": ("Passes at", "Pasa a"),
    "never": ("never", "nunca"),
    "times": ("first of {count}", "primera de {count}"),
    "frame.0": ("above sea level", "sobre el mar"),
    "frame.3": ("above home", "sobre casa"),
    "frame.10": ("above terrain", "sobre el terreno"),
    "error": ("Error", "Error"),
    "warning": ("Warning", "Aviso"),
    "no-findings": ("The checks find nothing wrong.", "Las comprobaciones no ven nada mal."),
    "what-if": ("What if, at these moments", "¿Y si…? En estos momentos"),
    "trigger.return-asked": ("A return is asked for", "Se pide volver"),
    "trigger.link-lost": ("The station falls silent", "Calla la estación"),
    "trigger.radio-lost": ("The remote control falls silent", "Calla la emisora"),
    "trigger.battery-low": ("Battery low", "Batería baja"),
    "trigger.battery-critical": ("Battery critical", "Batería crítica"),
    "trigger.go-around": ("The landing is broken off", "Se interrumpe el aterrizaje"),
    "trigger.engine-stopped": ("The engine stops", "Se para el motor"),
    "reaction.flies-mission": ("flies its mission", "vuela su misión"),
    "reaction.goes-around": ("climbs away and lands anew", "sube y vuelve a aterrizar"),
    "reaction.goes-on": ("goes on", "sigue"),
    "reaction.returns": ("returns", "vuelve"),
    "reaction.lands": ("goes to land", "va a aterrizar"),
    "reaction.circles": ("circles", "da vueltas"),
    "reaction.glides": ("glides", "planea"),
    "reaction.not-rehearsed": ("not rehearsed", "no se ensaya"),
    "short.landed": ("lands", "aterriza"),
    "short.returned": ("there", "llega"),
    "short.unlimited": ("circles on", "sigue en círculo"),
    "short.endless": ("flies on", "sigue volando"),
    "short.ground": ("on the ground", "en el suelo"),
    "short.held": ("held by the wind", "lo frena el viento"),
    "short.grounded": ("does not take off", "no despega"),
    "short.not-rehearsed": ("not rehearsed", "no se ensaya"),
    "short.too-long": ("flies on", "sigue volando"),
    "airframe.parameters": (
        "A foam pusher, as far as parameters do not tell of another plane.",
        "Un avión de espuma con hélice trasera, mientras los parámetros no digan otra cosa.",
    ),
    "airframe.simulator": ("The plane of ArduPilot's simulator.", "El avión del simulador de ArduPilot."),
    "airframe.flight": ("Learned from a recorded flight.", "Aprendido de un vuelo grabado."),
    "no-parameters": (
        "Steered as ArduPilot's simulated plane: no parameters were given.",
        "Pilotado como el avión simulado de ArduPilot: no se dieron parámetros.",
    ),
    "parameters": ("Steered with these parameters:", "Pilotado con estos parámetros:"),
    "cruise": (
        "Cruise {speed} m/s at {throttle} % of throttle.",
        "Crucero a {speed} m/s con {throttle} % de gas.",
    ),
    "power": ("{power} W of level flight.", "{power} W en vuelo nivelado."),
    "wind-fades": (
        "The wind is that of 60 m above home; lower down it fades as over open land. No gusts.",
        "El viento es el de 60 m sobre casa; más abajo amaina como en campo abierto. Sin rachas.",
    ),
    "home": ("Home", "Casa"),
    "home-at": ("{lat}, {lon}, {alt} m above sea level", "{lat}, {lon}, {alt} m sobre el mar"),
    "source-notes": ("Said when the file was read", "Dicho al leer el fichero"),
    "limits": (
        "A rehearsal is a calculation, no clearance: it knows no ground but that of home and of the landings, no obstacles, no traffic and no failure.",
        "Un ensayo es un cálculo, no una autorización: no conoce más terreno que el de casa y el de los aterrizajes, ni obstáculos, ni tráfico, ni averías.",
    ),
    "made": ("Made by Vencejo {version}", "Hecho por Vencejo {version}"),
}

TELLING: Final = ("wanted", "missing", "fault")
"""Figures whose word says which finding of its code it is."""


@functools.cache
def _spanish() -> Mapping[str, Mapping[str, str]]:
    text = (files("vencejo") / "data" / "texts.es.json").read_text(encoding="utf-8")
    shared: Mapping[str, Mapping[str, str]] = json.loads(text)
    return shared


class Texts:
    """Texts and numbers in one language; nothing is escaped."""

    def __init__(self, language: Language) -> None:
        self.language: Language = language

    def say(self, key: str, **values: object) -> str:
        """A text by its key."""
        return TEXTS[key][self.language == "es"].format(**values)

    def number(self, value: float, digits: int = 0) -> str:
        """A number: no minus before zero, a comma in Spanish, thousands apart."""
        text = f"{round(value, digits) + 0.0:,.{digits}f}"
        if self.language == "es":
            return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace(".", ",")
        return text

    def command(self, item: MissionItem) -> str:
        """What an item does."""
        title = _native.command_title(item.command)
        if title is None:
            return item.name
        return _spanish()["commands"].get(title, title) if self.language == "es" else title

    def note(self, note: PlanNote) -> str:
        """What a file left to say."""
        spanish = _spanish()["notes"].get(f"note.{note.code}") if self.language == "es" else None
        return note.message if spanish is None else spanish.format(count=note.count)

    def finding(self, finding: Finding, plan: Plan) -> tuple[str, str]:
        """A finding and its remedy; one whose Spanish is not known in English."""
        english = finding.message, finding.remedy
        if self.language == "en":
            return english
        texts, figures = _spanish()["findings"], finding.figures
        words = [figures[name] for name in TELLING if isinstance(figures.get(name), str)]
        flags = [name.replace("_", "-") for name, value in figures.items() if value is True]
        variant = f"{finding.code}.{(*words, *flags, '')[0]}"
        text = texts.get(variant, texts.get(finding.code))
        remedy = texts.get(f"{variant}.remedy", texts.get(f"{finding.code}.remedy"))
        if text is None or remedy is None:
            return english
        values = {name: self._figure(name, value, figures) for name, value in figures.items()}
        values["item"] = self._subject(finding, plan)
        said = text.format(**values)
        return said[:1].upper() + said[1:], remedy.format(**values)

    def _subject(self, finding: Finding, plan: Plan) -> str:
        texts = _spanish()["findings"]
        if finding.item is not None:
            name = self.command(plan.items[finding.item - 1]) if finding.item <= len(plan.items) else "?"
            return texts["item"].format(number=finding.item, name=name)
        rally, zone = finding.figures.get("rally_point"), finding.figures.get("fence_zone")
        if rally is not None:
            return texts["rally"].format(number=rally)
        if zone is not None:
            return texts["zone"].format(number=zone)
        return texts["returnPoint" if "fence_zone" in finding.figures else "home"]

    def _figure(self, name: str, value: Any, figures: Mapping[str, Any]) -> str:
        texts = _spanish()
        if name == "datum":
            return "" if value is None else texts["findings"][f"datum.{value}"]
        if isinstance(value, str):
            return texts["commands"].get(value, value) if name == "label" else value
        if value is None:
            return "…" if name in ("min", "max") else "–"
        unit = str(figures.get("unit") or "") if name in ("value", "kept", "min", "max") else ""
        if name.endswith("_m_s"):
            unit = "m/s"
        elif name.endswith("_m"):
            unit = "m"
        shown = self.number(float(value), 0 if float(value).is_integer() else 1)
        return f"{shown} {unit}".rstrip()
