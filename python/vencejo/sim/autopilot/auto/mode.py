"""AUTO: the mode that flies the mission."""

from __future__ import annotations

from vencejo.sim.autopilot.interface import Mode, Severity
from vencejo.sim.autopilot.landing import Stage
from vencejo.sim.autopilot.modes.base import FlightMode

from .mission import RunState
from .names import Cmd

__all__ = ["MODES"]


class AutoMode(FlightMode):
    """Flies the mission."""

    number = Mode.AUTO
    auto_throttle = True
    navigates = True
    captures_direction = True

    def enter(self) -> None:
        plane = self._plane
        self._nav.stay()
        self._mission.start_or_resume(restart=plane.tune["MIS_RESTART"] == 1 and not plane.resume_forced)

    def leave(self) -> None:
        plane = self._plane
        is_landing = self._landing.active
        self._landing.end()
        if self._mission.state is RunState.RUNNING:
            self._mission.stop()
            if is_landing:
                self._mission.restart_landing(plane.distance_to_item)
        self._nav.hold_course_rad = None

    def navigate(self) -> None:
        plane = self._plane
        for seq in self._mission.update():
            plane.item_reached(seq)

    def update(self) -> None:
        plane = self._plane
        if self._mission.state is not RunState.RUNNING:
            # The mission was removed, or a landing could not be restarted.
            self._change_mode(Mode.RTL, "mission end")
            plane.say(Severity.INFO, "Aircraft in auto without a running mission")
            return
        command = self._mission.nav_command
        if (command == Cmd.NAV_TAKEOFF and not self._commands.takeoff_complete) or self._landing.aborting:
            self._climbout.order_climb(self._energy.airspeed_m_s())
        elif self._landing.active and self._landing.stage is not Stage.NORMAL:
            self._landing.order()
        elif command == Cmd.NAV_ALTITUDE_WAIT:
            plane.pilot.stick_aileron(0.0)
            plane.pilot.stick_elevator(0.0, 0.0)
        elif self._commands.scripted:
            self._commands.order_script()
        else:
            self._energy.order()

    def adjust_altitude(self) -> None:
        if not self._landing.adjust_altitude():
            self._nav.adjust_altitude()


MODES = (AutoMode,)
