"""The messages of mission, fence and rally points, and the parameters that mirror those plans."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Protocol

from vencejo.sim.autopilot.interface import AutopilotPort, MavResult, MissionState, Severity, Snapshot
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.guided import GuidedMessages
from vencejo.sim.mavlink.link import Link, Peer
from vencejo.sim.mavlink.mission import PlanItems, PlanKind, PlanProtocol
from vencejo.sim.mavlink.telemetry import TelemetryContext, build
from vencejo.sim.params import Parameter, ParamStore
from vencejo.sim.plan_store import MissionResult, PlanStore

__all__ = ["PlanMessages"]

_STORAGE_READY_S = 1.0
"""Until then no mission is accepted ("Only 0 items are supported")."""
_KINDS = (
    PlanKind(0, "Mission", (Severity.INFO, "Flight plan received")),
    PlanKind(1, "Fence", (Severity.DEBUG, "Fence Indexed OK"), says_when_cleared=True),
    PlanKind(2, "Rally", None),
)

Handler = Callable[[Peer, MavMessage], None]


class Vehicle(Protocol):
    """The part of :class:`vencejo.sim.mavlink.component.PlaneComponent` that these messages use."""

    autopilot: AutopilotPort
    params: ParamStore
    plans: PlanStore

    def snapshot(self) -> Snapshot:
        """The present state."""
        ...

    def context(self) -> TelemetryContext:
        """Telemetry data that is not in the snapshot."""
        ...

    def reply(self, peer: Peer, message: MavMessage) -> None:
        """Send to one peer's link."""

    def say(self, severity: Severity, text: str) -> None:
        """Send a text to every link."""

    def broadcast(self, message: MavMessage | None) -> None:
        """Send a message to every link."""


class PlanMessages:
    """The plan transfers of one plane.

    Parameters
    ----------
    vehicle : Vehicle
    guided : GuidedMessages
        Handles mission items that are guided commands.
    value_of : callable
        Builds PARAM_VALUE of a parameter.
    """

    def __init__(self, vehicle: Vehicle, guided: GuidedMessages, value_of: Callable[[Parameter], MavMessage]) -> None:
        self._vehicle = vehicle
        self._guided = guided
        self._value_of = value_of
        self._fence_total = vehicle.params.integer("FENCE_TOTAL")
        self._announced: dict[str, float] = {}
        self._announced_revisions: tuple[int, ...] = ()
        plans = vehicle.plans
        plans.mission_store.may_clear = self._mission_may_go
        stores: tuple[PlanItems, ...] = (plans.mission_store, plans.fence_store, plans.rally_store)
        self._protocols = {
            kind.number: PlanProtocol(
                kind,
                store,
                reply=vehicle.reply,
                say=vehicle.say,
                now_s=lambda: vehicle.autopilot.time_s,
                capacity=self._mission_capacity if kind.number == 0 else None,
            )
            for kind, store in zip(_KINDS, stores, strict=True)
        }
        self.by_file = {f"{kind.name.lower()}.dat": (kind, store) for kind, store in zip(_KINDS, stores, strict=True)}
        """Kind and store of each plan by the name of its file in ``@MISSION``."""
        self.handlers: Mapping[str, Handler] = {
            "MISSION_COUNT": self._of_plan(lambda plan, p, m: plan.on_count(p, m)),
            "MISSION_WRITE_PARTIAL_LIST": self._of_plan(lambda plan, p, m: plan.on_write_partial(p, m)),
            "MISSION_ITEM": self._on_item,
            "MISSION_ITEM_INT": self._on_item,
            "MISSION_REQUEST_LIST": self._of_plan(lambda plan, p, _: plan.on_request_list(p)),
            "MISSION_REQUEST": self._of_plan(lambda plan, p, m: plan.on_request(p, m.seq, as_float=True)),
            "MISSION_REQUEST_INT": self._of_plan(lambda plan, p, m: plan.on_request(p, m.seq, as_float=False)),
            "MISSION_CLEAR_ALL": self._of_plan(lambda plan, p, _: plan.on_clear(p)),
            "MISSION_SET_CURRENT": self._on_set_current,
        }

    def forget(self, link: Link) -> None:
        """Handle the loss of a link."""
        for plan in self._protocols.values():
            plan.forget(link)

    def tick(self) -> None:
        """Repeat requests and time out; ten times a second."""
        for plan in self._protocols.values():
            plan.tick()
        self._erase_fence()

    def _erase_fence(self) -> None:
        """Erase a fence whose FENCE_TOTAL has become 0, as AC_PolyFence_loader::update does for old stations.

        A station may set the parameter; and one or two circles alone, which count 0, are erased after they were accepted
        when they replace a fence that counted.
        """
        total, before = self._vehicle.params.integer("FENCE_TOTAL"), self._fence_total
        self._fence_total = total
        if total == 0 and before != 0 and self._vehicle.plans.fence_store.shapes:
            self._vehicle.plans.fence_store.clear()
            self._announced_revisions = self._revisions  # without another word

    def reset(self) -> None:
        """Reset after a reboot."""
        for plan in self._protocols.values():
            plan.reset()

    def _of_plan(self, action: Callable[[PlanProtocol, Peer, MavMessage], None]) -> Handler:
        """The handler of a message that names its plan."""

        def handle(peer: Peer, message: MavMessage) -> None:
            plan = self._protocols.get(message.mission_type)
            if plan is not None:
                action(plan, peer, message)
                return
            unsupported = int(MissionResult.UNSUPPORTED)
            self._vehicle.reply(
                peer,
                dialect.MAVLink_mission_ack_message(peer.system, peer.component, unsupported, message.mission_type),
            )

        return handle

    def _on_item(self, peer: Peer, message: MavMessage) -> None:
        if message.mission_type == 0 and message.current in (2, 3):
            self._guided.on_item(peer, message)
        else:
            self._of_plan(lambda plan, p, m: plan.on_item(p, m))(peer, message)

    def _on_set_current(self, peer: Peer, message: MavMessage) -> None:
        """Make an item the current one. The answer has the requested number, even that of home or a DO command."""
        vehicle = self._vehicle
        if vehicle.autopilot.set_mission_current(message.seq) is MavResult.ACCEPTED:
            answer = build(42, replace(vehicle.autopilot.snapshot(), mission_current=message.seq), vehicle.context())
            if answer is not None:
                vehicle.reply(peer, answer)

    def _mission_may_go(self) -> bool:
        """Whether the mission may be removed: not while it is flown (AP_Mission::clear)."""
        now = self._vehicle.snapshot()
        return not (now.armed and now.mission_state is MissionState.ACTIVE)

    def _mission_capacity(self) -> int:
        is_ready = self._vehicle.autopilot.time_s >= _STORAGE_READY_S
        return self._vehicle.plans.mission_store.max_items if is_ready else 0

    @property
    def _revisions(self) -> tuple[int, ...]:
        plans = self._vehicle.plans
        return plans.mission_store.revision, plans.fence_store.revision, plans.rally_store.revision

    def announce_totals(self) -> None:
        """Announce the parameters that mirror the stored plan when they change."""
        plans, revisions = self._vehicle.plans, self._revisions
        if revisions == self._announced_revisions:
            return
        if self._announced_revisions and self._announced_revisions[1] != revisions[1]:
            # The loader writes FENCE_TOTAL each time.
            self._announced.pop("FENCE_TOTAL", None)
        self._announced_revisions = revisions
        totals = (
            ("MIS_TOTAL", len(plans.mission_store)),
            ("FENCE_TOTAL", plans.fence_store.vertex_total),
            ("RALLY_TOTAL", len(plans.rally_store)),
        )
        for name, total in totals:
            if self._announced.get(name) != total:
                self._announced[name] = total
                if self._vehicle.params.get(name) != total or name == "FENCE_TOTAL":
                    self._vehicle.broadcast(self._value_of(self._vehicle.params.set(name, total)))
