//! Maps the core's errors to problems: causes for programs, and the core's own texts for people.

use vencejo_flight::plan::{Command, PlanKind};
use vencejo_flight::{FlightError, LandingProblem, Plain, SurveyProblem};
use vencejo_link::{LinkError, MAX_LINKS};
use vencejo_maps::MapError;
use vencejo_proto::message_name;
use vencejo_station::{MAX_REPLAYS, SigningError, StationError};
use vencejo_store::LowSpace;
use vencejo_vehicle::VehicleError;
use vencejo_vehicle::registry::MAX_FAR;
use vencejo_vehicle::transfer::{FTP_OPEN, NoPlanKinds, TransferError};

use super::Problem;
use crate::convert;
use crate::dto;
use crate::dto::cause::{Cause, LimitKind, OnlyMissionReason, ResourceKind, finite};

/// Problem for an error of the station.
pub fn from_station(error: &StationError) -> Problem {
    let cause = match error {
        StationError::Vehicle(error) => return from_vehicle(error),
        StationError::Address(error) => Cause::LinkAddress { problem: error.to_string() },
        StationError::Link(LinkError::UnknownLink(id)) => {
            Cause::NotFound { what: ResourceKind::Link, name: id.0.to_string() }
        }
        StationError::Link(LinkError::TooManyLinks) => {
            Cause::TooMany { what: LimitKind::Links, limit: MAX_LINKS as u64 }
        }
        StationError::NoVehicle { waited, .. } => Cause::NoVehicle { waited_s: waited.as_secs_f64() },
        StationError::Control { holder, vehicle: None } => return Problem::no_control(Some(holder)),
        StationError::Control { holder, vehicle: Some(vehicle) } => {
            let cause = Cause::VehicleControl { vehicle: vehicle.clone(), holder: holder.clone() };
            let detail = format!("{holder} holds control of {vehicle}");
            return Problem::new(cause, detail).remedy("ask for it: POST /api/v1/vehicles/{id}/control/request");
        }
        StationError::Dismissed => return Problem::no_session(),
        StationError::NeedsConfirmation { challenge } => {
            let cause = Cause::NeedsConfirmation {
                act: challenge.danger.code().to_owned(),
                vehicle: challenge.vehicle.number(),
                confirmation: challenge.id.clone(),
                valid_s: challenge.valid_for.as_secs_f64(),
            };
            return Problem::new(cause, error.to_string())
                .remedy("repeat the request with the header Vencejo-Confirmation set to the cause's `confirmation`");
        }
        StationError::BadConfirmation => Cause::BadConfirmation,
        StationError::RemoteRefused { name, why } => Cause::RemoteRefused { vehicle: name.clone(), why: why.clone() },
        StationError::Replayed { vehicle } => Cause::Replayed { vehicle: vehicle.clone() },
        StationError::BadRecording { reason, .. } => Cause::BadFile { place: None, problem: reason.clone() },
        StationError::TooManyReplays => Cause::TooMany { what: LimitKind::Replays, limit: MAX_REPLAYS as u64 },
        StationError::TooManyVehicles => Cause::TooMany { what: LimitKind::Vehicles, limit: MAX_FAR as u64 },
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

/// Name of a command, else its number.
fn name_of(command: Command) -> String {
    if command.name().is_some() { command.to_string() } else { command.0.to_string() }
}

/// Problem for an error of a vehicle.
pub(super) fn from_vehicle(error: &VehicleError) -> Problem {
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
        VehicleError::TooManyRequests { limit } => Cause::TooMany { what: LimitKind::Requests, limit: *limit as u64 },
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
        VehicleError::OutOfReach { item, distance_m, is_swapped } => {
            Cause::OutOfReach { item: *item as u64, distance_m: *distance_m, is_swapped: *is_swapped }
        }
        VehicleError::TooOld { what, .. } => Cause::TooOld { what: (*what).to_owned() },
        VehicleError::Armed { action } => Cause::Armed { action: (*action).to_owned() },
        VehicleError::InTheAir { action } => Cause::InTheAir { action: (*action).to_owned() },
        VehicleError::NotFlying { action, .. } => Cause::NotFlying { action: (*action).to_owned() },
        VehicleError::Landing { action, is_known, .. } => {
            Cause::Landing { action: (*action).to_owned(), is_known: *is_known }
        }
        VehicleError::HomeUnknown => Cause::HomeUnknown,
        VehicleError::Rebooted => Cause::Rebooted,
        VehicleError::Cancelled => Cause::Cancelled,
        _ => Cause::Internal,
    };
    let problem = Problem::new(cause, error.to_string());
    match error {
        VehicleError::CommandRefused { reasons, .. }
        | VehicleError::NotConfirmed { reasons, .. }
        | VehicleError::CommandTimeout { reasons, .. } => problem.refused(reasons, &error.remedies()),
        _ => problem,
    }
}

/// Problem for an error of a transfer.
pub(super) fn from_transfer(error: &TransferError) -> Problem {
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
        TransferError::Refused { kind, result, item } => Cause::PlanRefused {
            plan: plan(kind),
            result: result.name().trim_start_matches("MAV_MISSION_").to_owned(),
            item: *item,
        },
        TransferError::NotAsSent { kind, differences } => {
            let cause = Cause::PlanMismatch { plan: plan(kind), differences: differences.len() as u64 };
            return Problem::new(cause, error.to_string()).reasons(differences.iter().map(ToString::to_string));
        }
        TransferError::Rejected { reasons } => {
            return Problem::new(Cause::MissionRejected, error.to_string()).reasons(reasons.iter().cloned());
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

/// Problem for an invalid plan or file.
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
                return Problem::out_of_range(option, Plain(value), Plain(low), Plain(high));
            }
            LandingProblem::NoDirection { nearest_m } => Cause::LandingDirection { nearest_m },
            LandingProblem::TooMuchWind { wind_m_s, airspeed_m_s, course_deg } => {
                Cause::LandingWind { wind_m_s, airspeed_m_s, course_deg }
            }
            LandingProblem::NotDesigned => return Problem::invalid(error.to_string()),
        },
        FlightError::BadSurvey(problem) => match *problem {
            SurveyProblem::OutOfRange { option, value, low, high } => {
                return Problem::out_of_range(option, Plain(value), Plain(low), Plain(high));
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

/// Problem for an error of the maps.
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
                .remedy("correct the file there, or move it away: a new one is created at the next start");
        }
        MapError::Service { host: service, status, reason: problem } => {
            Cause::SourceFailed { service, status, problem }
        }
        MapError::LocalAddress { host: service, is_permissible, reason: problem } => {
            Cause::SourceLocal { service, is_permissible, problem }
        }
        MapError::Timeout { host: service, seconds: waited_s } => Cause::SourceTimeout { service, waited_s },
        MapError::Offline { host: service, why, reason: problem, retry_s } => {
            Cause::SourceOffline { service, why, problem, retry_s }
        }
        MapError::Busy => Cause::SourceBusy,
        MapError::OfflineRefused { source_id: source, reason: problem } => Cause::OfflineRefused { source, problem },
        MapError::AreaTooLarge { tiles, most: limit } => Cause::AreaTooLarge { tiles, limit },
        MapError::NoArea(name) => Cause::NotFound { what: ResourceKind::Area, name },
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
