"""What the commands `vencejo plan …` fly with: the options that say the wind, the plane and the ground, and what they make."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.common import Exit, Failed

if TYPE_CHECKING:
    from vencejo.landing import Wind
    from vencejo.plan import Plan
    from vencejo.rehearsal import Elevation, Rehearsal

WindOption = Annotated[
    float | None, typer.Option("--wind", min=0.0, max=60.0, help="Wind 60 m up, m/s; calm by default.")
]
WindFromOption = Annotated[
    float | None,
    typer.Option(
        "--wind-from", metavar="DEGREES", help="Direction that it comes from, degrees from true north; 0 by default."
    ),
]
ParamsOption = Annotated[
    Path | None,
    typer.Option("--params", metavar="FILE", help="The plane's parameters; else those of ArduPilot's simulated plane."),
]
LearnOption = Annotated[
    Path | None, typer.Option("--learn", metavar="TLOG", help="A recorded flight from which to learn the airframe.")
]
CapacityOption = Annotated[
    float | None,
    typer.Option("--capacity", metavar="MAH", min=1.0, help="Charge of the battery; else BATT_CAPACITY of --params."),
]
VoltageOption = Annotated[
    float | None, typer.Option("--voltage", metavar="V", min=1.0, help="Of the battery; else that of --learn.")
]
PowerOption = Annotated[
    float | None,
    typer.Option("--power", metavar="W", min=0.1, help="Drawn in level flight at cruise; else that of --learn."),
]
ReserveOption = Annotated[
    float | None,
    typer.Option(
        "--reserve", metavar="PERCENT", min=0.0, max=100.0, help="Of the battery at the landing; 20 by default."
    ),
]
GroundOption = Annotated[
    Path | None,
    typer.Option("--ground", metavar="PATH", help="Terrain elevation: .hgt, GeoTIFF, or a folder of them."),
]
GroundAboveHomeOption = Annotated[
    float | None,
    typer.Option("--ground-above-home", metavar="M", help="Height of the ground above home; by default that of home."),
]
ClearanceOption = Annotated[
    float, typer.Option("--clearance", min=0.0, max=1_000.0, help="Height above the ground to keep, m.")
]


class Flight:
    """The plane, the wind and the ground that a plan is rehearsed with."""

    def __init__(
        self,
        params: Path | None,
        learned_from: Path | None,
        wind_m_s: float | None,
        wind_from_deg: float | None,
        ground: Path | None,
        clearance_m: float,
        battery: tuple[float | None, float | None, float | None, float | None],
    ) -> None:
        from vencejo.rehearsal import Battery, learn

        parameters = parameters_of(params)
        capacity_mah, voltage_v, power_w, reserve_pct = battery
        self.clearance_m = clearance_m
        #: By the names of `vencejo.rehearsal.rehearse` and its like.
        self.given: dict[str, Any] = {
            "parameters": parameters,
            "airframe": None if learned_from is None else learn(learned_from, parameters=parameters).airframe,
            "battery": Battery(
                capacity_mah=capacity_mah, voltage_v=voltage_v, power_cruise_w=power_w, reserve_pct=reserve_pct
            ),
            "wind": wind_of(wind_m_s, wind_from_deg),
            "ground": ground_of(ground),
        }

    def fly(self, plan: Plan, *, gust_m_s: float = 0.0, seed: int = 0) -> Rehearsal:
        """Rehearse a plan.

        Raises
        ------
        InvalidRequest
            Also for a plan without a home, naming the option that gives one.
        """
        from vencejo.errors import InvalidRequest
        from vencejo.rehearsal import rehearse

        if plan.home is None:
            raise InvalidRequest("a rehearsal begins at home, and the plan has none; give one with --home LAT,LON,ALT")
        return rehearse(plan, **self.given, gust_m_s=gust_m_s, seed=seed, clearance_m=self.clearance_m)


def wind_of(speed_m_s: float | None, from_deg: float | None) -> Wind:
    """The wind of the options; a direction alone would be calm air that nobody meant."""
    from vencejo.landing import Wind

    if from_deg is not None and speed_m_s is None:
        raise Failed(f"--wind-from {from_deg:g} says no wind speed: add --wind M_S", Exit.USAGE)
    return Wind(from_deg or 0.0, speed_m_s or 0.0)


def parameters_of(file: Path | None) -> Mapping[str, float] | None:
    """The plane's, where there is a file of them."""
    from vencejo.params import load_params

    return None if file is None else load_params(file)


def ground_of(path: Path | None) -> Elevation | None:
    """Heights of the ground, where there are files of them."""
    from vencejo.rehearsal import Elevation

    return None if path is None else Elevation(path)


def numbers(option: str, text: str, wanted: str) -> list[float]:
    """Numbers with commas between them, as many as ``wanted`` names."""
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        found = []
    if len(found) != wanted.count(",") + 1:
        raise Failed(f"{option} {text}: write {wanted}, decimals with a point, as in 40.3332,-3.7978", Exit.USAGE)
    return found
