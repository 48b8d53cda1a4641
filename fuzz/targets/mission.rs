//! A vehicle that sends anything at any time during transfers of plans and parameters: nothing overflows, nothing waits
//! forever, and nothing is sent without end.
#![no_main]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use vencejo_flight::plan::{MissionItem, PlanKind};
use vencejo_proto::{Address, MavVersion, Message, MonoTime};
use vencejo_vehicle::{Request, VehicleConfig, Vehicles};

mod quick;
use quick::quick;

/// Messages of a vehicle about plans, parameters, files and itself.
const IDS: [u32; 24] =
    [0, 1, 22, 24, 30, 33, 39, 40, 42, 43, 44, 45, 46, 47, 51, 66, 73, 74, 76, 77, 110, 148, 242, 253];
const OUTPUTS: usize = 4096;

fuzz_target!(|data: &[u8]| quick(|| {
    let us = Address::new(255, 190);
    let plane = Address::new(1, 1);
    let mut now = MonoTime::ZERO;
    let mut vehicles = Vehicles::new(us, VehicleConfig::default());
    let mut heartbeat = [0_u8; 9];
    (heartbeat[4], heartbeat[5], heartbeat[6], heartbeat[8]) = (1, 3, 81, 3);
    let heartbeat = Message::from_payload(MavVersion::V2, 0, &heartbeat).expect("a heartbeat");
    vehicles.on_message(plane, &heartbeat, now);
    let mut rest = data;
    while let Some((&[act, value], tail)) = rest.split_first_chunk::<2>() {
        rest = tail;
        match act % 8 {
            0 => now += Duration::from_millis(u64::from(value) * 40),
            1 => {
                let kind = PlanKind::ALL[usize::from(value) % 3];
                let request = match value / 3 % 6 {
                    0 => Request::DownloadPlan { kind },
                    1 => Request::ClearPlan { kind },
                    2 => Request::ParamList,
                    3 => Request::ParamRead { name: "WP_RADIUS".into() },
                    4 => Request::ParamSet { name: "WP_RADIUS".into(), value: 90.0 },
                    _ => Request::UploadPlan {
                        kind: PlanKind::Mission,
                        items: vec![MissionItem::waypoint(40.0, -3.0, 100.0); 3],
                        home: None,
                        despite_findings: false,
                    },
                };
                if let Some(vehicle) = vehicles.get_mut(plane.system) {
                    vehicle.request(request, now);
                }
            }
            act => {
                let id = IDS[usize::from(value) % IDS.len()];
                let length = tail.first().map_or(0, |length| usize::from(*length)).min(tail.len().saturating_sub(1));
                let payload = tail.get(1..1 + length).unwrap_or_default();
                rest = tail.get(1 + length..).unwrap_or_default();
                let source = if act == 7 { Address::new(value, 190) } else { plane };
                if let Ok(message) = Message::from_payload(MavVersion::V2, id, payload) {
                    vehicles.on_message(source, &message, now);
                }
            }
        }
        vehicles.on_time(now);
        let sent = std::iter::from_fn(|| vehicles.poll_output()).take(OUTPUTS).count();
        assert!(sent < OUTPUTS, "it sends without end");
    }
    // Every transfer ends by itself.
    for _ in 0..20_000 {
        let Some(deadline) = vehicles.deadline() else { break };
        if vehicles.get(plane.system).is_none_or(|vehicle| vehicle.pending() == 0) {
            break;
        }
        now = now.max(deadline);
        vehicles.on_time(now);
        while vehicles.poll_output().is_some() {}
    }
    assert!(vehicles.get(plane.system).is_none_or(|vehicle| vehicle.pending() == 0), "a request never ends");
}));
