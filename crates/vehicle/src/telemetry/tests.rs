//! Telemetry against what a real ArduPlane sent (tests/fixtures/captures), and against what none should send.

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_proto::dialect::*;
use vencejo_proto::{Address, Frame, FrameDecoder, Header, Heartbeat, MavVersion, Message, MonoTime};

use super::MissionState;
use super::*;
use crate::modes::ModeFamily;
use crate::transfer::testing::{PLANE, recorded};

fn apply(message: MavMessage) -> Telemetry {
    apply_to(Telemetry::new(), message)
}

fn apply_to(mut telemetry: Telemetry, message: MavMessage) -> Telemetry {
    telemetry.apply(&Message::Dialect(message), MonoTime::from_millis(7)).expect("has a group");
    telemetry
}

fn arduplane() -> Telemetry {
    let mut telemetry = Telemetry::new();
    let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, custom_mode: 10, base_mode: 217, ..Heartbeat::default() };
    telemetry.apply(&Message::Heartbeat(heartbeat), MonoTime::ZERO);
    telemetry
}

fn near(value: Option<f64>, expected: f64) {
    let value = value.expect("known");
    assert!((value - expected).abs() < 1e-6 * expected.abs().max(1.0), "{value} instead of {expected}");
}

#[test]
fn every_stream_of_a_real_plane_is_read_and_valid() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/captures/arduplane-50hz-20s.mavlink");
    let bytes = std::fs::read(path).expect("fixture");
    let mut decoder = FrameDecoder::new();
    let mut telemetry = Telemetry::new();
    for chunk in bytes.chunks(700) {
        decoder.push(chunk);
        while let Some(frame) = decoder.next_frame() {
            if let Ok(message) = frame.decode() {
                telemetry.apply(&message, MonoTime::ZERO);
            }
        }
    }
    assert!(telemetry.messages > 10_000, "{}", telemetry.messages);
    assert_eq!(telemetry.invalid_values, 0, "{telemetry:#?}");
    let t = telemetry;
    assert!(t.heartbeat.is_some() && t.attitude.is_some() && t.position.is_some() && t.hud.is_some());
    assert!(t.gps.is_some() && t.sys_status.is_some() && t.raw_imu.is_some() && t.pressure.is_some());
    assert!(t.wind.is_some() && t.mission.is_some() && t.ekf.is_some() && t.vibration.is_some());
    assert!(t.airspeed.is_some() && t.servos.is_some() && t.rc.is_some() && t.system_time.is_some());
    assert!(t.batteries[0].is_some() && t.imus.iter().all(Option::is_some));
    let position = t.position.expect("position").value;
    assert!((position.lat_deg.expect("lat") - 40.3332).abs() < 0.001);
    assert!((position.lon_deg.expect("lon") + 3.7978).abs() < 0.001);
    assert!((position.alt_amsl_m.expect("alt") - 600.0).abs() < 2.0);
    let gps = t.gps.expect("gps").value;
    assert!(gps.fix.is_3d(), "{}", gps.fix);
    let gravity = t.imus[0].expect("imu").value.acc_g.expect("acc");
    assert!((gravity[2] + 1.0).abs() < 0.05, "at rest the specific force points up: {gravity:?}");
}

/// Figures: the last messages of the recording as pymavlink 2.4.50 reads them.
#[test]
fn values_are_those_that_an_independent_reader_finds() {
    let mut telemetry = Telemetry::new();
    for (at, message) in recorded("arduplane-takeoff-to-landing", PLANE) {
        telemetry.apply(&message, at);
    }
    assert_eq!(telemetry.invalid_values, 0);
    let gps = telemetry.gps.expect("gps").value;
    assert_eq!((gps.fix.name(), gps.satellites), ("RTK fixed", Some(10)));
    near(gps.lat_deg, 40.333_201_5);
    near(gps.lon_deg, -3.797_032_6);
    near(gps.alt_amsl_m, 600.1);
    near(gps.alt_ellipsoid_m, 600.1);
    near(gps.hdop, 1.21);
    near(gps.course_deg, 269.85);
    near(gps.horizontal_accuracy_m, 0.3);
    let status = telemetry.sys_status.expect("status").value;
    near(status.voltage_v, 12.6);
    near(status.current_a, 0.0);
    near(status.battery_remaining_pct, 75.0);
    assert_eq!(status.is_ready_to_arm, Some(false));
    assert_eq!(status.unhealthy_sensors.names().collect::<Vec<_>>(), ["terrain", "pre-arm check"]);
    let battery = telemetry.batteries[0].expect("battery").value;
    near(battery.voltage_v, 12.6);
    near(battery.consumed_mah, 796.0);
    near(battery.consumed_j, 34_900.0);
    assert_eq!((battery.temperature_c, battery.time_remaining_s), (None, None));
    assert!(battery.cells_v.iter().all(Option::is_none), "only the pack is measured");
    let imu = telemetry.imus[0].expect("imu").value;
    assert_eq!(imu.acc_g, Some([0.0, 0.0, -1.001]));
    near(imu.temperature_c, 37.71);
    let wind = telemetry.wind.expect("wind").value;
    near(wind.from_deg, 97.025_482);
    near(wind.speed_m_s, 0.327_476);
    let home = telemetry.home.expect("home").value;
    assert_eq!((home.lat_deg, home.lon_deg, home.alt_amsl_m), (40.333_201_7, -3.797_032_3, 600.1));
    let nav = telemetry.nav.expect("nav").value;
    near(nav.airspeed_error_m_s, 15.394_397);
    near(nav.wp_distance_m, 5.0);
    near(telemetry.pressure.expect("pressure").value.absolute_pa, 94_323.144_5);
    let mission = telemetry.mission.expect("mission").value;
    assert_eq!((mission.seq, mission.total, mission.state), (11, Some(11), Some(MissionState::Active)));
    assert_eq!(telemetry.item_reached.expect("reached").value, 10);
    assert_eq!(
        (telemetry.mode().map(|mode| mode.to_string()), telemetry.is_armed()),
        (Some("AUTO".into()), Some(false))
    );
}

#[test]
fn unknown_is_none_and_not_invalid() {
    let t = apply(MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        hdg: u16::MAX,
        ..GLOBAL_POSITION_INT_DATA::default()
    }));
    let position = t.position.expect("position");
    assert_eq!((position.value.lat_deg, position.value.lon_deg, position.value.heading_deg), (None, None, None));
    assert!(!position.invalid);

    let t = apply(MavMessage::SYS_STATUS(SYS_STATUS_DATA {
        voltage_battery: 0,
        current_battery: -1,
        battery_remaining: -1,
        ..SYS_STATUS_DATA::default()
    }));
    let status = t.sys_status.expect("status").value;
    assert_eq!((status.voltage_v, status.current_a, status.battery_remaining_pct), (None, None, None));
    assert_eq!(status.is_ready_to_arm, None);

    let t = apply(MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
        fix_type: GpsFixType::GPS_FIX_TYPE_NO_FIX,
        lat: 403_332_000,
        lon: -37_978_000,
        eph: u16::MAX,
        epv: u16::MAX,
        vel: u16::MAX,
        cog: u16::MAX,
        satellites_visible: 255,
        ..GPS_RAW_INT_DATA::default()
    }));
    let gps = t.gps.expect("gps").value;
    assert_eq!((gps.lat_deg, gps.alt_amsl_m, gps.hdop, gps.vdop), (None, None, None, None));
    assert_eq!((gps.groundspeed_m_s, gps.course_deg, gps.satellites), (None, None, None));

    let t = apply(MavMessage::RADIO_STATUS(RADIO_STATUS_DATA {
        rssi: 255,
        remrssi: 200,
        noise: 255,
        remnoise: 40,
        txbuf: 100,
        ..RADIO_STATUS_DATA::default()
    }));
    let radio = t.radio.expect("radio").value;
    assert_eq!((radio.rssi, radio.remote_rssi, radio.noise, radio.remote_noise), (None, Some(200), None, Some(40)));
    assert_eq!(radio.tx_buffer_pct, Some(100));

    let t = apply(MavMessage::RC_CHANNELS(RC_CHANNELS_DATA {
        chancount: 255,
        chan1_raw: 1_500,
        chan2_raw: u16::MAX,
        rssi: 255,
        ..RC_CHANNELS_DATA::default()
    }));
    let rc = t.rc.expect("rc").value;
    assert_eq!((rc.count, rc.pulse_us[0], rc.pulse_us[1], rc.rssi), (18, Some(1_500), None, None));

    let t = apply(MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA { seq: 3, ..MISSION_CURRENT_DATA::default() }));
    let mission = t.mission.expect("mission").value;
    assert_eq!((mission.total, mission.state, mission.in_mission_mode), (None, None, None), "an old vehicle");
    let unknown = vencejo_proto::dialect::MissionState::MISSION_STATE_UNKNOWN;
    let none = vencejo_proto::dialect::MissionState::MISSION_STATE_NO_MISSION;
    // PX4, PX4 1.14, ArduPilot.
    for (total, mission_state) in [(u16::MAX, none), (u16::MAX, unknown), (0, none)] {
        let data = MISSION_CURRENT_DATA { total, mission_state, ..MISSION_CURRENT_DATA::default() };
        let t = apply(MavMessage::MISSION_CURRENT(data));
        assert_eq!(t.mission.expect("mission").value.total, Some(0), "{total}, {mission_state:?}: no mission on board");
    }

    let t = apply(MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec: 0, time_boot_ms: 9 }));
    assert_eq!(t.system_time.expect("time").utc_offset_us(), None);
    let t = apply(MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec: 1_800_000_000_000_000, time_boot_ms: 9 }));
    assert_eq!(t.system_time.expect("time").utc_offset_us(), Some(1_800_000_000_000_000 - 7_000));
}

// fault 24: no value, flagged, counted
#[test]
fn what_cannot_be_is_none_counted_and_flagged() {
    let check = |t: Telemetry, invalid: bool, count: u64| {
        assert!(invalid, "flagged");
        assert_eq!(t.invalid_values, count, "{t:#?}");
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let t =
            apply(MavMessage::ATTITUDE(ATTITUDE_DATA { roll: bad, pitch: 0.1, yaw: bad, ..ATTITUDE_DATA::default() }));
        let attitude = t.attitude.expect("attitude");
        assert_eq!((attitude.value.roll_rad, attitude.value.yaw_rad), (None, None));
        assert!(attitude.value.pitch_rad.is_some(), "the others stay");
        check(t, attitude.invalid, 2);
        let t = apply(MavMessage::VFR_HUD(VFR_HUD_DATA {
            airspeed: bad,
            climb: bad,
            throttle: 101,
            ..VFR_HUD_DATA::default()
        }));
        check(t, t.hud.expect("hud").invalid, 3);
        let t = apply(MavMessage::WIND(WIND_DATA { direction: bad, speed: bad, speed_z: bad }));
        check(t, t.wind.expect("wind").invalid, 3);
    }
    let far =
        GLOBAL_POSITION_INT_DATA { lat: 910_000_000, lon: 10, vx: i16::MIN, ..GLOBAL_POSITION_INT_DATA::default() };
    let t = apply(MavMessage::GLOBAL_POSITION_INT(far));
    let position = t.position.expect("position");
    assert_eq!((position.value.lat_deg, position.value.lon_deg), (None, None), "half a position is none");
    check(t, position.invalid, 2);
    let t = apply(MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
        lat: i32::MIN,
        lon: i32::MIN,
        alt: i32::MIN,
        hdg: 36_001,
        ..GLOBAL_POSITION_INT_DATA::default()
    }));
    check(t, t.position.expect("position").invalid, 4);
    let t = apply_to(arduplane(), MavMessage::RAW_IMU(RAW_IMU_DATA { xacc: i16::MIN, ..RAW_IMU_DATA::default() }));
    assert_eq!(t.imus[0].expect("imu").value.acc_g, None);
    let t = apply(MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA { id: 200, ..BATTERY_STATUS_DATA::default() }));
    assert_eq!((t.batteries, t.invalid_values), ([None; MAX_BATTERIES], 1));
    // A home that cannot be does not replace one that can.
    let good =
        HOME_POSITION_DATA { latitude: 403_332_000, longitude: -37_978_000, altitude: 600_000, ..Default::default() };
    let t = apply(MavMessage::HOME_POSITION(good));
    let t = apply_to(t, MavMessage::HOME_POSITION(HOME_POSITION_DATA { latitude: 910_000_000, ..Default::default() }));
    assert_eq!(t.home.expect("home").value.alt_amsl_m, 600.0);
}

// fault 24 (1 seeds): more than 4,000 random payloads of 29 messages: no value that is not a number
/// Whatever bytes a message holds, nothing but finite numbers comes out.
#[test]
fn no_payload_makes_a_value_that_is_no_number() {
    let ids = [
        1, 2, 24, 26, 27, 29, 30, 33, 36, 42, 46, 62, 65, 74, 109, 116, 129, 147, 148, 162, 166, 168, 193, 225, 231,
        241, 242, 245, 295,
    ];
    // CRC_EXTRA is one byte: the right one is the one that the decoder takes.
    let extras = ids.map(|id| (0..=255).find(|extra| frame(id, &[1; 255], *extra).is_some()).expect("known message"));
    let mut rng = SmallRng::seed_from_u64(1);
    let mut read = 0;
    let mut telemetry = arduplane();
    for _ in 0..400 {
        for (id, extra) in ids.into_iter().zip(extras) {
            let mut payload = [0u8; 255];
            rng.fill(&mut payload[..]);
            if rng.random_bool(0.3) {
                // All ones: NaN, −1 and the largest numbers.
                payload.fill(0xff);
            }
            let frame = frame(id, &payload, extra).expect("a valid frame");
            // Numbers that are no member of an enum do not decode.
            let Ok(message) = frame.decode() else { continue };
            read += 1;
            telemetry.apply(&message, MonoTime::ZERO);
        }
        let text = format!("{telemetry:?}");
        assert!(!text.contains("NaN") && !text.contains("inf,") && !text.contains("inf)"), "{text}");
    }
    assert!(read > 4_000, "{read}");
    assert!(telemetry.invalid_values > 1_000);
}

/// CRC-16/MCRF4XX, as mavlink.io, "Packet Serialization", has it.
fn crc(bytes: impl IntoIterator<Item = u8>) -> u16 {
    bytes.into_iter().fold(0xffff, |crc, byte| {
        let mut low = byte ^ (crc as u8);
        low ^= low << 4;
        (crc >> 8) ^ (u16::from(low) << 8) ^ (u16::from(low) << 3) ^ (u16::from(low) >> 4)
    })
}

/// A frame with any payload; `extra` is the message's CRC_EXTRA.
fn frame(id: u32, payload: &[u8; 255], extra: u8) -> Option<Frame> {
    let mut bytes = vec![0xfd, 255, 0, 0, 0, 1, 1, id as u8, (id >> 8) as u8, 0];
    bytes.extend_from_slice(payload);
    let checksum = crc(bytes[1..].iter().copied().chain([extra]));
    bytes.extend_from_slice(&checksum.to_le_bytes());
    let mut decoder = FrameDecoder::new();
    decoder.push(&bytes);
    decoder.next_frame()
}

#[test]
fn wind_is_named_after_where_it_comes_from() {
    let t = apply(MavMessage::WIND(WIND_DATA { direction: -90.0, speed: 5.0, speed_z: 0.0 }));
    near(t.wind.expect("wind").value.from_deg, 270.0);
    // The air moves north and east: a wind from the south-west.
    let t = apply(MavMessage::WIND_COV(WIND_COV_DATA { wind_x: 3.0, wind_y: 3.0, ..WIND_COV_DATA::default() }));
    let wind = t.wind.expect("wind").value;
    near(wind.from_deg, 225.0);
    near(wind.speed_m_s, 18.0f64.sqrt());
}

#[test]
fn cells_are_told_from_packs() {
    let voltages = |raw: [u16; 4]| {
        let mut all = [u16::MAX; 10];
        all[..4].copy_from_slice(&raw);
        let data = BATTERY_STATUS_DATA { id: 1, voltages: all, ..BATTERY_STATUS_DATA::default() };
        apply(MavMessage::BATTERY_STATUS(data)).batteries[1].expect("battery").value
    };
    let cells = voltages([4_100, 4_000, 4_050, u16::MAX]);
    near(cells.voltage_v, 12.15);
    assert_eq!(cells.cells_v[..4], [Some(4.1), Some(4.0), Some(4.05), None]);
    // 70 V do not fit 16 bits: the rest overflows into the next entry.
    let pack = voltages([65_534, 4_466, u16::MAX, u16::MAX]);
    near(pack.voltage_v, 70.0);
    assert_eq!(pack.cells_v[0], None);
}

// fault 12: each value: fresh up to 3.5 s, stale up to 5 s, then lost
#[test]
fn values_age() {
    let sampled = Sampled { value: 1, at: MonoTime::from_millis(1_000), invalid: false };
    let at = |ms| sampled.freshness(MonoTime::from_millis(ms));
    assert_eq!(
        (at(4_500), at(4_501), at(6_000), at(6_001)),
        (Freshness::Fresh, Freshness::Stale, Freshness::Stale, Freshness::Lost)
    );
    assert_eq!(at(0), Freshness::Fresh, "a clock does not go back, but if it did");
}

#[test]
fn versions_and_hashes_read_as_people_write_them() {
    let t = apply(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        flight_sw_version: 0x0408_0000,
        flight_custom_version: *b"1a2b3c4d",
        capabilities: MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_FTP,
        ..AUTOPILOT_VERSION_DATA::default()
    }));
    let version = t.version.expect("version").value;
    assert_eq!((version.flight_sw.to_string(), version.git_hash.to_string()), ("4.8.0-dev".into(), "1a2b3c4d".into()));
    assert!(version.has_ftp());
    assert_eq!(SoftwareVersion::from(0x0406_03ff).to_string(), "4.6.3");
    assert_eq!(GitHash([0xef, 0xbe, 0xad, 0xde, 0, 0, 0, 1]).to_string(), "01000000deadbeef");
}

#[test]
fn a_heartbeat_names_mode_and_family() {
    let t = arduplane();
    let heartbeat = t.heartbeat.expect("heartbeat").value;
    assert_eq!(
        (heartbeat.mode.family, heartbeat.mode.name(), heartbeat.is_armed),
        (ModeFamily::ArduPlane, Some("AUTO"), true)
    );
}

#[test]
fn a_snapshot_needs_no_heap() {
    fn is_copy<T: Copy>() {}
    is_copy::<Telemetry>();
    assert!(size_of::<Telemetry>() < 5_000, "{} bytes", size_of::<Telemetry>());
    // And a frame goes around without loss.
    let frame = Message::Heartbeat(Heartbeat::default()).encode(Header {
        sequence: 0,
        source: Address::new(1, 1),
        version: MavVersion::V2,
    });
    assert!(frame.decode().is_ok());
}

#[test]
fn a_terrain_report_has_heights_only_where_the_vehicle_knows_them() {
    let report = |lat, lon, spacing| {
        let report = TERRAIN_REPORT_DATA {
            lat,
            lon,
            terrain_height: 612.5,
            current_height: 90.25,
            spacing,
            pending: 4,
            loaded: 52,
        };
        let value = apply(MavMessage::TERRAIN_REPORT(report)).terrain.expect("a report").value;
        assert_eq!((value.pending, value.loaded), (4, 52));
        (value.ground_amsl_m, value.alt_terrain_m)
    };
    assert_eq!(report(403_332_000, -37_978_000, 100), (Some(612.5), Some(90.25)));
    assert_eq!(report(403_332_000, -37_978_000, 0), (None, None), "no data there");
    assert_eq!(report(0, 0, 100), (None, None), "no position yet");
}

#[test]
fn a_flight_is_learned_by_the_vehicles_clock() {
    let mut telemetry = Telemetry::new();
    let mut hear = |message: MavMessage, now_ms: u64| {
        let now = MonoTime::from_micros(now_ms * 1_000);
        telemetry.apply(&Message::Dialect(message), now);
        telemetry.recorded(now).map(|moment| moment.time_s)
    };
    hear(MavMessage::ATTITUDE(ATTITUDE_DATA::default()), 0);
    hear(MavMessage::VFR_HUD(VFR_HUD_DATA::default()), 0);
    let mut at = |time_boot_ms: u32, now_ms: u64| {
        let position = GLOBAL_POSITION_INT_DATA { time_boot_ms, lat: 403_332_000, ..Default::default() };
        hear(MavMessage::GLOBAL_POSITION_INT(position), now_ms)
    };
    // A radio that held two back brings three at once.
    let told: Vec<Option<f64>> =
        [(7_000, 10), (7_200, 600), (7_400, 601), (7_600, 602)].map(|(boot, now)| at(boot, now)).into();
    assert_eq!(told, [Some(7.0), Some(7.2), Some(7.4), Some(7.6)]);
}

#[test]
fn a_position_counted_from_no_origin_is_none() {
    let place = |lat, lon| {
        let message = GLOBAL_POSITION_INT_DATA { lat, lon, ..Default::default() };
        let position = apply(MavMessage::GLOBAL_POSITION_INT(message)).position.expect("heard");
        assert!(!position.invalid);
        position.value.lat_deg.zip(position.value.lon_deg)
    };
    assert_eq!(place(0, 0), None);
    assert_eq!(place(-16, -2_550), None, "as a real ArduPlane says before its first fix");
    assert_eq!(place(0, 7_000_000), Some((0.0, 0.7)), "on the equator");
    assert_eq!(place(514_000_000, 0), Some((51.4, 0.0)), "on the meridian of Greenwich");
}

/// The first seconds of arduplane-takeoff-to-landing.tlog, on a field at 600 m.
#[test]
fn heights_of_a_plane_without_home_are_not_above_the_sea() {
    let mut telemetry = Telemetry::new();
    let mut told = |lat, lon, alt, relative_alt, hdg, fix_alt: Option<i32>| {
        let fix_type = if fix_alt.is_some() { GpsFixType::GPS_FIX_TYPE_3D_FIX } else { GpsFixType::default() };
        let gps = GPS_RAW_INT_DATA { fix_type, lat, lon, alt: fix_alt.unwrap_or(0), ..Default::default() };
        let position = GLOBAL_POSITION_INT_DATA { lat, lon, alt, relative_alt, hdg, ..Default::default() };
        let heading = (hdg / 100) as i16;
        let hud = VFR_HUD_DATA { alt: alt as f32 / 1e3, heading, ..Default::default() };
        for message in
            [MavMessage::GPS_RAW_INT(gps), MavMessage::GLOBAL_POSITION_INT(position), MavMessage::VFR_HUD(hud)]
        {
            telemetry.apply(&Message::Dialect(message), MonoTime::from_millis(7)).expect("has a group");
        }
        let (position, hud) = (telemetry.position.expect("heard").value, telemetry.hud.expect("heard").value);
        assert_eq!(position.alt_rel_home_m, Some(f64::from(relative_alt) / 1e3), "its barometer's");
        ((position.alt_amsl_m, position.heading_deg), (hud.alt_amsl_m.map(f64::round), hud.heading_deg))
    };
    let (lat, lon) = (403_332_000, -37_977_998);
    assert_eq!(told(0, 0, 140, 141, 0, None), ((None, None), (None, None)), "just switched on");
    assert_eq!(told(0, 0, 170, 173, 28_337, None), ((None, Some(283.37)), (None, Some(283.0))));
    assert_eq!(told(lat, lon, -120, -126, 26_960, Some(600_090)).0, (None, Some(269.6)), "a place, and no home");
    assert_eq!(told(lat, lon, 600_270, 185, 0, Some(600_090)), ((Some(600.27), Some(0.0)), (Some(600.0), Some(0.0))));
    assert_eq!(told(lat, lon, 1_120, 1_126, 26_960, Some(4_000)).0.0, Some(1.12), "by the sea");
}

#[test]
fn outputs_17_to_32_are_not_taken_for_1_to_16() {
    let outputs = |port, pulse_us| {
        MavMessage::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA { port, servo1_raw: pulse_us, ..Default::default() })
    };
    let mut telemetry = apply(outputs(0, 1_500));
    assert_eq!(telemetry.apply(&Message::Dialect(outputs(1, 1_900)), MonoTime::from_millis(9)), None);
    let servos = telemetry.servos.expect("the first bank");
    assert_eq!((servos.value.pulse_us[0], servos.at), (Some(1_500), MonoTime::from_millis(7)));
}

/// Frames of pymavlink 2.4.50 (`MAVLink_efi_status_message.pack`).
#[test]
fn an_engine_reports_what_it_measures() {
    let read = |hex: &str| {
        let bytes: Vec<u8> =
            (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hex")).collect();
        let mut decoder = FrameDecoder::new();
        decoder.push(&bytes);
        let message = decoder.next_frame().expect("a frame").decode().expect("a message");
        let mut telemetry = Telemetry::new();
        assert_eq!(telemetry.apply(&message, MonoTime::ZERO), Some(Group::Engine));
        (telemetry.engine.expect("an engine"), telemetry.invalid_values)
    };
    let (running, invalid) = read(concat!(
        "fd490000070101e10000000000000010a44500204b440000c64100007a4200005c42000020400080be420000a3420000fa4100800e43",
        "000094c10000704000c0234400005a420000903f0100003c4100c0974339bd",
    ));
    assert_eq!(
        (running.value, invalid),
        (
            Engine {
                health: 1,
                ecu_index: Some(0.0),
                rpm: Some(5_250.0),
                fuel_consumed_cm3: Some(812.5),
                fuel_flow_cm3_min: Some(24.75),
                load_pct: Some(62.5),
                throttle_position_pct: Some(55.0),
                throttle_output_pct: Some(54.5),
                spark_dwell_ms: Some(2.5),
                ignition_timing_deg: Some(-18.5),
                injection_ms: Some(3.75),
                barometric_pa: Some(95_250.0),
                intake_manifold_pa: Some(81_500.0),
                intake_manifold_temperature_c: Some(31.25),
                cylinder_head_temperature_c: Some(142.5),
                exhaust_gas_temperature_c: Some(655.0),
                pressure_temperature_compensation: Some(1.125),
                ignition_v: Some(11.75),
                fuel_pressure_pa: Some(303_500.0),
            },
            0
        )
    );
    // Not measured: NaN, 0 K, and 0 V. An empty fuel line is none of these, a load of 250 % cannot be.
    let (lame, invalid) = read(concat!(
        "fd490000070101e10000000000000000c07f000000000000c07f00007a430000000000000000000000000000000000000000339388c3",
        "00000000000000000000c07f0000000000000000020000000017b7d1384e82",
    ));
    assert_eq!(
        (lame.value.rpm, lame.value.fuel_flow_cm3_min, lame.value.cylinder_head_temperature_c),
        (None, None, None)
    );
    assert_eq!((lame.value.exhaust_gas_temperature_c, lame.value.ignition_v), (None, None));
    assert_eq!((lame.value.fuel_pressure_pa, lame.value.load_pct), (Some(0.0), None));
    assert_eq!((lame.invalid, invalid), (true, 1));
}

// Fields as PX4 v1.17.0 sent them: it tells whether its checks pass in `health` alone, and −1 A without a current sensor
// (`SYS_STATUS.hpp`).
#[test]
fn a_px4_tells_whether_it_is_ready_to_arm_in_its_own_way() {
    use vencejo_proto::dialect::MavSysStatusSensor;
    let status = |autopilot, health: u32| {
        let mut telemetry = Telemetry::new();
        let heartbeat = Heartbeat { mav_type: 1, autopilot, ..Heartbeat::default() };
        telemetry.apply(&Message::Heartbeat(heartbeat), MonoTime::ZERO);
        let told = apply_to(
            telemetry,
            MavMessage::SYS_STATUS(SYS_STATUS_DATA {
                onboard_control_sensors_present: MavSysStatusSensor::from_bits_retain(50_348_095),
                onboard_control_sensors_enabled: MavSysStatusSensor::from_bits_retain(50_413_631),
                onboard_control_sensors_health: MavSysStatusSensor::from_bits_retain(health),
                current_battery: -100,
                ..SYS_STATUS_DATA::default()
            }),
        );
        let status = told.sys_status.expect("status").value;
        let battery = MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA { current_battery: -100, ..Default::default() });
        let battery = apply_to(told, battery).batteries[0].expect("a battery").value;
        assert_eq!(battery.current_a, status.current_a);
        (status.is_ready_to_arm, status.current_a)
    };
    assert_eq!(status(12, 50_348_095 | 1 << 28), (Some(true), None));
    assert_eq!(status(12, 50_348_095), (Some(false), None));
    assert_eq!(status(3, 50_348_095), (None, Some(-1.0)));
}
