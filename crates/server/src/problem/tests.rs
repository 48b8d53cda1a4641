//! The mapping of errors: every kind has an explicit row with everything that a client needs.

use std::collections::BTreeMap;

use vencejo_flight::plan::{Command, PlanKind};
use vencejo_link::{LinkError, LinkId};
use vencejo_maps::MapError;
use vencejo_proto::Address;
use vencejo_station::SigningError;
use vencejo_vehicle::VehicleError;
use vencejo_vehicle::command::CommandResult;
use vencejo_vehicle::transfer::TransferError;

use super::from_core::{from_transfer, from_vehicle};
use super::*;

/// Name of the kind and its problem, for every error of the core.
fn all() -> BTreeMap<String, dto::Problem> {
    let kind = |debug: String| debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned();
    let station = StationError::examples().into_iter();
    let station = station.filter(|error| !matches!(error, StationError::Vehicle(_) | StationError::Signing(_)));
    let station = station.map(|error| (format!("Station.{}", kind(format!("{error:?}"))), from_station(&error)));
    let signing = SigningError::examples().into_iter();
    let signing = signing
        .map(|error| (format!("Signing.{}", kind(format!("{error:?}"))), from_station(&StationError::Signing(error))));
    let vehicle = VehicleError::examples().into_iter();
    let vehicle = vehicle.map(|error| (format!("Vehicle.{}", kind(format!("{error:?}"))), from_vehicle(&error)));
    let transfer = TransferError::examples().into_iter();
    let transfer = transfer.map(|error| (format!("Transfer.{}", kind(format!("{error:?}"))), from_transfer(&error)));
    let maps = MapError::examples().into_iter();
    let maps = maps.map(|error| (format!("Maps.{}", kind(format!("{error:?}"))), from_maps(&error)));
    station
        .chain(signing)
        .chain(vehicle)
        .chain(transfer)
        .chain(maps)
        .map(|(name, problem)| (name, *problem.0))
        .collect()
}

#[test]
fn every_kind_of_error_has_a_row() {
    let problems = all();
    assert!(problems.len() >= 69, "{}", problems.len());
    for (name, problem) in &problems {
        assert_ne!(problem.r#type, "urn:vencejo:internal", "{name} is not in the table");
        assert!(problem.r#type.starts_with("urn:vencejo:") && !problem.title.is_empty(), "{name}");
        assert!(!problem.detail.is_empty(), "{name}");
        assert!((400..600).contains(&problem.status), "{name}");
    }
}

#[test]
fn a_source_that_fails_is_told_as_its_tiles_are() {
    let mut told = 0;
    for error in MapError::examples() {
        let Some(cause) = vencejo_maps::SourceCause::of(&error) else { continue };
        let of_tile = serde_json::to_value(&from_maps(&error).0.cause).expect("JSON");
        assert_eq!(serde_json::to_value(&cause).expect("JSON"), of_tile);
        told += 1;
    }
    assert_eq!(told, 6);
}

#[test]
fn each_kind_has_a_code_of_its_own_and_what_a_sentence_needs() {
    let problems = all();
    let mut kinds: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, problem) in &problems {
        let cause = serde_json::to_value(&problem.cause).expect("JSON");
        let code = cause["code"].as_str().expect("a code");
        assert_eq!(problem.r#type, format!("urn:vencejo:{code}"), "{name}");
        assert!(code.chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{code}");
        kinds.entry(problem.r#type.as_str()).or_default().push(name);
    }
    let shared: Vec<_> = kinds.values().filter(|names| names.len() > 1).map(|names| names.join(" ")).collect();
    // People get the same text, wherever the error comes from.
    assert_eq!(
        shared,
        [
            "Transfer.Cancelled Vehicle.Cancelled Vehicle.Transfer",
            "Maps.Closed Station.Closed",
            "Maps.Request Transfer.BadList",
            "Transfer.Item Vehicle.Plan",
            "Signing.BadName Signing.KeyInUse Signing.NameTaken Signing.NoSuchKey",
            "Station.Link Station.TooManyReplays Station.TooManyVehicles Vehicle.TooManyRequests",
            "Transfer.IntegerItemsIgnored Vehicle.TooOld",
            "Transfer.FtpAbsent Transfer.Timeout",
            "Transfer.BadFile Transfer.Ftp",
        ]
    );
    let of = |name: &str| serde_json::to_value(&problems[name].cause).expect("JSON");
    assert_eq!(
        of("Vehicle.CommandRefused"),
        serde_json::json!({"code": "command-refused", "command": "COMPONENT_ARM_DISARM", "result": "FAILED", "cure_mode": null})
    );
    assert_eq!(
        of("Transfer.Refused"),
        serde_json::json!({"code": "plan-refused", "plan": "mission", "result": "DENIED", "item": 3})
    );
    assert_eq!(
        of("Vehicle.PlanUnknown"),
        serde_json::json!({"code": "plan-unknown", "plan": "mission", "reason": "transfer_failed"})
    );
}

#[test]
fn statuses_are_those_of_the_contract() {
    let problems = all();
    for (name, status) in [
        ("Station.Address", 422),
        ("Station.Closed", 503),
        ("Station.NoVehicle", 404),
        ("Station.Control", 423),
        ("Station.NeedsConfirmation", 428),
        ("Station.BadConfirmation", 412),
        ("Vehicle.CommandRefused", 409),
        ("Vehicle.CommandTimeout", 504),
        ("Vehicle.NotConfirmed", 504),
        ("Vehicle.CommandBusy", 409),
        ("Vehicle.TransferBusy", 409),
        ("Vehicle.TooManyRequests", 429),
        ("Vehicle.UnknownMode", 422),
        ("Vehicle.InvalidValue", 422),
        ("Vehicle.Plan", 422),
        ("Vehicle.PlanUnknown", 409),
        ("Vehicle.OutOfReach", 409),
        ("Vehicle.Armed", 409),
        ("Vehicle.InTheAir", 409),
        ("Vehicle.NotFlying", 409),
        ("Vehicle.Landing", 409),
        ("Vehicle.NotHeard", 504),
        ("Transfer.Timeout", 504),
        ("Transfer.Refused", 409),
        ("Transfer.NotAsSent", 409),
        ("Transfer.UnknownParam", 404),
        ("Transfer.ParamNotKept", 409),
        ("Transfer.BadFile", 502),
        ("Maps.NoTile", 404),
        ("Maps.Settings", 422),
        ("Maps.Service", 502),
        ("Maps.LocalAddress", 502),
        ("Maps.Timeout", 504),
        ("Maps.Offline", 503),
        ("Maps.OfflineRefused", 409),
    ] {
        assert_eq!(problems[name].status, status, "{name}");
    }
    let unknown = from_station(&StationError::Link(LinkError::UnknownLink(LinkId(7))));
    assert_eq!(unknown.0.status, 404);
}

fn refused(reasons: &[&str]) -> dto::Problem {
    refused_command(400, reasons)
}

fn refused_command(command: u16, reasons: &[&str]) -> dto::Problem {
    let error = VehicleError::CommandRefused {
        target: Address::new(1, 1).into(),
        command: Command(command),
        result: CommandResult(4),
        reasons: reasons.iter().map(|reason| (*reason).to_owned()).collect(),
        cure: None,
    };
    *from_vehicle(&error).0
}

#[test]
fn a_refusal_lists_the_reasons_and_the_remedy_where_one_is_known() {
    let problem = refused(&["PreArm: DO_LAND_START set and RTL_AUTOLAND disabled"]);
    assert_eq!(problem.reasons, ["PreArm: DO_LAND_START set and RTL_AUTOLAND disabled"]);
    assert!(problem.remedy.expect("known").contains("RTL_AUTOLAND"));
    assert!(refused(&["Arm: RTL mode not armable"]).remedy.expect("known").contains("mode"));
    let both = refused(&["PreArm: GPS 1: Bad fix", "Arm: RTL mode not armable", "PreArm: GPS 1: Bad fix"]).remedy;
    let both = both.expect("known");
    assert!(both.matches("GPS").count() == 1 && both.contains("mode"), "each once: {both}");
    let new = refused(&["PreArm: something new", "PreArm: In landing sequence"]);
    let codes = serde_json::to_value(&new).expect("JSON")["refusals"].clone();
    assert_eq!(codes, serde_json::json!([null, "landing-sequence"]));
    assert_eq!(refused(&["PreArm: something new"]).remedy, None);
    assert_eq!((refused(&[]).reasons, refused(&[]).remedy), (vec![], None));
    // An ArduPlane does not report why it refuses to enable its fence.
    assert!(refused_command(207, &[]).remedy.expect("known").contains("send a fence"));
}

#[test]
fn a_plan_that_differs_everywhere_makes_no_endless_answer() {
    let differences =
        match TransferError::examples().into_iter().find(|error| matches!(error, TransferError::NotAsSent { .. })) {
            Some(TransferError::NotAsSent { differences, .. }) => differences,
            other => panic!("{other:?}"),
        };
    let differences = differences.into_iter().cycle().take(1000).collect();
    let problem = from_transfer(&TransferError::NotAsSent { kind: PlanKind::Mission, differences });
    assert_eq!(problem.0.reasons.len(), MAX_REASONS);
}

#[test]
fn it_is_served_as_problem_json() {
    let response = Problem::no_control(Some("Ana")).into_response();
    assert_eq!(response.status(), StatusCode::LOCKED);
    assert_eq!(response.headers()[header::CONTENT_TYPE], "application/problem+json");
}
