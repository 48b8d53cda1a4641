//! The laws fly a point-mass plane: every output stays within bounds, and the targets are reached.

use super::attitude::{self, Attitude, AttitudeParams, AttitudeState};
use super::l1::{self, L1Params, L1State, Motion, Track, Turn};
use super::pilot::{self, Lateral, Orders, PilotParams, PilotState, Sensed, Vertical};
use super::tecs::{self, Demand, Energy, Phase, TecsParams, TecsState};
use super::{GRAVITY_M_S2, NorthEast, bound, lag, wrap_pi};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

const DT: f64 = 0.05;

/// A plane that turns by bank, with a roll lag of half a second, in a steady wind.
struct Kite {
    position: NorthEast,
    heading: f64,
    bank: f64,
    airspeed: f64,
    wind: NorthEast,
}

impl Kite {
    fn motion(&self) -> Motion {
        Motion {
            position: self.position,
            velocity: NorthEast::from_bearing(self.heading) * self.airspeed + self.wind,
            heading_rad: self.heading,
        }
    }

    fn fly(&mut self, bank: f64) {
        self.bank = lag(self.bank, bound(bank, -1.1, 1.1), 0.5, DT);
        self.heading = wrap_pi(self.heading + GRAVITY_M_S2 * self.bank.tan() / self.airspeed * DT);
        let velocity = self.motion().velocity;
        self.position = self.position + velocity * DT;
    }
}

fn wind(speed: f64, from: f64) -> NorthEast {
    NorthEast::from_bearing(from + PI) * speed
}

proptest! {
    #[test]
    fn l1_meets_a_line_and_stays_on_it(
        north in -200.0..200.0f64, east in -400.0..400.0f64, heading in -PI..PI,
        bearing in -PI..PI, airspeed in 14.0..26.0f64, wind_part in 0.0..0.4f64, from in -PI..PI,
    ) {
        let params = L1Params::default();
        let mut kite = Kite {
            position: NorthEast::new(north, east), heading, bank: 0.0, airspeed,
            wind: wind(wind_part * airspeed, from),
        };
        let along = NorthEast::from_bearing(bearing);
        let track = Track::Leg { from: along * -1000.0, to: along * 20_000.0 };
        let mut state = L1State::default();
        let mut worst: f64 = 0.0;
        for step in 0..4000 {
            let (next, output) = l1::steer(state, &kite.motion(), &track, &params, DT);
            prop_assert!(output.lateral_accel_m_s2.is_finite());
            prop_assert!(output.lateral_accel_m_s2.abs() < 60.0);
            state = next;
            kite.fly(output.bank_rad(0.0));
            if step > 3000 {
                worst = worst.max(output.xtrack_error_m.abs());
            }
        }
        prop_assert!(worst < 2.0, "cross-track {worst} m after 150 s");
    }

    #[test]
    fn l1_captures_a_circle_and_flies_round_it(
        north in -500.0..500.0f64, east in -500.0..500.0f64, heading in -PI..PI,
        airspeed in 14.0..24.0f64, radius in 70.0..200.0f64, clockwise: bool,
        wind_part in 0.0..0.25f64, from in -PI..PI,
    ) {
        let turn = if clockwise { Turn::Clockwise } else { Turn::Anticlockwise };
        let mut kite = Kite {
            position: NorthEast::new(north, east), heading, bank: 0.0, airspeed,
            wind: wind(wind_part * airspeed, from),
        };
        let track = Track::Circle { centre: NorthEast::default(), radius_m: radius, turn };
        let params = L1Params::default();
        let mut state = L1State::default();
        let mut worst: f64 = 0.0;
        let mut turned = 0.0;
        for step in 0..6000 {
            let before = kite.position.bearing_rad();
            let (next, output) = l1::steer(state, &kite.motion(), &track, &params, DT);
            state = next;
            kite.fly(output.bank_rad(0.0));
            if step > 3000 {
                worst = worst.max(output.xtrack_error_m.abs());
                turned += wrap_pi(kite.position.bearing_rad() - before);
            }
        }
        prop_assert!(state.on_circle);
        prop_assert!(worst < 0.25 * radius, "{worst} m off a circle of {radius} m");
        prop_assert!(if clockwise { turned > TAU } else { turned < -TAU }, "turned {turned} rad");
    }

    #[test]
    fn l1_holds_a_heading(heading in -PI..PI, wanted in -PI..PI, airspeed in 12.0..28.0f64) {
        let mut kite = Kite {
            position: NorthEast::default(), heading, bank: 0.0, airspeed, wind: NorthEast::default(),
        };
        let track = Track::Heading { heading_rad: wanted };
        for _ in 0..2000 {
            let (_, output) = l1::steer(L1State::default(), &kite.motion(), &track, &L1Params::default(), DT);
            kite.fly(output.bank_rad(0.0));
        }
        prop_assert!(wrap_pi(kite.heading - wanted).abs() < 0.01);
    }

    #[test]
    fn whatever_the_state_the_answers_are_bounded(
        values in proptest::array::uniform24(-1e6..1e6f64), track in 0..4u8, phase in 0..4u8,
        dt in -1.0..10.0f64,
    ) {
        let v = values;
        let track = match track {
            0 => Track::Leg { from: NorthEast::new(v[0], v[1]), to: NorthEast::new(v[2], v[3]) },
            1 => Track::Circle { centre: NorthEast::new(v[0], v[1]), radius_m: v[2], turn: Turn::Anticlockwise },
            2 => Track::Heading { heading_rad: v[0] },
            _ => Track::Level,
        };
        let phase = match phase {
            0 => Phase::Cruise,
            1 => Phase::Climbout,
            2 => Phase::Approach { proportion: v[4] },
            _ => Phase::Flare { height_m: v[4], start_height_m: v[5], start_sink_m_s: v[6] },
        };
        let sensed = Sensed {
            position: NorthEast::new(v[7], v[8]), height_m: v[9], velocity: NorthEast::new(v[10], v[11]),
            climb_m_s: v[12], roll_rad: v[13], pitch_rad: v[14], heading_rad: v[15],
            rates_rad_s: [v[16], v[17], v[18]], airspeed_m_s: v[19], eas_to_tas: v[20], forward_accel_m_s2: v[21],
        };
        let orders = Orders {
            lateral: Lateral::Track(track),
            vertical: Vertical::Energy(Demand {
                height_m: v[22], airspeed_m_s: v[23], phase, pitch_min_rad: -0.35, pitch_max_rad: 0.4,
                throttle_min: 0.0, throttle_max: 1.0,
            }),
            bank_max_rad: 1.1, rudder: 0.0, ground_heading_rad: Some(v[3]), on_ground: dt > 0.0, throttle_off: false,
        };
        let mut state = PilotState::default();
        for _ in 0..5 {
            let (next, output) = pilot::step(state, &sensed, &orders, &PilotParams::default(), dt);
            state = next;
            for surface in [output.surfaces.aileron, output.surfaces.elevator, output.surfaces.rudder] {
                prop_assert!((-1.0..=1.0).contains(&surface));
            }
            prop_assert!((0.0..=1.0).contains(&output.throttle));
            prop_assert!(output.bank_rad.abs() <= 1.1);
            prop_assert!((-0.35..=0.4).contains(&output.pitch_rad));
        }
    }

    #[test]
    fn energy_control_settles_at_height_and_speed(
        start in -40.0..40.0f64, speed in 13.0..26.0f64, wanted in 13.0..26.0f64,
    ) {
        // A point mass: throttle makes energy, pitch trades it, each with a lag.
        let params = TecsParams::default();
        let (mut height, mut v, mut gamma, mut thrust) = (100.0 + start, speed, 0.0, 0.5);
        let demand = Demand {
            height_m: 100.0, airspeed_m_s: wanted, phase: Phase::Cruise, pitch_min_rad: -0.35,
            pitch_max_rad: 0.44, throttle_min: 0.0, throttle_max: 1.0,
        };
        let mut state = TecsState::default();
        let mut accel: f64 = 0.0;
        for _ in 0..6000 {
            let now = Energy {
                height_m: height, climb_m_s: v * f64::sin(gamma), airspeed_m_s: v, eas_to_tas: 1.0,
                accel_m_s2: accel, roll_rad: 0.0, pitch_rad: gamma + 0.05,
            };
            let (next, output) = tecs::manage(state, &now, &demand, &params, 0.02);
            state = next;
            thrust = lag(thrust, output.throttle, 0.2, 0.02);
            gamma = lag(gamma, output.pitch_rad - 0.05, 0.4, 0.02);
            accel = 8.0 * thrust - 4.0 * (v / 22.0f64).powi(2) - GRAVITY_M_S2 * f64::sin(gamma);
            v = (v + accel * 0.02).max(5.0);
            height += v * f64::sin(gamma) * 0.02;
        }
        prop_assert!((height - 100.0).abs() < 1.0, "height {height}");
        prop_assert!((v - wanted).abs() < 0.5, "speed {v} of {wanted}");
    }
}

#[test]
fn the_l1_length_is_the_papers_at_its_damping() {
    // ζ = 1/√2 makes K = 2, the gain of eq. (1); ω = √2 V / L1 is then 2π/T.
    let params = L1Params { damping: std::f64::consts::FRAC_1_SQRT_2, ..L1Params::default() };
    let length = params.length_m(20.0);
    let omega = 2_f64.sqrt() * 20.0 / length;
    assert!((omega - TAU / params.period_s).abs() < 1e-9);
}

#[test]
fn a_plane_left_of_its_track_turns_right() {
    let motion =
        Motion { position: NorthEast::new(100.0, -20.0), velocity: NorthEast::new(20.0, 0.0), heading_rad: 0.0 };
    let track = Track::Leg { from: NorthEast::default(), to: NorthEast::new(1000.0, 0.0) };
    let (_, output) = l1::steer(L1State::default(), &motion, &track, &L1Params::default(), 0.01);
    assert!(output.xtrack_error_m > 19.9);
    assert!(output.lateral_accel_m_s2 > 0.0);
    assert!(output.nav_bearing_rad > 0.0);
}

#[test]
fn a_bank_error_moves_the_aileron_its_way_across_the_wrap() {
    let now = Attitude { roll_rad: 3.0, airspeed_m_s: 15.0, eas_to_tas: 1.0, ..Attitude::default() };
    let (_, surfaces) =
        attitude::stabilise(AttitudeState::default(), &now, -3.0, 0.0, true, &AttitudeParams::default(), 0.01);
    assert!(surfaces.aileron > 0.0, "the short way from 172° to −172° is right");
}

#[test]
fn full_feed_forward_is_airspeed_scaled() {
    let params = AttitudeParams::default();
    let at = |airspeed| {
        let now = Attitude { airspeed_m_s: airspeed, eas_to_tas: 1.0, ..Attitude::default() };
        attitude::stabilise(AttitudeState::default(), &now, 0.1, 0.0, true, &params, 0.01).1.aileron
    };
    assert!(at(12.0) > at(15.0) && at(15.0) > at(25.0));
}

#[test]
fn the_flare_fades_the_sink_rate() {
    let params = TecsParams::default();
    let mut state = TecsState::default();
    let run = |state, height_m, climb| {
        let now = Energy { height_m, climb_m_s: climb, airspeed_m_s: 14.0, eas_to_tas: 1.0, ..Energy::default() };
        let demand = Demand {
            height_m: 0.0,
            airspeed_m_s: 14.0,
            pitch_min_rad: -0.3,
            pitch_max_rad: 0.3,
            phase: Phase::Flare { height_m, start_height_m: 3.0, start_sink_m_s: 1.3 },
            throttle_min: 0.0,
            throttle_max: 1.0,
        };
        tecs::manage(state, &now, &demand, &params, 0.02)
    };
    let (next, first) = run(state, 3.0, -1.3);
    state = next;
    let mut last = first;
    for step in 0..50 {
        (state, last) = run(state, 3.0 - f64::from(step) * 0.05, -1.3);
    }
    assert_eq!(last.throttle, 0.0);
    assert!(last.pitch_rad > first.pitch_rad, "nose comes up when it sinks faster than wanted");
}

#[test]
fn nonsense_in_is_a_still_plane_out() {
    let sensed = Sensed { airspeed_m_s: f64::NAN, ..Sensed::default() };
    let orders = Orders {
        lateral: Lateral::Bank(0.5),
        vertical: Vertical::Pitch { pitch_rad: 0.1, throttle: 1.0 },
        bank_max_rad: 1.0,
        rudder: 0.0,
        ground_heading_rad: None,
        on_ground: false,
        throttle_off: false,
    };
    let (_, output) = pilot::step(PilotState::default(), &sensed, &orders, &PilotParams::default(), 0.01);
    assert_eq!(output.throttle, 0.0);
    assert_eq!(output.surfaces, attitude::Surfaces::default());
}

#[test]
fn angles_wrap() {
    assert!((wrap_pi(3.0 * PI) - PI).abs() < 1e-12);
    assert!((wrap_pi(-3.0 * PI) - PI).abs() < 1e-12);
    assert!((wrap_pi(-0.5) + 0.5).abs() < 1e-12);
    assert!((wrap_pi(TAU + 0.5) - 0.5).abs() < 1e-12);
}

#[test]
fn the_defaults_are_the_recorded_planes_parameters() {
    // Every name that the laws read, from the parameters of a real ArduPlane.
    let text = include_str!("../../../../tests/fixtures/captures/arduplane-params.parm");
    let recorded: std::collections::HashMap<&str, f64> = text
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?, words.next()?.parse().ok()?))
        })
        .collect();
    assert!(recorded.len() > 1000);
    let asked = std::cell::Cell::new(0);
    let read = PilotParams::from_ardupilot(|name| {
        asked.set(asked.get() + 1);
        let value = recorded.get(name).copied();
        assert!(value.is_some(), "ArduPlane has no {name}");
        value
    });
    assert!(asked.get() > 30);
    let (defaults, close) = (PilotParams::default(), |a: f64, b: f64| (a - b).abs() < 1e-5);
    assert!(close(read.l1.period_s, defaults.l1.period_s));
    assert!(close(read.tecs.integrator_gain_per_s, defaults.tecs.integrator_gain_per_s));
    assert!(close(read.attitude.pitch.ff, defaults.attitude.pitch.ff));
    assert!(close(read.attitude.roll.d, defaults.attitude.roll.d));
}
