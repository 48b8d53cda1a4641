"""ArDroneExtra: take-off and landing, as marks for a mission or alone; the camera; levelling."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Final, Protocol

from vencejo.errors import Busy, Cancelled, CommandRefused, VencejoError
from vencejo.jderobot.access import despite_mixed_plan
from vencejo.jderobot.marks import Marks, Taken
from vencejo.jderobot.settings import IceSettings
from vencejo.jderobot.subject import Subject, stand_down
from vencejo.jderobot.workers import Workers
from vencejo.landing import landing_item
from vencejo.vehicle import Vehicle

__all__ = ["CameraSwitch", "Extra"]

_LEVEL: Final = 2.0
"""Parameter 5 of PREFLIGHT_CALIBRATION: the accelerometers' level."""
_FIXED_WING: Final = 1


class CameraSwitch(Protocol):
    """What ArDroneExtra does with cameras (`vencejo.jderobot.camera.Camera`)."""

    def toggle(self) -> str:
        """Take the next camera; its name."""

    def record(self, wanted: bool) -> None:
        """Start or stop recording."""


class Extra:
    """Servant of ``jderobot::ArDroneExtra``. Nothing is returned: what cannot be done stands in the log and the station."""

    def __init__(
        self,
        subject: Subject,
        workers: Workers,
        marks: Marks,
        settings: IceSettings,
        camera: CameraSwitch,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._subject = subject
        self._workers = workers
        self._marks = marks
        self._settings = settings
        self._camera = camera
        self._clock = clock
        self._changed = threading.Condition()
        self._closed = False
        self._despite = False
        """Whether the last mark came with leave to fly a mission that may be mixed."""
        self._thread = threading.Thread(target=self._watch, name="vencejo-ice-marks", daemon=True)
        self._thread.start()

    def takeoff(self, current: Any = None) -> None:
        """Make the first pose of the next mission the take-off; alone, take off."""
        self._mark(despite_mixed_plan(current), takeoff=True)

    def land(self, current: Any = None) -> None:
        """Make the last pose of the next mission the landing; alone, land."""
        self._mark(despite_mixed_plan(current), land=True)

    def toggleCam(self, current: Any = None) -> None:
        """Give the pictures of the next camera."""
        self._subject.tell(f"camera: {self._camera.toggle()}", is_problem=False)

    def reset(self, current: Any = None) -> None:
        """Forget the marks. An AR.Drone stops its motors; this does not: nothing is sent."""
        self._marks.take()

    def recordOnUsb(self, record: bool, current: Any = None) -> None:
        """Record the camera, or stop it."""

        def work() -> None:
            try:
                self._camera.record(record)
            except VencejoError as error:
                self._subject.tell(f"recording: {error}")

        self._later("recording", work)

    def ledAnimation(self, type: int, duration: float, req: float, current: Any = None) -> None:
        """No vehicle of ours has these lights."""
        self._subject.tell("ledAnimation: this vehicle has no such lights")

    def flightAnimation(self, type: int, duration: float, current: Any = None) -> None:
        """No vehicle of ours dances."""
        self._subject.tell("flightAnimation: this vehicle has no such figures")

    def flatTrim(self, current: Any = None) -> None:
        """Take the present attitude for level; only disarmed."""
        self._later("flatTrim", self._level)

    def close(self) -> None:
        """End the watch; marks that wait are dropped."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join(timeout=5.0)

    def _later(self, what: str, work: Callable[[], None]) -> None:
        """Do what takes a while; these operations answer at once."""
        try:
            self._workers.later(work)
        except Busy as error:
            self._subject.tell(f"{what}: {error}")

    def _mark(self, despite: bool, *, takeoff: bool = False, land: bool = False) -> None:
        with self._changed:
            self._despite = despite
            self._marks.mark(self._clock(), takeoff=takeoff, land=land)
            self._changed.notify_all()

    def _watch(self) -> None:
        while True:
            with self._changed:
                if self._closed:
                    return
                now = self._clock()
                taken = self._marks.take_due(now)
                if taken == Taken():
                    due = self._marks.due_s
                    self._changed.wait(None if due is None else max(0.0, due - now))
                    continue
                despite = self._despite
            self.act_alone(taken, despite)

    def act_alone(self, taken: Taken, despite: bool = False) -> None:
        """Do what was marked, without a mission."""
        if taken.takeoff and taken.land:
            self._subject.tell("take-off and landing were both marked and no mission followed; nothing was done")
            return
        try:
            vehicle = self._subject.hear()
            if taken.takeoff:
                self._take_off(vehicle, despite)
            elif taken.land:
                self._land(vehicle, despite)
        except VencejoError as error:
            self._subject.tell(f"{'take-off' if taken.takeoff else 'landing'}: {error}")

    def _take_off(self, vehicle: Vehicle, despite: bool) -> None:
        if self._settings.missions == "upload":
            self._subject.tell("take-off: nothing is armed over these interfaces (Missions is upload)")
            return
        telemetry = vehicle.telemetry
        if telemetry.is_on_ground is False:
            self._subject.tell("take-off: the vehicle is in the air already", is_problem=False)
            return
        self._subject.tell("taking off", is_problem=False)
        if not telemetry.is_armed:
            # In the landing sequence of its last mission it would not arm.
            vehicle.prepare_flight(despite_mixed_plan=despite)
        self._workers.go_on()
        mode = vehicle.telemetry.mode
        if telemetry.heartbeat is not None and telemetry.heartbeat.mav_type == _FIXED_WING:
            # It begins to roll when it is armed.
            vehicle.takeoff(alt_rel_home_m=self._settings.takeoff_alt_m)
            self._arm(vehicle, mode, despite)
        else:
            vehicle.set_mode("GUIDED")
            self._arm(vehicle, mode, despite)
            self._workers.go_on(otherwise=lambda: None if telemetry.is_armed else stand_down(vehicle))
            vehicle.takeoff(alt_rel_home_m=self._settings.takeoff_alt_m)

    def _arm(self, vehicle: Vehicle, mode_before: str | None, despite: bool) -> None:
        """Arm; if that is refused, restore the mode: a pilot who arms later by radio expects it."""
        try:
            self._workers.go_on()
            vehicle.arm(despite_mixed_plan=despite)
        except (CommandRefused, Cancelled):
            if mode_before is not None:
                vehicle.set_mode(mode_before)
            raise

    def _land(self, vehicle: Vehicle, despite: bool) -> None:
        if vehicle.telemetry.is_on_ground:
            self._subject.tell("landing: the vehicle is on the ground already", is_problem=False)
            return
        try:
            vehicle.land(despite_mixed_plan=despite)
            self._subject.tell("landing", is_problem=False)
        except CommandRefused as error:
            # An ArduPlane finds a landing by DO_LAND_START alone; a mission may have one without it.
            item = self._landing_of(vehicle)
            if item is not None:
                vehicle.start_mission(from_item=item, despite_mixed_plan=despite)
                self._subject.tell(f"landing: flying the mission's own, from item {item}", is_problem=False)
                return
            vehicle.return_to_launch()
            self._subject.tell(f"landing: {error}; it returns home instead, because its mission has no landing")

    def _landing_of(self, vehicle: Vehicle) -> int | None:
        """Where the landing of the mission on board begins; ``None`` when it has none, or cannot be read."""
        try:
            return landing_item(vehicle.download())
        except VencejoError as error:
            self._subject.tell(f"landing: the mission cannot be read: {error}")
            return None

    def _level(self) -> None:
        try:
            vehicle = self._subject.hear()
            if vehicle.telemetry.is_armed is not False:
                self._subject.tell("flatTrim: only when the vehicle is disarmed")
                return
            vehicle.command("PREFLIGHT_CALIBRATION", 0.0, 0.0, 0.0, 0.0, _LEVEL)
            self._subject.tell("flatTrim: the present attitude is level now", is_problem=False)
        except VencejoError as error:
            self._subject.tell(f"flatTrim: {error}")
