//! Conversion of requests to orders and of their results to answers.

use std::time::Duration;

use vencejo_flight::plan::{Command, Mission};
use vencejo_proto::{Address, CommandInt, CommandLong};
use vencejo_station::{RequestResult, StationError};
use vencejo_vehicle::command::CommandResult;
use vencejo_vehicle::modes::{FlightMode, ModeFamily};
use vencejo_vehicle::transfer::TransferError;
use vencejo_vehicle::{AltFrame, Danger, ModeChoice, Recipient, Reply, Request, SpeedKind, Turn, VehicleError};

use crate::authority::{Claim, answer};
use crate::content::{Content, MAX_PACKED, pack_items, unpack_items};
use crate::deed::{
    AbortLanding, Act, Altitude, Climb, Course, Deed, Int, Long, NewParam, Nothing, PlanClear, PlanPut, Reposition,
};
use crate::outcome::{Outcome, STEP, fault_of, outcome_of, unverified};
use crate::payload::{Answer, BadPayload, End};
use crate::plans::kind_of;

/// The order body of a request. The plan revision that it is based on is filled in later.
///
/// # Errors
/// Why it cannot be sent over a network, and what to do instead.
pub fn act_of(request: &Request, confirmed: Option<Danger>) -> Result<Act, &'static str> {
    let deed = match request {
        Request::DespiteMixedPlan(request) => {
            return Ok(Act { despite_mixed_plan: true, ..act_of(request, confirmed)? });
        }
        Request::Arm { force } => Deed::Arm(*force),
        Request::Disarm { force } => Deed::Disarm(*force),
        Request::SetMode { mode: ModeChoice::Name(name) } => Deed::Mode(name.clone()),
        Request::SetMode { mode: ModeChoice::Custom(number) } => Deed::ModeNumber(*number),
        Request::Takeoff { alt_rel_home_m } => Deed::Takeoff(*alt_rel_home_m),
        Request::Reposition {
            lat_deg,
            lon_deg,
            alt_m,
            alt_frame,
            radius_m,
            turn,
            speed_m_s,
            change_mode,
            below_home,
        } => Deed::Reposition(Reposition {
            lat_deg: *lat_deg,
            lon_deg: *lon_deg,
            alt_m: *alt_m,
            frame: alt_frame.mav_frame().into(),
            radius_m: *radius_m,
            counter_clockwise: *turn == Turn::CounterClockwise,
            speed_m_s: *speed_m_s,
            change_mode: *change_mode,
            below_home: *below_home,
        }),
        Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s } => Deed::Airspeed(*speed_m_s),
        Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s } => Deed::Groundspeed(*speed_m_s),
        Request::ChangeAltitude { alt_m, alt_frame, below_home } => {
            Deed::Altitude(Altitude { alt_m: *alt_m, frame: alt_frame.mav_frame().into(), below_home: *below_home })
        }
        Request::LoiterHere => Deed::LoiterHere(Nothing {}),
        Request::ReturnToLaunch => Deed::ReturnToLaunch(Nothing {}),
        Request::Land => Deed::Land(Nothing {}),
        Request::AbortLanding { alt_rel_home_m } => {
            Deed::AbortLanding(AbortLanding { alt_rel_home_m: *alt_rel_home_m })
        }
        Request::PrepareFlight => Deed::PrepareFlight(Nothing {}),
        Request::MissionPause => Deed::MissionPause(Nothing {}),
        Request::MissionResume => Deed::MissionResume(Nothing {}),
        Request::GuidedCourse { course_deg, accel_m_s2 } => {
            Deed::Course(Course { course_deg: *course_deg, accel_m_s2: *accel_m_s2 })
        }
        Request::GuidedClimb { alt_m, alt_frame, rate_m_s, below_home } => Deed::Climb(Climb {
            alt_m: *alt_m,
            frame: alt_frame.mav_frame().into(),
            rate_m_s: *rate_m_s,
            below_home: *below_home,
        }),
        Request::Reboot => Deed::Reboot(Nothing {}),
        Request::RawCommandLong(long) if long.target == THE_AUTOPILOT => {
            Deed::Long(Long { command: long.command.into(), params: long.params.to_vec() })
        }
        Request::RawCommandInt(int) if int.target == THE_AUTOPILOT => {
            let params = int.params.into_iter().chain([int.z]).collect();
            Deed::Int(Int { command: int.command.into(), frame: int.frame.into(), params, x: int.x, y: int.y })
        }
        Request::RawCommandLong(_) | Request::RawCommandInt(_) => {
            return Err(
                "a command goes to the autopilot alone, which is target 0; for another component use a direct link",
            );
        }
        Request::UploadPlan { kind, items, home, despite_findings } => {
            let packed = pack_items(&Mission { home: *home, items: items.clone() });
            if packed.len() > MAX_PACKED {
                return Err("the plan is longer than 256 KiB packed; send a shorter one, or this one at a direct link");
            }
            let (kind, list) = (kind.mission_type().into(), Some(Content::of(packed)));
            Deed::PlanPut(PlanPut { kind, revision: 0, list, despite_findings: *despite_findings })
        }
        Request::ClearPlan { kind } => Deed::PlanClear(PlanClear { kind: kind.mission_type().into(), revision: 0 }),
        Request::DownloadPlan { kind } => Deed::PlanRead(kind.mission_type().into()),
        Request::ParamList => Deed::ParamList(Nothing {}),
        Request::ParamRead { name } => Deed::ParamRead(name.clone()),
        Request::ParamSet { name, value } => Deed::ParamSet(NewParam { name: name.clone(), value: *value }),
        Request::Velocity { .. } => {
            return Err(
                "a velocity has to be repeated several times a second, which no network promises: order a position, \
                        a course or a climb, or fly it at a direct link",
            );
        }
        other => {
            let Ok(text) = serde_json::to_string(other) else {
                return Err("this program does not send it over a network; ask for it at a direct link");
            };
            // JSON has no numbers for NaN and infinities.
            if serde_json::from_str(&text).ok().as_ref() != Some(other) {
                return Err("one of its values is not a finite number");
            }
            Deed::Other(text)
        }
    };
    let confirmed = confirmed.map(|danger| danger.code().to_owned()).unwrap_or_default();
    Ok(Act { despite_mixed_plan: false, confirmed, deed: Some(deed) })
}

/// Commands go to the vehicle's autopilot, whatever its MAVLink address on board.
const THE_AUTOPILOT: Address = Address::new(0, 0);

/// The parameters of a command, exactly `N`.
fn params_of<const N: usize>(params: &[f32]) -> Result<[f32; N], BadPayload> {
    params.try_into().map_err(|_| BadPayload::Field("params"))
}

fn short<T: TryFrom<u32>>(number: u32, field: &'static str) -> Result<T, BadPayload> {
    number.try_into().map_err(|_| BadPayload::Field(field))
}

/// The request of an order, and the danger that was confirmed. A list must be present with its bytes.
///
/// # Errors
/// [`BadPayload`] for an invalid order. Numbers are checked where they are used.
pub fn request_of(act: &Act) -> Result<(Request, Option<Danger>), BadPayload> {
    let deed = act.deed.as_ref().ok_or(BadPayload::Field("deed"))?;
    let request = match deed {
        Deed::Arm(force) => Request::Arm { force: *force },
        Deed::Disarm(force) => Request::Disarm { force: *force },
        Deed::Mode(name) => Request::SetMode { mode: ModeChoice::Name(name.clone()) },
        Deed::ModeNumber(number) => Request::SetMode { mode: ModeChoice::Custom(*number) },
        Deed::Takeoff(alt_rel_home_m) => Request::Takeoff { alt_rel_home_m: *alt_rel_home_m },
        Deed::Reposition(to) => Request::Reposition {
            lat_deg: to.lat_deg,
            lon_deg: to.lon_deg,
            alt_m: to.alt_m,
            alt_frame: alt_frame(to.frame)?,
            radius_m: to.radius_m,
            turn: if to.counter_clockwise { Turn::CounterClockwise } else { Turn::Clockwise },
            speed_m_s: to.speed_m_s,
            change_mode: to.change_mode,
            below_home: to.below_home,
        },
        Deed::Airspeed(speed_m_s) => Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: *speed_m_s },
        Deed::Groundspeed(speed_m_s) => Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s: *speed_m_s },
        Deed::Altitude(to) => {
            Request::ChangeAltitude { alt_m: to.alt_m, alt_frame: alt_frame(to.frame)?, below_home: to.below_home }
        }
        Deed::LoiterHere(_) => Request::LoiterHere,
        Deed::ReturnToLaunch(_) => Request::ReturnToLaunch,
        Deed::Land(_) => Request::Land,
        Deed::AbortLanding(how) => Request::AbortLanding { alt_rel_home_m: how.alt_rel_home_m },
        Deed::PrepareFlight(_) => Request::PrepareFlight,
        Deed::MissionPause(_) => Request::MissionPause,
        Deed::MissionResume(_) => Request::MissionResume,
        Deed::Course(to) => Request::GuidedCourse { course_deg: to.course_deg, accel_m_s2: to.accel_m_s2 },
        Deed::Climb(to) => Request::GuidedClimb {
            alt_m: to.alt_m,
            alt_frame: alt_frame(to.frame)?,
            rate_m_s: to.rate_m_s,
            below_home: to.below_home,
        },
        Deed::Reboot(_) => Request::Reboot,
        Deed::Long(long) => Request::RawCommandLong(CommandLong {
            target: THE_AUTOPILOT,
            command: short(long.command, "command")?,
            confirmation: 0,
            params: params_of(&long.params)?,
        }),
        Deed::Int(int) => {
            let [p1, p2, p3, p4, z] = params_of(&int.params)?;
            Request::RawCommandInt(CommandInt {
                target: THE_AUTOPILOT,
                frame: short(int.frame, "frame")?,
                command: short(int.command, "command")?,
                current: 0,
                autocontinue: 0,
                params: [p1, p2, p3, p4],
                x: int.x,
                y: int.y,
                z,
            })
        }
        Deed::PlanPut(put) => {
            let list = put.list.as_ref().ok_or(BadPayload::Field("list"))?;
            list.name()?;
            let Mission { home, items } = unpack_items(&list.here)?;
            Request::UploadPlan { kind: kind_of(put.kind)?, items, home, despite_findings: put.despite_findings }
        }
        Deed::PlanClear(clear) => Request::ClearPlan { kind: kind_of(clear.kind)? },
        Deed::PlanRead(kind) => Request::DownloadPlan { kind: kind_of(*kind)? },
        Deed::ParamList(_) => Request::ParamList,
        Deed::ParamRead(name) => Request::ParamRead { name: name.clone() },
        Deed::ParamSet(param) => Request::ParamSet { name: param.name.clone(), value: param.value },
        Deed::Other(text) => serde_json::from_str(text).map_err(|_| BadPayload::Field("other"))?,
    };
    let confirmed = match act.confirmed.as_str() {
        "" => None,
        code => Some(Danger::from_code(code).ok_or(BadPayload::Field("confirmed"))?),
    };
    Ok(if act.despite_mixed_plan {
        (Request::DespiteMixedPlan(Box::new(request)), confirmed)
    } else {
        (request, confirmed)
    })
}

fn alt_frame(number: u32) -> Result<AltFrame, BadPayload> {
    let known = [AltFrame::Amsl, AltFrame::RelHome, AltFrame::Terrain];
    known.into_iter().find(|frame| u32::from(frame.mav_frame()) == number).ok_or(BadPayload::Field("frame"))
}

/// An order in brief, for the log.
pub fn brief(act: &Act) -> String {
    match &act.deed {
        Some(Deed::PlanPut(put)) => {
            let bytes = put.list.as_ref().map_or(0, |list| list.length);
            format!("PlanPut {{ kind: {}, revision: {}, bytes: {bytes} }}", put.kind, put.revision)
        }
        deed => format!("{deed:?}").chars().take(200).collect(),
    }
}

/// The answer for a result on board.
pub fn answer_of(claim: &Claim, result: &RequestResult) -> Answer {
    let error = match result {
        Ok(reply) => return Answer { outcome: outcome_of(reply), ..answer(claim, End::Done, "") },
        Err(error) => error,
    };
    let why = match error {
        StationError::RemoteRefused { why, .. } => why.clone(),
        _ => error.to_string(),
    };
    if let StationError::Vehicle(error) = error
        && let Some(fault) = fault_of(error)
    {
        return Answer { outcome: Some(Outcome::Fault(fault)), ..answer(claim, End::Failed, &why) };
    }
    match error {
        StationError::Vehicle(VehicleError::CommandRefused { command, result, reasons, cure, .. }) => Answer {
            command: command.0.into(),
            result: result.0.into(),
            reasons: reasons.clone(),
            cure: cure.map_or(0, |mode| u64::from(mode.custom_mode) + 1),
            ..answer(claim, End::CommandRefused, &why)
        },
        StationError::Vehicle(
            VehicleError::CommandTimeout { command, .. } | VehicleError::NotConfirmed { command, .. },
        ) => Answer { command: command.0.into(), ..answer(claim, End::Unknown, &why) },
        StationError::Vehicle(VehicleError::Rebooted | VehicleError::Cancelled) | StationError::Closed => {
            answer(claim, End::Unknown, &why)
        }
        StationError::Control { holder, .. } => Answer { holder: holder.clone(), ..answer(claim, End::Held, "") },
        _ => answer(claim, End::Refused, &why),
    }
}

/// The result of `request` to the vehicle of this name by its answer.
///
/// # Errors
/// The error of the answer.
pub fn result_of(answer: &Answer, request: &Request, name: &str, family: ModeFamily) -> RequestResult {
    let refused = |why: String| Err(StationError::RemoteRefused { name: name.to_owned(), why });
    let reasons = || std::iter::once(&answer.why).filter(|why| !why.is_empty()).chain(&answer.reasons).cloned();
    let unknown_end = || Err(unknown_end(request, name, 1, Duration::ZERO, reasons().collect()));
    let command = u16::try_from(answer.command).ok().filter(|number| *number != 0).map(Command);
    match answer.end() {
        End::Done | End::Granted => Ok(Reply::Done),
        End::Held | End::Asked if !answer.holder.is_empty() => {
            Err(StationError::Control { holder: answer.holder.clone(), vehicle: Some(name.to_owned()) })
        }
        End::CommandRefused => {
            let cure = answer.cure.checked_sub(1).and_then(|number| u32::try_from(number).ok());
            Err(StationError::Vehicle(VehicleError::CommandRefused {
                target: Recipient::Remote(name.to_owned()),
                command: command.unwrap_or_else(|| request.command()),
                result: CommandResult(u8::try_from(answer.result).unwrap_or(u8::MAX)),
                reasons: answer.reasons.clone(),
                cure: cure.map(|custom_mode| FlightMode { family, custom_mode }),
            }))
        }
        // It has read nothing.
        End::Unknown if command.is_none() && !request.is_act() => refused(reasons().collect::<Vec<_>>().join("; ")),
        End::Unknown => {
            command.map_or_else(unknown_end, |command| Err(unknown(command, name, 1, answer.reasons.clone())))
        }
        End::Failed => match &answer.outcome {
            Some(Outcome::Fault(fault)) => fault.read().map_or_else(|_| unknown_end(), Err),
            _ => unknown_end(),
        },
        End::ListMissing => refused("the list has not arrived whole; send it again".to_owned()),
        End::Stale | End::Refused | End::Held | End::Asked | End::Unspecified => {
            refused(reasons().collect::<Vec<_>>().join("; "))
        }
    }
}

/// The error when the outcome of a request is unknown after this many attempts in this time.
pub fn unknown_end(
    request: &Request,
    name: &str,
    attempts: u32,
    waited: Duration,
    reasons: Vec<String>,
) -> StationError {
    let error = match request {
        Request::UploadPlan { kind, .. } | Request::ClearPlan { kind } => unverified(*kind, waited),
        Request::DownloadPlan { .. } | Request::ParamList | Request::ParamRead { .. } | Request::ParamSet { .. } => {
            TransferError::Timeout { step: STEP, waited }
        }
        request => return unknown(request.command(), name, attempts, reasons),
    };
    VehicleError::Transfer(error).into()
}

/// It is unknown whether it was done.
fn unknown(command: Command, name: &str, attempts: u32, reasons: Vec<String>) -> StationError {
    let target = Recipient::Remote(name.to_owned());
    StationError::Vehicle(VehicleError::CommandTimeout { target, command, attempts, reasons })
}

#[cfg(test)]
mod tests {
    use vencejo_flight::plan::{MissionItem, PlanKind};
    use vencejo_vehicle::telemetry::Severity;
    use vencejo_vehicle::{MessageId, MessageRate};

    use super::*;
    use crate::authority::Wish;
    use crate::stamp::StateStamp;

    #[test]
    fn a_request_comes_out_as_it_went_in() {
        let reposition = |alt_frame, turn, radius_m| Request::Reposition {
            lat_deg: 40.123_456_789,
            lon_deg: -3.7,
            alt_m: 80.1,
            alt_frame,
            radius_m,
            turn,
            speed_m_s: None,
            change_mode: true,
            below_home: false,
        };
        let requests = [
            Request::Arm { force: true },
            Request::Disarm { force: false },
            Request::SetMode { mode: ModeChoice::Name("FBWA".into()) },
            Request::SetMode { mode: ModeChoice::Custom(0) },
            Request::Takeoff { alt_rel_home_m: 50.0 },
            reposition(AltFrame::RelHome, Turn::CounterClockwise, Some(60.0)),
            reposition(AltFrame::Terrain, Turn::Clockwise, None),
            Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 14.2 },
            Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s: 14.2 },
            Request::ChangeAltitude { alt_m: 100.0, alt_frame: AltFrame::Amsl, below_home: false },
            Request::LoiterHere,
            Request::ReturnToLaunch,
            Request::Land,
            Request::AbortLanding { alt_rel_home_m: None },
            Request::AbortLanding { alt_rel_home_m: Some(40.0) },
            Request::PrepareFlight,
            Request::MissionStart { from_item: None },
            Request::MissionStart { from_item: Some(1) },
            Request::MissionPause,
            Request::MissionResume,
            Request::SetCurrentItem { item: 65_535 },
            Request::DespiteMixedPlan(Box::new(Request::Arm { force: false })),
            Request::GuidedCourse { course_deg: 271.3, accel_m_s2: 2.0 },
            Request::GuidedClimb { alt_m: 99.9, alt_frame: AltFrame::Terrain, rate_m_s: Some(1.5), below_home: true },
            Request::SetHome { lat_deg: None, lon_deg: None, alt_amsl_m: None },
            Request::SetHome { lat_deg: Some(40.123_456_789), lon_deg: Some(-3.7), alt_amsl_m: Some(612.3) },
            Request::Reboot,
            Request::RawCommandLong(CommandLong {
                target: THE_AUTOPILOT,
                command: 400,
                confirmation: 0,
                params: [1.0, 0.1, 0.0, 0.0, 0.0, 0.0, -0.0],
            }),
            Request::RawCommandInt(CommandInt {
                target: THE_AUTOPILOT,
                frame: 3,
                command: 192,
                current: 0,
                autocontinue: 0,
                params: [-1.0, 0.0, 60.0, 0.0],
                x: 403_332_000,
                y: -37_978_000,
                z: 80.5,
            }),
            Request::RequestMessage { message: MessageId(148) },
            Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Stop },
            Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Default },
            Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Hz(0.5) },
            Request::UploadPlan {
                kind: PlanKind::Rally,
                items: vec![MissionItem::waypoint(40.123_456_789, -3.7, 80.1)],
                home: None,
                despite_findings: true,
            },
            Request::ClearPlan { kind: PlanKind::Fence },
            Request::DownloadPlan { kind: PlanKind::Mission },
            Request::ParamList,
            Request::ParamRead { name: "WP_RADIUS".into() },
            Request::ParamSet { name: "WP_RADIUS".into(), value: 90.1 },
            Request::SwitchFence { on: false },
            Request::Note { severity: Severity::INFO, text: "\"ñ\"".into() },
        ];
        for request in requests {
            let act = act_of(&request, None).expect("goes over a network");
            assert_eq!(request_of(&act), Ok((request, None)));
        }
        for danger in Danger::ALL {
            let act = act_of(&Request::Disarm { force: true }, Some(danger)).expect("goes over a network");
            assert_eq!(request_of(&act), Ok((Request::Disarm { force: true }, Some(danger))));
        }
    }

    #[test]
    fn what_does_not_go_over_a_network_is_refused_in_words() {
        let other = CommandLong { target: Address::new(1, 100), command: 1, confirmation: 0, params: [0.0; 7] };
        for (request, says) in [
            (Request::Velocity { forward_m_s: 1.0, right_m_s: 0.0, down_m_s: 0.0, yaw_rate_rad_s: 0.0 }, "repeated"),
            (
                Request::SetHome { lat_deg: Some(f64::NAN), lon_deg: Some(-3.0), alt_amsl_m: Some(600.0) },
                "not a finite number",
            ),
            (Request::RawCommandLong(other), "direct link"),
            (Request::DespiteMixedPlan(Box::new(Request::RawCommandLong(other))), "direct link"),
        ] {
            assert!(act_of(&request, None).is_err_and(|why| why.contains(says)), "{request:?}");
        }
        assert_eq!(request_of(&Act::default()), Err(BadPayload::Field("deed")));
        let odd = |deed| request_of(&Act { deed: Some(deed), ..Act::default() });
        assert_eq!(
            odd(Deed::Altitude(Altitude { alt_m: 1.0, frame: 1, below_home: false })),
            Err(BadPayload::Field("frame"))
        );
        let long = |command, count| odd(Deed::Long(Long { command, params: vec![0.0; count] }));
        assert_eq!(
            (long(65_536, 7), long(1, 8)),
            (Err(BadPayload::Field("command")), Err(BadPayload::Field("params")))
        );
        let put = |list| odd(Deed::PlanPut(PlanPut { kind: 0, revision: 1, list, despite_findings: false }));
        assert_eq!(
            odd(Deed::Other(r#"{"warp":{"factor":9}}"#.into())),
            Err(BadPayload::Field("other")),
            "newer than this"
        );
        assert_eq!(put(None), Err(BadPayload::Field("list")));
        assert!(put(Some(Content::of(b"nonsense".to_vec()))).is_err());
        assert!(put(Some(Content::of(pack_items(&Mission::default())).at_most(0))).is_err(), "by its name alone");
        let danger = Act { confirmed: "fun".into(), ..act_of(&Request::Land, None).expect("goes") };
        assert_eq!(request_of(&danger), Err(BadPayload::Field("confirmed")));
    }

    #[test]
    fn what_the_vehicle_said_is_what_is_told_far_away() {
        let claim = Claim { boot: 1, epoch: 1, id: 5, based_on: StateStamp::default(), wish: Wish::Act };
        let arm = Request::Arm { force: false };
        let told =
            |result: &RequestResult| result_of(&answer_of(&claim, result), &arm, "plane7", ModeFamily::ArduPlane);
        let target = Recipient::Remote("plane7".into());
        assert_eq!(told(&Ok(Reply::Done)), Ok(Reply::Done));
        let refused = VehicleError::CommandRefused {
            target,
            command: Command::COMPONENT_ARM_DISARM,
            result: CommandResult(4),
            reasons: vec!["PreArm: no GPS".into()],
            cure: Some(FlightMode { family: ModeFamily::ArduPlane, custom_mode: 0 }),
        };
        assert_eq!(told(&Err(refused.clone().into())), Err(refused.into()));
        let silent = unknown(Command::COMPONENT_ARM_DISARM, "plane7", 1, Vec::new());
        assert!(silent.to_string().starts_with("plane7 did not answer COMPONENT_ARM_DISARM (400), sent 1 time: "));
        assert_eq!(told(&Err(silent.clone())), Err(silent.clone()));
        let restarted = told(&Err(VehicleError::Rebooted.into())).expect_err("unknown").to_string();
        assert!(restarted.contains("sent 1 time; the vehicle restarted meanwhile"), "{restarted}");
        assert!(restarted.contains("it may or may not have executed it"), "{restarted}");
        let unheard = vec!["its autopilot has been silent".to_owned()];
        let of_silent = |error: StationError| {
            let answer = Answer { reasons: unheard.clone(), ..answer_of(&claim, &Err(error)) };
            result_of(&answer, &arm, "plane7", ModeFamily::ArduPlane).expect_err("not done").to_string()
        };
        let text = of_silent(silent);
        assert!(text.contains("sent 1 time; its autopilot has been silent: it may or may not"), "{text}");
        let text = of_silent(VehicleError::HomeUnknown.into());
        assert!(text.contains("where home is") && text.ends_with("; its autopilot has been silent"), "{text}");
        let rejected = TransferError::Rejected { reasons: vec!["Takeoff waypoint required".into()] };
        let rejected: StationError = VehicleError::Transfer(rejected).into();
        assert_eq!(told(&Err(rejected.clone())), Err(rejected));
        let other = told(&Err(VehicleError::HomeUnknown.into())).expect_err("refused");
        assert!(
            matches!(other, StationError::RemoteRefused { why, .. } if why.contains("home") && !why.ends_with("; ")),
            "what the other said"
        );
    }
}
