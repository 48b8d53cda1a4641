//! What a PX4 takes otherwise than an ArduPilot: read in its source and its issues, not tried on one.

use vencejo_proto::param::ParamEncoding;

use super::*;

/// `MAV_AUTOPILOT_PX4`.
const PX4: u8 = 12;
/// AUTO.LOITER: main mode 4, sub mode 3.
const AUTO_LOITER: u32 = (4 << 16) | (3 << 24);

fn px4() -> Plane {
    let mut plane = Plane::new();
    (plane.autopilot, plane.mode, plane.is_armed) = (PX4, AUTO_LOITER, true);
    plane.services.param_encoding = ParamEncoding::Bytewise;
    plane
}

fn flying(config: VehicleConfig) -> Pair {
    let mut world = World::new(Station::with(config), px4(), Faults::default(), 1);
    wait(&mut world, 3_000);
    world
}

/// One that is asked for nothing by itself.
fn unasked() -> VehicleConfig {
    VehicleConfig { streams: StreamConfig::listen_only(), ..VehicleConfig::default() }
}

fn go_to(alt_m: f64, alt_frame: AltFrame) -> Request {
    Request::Reposition {
        lat_deg: 40.334,
        lon_deg: -3.79,
        alt_m,
        alt_frame,
        radius_m: None,
        turn: Turn::Clockwise,
        speed_m_s: None,
        change_mode: true,
    }
}

// Its MAVLink receiver drops the frame of a COMMAND_INT, and its navigator takes the height as one above mean sea level (PX4 issues
// 8502, 10246, 28257).
#[test]
fn it_is_sent_heights_above_mean_sea_level() {
    let mut world = flying(VehicleConfig::default());
    let home_m = world.station.vehicle.telemetry().home.expect("home").value.alt_amsl_m;
    assert!((home_m - 600.09).abs() < 1e-6);
    for (alt_m, alt_frame, sent_m) in
        [(100.0, AltFrame::RelHome, 700.09), (0.0, AltFrame::RelHome, 600.09), (750.0, AltFrame::Amsl, 750.0)]
    {
        assert_eq!(ask(&mut world, go_to(alt_m, alt_frame)), Ok(Reply::Done));
        let sent = world.plane.ints.last().expect("a go-to");
        assert_eq!((sent.command, sent.frame, sent.z), (cmd::DO_REPOSITION, 0, sent_m));
        assert_eq!(ask(&mut world, Request::ChangeAltitude { alt_m, alt_frame }), Ok(Reply::Done));
        let sent = world.plane.commands.last().expect("a change of height");
        assert_eq!((sent.command, sent.params[0], sent.params[1]), (cmd::DO_CHANGE_ALTITUDE, sent_m, 0.0));
    }
}

#[test]
fn a_height_that_cannot_be_counted_from_there_is_not_sent() {
    let (mut world, mut homeless) = (flying(VehicleConfig::default()), flying(unasked()));
    let before = world.plane.commands.len();
    for terrain in
        [go_to(80.0, AltFrame::Terrain), Request::ChangeAltitude { alt_m: 80.0, alt_frame: AltFrame::Terrain }]
    {
        let error = ask(&mut world, terrain).expect_err("it knows no such frame");
        assert!(matches!(error, VehicleError::InvalidValue { field: "alt_frame", .. }), "{error}");
    }
    for (alt_m, alt_frame) in [(1e9, AltFrame::RelHome), (f64::NAN, AltFrame::RelHome), (f64::NAN, AltFrame::Amsl)] {
        for request in [go_to(alt_m, alt_frame), Request::ChangeAltitude { alt_m, alt_frame }] {
            assert!(matches!(ask(&mut world, request), Err(VehicleError::InvalidValue { field: "alt_m", .. })));
        }
    }
    for request in
        [go_to(80.0, AltFrame::RelHome), Request::ChangeAltitude { alt_m: 80.0, alt_frame: AltFrame::RelHome }]
    {
        assert_eq!(ask(&mut homeless, request), Err(VehicleError::HomeUnknown));
    }
    assert_eq!((world.plane.commands.len(), homeless.plane.commands.len()), (before, 0));
    assert!(world.plane.ints.is_empty() && homeless.plane.ints.is_empty());
}

// 5 was written as the bits of 5.0, which are 1084227584, and told as set: the vehicle gives back the bits that it got.
#[test]
fn an_integer_is_set_as_one_before_it_has_told_its_capabilities() {
    let mut world = flying(unasked());
    let name = ParamName::new("COM_FLTMODE1").expect("a name");
    world.plane.services.params.push(Param { name, value: ParamValue::I32(0) });
    assert_eq!(world.station.vehicle.telemetry().version, None);
    let set = Request::ParamSet { name: "COM_FLTMODE1".into(), value: 5.0 };
    let kept = Param { name, value: ParamValue::I32(5) };
    assert_eq!(ask(&mut world, set.clone()), Ok(Reply::Parameter(kept)));
    assert_eq!(world.plane.services.params.last(), Some(&kept));
    assert_eq!(ask(&mut world, Request::ParamRead { name: "COM_FLTMODE1".into() }), Ok(Reply::Parameter(kept)));
    // What it is is not known before its first heartbeat.
    let mut unheard = World::new(Station::with(unasked()), px4(), Faults::default(), 1);
    assert!(matches!(ask(&mut unheard, set), Err(VehicleError::NotHeard { .. })));
}
