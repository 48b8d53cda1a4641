//! HTTP status and title of each cause.

use axum::http::StatusCode;

use crate::dto::cause::Cause;

/// Status and title of a cause.
pub(super) fn kind_of(cause: &Cause) -> (StatusCode, &'static str) {
    match cause {
        Cause::Host { .. } | Cause::Origin { .. } => (StatusCode::FORBIDDEN, "Host or origin not allowed"),
        Cause::NoSession => (StatusCode::UNAUTHORIZED, "No session"),
        Cause::BadToken => (StatusCode::UNAUTHORIZED, "Wrong token"),
        Cause::Role => (StatusCode::FORBIDDEN, "Not permitted for viewers"),
        Cause::Control { .. } => (StatusCode::LOCKED, "Control required"),
        Cause::NeedsConfirmation { .. } => (StatusCode::PRECONDITION_REQUIRED, "Confirmation required"),
        Cause::BadConfirmation => (StatusCode::PRECONDITION_FAILED, "Invalid confirmation"),
        Cause::TooMany { .. } => (StatusCode::TOO_MANY_REQUESTS, "Too many at once"),
        Cause::SigningUnproven => (StatusCode::GATEWAY_TIMEOUT, "The vehicle does not show the change"),
        Cause::SigningNoKeys | Cause::SigningStorage { .. } => {
            (StatusCode::INTERNAL_SERVER_ERROR, "The signing keys cannot be used")
        }
        Cause::SigningKeyName { .. } => (StatusCode::CONFLICT, "Invalid key name"),
        Cause::SigningBusy => (StatusCode::CONFLICT, "Another operation is in progress"),
        Cause::SigningRefused { .. } => (StatusCode::CONFLICT, "The vehicle refused"),
        Cause::SigningState { .. } | Cause::SigningNotDisarmed { .. } | Cause::SigningNotPrivate { .. } => {
            (StatusCode::CONFLICT, "Signing cannot be changed now")
        }
        Cause::Closed => (StatusCode::SERVICE_UNAVAILABLE, "The station is closed"),
        Cause::InvalidRequest { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid request"),
        Cause::InvalidValue { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid value"),
        Cause::MediaType => (StatusCode::UNSUPPORTED_MEDIA_TYPE, "Not JSON"),
        Cause::BodyTooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "Too large"),
        Cause::BodyTooSlow => (StatusCode::REQUEST_TIMEOUT, "Too slow"),
        Cause::TokensSlowed { .. } => (StatusCode::TOO_MANY_REQUESTS, "Too many wrong tokens"),
        Cause::Method => (StatusCode::METHOD_NOT_ALLOWED, "Method not allowed"),
        Cause::NotFound { .. } => (StatusCode::NOT_FOUND, "Not found"),
        Cause::RecordingAsLink => (StatusCode::UNPROCESSABLE_ENTITY, "Not permitted over the network"),
        Cause::Camera { .. } => (StatusCode::CONFLICT, "The camera cannot do that"),
        Cause::HeartbeatFollowsOperator => (StatusCode::CONFLICT, "The heartbeat follows the operator"),
        Cause::Internal => (StatusCode::INTERNAL_SERVER_ERROR, "Internal error"),
        Cause::LinkAddress { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Not a link string"),
        Cause::Recorder { .. } => (StatusCode::INTERNAL_SERVER_ERROR, "Nothing can be recorded"),
        Cause::NoVehicle { .. } => (StatusCode::NOT_FOUND, "No such vehicle"),
        Cause::NotSent { .. } => (StatusCode::CONFLICT, "Not sent"),
        Cause::CommandRefused { .. } => (StatusCode::CONFLICT, "The vehicle refused"),
        Cause::RemoteRefused { .. } => (StatusCode::CONFLICT, "The station on board refused"),
        Cause::Replayed { .. } => (StatusCode::CONFLICT, "The vehicle is a recording"),
        Cause::CommandTimeout { .. } | Cause::MessageNotReceived { .. } | Cause::TransferTimeout { .. } => {
            (StatusCode::GATEWAY_TIMEOUT, "The vehicle did not answer")
        }
        Cause::NotConfirmed { .. } => (StatusCode::GATEWAY_TIMEOUT, "The effect was not observed"),
        Cause::VehicleLost { .. } => (StatusCode::GATEWAY_TIMEOUT, "The vehicle is not heard"),
        Cause::CommandBusy { .. } | Cause::TransferBusy { .. } | Cause::FilesBusy { .. } => {
            (StatusCode::CONFLICT, "Another operation is in progress")
        }
        Cause::UnknownMode { .. } | Cause::NoModeFor { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "No such mode"),
        Cause::PlanUnknown { .. } => (StatusCode::CONFLICT, "The plan on board is not known"),
        Cause::TooOld { .. } => (StatusCode::CONFLICT, "The vehicle's firmware is too old"),
        Cause::Armed { .. } => (StatusCode::CONFLICT, "The vehicle is armed"),
        Cause::InTheAir { .. } => (StatusCode::CONFLICT, "The vehicle is in the air"),
        Cause::Landing { .. } => (StatusCode::CONFLICT, "The vehicle is landing"),
        Cause::HomeUnknown => (StatusCode::CONFLICT, "Home is not known"),
        Cause::Rebooted => (StatusCode::CONFLICT, "The vehicle restarted"),
        Cause::Cancelled => (StatusCode::CONFLICT, "Cancelled"),
        Cause::Unreached { .. } => (StatusCode::GATEWAY_TIMEOUT, "The vehicle does not hear us"),
        Cause::NoProgress { .. } => (StatusCode::GATEWAY_TIMEOUT, "The transfer made no progress"),
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
        Cause::InvalidParam { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid parameter"),
        Cause::PlanUnsound { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The plan has errors"),
        Cause::NotOnEarth { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid position"),
        Cause::LandingDirection { .. } | Cause::LandingWind { .. } => {
            (StatusCode::UNPROCESSABLE_ENTITY, "No landing there")
        }
        Cause::BadSurvey { .. }
        | Cause::SurveyCrosses { .. }
        | Cause::SurveyItems { .. }
        | Cause::SurveyWind { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "No survey there"),
        Cause::BadItem { .. } | Cause::BadPlan { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid plan"),
        Cause::BadFile { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid file"),
        Cause::NoMaps => (StatusCode::SERVICE_UNAVAILABLE, "Maps are not available"),
        Cause::NoSource { .. } => (StatusCode::NOT_FOUND, "No such map source"),
        Cause::NoTile => (StatusCode::NOT_FOUND, "No tile there"),
        Cause::SourceKey { .. } => (StatusCode::CONFLICT, "The source needs a key"),
        Cause::SourceInvalid { .. } => (StatusCode::CONFLICT, "The source cannot be used"),
        Cause::SourceSettings { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The settings are wrong"),
        Cause::SourceFile { .. } => (StatusCode::CONFLICT, "The file of the sources is wrong"),
        Cause::SourceFailed { .. } => (StatusCode::BAD_GATEWAY, "The map service failed"),
        Cause::SourceTimeout { .. } => (StatusCode::GATEWAY_TIMEOUT, "The map service did not answer"),
        Cause::SourceOffline { .. } => (StatusCode::SERVICE_UNAVAILABLE, "The map service cannot be reached"),
        Cause::SourceBusy => (StatusCode::SERVICE_UNAVAILABLE, "Too much at once"),
        Cause::OfflineRefused { .. } => (StatusCode::CONFLICT, "Not for offline use"),
        Cause::AreaTooLarge { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "The area is too large"),
        Cause::MapFile { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "Invalid map file"),
        Cause::MapStorage { .. } => (StatusCode::INTERNAL_SERVER_ERROR, "The disk or a database failed"),
        Cause::LowSpace { .. } => (StatusCode::INSUFFICIENT_STORAGE, "The disk is too full"),
        Cause::DraftConflict { .. } => (StatusCode::CONFLICT, "The draft was changed meanwhile"),
    }
}
