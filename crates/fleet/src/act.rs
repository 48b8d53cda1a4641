//! Requests as orders carry them, and their results as answers do.

use vencejo_proto::{Address, MissionSeq};
use vencejo_station::{RequestResult, StationError};
use vencejo_vehicle::command::{CommandName, CommandResult, cmd};
use vencejo_vehicle::modes::{FlightMode, ModeFamily};
use vencejo_vehicle::{AltFrame, Danger, ModeChoice, Reply, Request, SpeedKind, Turn, VehicleError};

use crate::authority::{Claim, answer};
use crate::payload::{AbortLanding, Act, Altitude, Answer, BadPayload, Deed, End, Nothing, Reposition};

/// What an order says of a request; `None`: it does not go over a network.
#[must_use]
pub fn act_of(request: &Request, confirmed: Option<Danger>) -> Option<Act> {
    let deed = match request {
        Request::DespiteMixedPlan(request) => {
            return Some(Act { despite_mixed_plan: true, ..act_of(request, confirmed)? });
        }
        Request::Arm { force } => Deed::Arm(*force),
        Request::Disarm { force } => Deed::Disarm(*force),
        Request::SetMode(ModeChoice::Name(name)) => Deed::Mode(name.clone()),
        Request::SetMode(ModeChoice::Custom(number)) => Deed::ModeNumber(*number),
        Request::Takeoff { alt_rel_home_m } => Deed::Takeoff(*alt_rel_home_m),
        Request::Reposition { lat_deg, lon_deg, alt_m, alt_frame, radius_m, turn, speed_m_s, change_mode } => {
            Deed::Reposition(Reposition {
                lat_deg: *lat_deg,
                lon_deg: *lon_deg,
                alt_m: *alt_m,
                frame: alt_frame.mav_frame().into(),
                radius_m: *radius_m,
                counter_clockwise: *turn == Turn::CounterClockwise,
                speed_m_s: *speed_m_s,
                change_mode: *change_mode,
            })
        }
        Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s } => Deed::Airspeed(*speed_m_s),
        Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s } => Deed::Groundspeed(*speed_m_s),
        Request::ChangeAltitude { alt_m, alt_frame } => {
            Deed::Altitude(Altitude { alt_m: *alt_m, frame: alt_frame.mav_frame().into() })
        }
        Request::LoiterHere => Deed::LoiterHere(Nothing {}),
        Request::ReturnToLaunch => Deed::ReturnToLaunch(Nothing {}),
        Request::Land => Deed::Land(Nothing {}),
        Request::AbortLanding { alt_rel_home_m } => {
            Deed::AbortLanding(AbortLanding { alt_rel_home_m: *alt_rel_home_m })
        }
        Request::PrepareFlight => Deed::PrepareFlight(Nothing {}),
        Request::MissionStart { from } => Deed::MissionStart(from.map_or(0, |seq| u32::from(seq.0) + 1)),
        Request::MissionPause => Deed::MissionPause(Nothing {}),
        Request::MissionResume => Deed::MissionResume(Nothing {}),
        Request::SetCurrentItem(seq) => Deed::CurrentItem(seq.0.into()),
        _ => return None,
    };
    let confirmed = confirmed.map(|danger| danger.code().to_owned()).unwrap_or_default();
    Some(Act { despite_mixed_plan: false, confirmed, deed: Some(deed) })
}

/// The request that an order is about, and the danger that was confirmed.
///
/// # Errors
/// [`BadPayload::Field`] for what cannot be. Numbers are checked where they are used.
pub fn request_of(act: &Act) -> Result<(Request, Option<Danger>), BadPayload> {
    let seq = |number: u32| u16::try_from(number).map(MissionSeq).map_err(|_| BadPayload::Field("item"));
    let deed = act.deed.as_ref().ok_or(BadPayload::Field("deed"))?;
    let request = match deed {
        Deed::Arm(force) => Request::Arm { force: *force },
        Deed::Disarm(force) => Request::Disarm { force: *force },
        Deed::Mode(name) => Request::SetMode(ModeChoice::Name(name.clone())),
        Deed::ModeNumber(number) => Request::SetMode(ModeChoice::Custom(*number)),
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
        },
        Deed::Airspeed(speed_m_s) => Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: *speed_m_s },
        Deed::Groundspeed(speed_m_s) => Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s: *speed_m_s },
        Deed::Altitude(to) => Request::ChangeAltitude { alt_m: to.alt_m, alt_frame: alt_frame(to.frame)? },
        Deed::LoiterHere(_) => Request::LoiterHere,
        Deed::ReturnToLaunch(_) => Request::ReturnToLaunch,
        Deed::Land(_) => Request::Land,
        Deed::AbortLanding(how) => Request::AbortLanding { alt_rel_home_m: how.alt_rel_home_m },
        Deed::PrepareFlight(_) => Request::PrepareFlight,
        Deed::MissionStart(0) => Request::MissionStart { from: None },
        Deed::MissionStart(number) => Request::MissionStart { from: Some(seq(number - 1)?) },
        Deed::MissionPause(_) => Request::MissionPause,
        Deed::MissionResume(_) => Request::MissionResume,
        Deed::CurrentItem(number) => Request::SetCurrentItem(seq(*number)?),
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

/// The command that stands for a request where nobody knows what became of it.
#[must_use]
pub fn command_of(request: &Request) -> CommandName {
    CommandName(match request {
        Request::DespiteMixedPlan(request) => return command_of(request),
        Request::Arm { .. } | Request::Disarm { .. } => cmd::COMPONENT_ARM_DISARM,
        Request::Reposition { .. } => cmd::DO_REPOSITION,
        Request::ChangeSpeed { .. } => cmd::DO_CHANGE_SPEED,
        Request::ChangeAltitude { .. } => cmd::DO_CHANGE_ALTITUDE,
        Request::Land => cmd::DO_LAND_START,
        Request::AbortLanding { .. } => cmd::DO_GO_AROUND,
        Request::SetCurrentItem(_) => cmd::DO_SET_MISSION_CURRENT,
        _ => cmd::DO_SET_MODE,
    })
}

/// What an answer says of a result on board.
#[must_use]
pub fn answer_of(claim: &Claim, result: &RequestResult) -> Answer {
    let error = match result {
        Ok(_) => return answer(claim, End::Done, ""),
        Err(error) => error,
    };
    let why = error.to_string();
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
        StationError::Control { holder } => Answer { holder: holder.clone(), ..answer(claim, End::Held, "") },
        _ => answer(claim, End::Refused, &why),
    }
}

/// The result that an answer tells to whoever asked for `request` of the vehicle with this name and address here.
///
/// # Errors
/// What the answer says.
pub fn result_of(answer: &Answer, request: &Request, name: &str, target: Address, family: ModeFamily) -> RequestResult {
    let refused = |why: String| Err(StationError::RemoteRefused { name: name.to_owned(), why });
    let command = u16::try_from(answer.command).ok().filter(|number| *number != 0).map(CommandName);
    match answer.end() {
        End::Done | End::Granted => Ok(Reply::Done),
        End::Held | End::Asked if !answer.holder.is_empty() => {
            Err(StationError::Control { holder: answer.holder.clone() })
        }
        End::CommandRefused => {
            let cure = answer.cure.checked_sub(1).and_then(|number| u32::try_from(number).ok());
            Err(StationError::Vehicle(VehicleError::CommandRefused {
                target,
                command: command.unwrap_or_else(|| command_of(request)),
                result: CommandResult(u8::try_from(answer.result).unwrap_or(u8::MAX)),
                reasons: answer.reasons.clone(),
                cure: cure.map(|custom_mode| FlightMode { family, custom_mode }),
            }))
        }
        End::Unknown => Err(unknown(command.unwrap_or_else(|| command_of(request)), target, 1)),
        End::Stale | End::Refused | End::Held | End::Asked | End::Unspecified => refused(answer.why.clone()),
    }
}

/// Nobody knows whether it was done.
#[must_use]
pub fn unknown(command: CommandName, target: Address, attempts: u32) -> StationError {
    StationError::Vehicle(VehicleError::CommandTimeout { target, command, attempts })
}

#[cfg(test)]
mod tests {
    use vencejo_proto::MonoTime;

    use super::*;
    use crate::authority::Wish;

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
        };
        let requests = [
            Request::Arm { force: true },
            Request::Disarm { force: false },
            Request::SetMode(ModeChoice::Name("FBWA".into())),
            Request::SetMode(ModeChoice::Custom(0)),
            Request::Takeoff { alt_rel_home_m: 50.0 },
            reposition(AltFrame::RelHome, Turn::CounterClockwise, Some(60.0)),
            reposition(AltFrame::Terrain, Turn::Clockwise, None),
            Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 14.2 },
            Request::ChangeSpeed { kind: SpeedKind::Groundspeed, speed_m_s: 14.2 },
            Request::ChangeAltitude { alt_m: 100.0, alt_frame: AltFrame::Amsl },
            Request::LoiterHere,
            Request::ReturnToLaunch,
            Request::Land,
            Request::AbortLanding { alt_rel_home_m: None },
            Request::AbortLanding { alt_rel_home_m: Some(40.0) },
            Request::PrepareFlight,
            Request::MissionStart { from: None },
            Request::MissionStart { from: Some(MissionSeq(0)) },
            Request::MissionPause,
            Request::MissionResume,
            Request::SetCurrentItem(MissionSeq(65_535)),
            Request::DespiteMixedPlan(Box::new(Request::Arm { force: false })),
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
    fn what_does_not_go_over_a_network_is_not_made_something_else() {
        for request in [
            Request::Reboot,
            Request::ParamList,
            Request::Velocity { forward_m_s: 1.0, right_m_s: 0.0, down_m_s: 0.0, yaw_rate_rad_s: 0.0 },
        ] {
            assert_eq!(act_of(&request, None), None, "{request:?}");
        }
        assert_eq!(request_of(&Act::default()), Err(BadPayload::Field("deed")));
        let odd = |deed| request_of(&Act { deed: Some(deed), ..Act::default() });
        assert_eq!(odd(Deed::CurrentItem(65_536)), Err(BadPayload::Field("item")));
        assert_eq!(odd(Deed::Altitude(Altitude { alt_m: 1.0, frame: 1 })), Err(BadPayload::Field("frame")));
        let danger = Act { confirmed: "fun".into(), ..act_of(&Request::Land, None).expect("goes") };
        assert_eq!(request_of(&danger), Err(BadPayload::Field("confirmed")));
    }

    #[test]
    fn what_the_vehicle_said_is_what_is_told_far_away() {
        let target = Address::new(250, 1);
        let claim = Claim { boot: 1, epoch: 1, id: 5, based_on: MonoTime::ZERO, wish: Wish::Act };
        let arm = Request::Arm { force: false };
        let told = |result: &RequestResult| {
            result_of(&answer_of(&claim, result), &arm, "plane7", target, ModeFamily::ArduPlane)
        };
        assert_eq!(told(&Ok(Reply::Done)), Ok(Reply::Done));
        let refused = VehicleError::CommandRefused {
            target,
            command: CommandName(cmd::COMPONENT_ARM_DISARM),
            result: CommandResult(4),
            reasons: vec!["PreArm: no GPS".into()],
            cure: Some(FlightMode { family: ModeFamily::ArduPlane, custom_mode: 0 }),
        };
        assert_eq!(told(&Err(refused.clone().into())), Err(refused.into()));
        let silent = unknown(CommandName(cmd::COMPONENT_ARM_DISARM), target, 1);
        assert_eq!(told(&Err(silent.clone())), Err(silent.clone()));
        assert_eq!(told(&Err(VehicleError::Rebooted.into())), Err(silent), "it may or may not have been done");
        let other = told(&Err(VehicleError::HomeUnknown.into())).expect_err("refused");
        assert!(
            matches!(other, StationError::RemoteRefused { why, .. } if why.contains("home")),
            "what the other said"
        );
    }
}
