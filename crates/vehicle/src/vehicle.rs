//! One vehicle: its telemetry, its plans' states, and every request to it, as one state machine.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Address, ComponentId, Message, MonoTime};

use crate::plan_state::PlanState;
use crate::progress::MissionProgress;
use crate::request::{Output, Request, RequestId};
use crate::telemetry::{Group, StatusLog, Telemetry};

/// One vehicle. See the [crate](crate).
#[derive(Debug)]
pub struct Vehicle {}

impl Vehicle {
    /// A vehicle at `address` (its autopilot) as seen by us at `our`.
    pub fn new(address: Address, our: Address, config: VehicleConfig, now: MonoTime) -> Self;
    /// Its autopilot.
    pub fn address(&self) -> Address;
    /// A message from component `from` of the vehicle. Returns the telemetry group that it changed.
    pub fn on_message(&mut self, from: ComponentId, message: &Message, now: MonoTime) -> Option<Group>;
    /// A message that another system sent to the vehicle and that passed by us.
    pub fn on_foreign(&mut self, from: Address, message: &Message, now: MonoTime);
    /// Lets time pass; call at [`Self::deadline`] or later.
    pub fn on_time(&mut self, now: MonoTime);
    /// When [`Self::on_time`] is wanted next.
    pub fn deadline(&self) -> Option<MonoTime>;
    /// Starts a request. Its result comes as [`Output::Finished`], even when it is refused at once.
    pub fn request(&mut self, request: Request, now: MonoTime) -> RequestId;
    /// Gives a request up; its result comes as [`Output::Finished`] too.
    pub fn cancel(&mut self, id: RequestId, now: MonoTime);
    /// The next thing that the owner must do.
    pub fn poll_output(&mut self) -> Option<Output>;
    /// What it says about itself.
    pub fn telemetry(&self) -> &Telemetry;
    /// What it wrote.
    pub fn texts(&self) -> &StatusLog;
    /// Where it stands in its mission.
    pub fn progress(&self) -> MissionProgress;
    /// What is known of a plan on board.
    pub fn plan_state(&self, kind: PlanKind) -> PlanState;
    /// Whether it is heard (anything within 5 s).
    pub fn is_heard(&self, now: MonoTime) -> bool;
    /// When anything of it was heard last.
    pub fn heard_at(&self) -> MonoTime;
    /// Round trip by TIMESYNC, smoothed.
    pub fn round_trip(&self) -> Option<std::time::Duration>;
}
