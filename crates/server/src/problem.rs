//! The one table from the core's errors to `application/problem+json` (RFC 9457): a [`Cause`] for programs, English for people.

use axum::extract::rejection::{BytesRejection, JsonRejection, QueryRejection};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::collections::BTreeMap;

use utoipa::IntoResponses;
use utoipa::openapi::{ContentBuilder, Ref, RefOr, Response as Described, ResponseBuilder};
use vencejo_flight::plan::PlanKind;
use vencejo_flight::{FlightError, LandingProblem, Plain, SurveyProblem};
use vencejo_link::{LinkError, MAX_LINKS};
use vencejo_maps::MapError;
use vencejo_proto::message_name;
use vencejo_station::{SigningError, StationError};
use vencejo_store::LowSpace;
use vencejo_vehicle::command::CommandName;
use vencejo_vehicle::transfer::{FTP_OPEN, NoPlanKinds, TransferError};
use vencejo_vehicle::{Refusal, VehicleError, misread};

use crate::convert;
use crate::dto;
use crate::dto::cause::{Cause, Crowd, OnlyMissionReason, Thing, finite};

/// Differences of a plan that are listed at most.
const MAX_REASONS: usize = 50;

/// What a handler ends with when it cannot do what it was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem(pub Box<dto::Problem>);

impl IntoResponses for Problem {
    fn responses() -> BTreeMap<String, RefOr<Described>> {
        let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
        let response = ResponseBuilder::new().description("What was wrong and what to do");
        let response = response.content("application/problem+json", content).build();
        BTreeMap::from([("default".to_owned(), RefOr::T(response))])
    }
}

impl Problem {
    /// A problem: its kind, status and title follow from the cause; the detail says in English what was wrong, where, and what
    /// to do.
    pub fn new(cause: Cause, detail: impl Into<String>) -> Self {
        let (status, title) = kind_of(&cause);
        Self(Box::new(dto::Problem {
            r#type: format!("urn:vencejo:{}", cause.code()),
            title: title.to_owned(),
            status: status.as_u16(),
            detail: detail.into(),
            reasons: Vec::new(),
            refusals: Vec::new(),
            remedy: None,
            cause,
        }))
    }

    /// With what to do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    /// With the lines that tell more.
    #[must_use]
    pub fn reasons(mut self, reasons: impl IntoIterator<Item = String>) -> Self {
        self.0.reasons = reasons.into_iter().take(MAX_REASONS).collect();
        self
    }

    /// With what the vehicle wrote, and what to do about that.
    fn refused(mut self, reasons: &[String], remedies: &[&str]) -> Self {
        self = self.reasons(reasons.iter().cloned());
        let refusals: Vec<_> = self.0.reasons.iter().map(|reason| Refusal::of(reason)).collect();
        if !remedies.is_empty() {
            self.0.remedy = Some(remedies.join("; "));
        }
        self.0.refusals = refusals.into_iter().map(|refusal| refusal.map(dto::RefusalCode::from)).collect();
        self
    }

    /// The request makes no sense.
    pub fn invalid(detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self::new(Cause::InvalidRequest { problem: detail.clone() }, detail)
    }

    /// A value that may not be.
    pub fn invalid_value(field: &str, value: impl ToString, expected: &str) -> Self {
        let value = value.to_string();
        let detail = format!("{field} is {value}: {expected}");
        Self::new(Cause::InvalidValue { field: field.to_owned(), value, expected: expected.to_owned() }, detail)
    }

    /// A number of a request that is out of its range.
    pub fn out_of_range<T: std::fmt::Display>(field: &str, value: T, low: T, high: T) -> Self {
        Self::invalid_value(field, value, &format!("it goes from {low} to {high}"))
    }

    /// There is no such thing.
    pub fn not_found(what: Thing, name: impl ToString, detail: impl Into<String>) -> Self {
        Self::new(Cause::NotFound { what, name: name.to_string() }, detail)
    }

    /// Something that only a session may do.
    pub fn no_session() -> Self {
        Self::new(Cause::NoSession, "this needs a session, and yours is not known")
            .remedy("open one with POST /api/v1/session, with the token that the server shows in its terminal")
    }

    /// A token that is none of ours.
    pub fn bad_token() -> Self {
        Self::new(Cause::BadToken, "this token is not one of this server's")
            .remedy("copy the whole address from the server's terminal")
    }

    /// One more token after too many wrong ones.
    pub fn tokens_slowed(wait: std::time::Duration) -> Self {
        let wait_s = wait.as_secs().max(1);
        Self::new(Cause::TokensSlowed { wait_s }, "too many wrong tokens came from this address")
            .remedy(format!("wait {wait_s} s, then copy the whole address from the server's terminal"))
    }

    /// Something that viewers may not do.
    pub fn viewer() -> Self {
        Self::new(Cause::Role, "this session may look but not command")
            .remedy("open a session with the operator's token")
    }

    /// Something that needs control, which another session has or nobody.
    pub fn no_control(holder: Option<&str>) -> Self {
        let cause = Cause::Control { holder: holder.map(str::to_owned) };
        match holder {
            Some(holder) => {
                Self::new(cause, format!("{holder} holds control")).remedy("ask for it: POST /api/v1/control/request")
            }
            None => Self::new(cause, "nobody holds control").remedy("take it: POST /api/v1/control/take"),
        }
    }

    /// Too much at once.
    pub fn too_many(what: Crowd, limit: usize, detail: impl Into<String>) -> Self {
        Self::new(Cause::TooMany { what, limit: limit as u64 }, detail)
    }

    /// The server is on its way down, or a task of it has died.
    pub fn closed() -> Self {
        from_station(&StationError::Closed)
    }
}

/// Status and title of each kind.
fn kind_of(cause: &Cause) -> (StatusCode, &'static str) {
    match cause {
        Cause::Host { .. } | Cause::Origin { .. } => (StatusCode::FORBIDDEN, "Not from there"),
        Cause::NoSession => (StatusCode::UNAUTHORIZED, "No session"),
        Cause::BadToken => (StatusCode::UNAUTHORIZED, "Wrong token"),
        Cause::Role => (StatusCode::FORBIDDEN, "Not allowed to a viewer"),
        Cause::Control { .. } => (StatusCode::LOCKED, "Control is elsewhere"),
        Cause::NeedsConfirmation { .. } => (StatusCode::PRECONDITION_REQUIRED, "Has to be confirmed"),
        Cause::BadConfirmation => (StatusCode::PRECONDITION_FAILED, "Not confirmed"),
        Cause::TooMany { .. } => (StatusCode::TOO_MANY_REQUESTS, "Too much at once"),
        Cause::SigningUnproven => (StatusCode::GATEWAY_TIMEOUT, "The vehicle does not show the change"),
        Cause::SigningNoKeys | Cause::SigningStorage { .. } => {
            (StatusCode::INTERNAL_SERVER_ERROR, "The signing keys cannot be used")
        }
        Cause::SigningKeyName { .. } => (StatusCode::CONFLICT, "Not that name for a key"),
        Cause::SigningBusy => (StatusCode::CONFLICT, "Something else is under way"),
        Cause::SigningRefused { .. } => (StatusCode::CONFLICT, "The vehicle refused"),
        Cause::SigningState { .. } | Cause::SigningNotDisarmed { .. } | Cause::SigningNotPrivate { .. } => {
            (StatusCode::CONFLICT, "Signing is not changed now")
        }
        Cause::Closed => (StatusCode::SERVICE_UNAVAILABLE, "The station is closed"),
        Cause::InvalidRequest { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a valid request"),
        Cause::InvalidValue { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a valid value"),
        Cause::MediaType => (StatusCode::UNSUPPORTED_MEDIA_TYPE, "Not JSON"),
        Cause::BodyTooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "Too large"),
        Cause::BodyTooSlow => (StatusCode::REQUEST_TIMEOUT, "Too slow"),
        Cause::TokensSlowed { .. } => (StatusCode::TOO_MANY_REQUESTS, "Too many wrong tokens"),
        Cause::Method => (StatusCode::METHOD_NOT_ALLOWED, "Not with this method"),
        Cause::NotFound { .. } => (StatusCode::NOT_FOUND, "Not found"),
        Cause::RecordingAsLink => (StatusCode::UNPROCESSABLE_ENTITY, "Not over the network"),
        Cause::Camera { .. } => (StatusCode::CONFLICT, "The camera cannot do that"),
        Cause::HeartbeatFollowsOperator => (StatusCode::CONFLICT, "The heartbeat follows the operator"),
        Cause::Internal => (StatusCode::INTERNAL_SERVER_ERROR, "Something went wrong"),
        Cause::LinkAddress { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a link string"),
        Cause::Recorder { .. } => (StatusCode::INTERNAL_SERVER_ERROR, "Nothing can be recorded"),
        Cause::NoVehicle { .. } => (StatusCode::NOT_FOUND, "No such vehicle"),
        Cause::NotSent { .. } => (StatusCode::CONFLICT, "Not sent"),
        Cause::CommandRefused { .. } => (StatusCode::CONFLICT, "The vehicle refused"),
        Cause::RemoteRefused { .. } => (StatusCode::CONFLICT, "The station on board refused"),
        Cause::CommandTimeout { .. } | Cause::MessageNotReceived { .. } | Cause::TransferTimeout { .. } => {
            (StatusCode::GATEWAY_TIMEOUT, "The vehicle did not answer")
        }
        Cause::NotConfirmed { .. } => (StatusCode::GATEWAY_TIMEOUT, "The vehicle does not show it"),
        Cause::VehicleLost { .. } => (StatusCode::GATEWAY_TIMEOUT, "The vehicle is not heard"),
        Cause::CommandBusy { .. } | Cause::TransferBusy { .. } | Cause::FilesBusy { .. } => {
            (StatusCode::CONFLICT, "Something else is under way")
        }
        Cause::UnknownMode { .. } | Cause::NoModeFor { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "No such mode"),
        Cause::PlanUnknown { .. } => (StatusCode::CONFLICT, "The plan on board is not known"),
        Cause::TooOld { .. } => (StatusCode::CONFLICT, "The vehicle's firmware is too old"),
        Cause::Armed { .. } => (StatusCode::CONFLICT, "The vehicle is armed"),
        Cause::InTheAir { .. } => (StatusCode::CONFLICT, "The vehicle is in the air"),
        Cause::HomeUnknown => (StatusCode::CONFLICT, "Home is not known"),
        Cause::Rebooted => (StatusCode::CONFLICT, "The vehicle restarted"),
        Cause::Cancelled => (StatusCode::CONFLICT, "Cancelled"),
        Cause::Unreached { .. } => (StatusCode::GATEWAY_TIMEOUT, "The vehicle does not hear us"),
        Cause::NoProgress { .. } => (StatusCode::GATEWAY_TIMEOUT, "The transfer got nowhere"),
        Cause::PlanRefused { .. } => (StatusCode::CONFLICT, "The vehicle refused the plan"),
        Cause::PlanMismatch { .. } => (StatusCode::CONFLICT, "The vehicle holds another plan"),
        Cause::Unverified { .. } => (StatusCode::GATEWAY_TIMEOUT, "What the vehicle holds is unknown"),
        Cause::OnlyMission { .. } => (StatusCode::CONFLICT, "The vehicle takes only its mission"),
        Cause::NotCleared { .. } => (StatusCode::CONFLICT, "The plan is still on board"),
        Cause::TooLarge { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Too large"),
        Cause::VehicleFile { .. } => (StatusCode::BAD_GATEWAY, "The vehicle's file cannot be used"),
        Cause::UnknownParam { .. } => (StatusCode::NOT_FOUND, "No such parameter"),
        Cause::ParamRefused { .. } | Cause::ParamNotKept { .. } => {
            (StatusCode::CONFLICT, "The vehicle did not take the value")
        }
        Cause::InvalidParam { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a valid parameter"),
        Cause::PlanUnsound { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The plan has errors"),
        Cause::NotOnEarth { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not on Earth"),
        Cause::LandingDirection { .. } | Cause::LandingWind { .. } => {
            (StatusCode::UNPROCESSABLE_ENTITY, "No landing there")
        }
        Cause::BadSurvey { .. }
        | Cause::SurveyCrosses { .. }
        | Cause::SurveyItems { .. }
        | Cause::SurveyWind { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "No survey there"),
        Cause::BadItem { .. } | Cause::BadPlan { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a valid plan"),
        Cause::BadFile { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a valid file"),
        Cause::NoMaps => (StatusCode::SERVICE_UNAVAILABLE, "No maps here"),
        Cause::NoSource { .. } => (StatusCode::NOT_FOUND, "No such map source"),
        Cause::NoTile => (StatusCode::NOT_FOUND, "No tile there"),
        Cause::SourceKey { .. } => (StatusCode::CONFLICT, "The source needs a key"),
        Cause::SourceInvalid { .. } => (StatusCode::CONFLICT, "The source cannot be used"),
        Cause::SourceSettings { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The settings are wrong"),
        Cause::SourceFile { .. } => (StatusCode::CONFLICT, "The file of the sources is wrong"),
        Cause::SourceFailed { .. } => (StatusCode::BAD_GATEWAY, "The map service failed"),
        Cause::SourceTimeout { .. } => (StatusCode::GATEWAY_TIMEOUT, "The map service is silent"),
        Cause::SourceOffline { .. } => (StatusCode::SERVICE_UNAVAILABLE, "The map service is not reached"),
        Cause::SourceBusy => (StatusCode::SERVICE_UNAVAILABLE, "Too much at once"),
        Cause::OfflineRefused { .. } => (StatusCode::CONFLICT, "Not for offline use"),
        Cause::AreaTooLarge { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The area is too large"),
        Cause::MapFile { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a usable file"),
        Cause::MapStorage { .. } => (StatusCode::INTERNAL_SERVER_ERROR, "The disk or a database failed"),
        Cause::LowSpace { .. } => (StatusCode::INSUFFICIENT_STORAGE, "The disk is too full"),
        Cause::DraftConflict { .. } => (StatusCode::CONFLICT, "The draft was changed meanwhile"),
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, axum::Json(*self.0)).into_response();
        let kind = HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        response
    }
}

/// The problem for an error of the station.
pub fn from_station(error: &StationError) -> Problem {
    let cause = match error {
        StationError::Vehicle(error) => return from_vehicle(error),
        StationError::Address(error) => Cause::LinkAddress { problem: error.to_string() },
        StationError::Link(LinkError::UnknownLink(id)) => Cause::NotFound { what: Thing::Link, name: id.0.to_string() },
        StationError::Link(LinkError::TooManyLinks) => Cause::TooMany { what: Crowd::Links, limit: MAX_LINKS as u64 },
        StationError::NoVehicle { waited, .. } => Cause::NoVehicle { waited_s: waited.as_secs_f64() },
        StationError::Control { holder } => return Problem::no_control(Some(holder)),
        StationError::NeedsConfirmation { challenge } => {
            let cause = Cause::NeedsConfirmation {
                act: challenge.danger.code().to_owned(),
                vehicle: challenge.vehicle.number(),
                confirmation: challenge.id.clone(),
                valid_s: challenge.valid_for.as_secs_f64(),
            };
            return Problem::new(cause, error.to_string())
                .remedy("make the same request again with the header Vencejo-Confirmation: the cause's confirmation");
        }
        StationError::BadConfirmation => Cause::BadConfirmation,
        StationError::RemoteRefused { name, why } => Cause::RemoteRefused { vehicle: name.clone(), why: why.clone() },
        StationError::Closed => Cause::Closed,
        StationError::Signing(error) => signing_cause(error),
        StationError::CannotRecord { reason } => Cause::Recorder { reason: reason.clone() },
        _ => Cause::Internal,
    };
    Problem::new(cause, error.to_string())
}

fn signing_cause(error: &SigningError) -> Cause {
    match error.clone() {
        SigningError::NoFolder => Cause::SigningNoKeys,
        SigningError::Storage { problem, .. } => Cause::SigningStorage { problem },
        SigningError::BadName { name }
        | SigningError::NameTaken { name }
        | SigningError::NoSuchKey { name }
        | SigningError::KeyInUse { name } => Cause::SigningKeyName { name },
        SigningError::WrongState { signs } => Cause::SigningState { signs },
        SigningError::NotDisarmed { armed } => Cause::SigningNotDisarmed { armed },
        SigningError::NotPrivate { link } => Cause::SigningNotPrivate { link },
        SigningError::Busy => Cause::SigningBusy,
        SigningError::Refused { text } => Cause::SigningRefused { text },
        SigningError::Unproven => Cause::SigningUnproven,
        _ => Cause::Internal,
    }
}

/// A command by its name, else by its number.
fn name_of(command: CommandName) -> String {
    command.name().map_or_else(|| command.0.to_string(), str::to_owned)
}

/// The problem for an error of a vehicle.
pub fn from_vehicle(error: &VehicleError) -> Problem {
    let cause = match error {
        VehicleError::Transfer(error) => return from_transfer(error),
        VehicleError::Plan(error) => return from_flight(error),
        VehicleError::CommandRefused { command, result, cure, .. } => Cause::CommandRefused {
            command: name_of(*command),
            result: result.name().trim_start_matches("MAV_RESULT_").to_owned(),
            cure_mode: cure.map(|mode| mode.to_string()),
        },
        VehicleError::NotConfirmed { command, wanted, observed, within, .. } => Cause::NotConfirmed {
            command: name_of(*command),
            wanted: wanted.clone(),
            observed: observed.clone(),
            within_s: within.as_secs_f64(),
        },
        VehicleError::CommandTimeout { command, attempts, .. } => {
            Cause::CommandTimeout { command: name_of(*command), attempts: *attempts }
        }
        VehicleError::MessageNotReceived { message_id } => Cause::MessageNotReceived {
            message: message_name(*message_id).map_or_else(|| message_id.to_string(), str::to_owned),
        },
        VehicleError::NotHeard { age } => Cause::VehicleLost { age_s: age.as_secs_f64() },
        VehicleError::CommandBusy { command } => Cause::CommandBusy { command: name_of(*command) },
        VehicleError::TransferBusy { running } => Cause::TransferBusy { running: (*running).to_owned() },
        VehicleError::TooManyRequests { limit } => Cause::TooMany { what: Crowd::Requests, limit: *limit as u64 },
        VehicleError::UnknownMode(unknown) => Cause::UnknownMode {
            mode: unknown.name.clone(),
            suggestions: unknown.suggestions.iter().map(|mode| (*mode).to_owned()).collect(),
        },
        VehicleError::NoModeFor { action } => Cause::NoModeFor { action: (*action).to_owned() },
        VehicleError::InvalidValue { field, value, expected } => {
            Cause::InvalidValue { field: (*field).to_owned(), value: value.clone(), expected: (*expected).to_owned() }
        }
        VehicleError::PlanUnknown { kind, state } => {
            Cause::PlanUnknown { plan: convert::plan_kind(*kind), reason: convert::uncertainty(*state) }
        }
        VehicleError::TooOld { what, .. } => Cause::TooOld { what: (*what).to_owned() },
        VehicleError::Armed { action } => Cause::Armed { action: (*action).to_owned() },
        VehicleError::InTheAir { action } => Cause::InTheAir { action: (*action).to_owned() },
        VehicleError::HomeUnknown => Cause::HomeUnknown,
        VehicleError::Rebooted => Cause::Rebooted,
        VehicleError::Cancelled => Cause::Cancelled,
        _ => Cause::Internal,
    };
    let problem = Problem::new(cause, error.to_string());
    match error {
        VehicleError::CommandRefused { reasons, .. } | VehicleError::NotConfirmed { reasons, .. } => {
            problem.refused(reasons, &error.remedies())
        }
        _ => problem,
    }
}

/// The problem for an error of a transfer.
pub fn from_transfer(error: &TransferError) -> Problem {
    let plan = |kind: &PlanKind| convert::plan_kind(*kind);
    let cause = match error {
        TransferError::Item(error) => return from_flight(error),
        TransferError::Timeout { step, waited } => {
            Cause::TransferTimeout { step: (*step).to_owned(), waited_s: waited.as_secs_f64() }
        }
        TransferError::FtpAbsent { waited } => {
            Cause::TransferTimeout { step: FTP_OPEN.to_owned(), waited_s: waited.as_secs_f64() }
        }
        TransferError::Unreached { waited } => Cause::Unreached { waited_s: waited.as_secs_f64() },
        TransferError::NoProgress { step, attempts } => {
            Cause::NoProgress { step: (*step).to_owned(), attempts: *attempts }
        }
        TransferError::Refused { kind, result, seq } => Cause::PlanRefused {
            plan: plan(kind),
            result: result.name().trim_start_matches("MAV_MISSION_").to_owned(),
            seq: seq.map(|seq| seq.0),
        },
        TransferError::NotAsSent { kind, differences } => {
            let cause = Cause::PlanMismatch { plan: plan(kind), differences: differences.len() as u64 };
            return Problem::new(cause, error.to_string()).reasons(differences.iter().map(ToString::to_string));
        }
        TransferError::Unverified { kind, .. } => Cause::Unverified { plan: plan(kind) },
        TransferError::OnlyMission { kind, reason } => Cause::OnlyMission {
            plan: plan(kind),
            reason: match reason {
                NoPlanKinds::OldFirmware => OnlyMissionReason::OldFirmware,
                NoPlanKinds::Mavlink1 => OnlyMissionReason::Mavlink1,
            },
        },
        TransferError::IntegerItemsIgnored => Cause::TooOld { what: "MISSION_ITEM_INT".to_owned() },
        TransferError::NotCleared { kind, count } => Cause::NotCleared { plan: plan(kind), count: *count },
        TransferError::TooMany { what, count, limit } => {
            Cause::TooLarge { what: (*what).to_owned(), count: *count, limit: *limit }
        }
        TransferError::BadList { .. } => Cause::InvalidRequest { problem: error.to_string() },
        TransferError::Ftp { path, .. } | TransferError::BadFile { path, .. } => {
            Cause::VehicleFile { path: path.clone() }
        }
        TransferError::FtpBusy { path } => Cause::FilesBusy { path: path.clone() },
        TransferError::Param(error) => Cause::InvalidParam { problem: error.to_string() },
        TransferError::UnknownParam { name, told } => {
            Cause::UnknownParam { name: name.as_str().to_owned(), told: *told }
        }
        TransferError::ParamRefused { name, reason } => {
            Cause::ParamRefused { name: name.as_str().to_owned(), reason: (*reason).to_owned() }
        }
        TransferError::ParamNotKept { name, asked, kept } => {
            Cause::ParamNotKept { name: name.as_str().to_owned(), asked: asked.as_f64(), kept: kept.as_f64() }
        }
        TransferError::Cancelled => Cause::Cancelled,
        _ => Cause::Internal,
    };
    Problem::new(cause, error.to_string())
}

/// The problem for a plan or file that is none.
pub fn from_flight(error: &FlightError) -> Problem {
    let bad_plan = |plan, index: &usize, problem: &String| Cause::BadPlan {
        plan: Some(plan),
        item: Some(*index as u64 + 1),
        problem: problem.clone(),
    };
    let bad_file = |place: Option<String>, problem: &String| Cause::BadFile { place, problem: problem.clone() };
    let cause = match error {
        FlightError::NotOnEarth { lat_deg, lon_deg } => {
            Cause::NotOnEarth { lat_deg: finite(*lat_deg), lon_deg: finite(*lon_deg) }
        }
        FlightError::HomeHeight { alt_amsl_m } => {
            return Problem::invalid_value("home.alt_amsl_m", Plain(*alt_amsl_m), "within 83,000 m");
        }
        FlightError::BadLanding(problem) => match *problem {
            LandingProblem::OutOfRange { option, value, low, high } => {
                return Problem::invalid_value(option, Plain(value), &format!("{low} to {high}"));
            }
            LandingProblem::NoDirection { nearest_m } => Cause::LandingDirection { nearest_m },
            LandingProblem::TooMuchWind { wind_m_s, airspeed_m_s, course_deg } => {
                Cause::LandingWind { wind_m_s, airspeed_m_s, course_deg }
            }
            LandingProblem::NotDesigned => return Problem::invalid(error.to_string()),
        },
        FlightError::BadSurvey(problem) => match *problem {
            SurveyProblem::OutOfRange { option, value, low, high } => {
                return Problem::invalid_value(option, Plain(value), &format!("{low} to {high}"));
            }
            SurveyProblem::CrossesItself { one, other } => {
                Cause::SurveyCrosses { one: one as u64, other: other as u64 }
            }
            SurveyProblem::TooManyItems { count, max } => Cause::SurveyItems { count: count as u64, max: max as u64 },
            SurveyProblem::TooMuchWind { wind_m_s, airspeed_m_s, course_deg } => {
                Cause::SurveyWind { wind_m_s, airspeed_m_s, course_deg }
            }
            _ => Cause::BadSurvey { problem: problem.to_string() },
        },
        FlightError::BadItem { seq, command, field, value, problem } => Cause::BadItem {
            seq: *seq,
            command: command.to_string(),
            field: (*field).to_owned(),
            value: finite(*value),
            problem: (*problem).to_owned(),
        },
        FlightError::UnknownPlanKind(_) => Cause::BadPlan { plan: None, item: None, problem: error.to_string() },
        FlightError::BadMission { index, problem } => bad_plan(dto::PlanKind::Mission, index, problem),
        FlightError::BadFence { index, problem } => bad_plan(dto::PlanKind::Fence, index, problem),
        FlightError::BadRally { index, problem } => bad_plan(dto::PlanKind::Rally, index, problem),
        FlightError::BadLine { line, problem } => bad_file(Some(format!("line {line}")), problem),
        FlightError::BadJson { path, problem } => bad_file(Some(path.clone()), problem),
        FlightError::BadFile(problem) => bad_file(None, problem),
        _ => Cause::Internal,
    };
    Problem::new(cause, error.to_string())
}

/// The problem for an error of the maps.
pub fn from_maps(error: &MapError) -> Problem {
    let text = error.to_string();
    let cause = match error.clone() {
        MapError::NoSource(source) => Cause::NoSource { source },
        MapError::NoTile => Cause::NoTile,
        MapError::KeyMissing(source) => Cause::SourceKey { source },
        MapError::Unusable { source_id: source, reason: problem } => Cause::SourceInvalid { source, problem },
        MapError::Settings { source_id: source, faults: problems } => {
            let cause = Cause::SourceSettings { source, problems: problems.clone() };
            return Problem::new(cause, text).reasons(problems);
        }
        MapError::SourcesFile { reason: problem, .. } => {
            return Problem::new(Cause::SourceFile { problem }, text)
                .remedy("mend the file where it says, or move it away: a new one is made at the next start");
        }
        MapError::Service { host: service, status, reason: problem } => {
            Cause::SourceFailed { service, status, problem }
        }
        MapError::Timeout { host: service, seconds: waited_s } => Cause::SourceTimeout { service, waited_s },
        MapError::Offline { host: service, why, reason: problem, retry_s } => {
            Cause::SourceOffline { service, why, problem, retry_s }
        }
        MapError::Busy => Cause::SourceBusy,
        MapError::OfflineRefused { source_id: source, reason: problem } => Cause::OfflineRefused { source, problem },
        MapError::AreaTooLarge { tiles, most: limit } => Cause::AreaTooLarge { tiles, limit },
        MapError::NoArea(name) => Cause::NotFound { what: Thing::Area, name },
        MapError::MapFile { name, reason: problem } => Cause::MapFile { name, problem },
        MapError::Request(problem) => Cause::InvalidRequest { problem },
        MapError::LowSpace(LowSpace { free_bytes, floor_bytes, .. }) => {
            Cause::LowSpace { free_mb: free_bytes / 1_000_000, floor_mb: floor_bytes / 1_000_000 }
        }
        MapError::Storage(problem) => Cause::MapStorage { problem },
        MapError::Closed => Cause::Closed,
        _ => Cause::Internal,
    };
    Problem::new(cause, text)
}

impl From<StationError> for Problem {
    fn from(error: StationError) -> Self {
        from_station(&error)
    }
}

impl From<FlightError> for Problem {
    fn from(error: FlightError) -> Self {
        from_flight(&error)
    }
}

fn unreadable(status: StatusCode, text: String) -> Problem {
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => Problem::new(Cause::BodyTooLarge, "the request's body is too large"),
        StatusCode::UNSUPPORTED_MEDIA_TYPE => {
            Problem::new(Cause::MediaType, "send JSON with `Content-Type: application/json`")
        }
        _ => {
            let mut problem = Problem::invalid(text);
            // Not even JSON is another status, for whoever looks at that alone.
            problem.0.status = status.as_u16();
            problem
        }
    }
}

impl From<JsonRejection> for Problem {
    fn from(rejection: JsonRejection) -> Self {
        unreadable(rejection.status(), rejection.body_text())
    }
}

impl From<BytesRejection> for Problem {
    fn from(rejection: BytesRejection) -> Self {
        unreadable(rejection.status(), rejection.body_text())
    }
}

impl From<QueryRejection> for Problem {
    fn from(rejection: QueryRejection) -> Self {
        let text = rejection.body_text();
        let said = text.split_once("query string: ").map_or(text.as_str(), |(_, said)| said);
        let is_name = |path: &str| path.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let (path, said) = said.split_once(": ").filter(|(path, _)| is_name(path)).unwrap_or(("", said));
        Self::invalid(misread::in_words(path, said, |name| misread::unit(name).map(str::to_owned)))
    }
}

#[cfg(test)]
mod tests;
