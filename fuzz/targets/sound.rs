//! Invariants of every rehearsal.

use vencejo_flight::rehearsal::Rehearsal;

/// At most six hours, and finite values throughout.
pub fn check(flown: &Rehearsal) {
    assert!(!flown.track.is_empty(), "{:?} without a track", flown.ending);
    let mut before_s = f64::NEG_INFINITY;
    for sample in &flown.track {
        let numbers = [
            sample.time_s,
            sample.height_m,
            sample.height_asked_m,
            sample.ground_m.unwrap_or(0.0),
            sample.airspeed_m_s,
            sample.groundspeed_m_s,
            sample.course_deg,
            sample.heading_deg,
            sample.climb_m_s,
            sample.bank_deg,
            sample.pitch_deg,
            sample.throttle,
        ];
        assert!(numbers.iter().all(|number| number.is_finite()), "{sample:?}");
        assert!(sample.time_s > before_s, "{before_s} {sample:?}");
        before_s = sample.time_s;
    }
    for passage in &flown.passages {
        let numbers = [Some(passage.begins_s), passage.reached_s, passage.nearest_m, passage.height_error_m];
        assert!(numbers.iter().flatten().all(|number| number.is_finite()), "{passage:?}");
    }
    for order in &flown.camera {
        assert!(order.time_s.is_finite() && order.every_m.is_none_or(f64::is_finite), "{order:?}");
    }
    assert!(flown.duration_s.is_finite() && flown.distance_m.is_finite());
    assert!(flown.energy_wh.is_none_or(f64::is_finite), "{:?}", flown.energy_wh);
    if let Ok(battery) = flown.battery {
        assert!(battery.left_wh.is_finite() && battery.capacity_wh.is_finite(), "{battery:?}");
    }
    assert!(flown.duration_s <= 6.0 * 3_600.0 + 1.0);
}
