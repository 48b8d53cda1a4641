//! Types of the HTTP API and the WebSocket, separate from the core's so that the core can change without breaking
//! clients.
//!
//! Field names carry unit and datum. An absent value is null, never NaN, 0 or −1. Mission items are counted from 1,
//! without home.

pub mod camera;
pub mod cause;
pub mod command;
pub mod command_table;
pub mod landing;
pub mod link;
pub mod maps;
pub mod message;
pub mod operation;
pub mod plan;
pub mod recording;
pub mod rehearsal;
pub mod replay;
pub mod roster;
pub mod separation;
pub mod session;
pub mod signing;
pub mod socket;
pub mod storage;
pub mod survey;
pub mod vehicle;

use std::borrow::Cow;

use serde::Serialize;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};
use vencejo_vehicle::Refusal;

pub use cause::Cause;
pub use command::Done;
pub use command_table::{CommandCategory, CommandInfo, CommandParam, CommandSupport};
pub use landing::{
    Landing, LandingAlternative, LandingCaution, LandingMove, LandingReasonText, LandingRequest, Runway,
};
pub use link::{FleetNetwork, LinkFault, LinkInfo, LinkState, NewLink, SerialPort};
pub use message::RawMessage;
pub use operation::{Operation, OperationKind, OperationResult, OperationState};
pub use plan::{
    CountedItems, Fence, FenceZone, FindingFix, FrameChange, LatLon, PartComparison, Plan, PlanCertainty, PlanCheck,
    PlanComparison, PlanFormat, PlanItem, PlanKind, PlanOnBoard, PlanState, PlanStates, PlanUncertainty, RallyPoint,
    ReturnPoint, Unconverted, Way, WayRequest, ZoneShape,
};
pub use rehearsal::{
    Assessment, BatteryLeft, Beginning, Corridor, Decision, EndingCount, ExpectedTrack, FlightNow, LearnedPlane,
    Outlook, PlaneProfile, Rehearsal, RehearsalRequest, RehearsedFlight, RehearsedPassage, RehearsedTrack, Spread,
    SpreadRequest, VehicleProfile, WhatIf, WhatIfRequest, WhatIfs,
};
pub use session::{DeclinedRequest, NewSession, Role, SessionInfo, VehicleControl};
pub use signing::{ChangeSigning, SigningAct, SigningInfo};
pub use socket::{ClientMessage, EventDetail, ServerMessage};
pub use vehicle::{
    FlightParameters, FlightPreparation, MissionProgress, NewParam, Param, Text, VehicleState, VehicleSummary,
};

/// The server.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Info {
    /// Always `vencejo`.
    pub name: String,
    /// Version of the server.
    pub version: String,
    /// Whether `POST /session` needs a token.
    pub needs_token: bool,
}

/// Kind of a refusal by the vehicle (the core's [`Refusal`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RefusalCode(&'static str);

impl From<Refusal> for RefusalCode {
    fn from(refusal: Refusal) -> Self {
        Self(refusal.code())
    }
}

impl PartialSchema for RefusalCode {
    fn schema() -> RefOr<Schema> {
        let codes = Refusal::ALL.iter().map(|refusal| refusal.code());
        let schema = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(codes));
        schema.description(Some("Kind of a refusal by the vehicle.")).into()
    }
}

impl ToSchema for RefusalCode {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("RefusalCode")
    }
}

/// An error (RFC 9457), served as `application/problem+json`. Its texts are English; `cause` carries the same
/// information for programs, for example to show it in another language.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Problem {
    /// Stable type: `urn:vencejo:` followed by the code of `cause`, such as `urn:vencejo:command-refused`.
    pub r#type: String,
    /// Short description of the type.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What was wrong, where, and how to correct it.
    pub detail: String,
    /// Texts that the vehicle sent about it, or the differences that were found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub reasons: Vec<String>,
    /// Kind of each of the vehicle's `reasons`; null when no remedy is known for it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub refusals: Vec<Option<RefusalCode>>,
    /// How to resolve it, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub remedy: Option<String>,
    /// Machine-readable cause.
    pub cause: Cause,
}
