//! Replays.

use vencejo_station::Replay;
use vencejo_vehicle::VehicleId;

use crate::dto;

/// A replay and its state.
pub(crate) fn replay(replay: &Replay) -> dto::replay::Replay {
    let (status, info) = (replay.status(), replay.info());
    let unix_s = |unix_us: u64| unix_us as f64 / 1e6;
    dto::replay::Replay {
        id: replay.id(),
        name: replay.name().to_owned(),
        file: replay.path().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        vehicles: replay.vehicles().map(VehicleId::number).collect(),
        start_unix_s: info.start_unix_us.map(unix_s),
        unix_s: status.unix_us.map(unix_s),
        position_s: status.position.as_secs_f64(),
        duration_s: info.duration.as_secs_f64(),
        speed: status.speed,
        is_paused: status.is_paused,
        is_over: status.is_over,
        seeks: status.seeks,
        fault: status.fault,
        skipped_bytes: info.skipped_bytes,
    }
}
