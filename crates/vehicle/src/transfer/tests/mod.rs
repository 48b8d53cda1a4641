//! Tests of whole transfers: against recordings of a real ArduPlane, and against its imitation over a bad link.

mod floats;
mod hostile;
mod lossy;
mod misbehaving;
mod slower;
mod speed;
mod transcripts;

use std::time::Duration;

use vencejo_flight::plan::{MissionItem, PlanKind};
use vencejo_proto::{MissionItemInt, MissionSeq};

use super::testing::{PLANE, STATION};
use super::{FtpSessions, TransferConfig};

/// A transfer that fails does so by then, however it goes wrong on the way.
const LIMIT: Duration = Duration::from_secs(600);

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// An ArduPilot with MAVFTP, whose round trip is known as TIMESYNC would have measured it.
fn by_ftp(round_trip: Duration, seed: u32) -> TransferConfig {
    TransferConfig {
        round_trip: Some(round_trip),
        ftp_sessions: FtpSessions::new(seed),
        ..TransferConfig::ardupilot(PLANE, STATION)
    }
}

/// An ArduPilot without MAVFTP.
fn by_items(round_trip: Duration) -> TransferConfig {
    TransferConfig { has_ftp: false, ..by_ftp(round_trip, 0) }
}

/// A mission of `count` items, home included, in which no two items are alike and every kind of field is used.
fn mission(count: u16) -> Vec<MissionItemInt> {
    let item = |seq: u16| {
        let (lat, lon) = (40.33 + f64::from(seq) * 1e-4, -3.79 - f64::from(seq % 37) * 3e-4);
        match seq % 9 {
            4 => MissionItem::loiter_turns(lat, lon, 80.0, 2.0, 70.0),
            6 => MissionItem::change_airspeed(14.0),
            8 => MissionItem::loiter_to_alt(lat, lon, 120.0, -60.0),
            _ => MissionItem::waypoint(lat, lon, 50.0 + f64::from(seq % 100)),
        }
    };
    (0..count).map(|seq| item(seq).to_wire(MissionSeq(seq), PLANE, PlanKind::Mission, false)).collect()
}

/// Whether the plane has the mission that was sent, home aside: compared by what ArduPilot stores.
fn has(stored: &[MissionItemInt], sent: &[MissionItemInt]) -> bool {
    let parse = |items: &[MissionItemInt]| -> Vec<_> {
        items.iter().map(|item| MissionItem::from_wire(item).expect("an item")).collect()
    };
    vencejo_flight::plan::plans_equal_as_stored(
        &parse(sent),
        &parse(stored),
        PlanKind::Mission,
        vencejo_flight::plan::Keeping::ARDUPILOT,
    )
    .is_ok()
}
