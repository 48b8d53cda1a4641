//! What went wrong, for programs: a stable code, and what a sentence about it needs in any language.

use serde::Serialize;
use utoipa::ToSchema;

use super::{PlanKind, PlanUncertainty};

/// Something that a request may name and that is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Thing {
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
}

/// Of what there is too much at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Crowd {
    /// Sessions in use.
    Sessions,
    /// WebSockets of this session, or of all.
    Sockets,
    /// Viewers of cameras.
    Viewers,
    /// Operations under way.
    Operations,
    /// Requests that wait for one vehicle.
    Requests,
    /// Open links.
    Links,
    /// Vehicles or messages that one client follows.
    Subscriptions,
    /// Files that are worked on as they come.
    Bodies,
}

/// Why a vehicle takes its mission only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnlyMissionReason {
    /// Its firmware is too old.
    OldFirmware,
    /// It speaks MAVLink 1.
    Mavlink1,
}

/// What went wrong. `code` is stable, and is the end of the problem's `type`; the other fields hold what the English `detail`
/// says, so that it can be said in another language. A field in English words says so.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "code", rename_all = "kebab-case", rename_all_fields = "snake_case")]
pub enum Cause {
    // Who asks -------------------------------------------------------------------------------------------------------
    /// `Host` names another server.
    Host {
        /// What it says; null when it cannot be read.
        #[schema(required = true)]
        host: Option<String>,
    },
    /// The request comes from another site's page.
    Origin {
        /// That site.
        origin: String,
    },
    /// There is no session, or it is not known any more.
    NoSession,
    /// This token is none of the server's.
    BadToken,
    /// A viewer may not do that.
    Role,
    /// Only the session that holds control may do that.
    Control {
        /// Name of the session that holds it; null when nobody does.
        #[schema(required = true)]
        holder: Option<String>,
    },
    /// A dangerous act: the same request again, with `confirmation` in the header `Vencejo-Confirmation`, does it.
    NeedsConfirmation {
        /// What is dangerous: `force-arm`, `force-disarm`, `disarm-in-flight`, `terminate`, `clear-mission`, `clear-fence`,
        /// `clear-rally`, `clear-all`, `reboot`, `fence-off`, `erase` or `write-files`.
        act: String,
        /// Id of the vehicle that it would be done to.
        vehicle: u16,
        /// What to send; good once, for this session, this vehicle and this very act.
        confirmation: String,
        /// For how long it is good.
        valid_s: f64,
    },
    /// The confirmation was given out for another act, was used, or ran out. Nothing was sent.
    BadConfirmation,
    /// Too much at once.
    TooMany {
        /// Of what.
        what: Crowd,
        /// How many are taken.
        limit: u64,
    },
    /// The server or its station is being closed.
    Closed,

    // Signing ---------------------------------------------------------------------------------------------------------
    /// The server keeps no signing keys.
    SigningNoKeys,
    /// The file of the signing keys cannot be used.
    SigningStorage {
        /// What is wrong, in English.
        problem: String,
    },
    /// The name of a signing key is wrong, taken, unknown or in use.
    SigningKeyName {
        /// The name.
        name: String,
    },
    /// The vehicle signs already, or does not yet.
    SigningState {
        /// Whether it signs.
        signs: bool,
    },
    /// The vehicle is armed, or not heard.
    SigningNotDisarmed {
        /// Whether it is; null when it is not known.
        #[schema(required = true)]
        armed: Option<bool>,
    },
    /// Others can listen to the link that the key would go over.
    SigningNotPrivate {
        /// The link.
        link: String,
    },
    /// A change of the vehicle's signing is under way.
    SigningBusy,
    /// The vehicle refused the key.
    SigningRefused {
        /// In its own words.
        text: String,
    },
    /// The vehicle did not show the change in time.
    SigningUnproven,

    // What is asked --------------------------------------------------------------------------------------------------
    /// The request is not of the API's form: a fault of the program that made it.
    InvalidRequest {
        /// What is wrong, in English.
        problem: String,
    },
    /// The body is not JSON.
    MediaType,
    /// The body is larger than this path takes.
    BodyTooLarge,
    /// The request's body came too slowly.
    BodyTooSlow,
    /// Too many wrong tokens came from this address; the next is looked at after a while.
    TokensSlowed {
        /// How long that is.
        wait_s: u64,
    },
    /// The path is not used with this method.
    Method,
    /// There is no such thing.
    NotFound {
        /// What was looked for.
        what: Thing,
        /// What it was called.
        name: String,
    },
    /// A value that may not be sent.
    InvalidValue {
        /// Which.
        field: String,
        /// What it was.
        value: String,
        /// What it must be, in English.
        expected: String,
    },
    /// Recordings are opened on the server's own command line, not over the network.
    RecordingAsLink,
    /// On board a vehicle our heartbeat follows the operators' WebSockets.
    HeartbeatFollowsOperator,
    /// Something unforeseen.
    Internal,

    // Links, recordings ----------------------------------------------------------------------------------------------
    /// A camera cannot do what it was asked for.
    Camera {
        /// Its name.
        name: String,
        /// Why, in English.
        reason: String,
    },
    /// A link string that cannot be read.
    LinkAddress {
        /// What is wrong, in English.
        problem: String,
    },
    /// Nothing can be recorded.
    Recorder {
        /// What the system said.
        reason: String,
    },
    /// No vehicle was heard in time.
    NoVehicle {
        /// For how long it was waited.
        waited_s: f64,
    },
    /// A message was not sent: no link to the vehicle is open.
    NotSent {
        /// Which.
        message: String,
    },

    // What the vehicle answers ---------------------------------------------------------------------------------------
    /// The vehicle refused a command; its own words are the problem's `reasons`.
    CommandRefused {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// Name of the `MAV_RESULT` without that prefix, such as `DENIED`.
        result: String,
        /// Name of the mode that cures a refusal to arm, where a mode does.
        #[schema(required = true)]
        cure_mode: Option<String>,
    },
    /// The station on board of a vehicle far away did not do it; nothing was sent to the autopilot.
    RemoteRefused {
        /// Name of the vehicle.
        vehicle: String,
        /// Why, in English.
        why: String,
    },
    /// The vehicle is played from a recording, and takes no orders; nothing was sent.
    Replayed {
        /// Its id or name.
        vehicle: String,
    },
    /// The vehicle did not answer a command. It may have done it.
    CommandTimeout {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// How often it was sent.
        attempts: u32,
    },
    /// The vehicle agreed, but does not show the effect.
    NotConfirmed {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
        /// What should be seen, in English.
        wanted: String,
        /// What is seen, in English.
        observed: String,
        /// How long it was waited for.
        within_s: f64,
    },
    /// A message that was asked for did not come.
    MessageNotReceived {
        /// Its name, else its id.
        message: String,
    },
    /// Nothing was heard of the vehicle for too long to act on what it said.
    VehicleLost {
        /// For how long.
        age_s: f64,
    },
    /// The same command is on its way already.
    CommandBusy {
        /// Name of the command without `MAV_CMD_`, else its number.
        command: String,
    },
    /// Another transfer with this vehicle runs.
    TransferBusy {
        /// Which, in English.
        running: String,
    },
    /// The vehicle has no such mode.
    UnknownMode {
        /// What was asked for.
        mode: String,
        /// Names that come near.
        suggestions: Vec<String>,
    },
    /// The vehicle has no mode for this.
    NoModeFor {
        /// For what, in English.
        action: String,
    },
    /// The plan on board may be a mixture of two.
    PlanUnknown {
        /// Which plan.
        plan: PlanKind,
        /// Why it is not known; null when it is not for a reason of this list.
        #[schema(required = true)]
        reason: Option<PlanUncertainty>,
    },
    /// The vehicle's firmware is too old for this.
    TooOld {
        /// For what, in English.
        what: String,
    },
    /// Only possible when disarmed.
    Armed {
        /// What is, in English.
        action: String,
    },
    /// Only possible on the ground.
    InTheAir {
        /// What is, in English.
        action: String,
    },
    /// The vehicle lands, or may land in a mission that was not read.
    Landing {
        /// What is not possible then, in English.
        action: String,
        /// Whether it is known to land.
        is_known: bool,
    },
    /// Home is needed and not known.
    HomeUnknown,
    /// The vehicle restarted meanwhile.
    Rebooted,
    /// Given up on request.
    Cancelled,

    // Transfers ------------------------------------------------------------------------------------------------------
    /// The vehicle fell silent.
    TransferTimeout {
        /// What it was asked, in English.
        step: String,
        /// For how long.
        waited_s: f64,
    },
    /// The vehicle is heard, but does not hear us.
    Unreached {
        /// For how long nothing was answered.
        waited_s: f64,
    },
    /// The vehicle answers, but the transfer gets nowhere.
    NoProgress {
        /// What was being done, in English.
        step: String,
        /// How often it was begun.
        attempts: u32,
    },
    /// The vehicle refused a plan.
    PlanRefused {
        /// Which plan.
        plan: PlanKind,
        /// Name of the `MAV_MISSION_RESULT` without `MAV_MISSION_`.
        result: String,
        /// Number on the wire of the item that it most likely refused.
        #[schema(required = true)]
        seq: Option<u16>,
    },
    /// What the vehicle holds is not what was sent; the differences are the problem's `reasons`.
    PlanMismatch {
        /// Which plan.
        plan: PlanKind,
        /// How many differences there are.
        differences: u64,
    },
    /// A plan was sent but could not be read back: what the vehicle holds is unknown.
    Unverified {
        /// Which plan.
        plan: PlanKind,
    },
    /// The vehicle takes its mission only.
    OnlyMission {
        /// Which plan was wanted.
        plan: PlanKind,
        /// Why not.
        reason: OnlyMissionReason,
    },
    /// A plan was cleared, but items are left.
    NotCleared {
        /// Which plan.
        plan: PlanKind,
        /// How many.
        count: u16,
    },
    /// More than a transfer takes.
    TooLarge {
        /// Of what, in English.
        what: String,
        /// How many.
        count: u64,
        /// How many are taken.
        limit: u64,
    },
    /// A file of the vehicle cannot be read or written.
    VehicleFile {
        /// Which.
        path: String,
    },
    /// Another station uses the vehicle's files.
    FilesBusy {
        /// The file that was wanted.
        path: String,
    },
    /// The vehicle does not have this parameter, or does not answer for it.
    UnknownParam {
        /// Its name.
        name: String,
        /// Whether the vehicle said so; otherwise it was silent.
        told: bool,
    },
    /// The vehicle refused a parameter's value.
    ParamRefused {
        /// Its name.
        name: String,
        /// Why, in English.
        reason: String,
    },
    /// The vehicle keeps another value than the one that was sent.
    ParamNotKept {
        /// Its name.
        name: String,
        /// What was sent.
        asked: f64,
        /// What it has.
        kept: f64,
    },
    /// A parameter's name or value that may not be sent.
    InvalidParam {
        /// What is wrong, in English.
        problem: String,
    },

    // Plans ----------------------------------------------------------------------------------------------------------
    /// The checks found errors; nothing was sent.
    PlanUnsound {
        /// How many errors.
        errors: u64,
    },
    /// A latitude or longitude that is not on the globe.
    NotOnEarth {
        /// Latitude given; null when it is not a number.
        #[schema(required = true)]
        lat_deg: Option<f64>,
        /// Longitude given; null when it is not a number.
        #[schema(required = true)]
        lon_deg: Option<f64>,
    },
    /// Nothing says in which direction to land: no course, no place that the plane comes from, no wind.
    LandingDirection {
        /// How far away that place must lie at least.
        nearest_m: f64,
    },
    /// A survey that cannot be laid out as it is asked for.
    BadSurvey {
        /// What is wrong, in English.
        problem: String,
    },
    /// Two sides of an area cross.
    SurveyCrosses {
        /// The corner that one begins at, counted from 1.
        one: u64,
        /// The corner that the other begins at.
        other: u64,
    },
    /// A survey of more items than the vehicle holds.
    SurveyItems {
        /// How many, at least.
        count: u64,
        /// The most.
        max: u64,
    },
    /// The wind is too strong for the plane to get along the lines of a survey.
    SurveyWind {
        /// The wind's speed.
        wind_m_s: f64,
        /// The plane's airspeed.
        airspeed_m_s: f64,
        /// Course of the lines from true north.
        course_deg: f64,
    },
    /// The wind is too strong for the plane to come in on this course.
    LandingWind {
        /// The wind's speed.
        wind_m_s: f64,
        /// The plane's airspeed.
        airspeed_m_s: f64,
        /// Course of the final leg from true north.
        course_deg: f64,
    },
    /// An item of a mission holds a value that cannot be sent.
    BadItem {
        /// The item's number on the wire.
        seq: u16,
        /// Its command without `MAV_CMD_`.
        command: String,
        /// Which field.
        field: String,
        /// Its value; null when it is not a number.
        #[schema(required = true)]
        value: Option<f64>,
        /// Why it is wrong, in English.
        problem: String,
    },
    /// A plan that cannot be one.
    BadPlan {
        /// Which plan; null when it is none of the known kinds.
        #[schema(required = true)]
        plan: Option<PlanKind>,
        /// The item or zone, counted from 1; null when it is about the whole.
        #[schema(required = true)]
        item: Option<u64>,
        /// What is wrong, in English.
        problem: String,
    },
    /// A file that cannot be read.
    BadFile {
        /// Where: `line 4`, or a path in JSON; null when it is about the whole.
        #[schema(required = true)]
        place: Option<String>,
        /// What is wrong, in English.
        problem: String,
    },

    // Maps -----------------------------------------------------------------------------------------------------------
    /// The server was started without a folder for maps.
    NoMaps,
    /// No source of that id is configured.
    NoSource {
        /// The id.
        source: String,
    },
    /// Nothing is to be drawn there.
    NoTile,
    /// The source's service demands the user's key.
    SourceKey {
        /// Id of the source.
        source: String,
    },
    /// The source cannot be used as it is configured.
    SourceInvalid {
        /// Id of the source.
        source: String,
        /// Why, in English.
        problem: String,
    },
    /// Settings of a source that cannot be.
    SourceSettings {
        /// Id of the source.
        source: String,
        /// Each names its field, in English.
        problems: Vec<String>,
    },
    /// The file of the sources is wrong.
    SourceFile {
        /// What is wrong with its line, in English.
        problem: String,
    },
    /// The map service answered with something else.
    SourceFailed {
        /// Its host.
        service: String,
        /// The HTTP status, where that is what was wrong.
        #[schema(required = true)]
        status: Option<u16>,
        /// In its own words where it gave some.
        problem: String,
    },
    /// The map service did not answer in time.
    SourceTimeout {
        /// Its host.
        service: String,
        /// How long it was given.
        waited_s: u64,
    },
    /// The map service is not reached.
    SourceOffline {
        /// Its host.
        service: String,
        /// Why, as far as that is known.
        why: vencejo_maps::Unreached,
        /// Why, in English.
        problem: String,
        /// When it is tried again.
        retry_s: u64,
    },
    /// Too many tiles are being fetched.
    SourceBusy,
    /// No offline areas may be made of the source.
    OfflineRefused {
        /// Id of the source.
        source: String,
        /// Why, in English.
        problem: String,
    },
    /// An offline area of more tiles than are taken.
    AreaTooLarge {
        /// Of the area.
        tiles: u64,
        /// Taken at most.
        limit: u64,
    },
    /// A map file that was handed in is not what it should be.
    MapFile {
        /// Its name.
        name: String,
        /// What is wrong, in English.
        problem: String,
    },
    /// The disk or a database of the maps failed.
    MapStorage {
        /// What it said, in English.
        problem: String,
    },
    /// The server's disk is too full for that.
    LowSpace {
        /// Free megabytes.
        free_mb: u64,
        /// Megabytes that stay free.
        floor_mb: u64,
    },
    /// The draft of the plan was changed by somebody else meanwhile. Both are kept.
    DraftConflict {
        /// The revision that it has now.
        revision: u64,
        /// Name of the session that changed it.
        by: String,
    },
}

impl Cause {
    /// The stable code.
    pub fn code(&self) -> String {
        let value = serde_json::to_value(self).expect("invariant: the API's types are JSON");
        value["code"].as_str().expect("invariant: the tag is a text").to_owned()
    }
}

/// A number as JSON can say it.
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
