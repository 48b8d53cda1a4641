//! Machine-readable causes of errors: a stable code, and the values that a sentence about it needs in any language.

use axum::http::StatusCode;
use serde::Serialize;
use utoipa::ToSchema;

use super::{PlanKind, PlanUncertainty};

/// Kind of a resource that a request named and that does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Thing)]
pub enum ResourceKind {
    /// A path of the API.
    Path,
    /// A file of the web app.
    File,
    /// A vehicle, by system id.
    Vehicle,
    /// A link, by id.
    Link,
    /// An operation, by id.
    Operation,
    /// A recording, by the name of its file.
    Recording,
    /// A camera, by name.
    Camera,
    /// A MAVLink message, by name.
    Message,
    /// A MAVLink command, by name.
    Command,
    /// An offline area, by id.
    Area,
    /// A replay, by id.
    Replay,
}

/// Kind of a limit that was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Crowd)]
pub enum LimitKind {
    /// Sessions.
    Sessions,
    /// WebSockets of this session, or of all sessions.
    Sockets,
    /// Camera viewers.
    Viewers,
    /// Running operations.
    Operations,
    /// Requests waiting for one vehicle.
    Requests,
    /// Open links.
    Links,
    /// Vehicles or messages that one client is subscribed to.
    Subscriptions,
    /// Uploads that are processed while they arrive.
    Bodies,
    /// Open replays.
    Replays,
    /// Vehicles that are not at a link of the server.
    Vehicles,
}

/// Why a vehicle accepts only missions, and neither fences nor rally points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnlyMissionReason {
    /// Its firmware is too old.
    OldFirmware,
    /// It uses MAVLink 1.
    Mavlink1,
}

/// The list of causes: the enum, and status and title of the HTTP answer beside each variant.
macro_rules! causes {
    ($(
        $(#[doc = $doc:literal])*
        $name:ident $({ $($(#[$field_meta:meta])* $field:ident: $kind:ty,)* })? => $status:ident, $title:literal,
    )*) => {
        /// Cause of an error. `code` is stable and is the last part of the problem's `type`; the other fields hold the
        /// values of the English `detail`, so that clients can show it in another language. Fields that contain English
        /// text say so.
        #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
        #[serde(tag = "code", rename_all = "kebab-case", rename_all_fields = "snake_case")]
        pub enum Cause { $(
            $(#[doc = $doc])*
            $name $({ $($(#[$field_meta])* $field: $kind,)* })?,
        )* }

        impl Cause {
            /// Status and title of the HTTP answer.
            pub(crate) fn kind(&self) -> (StatusCode, &'static str) {
                match self { $(Self::$name { .. } => (StatusCode::$status, $title),)* }
            }
        }
    };
}

causes! {
    // Access ----------------------------------------------------------------------------------------------------------
    /// The `Host` header names another server.
    Host {
        /// The host in the header; null when it cannot be read.
        #[schema(required = true)]
        host: Option<String>,
    } => FORBIDDEN, "Host or origin not allowed",
    /// The request comes from a page of another site.
    Origin {
        /// Origin of that page.
        origin: String,
    } => FORBIDDEN, "Host or origin not allowed",
    /// There is no session, or it has expired.
    NoSession => UNAUTHORIZED, "No session",
    /// The token is not valid.
    BadToken => UNAUTHORIZED, "Wrong token",
    /// A session with the role viewer may not do this.
    Role => FORBIDDEN, "Not permitted for viewers",
    /// Only the session that holds control may do this.
    Control {
        /// Name of the session that holds control; null when there is none.
        #[schema(required = true)]
        holder: Option<String>,
    } => LOCKED, "Control required",
    /// Another ground station has control of this remote vehicle.
    VehicleControl {
        /// Name of the vehicle.
        vehicle: String,
        /// Name of the operator who has control, after that of the ground station.
        holder: String,
    } => LOCKED, "Control of the vehicle required",
    /// A dangerous action. It is carried out when the same request is repeated with `confirmation` in the header
    /// `Vencejo-Confirmation`.
    NeedsConfirmation {
        /// The dangerous action: `force-arm`, `force-disarm`, `disarm-in-flight`, `terminate`, `clear-mission`,
        /// `clear-fence`, `clear-rally`, `clear-all`, `reboot`, `fence-off`, `erase`, `write-files` or `move-home`.
        act: String,
        /// Id of the vehicle concerned.
        vehicle: u16,
        /// Value to send; valid once, for this session, this vehicle and this action.
        confirmation: String,
        /// Validity of the confirmation.
        valid_s: f64,
    } => PRECONDITION_REQUIRED, "Confirmation required",
    /// The confirmation belongs to another action, was already used, or has expired. Nothing was sent.
    BadConfirmation => PRECONDITION_FAILED, "Invalid confirmation",
    /// A limit was exceeded.
    TooMany {
        /// Kind of the limit.
        what: LimitKind,
        /// The limit.
        limit: u64,
    } => TOO_MANY_REQUESTS, "Too many at once",
    /// The server or its station is shutting down.
    Closed => SERVICE_UNAVAILABLE, "The station is closed",

    // Signing ---------------------------------------------------------------------------------------------------------
    /// The server has no store for signing keys.
    SigningNoKeys => INTERNAL_SERVER_ERROR, "The signing keys cannot be used",
    /// The file of the signing keys cannot be used.
    SigningStorage {
        /// The reason, in English.
        problem: String,
    } => INTERNAL_SERVER_ERROR, "The signing keys cannot be used",
    /// The name of a signing key is invalid, taken, unknown or in use.
    SigningKeyName {
        /// Name of the key.
        name: String,
    } => CONFLICT, "Invalid key name",
    /// The vehicle already signs, or does not sign yet.
    SigningState {
        /// Whether the vehicle signs.
        signs: bool,
    } => CONFLICT, "Signing cannot be changed now",
    /// The vehicle is armed, or its state is not known.
    SigningNotDisarmed {
        /// Whether the vehicle is armed; null when unknown.
        #[schema(required = true)]
        armed: Option<bool>,
    } => CONFLICT, "Signing cannot be changed now",
    /// The key would be sent over a link that others can listen to.
    SigningNotPrivate {
        /// Name of the link.
        link: String,
    } => CONFLICT, "Signing cannot be changed now",
    /// Another change of the vehicle's signing is in progress.
    SigningBusy => CONFLICT, "Another operation is in progress",
    /// The vehicle refused the key.
    SigningRefused {
        /// The vehicle's own text.
        text: String,
    } => CONFLICT, "The vehicle refused",
    /// The vehicle's frames did not confirm the change in time.
    SigningUnproven => GATEWAY_TIMEOUT, "The vehicle does not show the change",

    // Requests --------------------------------------------------------------------------------------------------------
    /// The request does not conform to the API: a fault of the client program.
    InvalidRequest {
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid request",
    /// The body is not JSON.
    MediaType => UNSUPPORTED_MEDIA_TYPE, "Not JSON",
    /// The body is larger than this path accepts.
    BodyTooLarge => PAYLOAD_TOO_LARGE, "Too large",
    /// The body of the request arrived too slowly.
    BodyTooSlow => REQUEST_TIMEOUT, "Too slow",
    /// Too many wrong tokens came from this address; the next is checked after `wait_s`.
    TokensSlowed {
        /// Time until the next token is checked.
        wait_s: u64,
    } => TOO_MANY_REQUESTS, "Too many wrong tokens",
    /// The path does not support this method.
    Method => METHOD_NOT_ALLOWED, "Method not allowed",
    /// The named resource does not exist.
    NotFound {
        /// Kind of the resource.
        what: ResourceKind,
        /// Name or id of the resource.
        name: String,
    } => NOT_FOUND, "Not found",
    /// An invalid value.
    InvalidValue {
        /// Name of the field.
        field: String,
        /// The value.
        value: String,
        /// What is accepted, in English.
        expected: String,
    } => UNPROCESSABLE_ENTITY, "Invalid value",
    /// Recordings can be opened only on the server's own command line, not over the network.
    RecordingAsLink => UNPROCESSABLE_ENTITY, "Not permitted over the network",
    /// On board a vehicle, the heartbeat follows the operators' WebSockets and cannot be switched.
    HeartbeatFollowsOperator => CONFLICT, "The heartbeat follows the operator",
    /// An internal error.
    Internal => INTERNAL_SERVER_ERROR, "Internal error",

    // Links and recordings --------------------------------------------------------------------------------------------
    /// A camera could not carry out the request.
    Camera {
        /// Name of the camera.
        name: String,
        /// The reason, in English.
        reason: String,
    } => CONFLICT, "The camera cannot do that",
    /// An invalid link string.
    LinkAddress {
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Not a link string",
    /// Recording is not possible.
    Recorder {
        /// The operating system's message.
        reason: String,
    } => INTERNAL_SERVER_ERROR, "Nothing can be recorded",
    /// No vehicle was heard in time.
    NoVehicle {
        /// Time waited.
        waited_s: f64,
    } => NOT_FOUND, "No such vehicle",
    /// A message was not sent because no link to the vehicle is open.
    NotSent {
        /// Name of the message.
        message: String,
    } => CONFLICT, "Not sent",

    // Answers of the vehicle ------------------------------------------------------------------------------------------
    /// The vehicle refused a command; its own texts are the problem's `reasons`.
    CommandRefused {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// Name of the `MAV_RESULT` without that prefix, such as `DENIED`.
        result: String,
        /// Name of the mode that permits arming, where another mode would; otherwise null.
        #[schema(required = true)]
        cure_mode: Option<String>,
    } => CONFLICT, "The vehicle refused",
    /// The onboard station of a remote vehicle refused the request; nothing was sent to the autopilot.
    RemoteRefused {
        /// Name of the vehicle.
        vehicle: String,
        /// The reason, in English.
        why: String,
    } => CONFLICT, "The station on board refused",
    /// The vehicle is played back from a recording and accepts no commands; nothing was sent.
    Replayed {
        /// Id or name of the vehicle.
        vehicle: String,
    } => CONFLICT, "The vehicle is a recording",
    /// The vehicle did not answer a command. It may have carried it out.
    CommandTimeout {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// Number of times that it was sent.
        attempts: u32,
    } => GATEWAY_TIMEOUT, "The vehicle did not answer",
    /// The vehicle accepted a command, but its telemetry does not show the effect.
    NotConfirmed {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// Expected state, in English.
        wanted: String,
        /// Observed state, in English.
        observed: String,
        /// Time waited for the effect.
        within_s: f64,
    } => GATEWAY_TIMEOUT, "The effect was not observed",
    /// A requested message was not received.
    MessageNotReceived {
        /// Name of the message, else its id.
        message: String,
    } => GATEWAY_TIMEOUT, "The vehicle did not answer",
    /// The vehicle has been silent for too long to act on its last known state.
    VehicleLost {
        /// Time since the vehicle was last heard.
        age_s: f64,
    } => GATEWAY_TIMEOUT, "The vehicle is not heard",
    /// The same command is already in progress.
    CommandBusy {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
    } => CONFLICT, "Another operation is in progress",
    /// Another transfer with this vehicle is in progress.
    TransferBusy {
        /// The running transfer, in English.
        running: String,
    } => CONFLICT, "Another operation is in progress",
    /// The vehicle has no such mode.
    UnknownMode {
        /// Name of the requested mode.
        mode: String,
        /// Names of similar modes.
        suggestions: Vec<String>,
    } => UNPROCESSABLE_ENTITY, "No such mode",
    /// The vehicle has no mode for this action.
    NoModeFor {
        /// The action, in English.
        action: String,
    } => UNPROCESSABLE_ENTITY, "No such mode",
    /// The plan on board may be a mixture of two plans.
    PlanUnknown {
        /// The plan concerned.
        plan: PlanKind,
        /// Why it is unknown; null when the reason is not in this list.
        #[schema(required = true)]
        reason: Option<PlanUncertainty>,
    } => CONFLICT, "The plan on board is not known",
    /// The mission on board leads farther than any flight is meant to, so it is not started.
    OutOfReach {
        /// The first such item, counted from 1.
        item: u64,
        /// To home or the vehicle, whichever is nearer.
        distance_m: f64,
        /// Whether it is in reach with latitude and longitude swapped.
        is_swapped: bool,
    } => CONFLICT, "The mission is out of reach",
    /// The vehicle's firmware does not support this.
    TooOld {
        /// The unsupported function, in English.
        what: String,
    } => CONFLICT, "The vehicle's firmware is too old",
    /// The action requires a disarmed vehicle.
    Armed {
        /// The action, in English.
        action: String,
    } => CONFLICT, "The vehicle is armed",
    /// The action requires a vehicle on the ground.
    InTheAir {
        /// The action, in English.
        action: String,
    } => CONFLICT, "The vehicle is in the air",
    /// The action requires a vehicle in flight.
    NotFlying {
        /// The action, in English.
        action: String,
    } => CONFLICT, "The vehicle is not flying",
    /// The vehicle is landing, or may be landing in a mission that was not read.
    Landing {
        /// The action that is not possible meanwhile, in English.
        action: String,
        /// Whether it is known to be landing.
        is_known: bool,
    } => CONFLICT, "The vehicle is landing",
    /// The home position is needed but unknown.
    HomeUnknown => CONFLICT, "Home is not known",
    /// The vehicle rebooted in the meantime.
    Rebooted => CONFLICT, "The vehicle restarted",
    /// Cancelled on request.
    Cancelled => CONFLICT, "Cancelled",

    // Transfers ------------------------------------------------------------------------------------------------------
    /// The vehicle stopped answering during a transfer.
    TransferTimeout {
        /// The unanswered step, in English.
        step: String,
        /// Time waited.
        waited_s: f64,
    } => GATEWAY_TIMEOUT, "The vehicle did not answer",
    /// The vehicle is heard, but does not hear us.
    Unreached {
        /// Time without an answer.
        waited_s: f64,
    } => GATEWAY_TIMEOUT, "The vehicle does not hear us",
    /// The vehicle answers, but the transfer makes no progress.
    NoProgress {
        /// The current step, in English.
        step: String,
        /// Number of attempts.
        attempts: u32,
    } => GATEWAY_TIMEOUT, "The transfer made no progress",
    /// The vehicle refused a plan.
    PlanRefused {
        /// The plan concerned.
        plan: PlanKind,
        /// Name of the `MAV_MISSION_RESULT` without `MAV_MISSION_`.
        result: String,
        /// The item that was most likely refused, counted from 1 (0 is the home of an ArduPilot's mission); null when unknown.
        #[schema(required = true)]
        item: Option<u16>,
    } => CONFLICT, "The vehicle refused the plan",
    /// The vehicle holds something other than what was sent; the differences are the problem's `reasons`.
    PlanMismatch {
        /// The plan concerned.
        plan: PlanKind,
        /// Number of differences.
        differences: u64,
    } => CONFLICT, "The vehicle holds another plan",
    /// The mission is on board, but the vehicle's own checks reject it; what they say is the problem's `reasons`.
    MissionRejected => CONFLICT, "The vehicle does not fly this mission",
    /// A plan was sent but could not be read back: what the vehicle holds is unknown.
    Unverified {
        /// The plan concerned.
        plan: PlanKind,
    } => GATEWAY_TIMEOUT, "What the vehicle holds is unknown",
    /// The vehicle accepts only missions.
    OnlyMission {
        /// The requested plan.
        plan: PlanKind,
        /// Why it is not accepted.
        reason: OnlyMissionReason,
    } => CONFLICT, "The vehicle takes only its mission",
    /// A plan was cleared, but some items remain.
    NotCleared {
        /// The plan concerned.
        plan: PlanKind,
        /// Number of remaining items.
        count: u16,
    } => CONFLICT, "The plan is still on board",
    /// More than is accepted.
    TooLarge {
        /// What is too large, in English.
        what: String,
        /// Its size or number of items.
        count: u64,
        /// Largest number accepted.
        limit: u64,
    } => UNPROCESSABLE_ENTITY, "Too large",
    /// A file on the vehicle cannot be read or written.
    VehicleFile {
        /// Path of the file.
        path: String,
    } => BAD_GATEWAY, "The vehicle's file cannot be used",
    /// Another station is using the vehicle's file transfer (MAVLink FTP).
    FilesBusy {
        /// Path of the requested file.
        path: String,
    } => CONFLICT, "Another operation is in progress",
    /// The vehicle does not have this parameter, or does not answer a request for it.
    UnknownParam {
        /// Name of the parameter.
        name: String,
        /// Whether the vehicle said so; otherwise it did not answer.
        told: bool,
    } => NOT_FOUND, "No such parameter",
    /// The vehicle refused a parameter's value.
    ParamRefused {
        /// Name of the parameter.
        name: String,
        /// The reason, in English.
        reason: String,
    } => CONFLICT, "The vehicle did not take the value",
    /// The vehicle stored a value other than the one that was sent.
    ParamNotKept {
        /// Name of the parameter.
        name: String,
        /// Value that was sent.
        asked: f64,
        /// Value that the vehicle has.
        kept: f64,
    } => CONFLICT, "The vehicle did not take the value",
    /// An invalid parameter name or value.
    InvalidParam {
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid parameter",

    // Plans ----------------------------------------------------------------------------------------------------------
    /// The plan checks found errors; nothing was sent.
    PlanUnsound {
        /// Number of errors.
        errors: u64,
    } => UNPROCESSABLE_ENTITY, "The plan has errors",
    /// An invalid latitude or longitude.
    NotOnEarth {
        /// Given latitude; null when it is not a number.
        #[schema(required = true)]
        lat_deg: Option<f64>,
        /// Given longitude; null when it is not a number.
        #[schema(required = true)]
        lon_deg: Option<f64>,
    } => UNPROCESSABLE_ENTITY, "Invalid position",
    /// The landing direction cannot be determined: no course, no preceding position and no wind was given.
    LandingDirection {
        /// Smallest distance at which a preceding position gives a direction.
        nearest_m: f64,
    } => UNPROCESSABLE_ENTITY, "No landing there",
    /// A survey that cannot be laid out as requested.
    BadSurvey {
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "No survey there",
    /// Two sides of a survey area cross.
    SurveyCrosses {
        /// Corner at which one side begins, counted from 1.
        one: u64,
        /// Corner at which the other side begins, counted from 1.
        other: u64,
    } => UNPROCESSABLE_ENTITY, "No survey there",
    /// A survey with more items than the vehicle can store.
    SurveyItems {
        /// Smallest number of items needed.
        count: u64,
        /// Largest number that the vehicle can store.
        max: u64,
    } => UNPROCESSABLE_ENTITY, "No survey there",
    /// The wind is too strong for the plane to follow the lines of a survey.
    SurveyWind {
        /// Wind speed.
        wind_m_s: f64,
        /// Airspeed of the plane.
        airspeed_m_s: f64,
        /// Course of the lines, from true north.
        course_deg: f64,
    } => UNPROCESSABLE_ENTITY, "No survey there",
    /// The wind is too strong for the plane to approach on this course.
    LandingWind {
        /// Wind speed.
        wind_m_s: f64,
        /// Airspeed of the plane.
        airspeed_m_s: f64,
        /// Course of the final leg, from true north.
        course_deg: f64,
    } => UNPROCESSABLE_ENTITY, "No landing there",
    /// A mission item holds a value that cannot be sent.
    BadItem {
        /// Sequence number of the item, with home as 0.
        seq: u16,
        /// Name of its command without `MAV_CMD_`.
        command: String,
        /// Name of the field.
        field: String,
        /// Value of the field; null when it is not a number.
        #[schema(required = true)]
        value: Option<f64>,
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid plan",
    /// An invalid plan.
    BadPlan {
        /// The plan concerned; null when it is not of a known kind.
        #[schema(required = true)]
        plan: Option<PlanKind>,
        /// The item or zone, counted from 1; null when the problem concerns the whole plan.
        #[schema(required = true)]
        item: Option<u64>,
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid plan",
    /// A file that cannot be read.
    BadFile {
        /// Position in the file: `line 4`, or a path in JSON; null when the problem concerns the whole file.
        #[schema(required = true)]
        place: Option<String>,
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid file",

    // Maps -----------------------------------------------------------------------------------------------------------
    /// The server was started without a maps folder.
    NoMaps => SERVICE_UNAVAILABLE, "Maps are not available",
    /// There is no map source with that id.
    NoSource {
        /// Id of the source.
        source: String,
    } => NOT_FOUND, "No such map source",
    /// The source has no tile at that position.
    NoTile => NOT_FOUND, "No tile there",
    /// The map service requires a key.
    SourceKey {
        /// Id of the source.
        source: String,
    } => CONFLICT, "The source needs a key",
    /// The source cannot be used as it is configured.
    SourceInvalid {
        /// Id of the source.
        source: String,
        /// The reason, in English.
        problem: String,
    } => CONFLICT, "The source cannot be used",
    /// Invalid settings of a map source.
    SourceSettings {
        /// Id of the source.
        source: String,
        /// One problem per faulty field, in English; each names the field.
        problems: Vec<String>,
    } => UNPROCESSABLE_ENTITY, "The settings are wrong",
    /// The configuration file of the map sources is invalid.
    SourceFile {
        /// The problem, with its line, in English.
        problem: String,
    } => CONFLICT, "The file of the sources is wrong",
    /// The map service returned an error or an unexpected answer.
    SourceFailed {
        /// Host of the service.
        service: String,
        /// HTTP status; null when the status was not the problem.
        #[schema(required = true)]
        status: Option<u16>,
        /// The service's own text where it sent one.
        problem: String,
    } => BAD_GATEWAY, "The map service failed",
    /// The address of the map service lies inside this network, where the source is not permitted to be: it was not asked.
    SourceLocal {
        /// Host of the service.
        service: String,
        /// Whether the setting `local_network` of the source would permit it.
        is_permissible: bool,
        /// The reason and the remedy, in English.
        problem: String,
    } => BAD_GATEWAY, "The map service is in the local network",
    /// The map service did not answer in time.
    SourceTimeout {
        /// Host of the service.
        service: String,
        /// Time waited.
        waited_s: u64,
    } => GATEWAY_TIMEOUT, "The map service did not answer",
    /// The map service cannot be reached.
    SourceOffline {
        /// Host of the service.
        service: String,
        /// The reason, as far as it is known.
        why: vencejo_maps::Unreached,
        /// The reason, in English.
        problem: String,
        /// Time until the next attempt.
        retry_s: u64,
    } => SERVICE_UNAVAILABLE, "The map service cannot be reached",
    /// Too many tiles are being fetched.
    SourceBusy => SERVICE_UNAVAILABLE, "Too much at once",
    /// Offline areas of this source are not permitted.
    OfflineRefused {
        /// Id of the source.
        source: String,
        /// The reason, in English.
        problem: String,
    } => CONFLICT, "Not for offline use",
    /// An offline area with too many tiles.
    AreaTooLarge {
        /// Tiles in the area.
        tiles: u64,
        /// Largest number accepted.
        limit: u64,
    } => UNPROCESSABLE_ENTITY, "The area is too large",
    /// An uploaded map file is invalid.
    MapFile {
        /// Name of the file.
        name: String,
        /// The reason, in English.
        problem: String,
    } => UNPROCESSABLE_ENTITY, "Invalid map file",
    /// The disk or a database of the maps failed.
    MapStorage {
        /// The error message, in English.
        problem: String,
    } => INTERNAL_SERVER_ERROR, "The disk or a database failed",
    /// The server's disk does not have enough free space.
    LowSpace {
        /// Free megabytes.
        free_mb: u64,
        /// Megabytes that must stay free.
        floor_mb: u64,
    } => INSUFFICIENT_STORAGE, "The disk is too full",
    /// Another client changed the draft of the plan in the meantime. Both versions are kept.
    DraftConflict {
        /// Current revision of the draft.
        revision: u64,
        /// Name of the session that changed it.
        by: String,
    } => CONFLICT, "The draft was changed meanwhile",
}

impl Cause {
    /// Stable code of the cause.
    pub fn code(&self) -> String {
        let value = serde_json::to_value(self).expect("invariant: the API's types are JSON");
        value["code"].as_str().expect("invariant: the tag is a text").to_owned()
    }
}

/// The value, or `None` when JSON cannot represent it (NaN or infinity).
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_its_code_and_what_belongs_to_it() {
        let cause = Cause::NoProgress { step: "sending".into(), attempts: 3 };
        let json = serde_json::json!({"code": "no-progress", "step": "sending", "attempts": 3});
        assert_eq!((serde_json::to_value(&cause).expect("JSON"), cause.code().as_str()), (json, "no-progress"));
        assert_eq!(serde_json::to_value(Cause::NoSession).expect("JSON"), serde_json::json!({"code": "no-session"}));
        assert_eq!(finite(f64::NAN), None);
    }
}
