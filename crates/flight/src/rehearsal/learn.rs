//! Learning a plane from its recorded flight: its pitot tube, how it turns, its lift, drag and thrust, and the wind.
//!
//! Least squares over moments in the air, each on the point mass' own equation, so that the numbers go straight into
//! [`Airframe`]:
//!
//! | what | from |
//! |---|---|
//! | wind, pitot | \|ground velocity − wind\| = pitot · true airspeed, while the plane flies in all directions |
//! | skid | turn rate of the air velocity over that of a coordinated turn at the same bank |
//! | pitch, attack | pitch − path angle = level pitch + attack · (load · (cruise / airspeed)² − 1), wings level |
//! | cruise throttle | its median in steady level flight at cruise |
//! | thrust, drag | V̇ + g ḣ / V = thrust − drag, both as [`Airframe`] has them, wings level and throttle held; down to the ground, for few planes climb at full throttle or glide elsewhere |
//! | static thrust | the same of a propeller, whose thrust falls with airspeed, wherever it pulls |
//! | drag on the ground | how fast it slows down between its touch-down and its rest, less its drag |
//! | power, voltage | their medians in level flight at cruise, and how power grows with throttle away from it |
//!
//! Values that a flight does not show are kept.

use super::air::eas_to_tas;
use std::collections::VecDeque;

use super::aircraft::Aircraft;
use super::airframe::{Airframe, Origin};
use crate::guidance::{GRAVITY_M_S2, NorthEast, wrap_pi};
use crate::landing::Wind;

/// One moment of a recorded flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded {
    /// Any clock, s, growing.
    pub time_s: f64,
    /// Over ground, m/s.
    pub velocity: NorthEast,
    /// Climb, m/s.
    pub climb_m_s: f64,
    /// Height above mean sea level, m.
    pub height_amsl_m: f64,
    /// Height above home, m.
    pub height_m: f64,
    /// Airspeed as the autopilot has it, m/s.
    pub airspeed_m_s: f64,
    /// Bank, rad.
    pub bank_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Electrical power, W, where it is measured.
    pub power_w: Option<f64>,
    /// Voltage of the battery, V, where it is measured.
    pub voltage_v: Option<f64>,
}

/// A plane, learned from a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learned {
    /// It.
    pub airframe: Airframe,
    /// The wind of that flight.
    pub wind: Wind,
    /// Moments that it rests on.
    pub moments: usize,
    /// How far measured and modelled airspeeds are apart, m/s RMS.
    pub airspeed_error_m_s: f64,
}

/// Height above home from which the plane is taken to fly free of the ground and of its wind, m.
const FREE_M: f64 = 20.0;
/// Climb or sink, m/s, that distinguishes flight from standing below that height.
const IN_AIR_M_S: f64 = 0.3;
/// Speed over the ground, m/s, above which a plane that landed rolls or slides, and the longest that it does, s.
const ROLLS_M_S: f64 = 3.0;
const ROLL_OUT_S: f64 = 20.0;
/// Fewest moments that anything is learned from.
const FEWEST: usize = 100;
/// Bank that is wings level, rad, and banks that a turn is looked at in.
const LEVEL_RAD: f64 = 0.1;
const TURN_RAD: std::ops::Range<f64> = 0.2..0.9;
/// Time over which rates are taken, s.
const RATE_S: f64 = 1.0;

/// Throttle change over [`RATE_S`] below which it counts as constant (engine and airframe lag).
const HELD: f64 = 0.1;
/// Difference from cruise, as a part of it, climb, m/s, and acceleration, m/s², of level flight at cruise.
const NEAR_CRUISE: f64 = 0.1;
const LEVEL_M_S: f64 = 0.5;
const STEADY_M_S2: f64 = 0.3;
/// Fewest moments at one end of the throttle.
const A_FEW: usize = 10;
/// Thrust deficit, as a part of the drag, from which a moment is used for drag: a propeller's thrust falls with
/// airspeed by a tenth or two. And the part of the way from cruise to full throttle above which a climb is used for
/// full thrust; throttles are known to some hundredths.
const CLEAR: f64 = 0.25;
const HIGH_PART: f64 = 0.15;
/// Thrust less drag of a plane that climbs or gains speed, and drag less thrust of one that sinks or loses it, m/s².
const CLIMBS_M_S2: f64 = 0.5;
const SINKS_M_S2: f64 = 0.5;
/// Throttle over that of cruise above which a propeller pulls, and the most that one pulls, over the plane's weight.
const PULLS: f64 = 0.6;
const MOST_STATIC: f64 = 4.0;
/// Logarithm of the throttle over that of cruise beyond which it differs, and the idle throttle, where the avionics
/// dominate.
const AWAY: f64 = 0.15;
const IDLE: f64 = 0.1;

/// How late a message may come after one that was sent later, s.
const OUT_OF_ORDER_S: f64 = 5.0;

/// Bounded buffer of a flight's last moments in the air, to learn from.
#[derive(Debug, Clone)]
pub struct Learner {
    moments: VecDeque<Recorded>,
    most: usize,
    every_s: f64,
}

impl Default for Learner {
    /// The last ten minutes, five moments a second.
    fn default() -> Self {
        Self { moments: VecDeque::new(), most: 3_000, every_s: 0.2 }
    }
}

impl Learner {
    /// For a recording: every moment, up to some fourteen hours at 10 Hz.
    pub fn of_recording() -> Self {
        Self { moments: VecDeque::new(), most: 500_000, every_s: 0.01 }
    }

    /// Keeps a moment in the air that is late enough after the last one. A clock that goes back restarts the buffer,
    /// unless messages were only reordered.
    pub fn note(&mut self, moment: Recorded) {
        if !moment.is_free() && !moment.is_in_air() && !moment.may_roll_out() {
            return;
        }
        match self.moments.back() {
            Some(last) if moment.time_s < last.time_s - OUT_OF_ORDER_S => self.moments.clear(),
            // Clocks count in thousandths: a moment on time is not early.
            Some(last) if moment.time_s < last.time_s + self.every_s - 1e-3 => return,
            _ => {}
        }
        if self.moments.len() == self.most {
            self.moments.pop_front();
        }
        self.moments.push_back(moment);
    }

    /// What these moments teach; see [`learn`].
    pub fn learned(&self, plane: &Aircraft) -> Option<Learned> {
        learn(&self.moments, plane)
    }
}

impl Recorded {
    /// Whether it is clear of the ground and of its wind.
    fn is_free(&self) -> bool {
        self.height_m > FREE_M
    }

    /// Whether it takes off or lands and is off the ground.
    fn is_in_air(&self) -> bool {
        self.climb_m_s.abs() > IN_AIR_M_S
    }

    /// Whether it moves on the ground without thrust.
    fn may_roll_out(&self) -> bool {
        !self.is_in_air() && self.throttle < IDLE && self.velocity.length() > ROLLS_M_S
    }
}

/// Learns a plane from a flight; `None` where it was too short or flew in one direction only.
pub fn learn<'a>(flight: impl IntoIterator<Item = &'a Recorded>, plane: &Aircraft) -> Option<Learned> {
    let flies = |moment: &Recorded| moment.airspeed_m_s > 0.6 * plane.tecs.airspeed_min_m_s;
    let (mut flown, mut low, mut rolled) = (Vec::new(), Vec::<Recorded>::new(), Vec::<Recorded>::new());
    for moment in flight {
        let came_down = low.last().is_some_and(|last| last.climb_m_s < 0.0 && moment.time_s < last.time_s + ROLL_OUT_S);
        match *moment {
            free if free.is_free() && flies(&free) => flown.push(free),
            near if !near.is_free() && near.is_in_air() && flies(&near) => {
                // It floated, or bounced.
                while rolled.pop_if(|down| near.time_s < down.time_s + ROLL_OUT_S).is_some() {}
                low.push(near);
            }
            down if !down.is_free() && down.may_roll_out() && came_down => rolled.push(down),
            _ => {}
        }
    }
    if flown.len() < FEWEST {
        return None;
    }
    let base = Airframe { pitot: 1.0, ..plane.airframe };
    let factor = |moment: &Recorded| base.true_over_indicated(eas_to_tas(moment.height_amsl_m));
    let (wind, pitot, airspeed_error_m_s) = wind_and_pitot(&flown, factor)?;
    let mut airframe =
        Airframe { origin: Origin::Flight, pitot, cruise_m_s: plane.airspeed_cruise_m_s, ..plane.airframe };
    let cruise = airframe.cruise_m_s;
    let speed = |moment: &Recorded| moment.airspeed_m_s * factor(moment) * pitot;

    let is_level = |moment: &Recorded| moment.bank_rad.abs() <= LEVEL_RAD;
    let is_held = |before: &Recorded, after: &Recorded| (after.throttle - before.throttle).abs() < HELD;

    let mut turns = Vec::new();
    let mut lifts = Lines::default();
    let mut pulls = Vec::new();
    let (mut throttles, mut powers, mut volts) = (Vec::new(), Vec::new(), Vec::new());
    for (before, now, after) in around(&flown) {
        let dt = after.time_s - before.time_s;
        let air = |moment: &Recorded| moment.velocity - wind;
        let is_steady = (after.bank_rad - before.bank_rad).abs() < 0.07;
        if TURN_RAD.contains(&now.bank_rad.abs()) && is_steady {
            let turned = wrap_pi(air(after).bearing_rad() - air(before).bearing_rad());
            turns.push(turned / dt * speed(now) / (GRAVITY_M_S2 * now.bank_rad.tan()));
        }
        if !is_level(now) {
            continue;
        }
        let path = (now.climb_m_s / speed(now)).clamp(-0.9, 0.9).asin();
        let ratio = cruise / now.airspeed_m_s;
        lifts.add(path.cos() * ratio * ratio - 1.0, now.pitch_rad - path);
        let accel = (speed(after) - speed(before)) / dt;
        if is_held(before, after) {
            pulls.push(Pull::of(before, now, after, accel + GRAVITY_M_S2 * path.sin()));
        }
        if now.climb_m_s.abs() < LEVEL_M_S && (ratio - 1.0).abs() < NEAR_CRUISE && accel.abs() < STEADY_M_S2 {
            throttles.push(mean_throttle(before, now, after));
            powers.extend(now.power_w.filter(|power| *power > 0.0));
            volts.extend(now.voltage_v.filter(|voltage| *voltage > 0.0));
        }
    }
    for (before, now, after) in around(&low).filter(|(before, now, after)| is_level(now) && is_held(before, after)) {
        // By the ground: the wind there grows with height, which does not change the plane's own speed.
        let along = (now.velocity - wind).unit_or(NorthEast::default());
        let accel = (after.velocity - before.velocity).dot(along) / (after.time_s - before.time_s);
        pulls.push(Pull::of(before, now, after, accel + GRAVITY_M_S2 * now.climb_m_s / speed(now)));
    }
    if let Some(turn) = median(&mut turns).filter(|_| turns.len() >= FEWEST) {
        let thin = airframe.skids_less(eas_to_tas(flown[flown.len() / 2].height_amsl_m));
        airframe.skid = (1.0 / turn.clamp(0.4, 1.0) - 1.0).max(0.0) * thin;
    }
    if lifts.count >= FEWEST as f64 {
        let (level, attack) = lifts.solve();
        airframe.level_pitch_rad = level;
        airframe.attack_rad = attack.filter(|attack| (0.01..0.3).contains(attack)).unwrap_or(airframe.attack_rad);
    }
    if let Some(throttle) = median(&mut throttles).filter(|_| throttles.len() >= FEWEST) {
        airframe.throttle_cruise = throttle.clamp(0.02, 0.98);
        (airframe.drag_m_s2, airframe.thrust_full_m_s2) = drag_and_thrust(&pulls, &airframe);
        if let Some((full, still)) = propeller(&pulls, &airframe) {
            (airframe.thrust_full_m_s2, airframe.thrust_static_m_s2) = (full, Some(still));
        }
    }
    airframe.ground_drag_m_s2 = ground_drag(&rolled, &airframe).or(airframe.ground_drag_m_s2);
    airframe.power_cruise_w = median(&mut powers).or(airframe.power_cruise_w);
    airframe.voltage_v = median(&mut volts).or(airframe.voltage_v);
    airframe.power_exponent = power_exponent(&pulls, &airframe).unwrap_or(airframe.power_exponent);
    let from_deg = crate::geodesy::wrap_360_deg((-wind).bearing_rad().to_degrees());
    Some(Learned {
        airframe,
        wind: Wind { from_deg, speed_m_s: wind.length() },
        moments: flown.len(),
        airspeed_error_m_s,
    })
}

/// Wind, pitot ratio and RMS of what is left, m/s, by Gauss's and Newton's method.
fn wind_and_pitot(flown: &[Recorded], factor: impl Fn(&Recorded) -> f64) -> Option<(NorthEast, f64, f64)> {
    let (mut wind, mut pitot, mut error) = (NorthEast::default(), 1.0, f64::INFINITY);
    for _ in 0..15 {
        // Normal equations of the residual's derivatives by north, east and pitot.
        let (mut normal, mut right, mut squares) = ([[0.0; 3]; 3], [0.0; 3], 0.0);
        for moment in flown {
            let air = moment.velocity - wind;
            let speed = air.length().hypot(moment.climb_m_s).max(0.5);
            let indicated = moment.airspeed_m_s * factor(moment);
            let residual = speed - pitot * indicated;
            let slopes = [-air.north / speed, -air.east / speed, -indicated];
            for row in 0..3 {
                right[row] -= slopes[row] * residual;
                for column in 0..3 {
                    normal[row][column] += slopes[row] * slopes[column];
                }
            }
            squares += residual * residual;
        }
        let count = flown.len() as f64;
        // On one course alone, wind and pitot error cannot be separated.
        let step = solve(normal, right, count)?;
        wind = wind + NorthEast::new(step[0], step[1]);
        pitot += step[2];
        error = (squares / count).sqrt();
    }
    ((0.5..2.0).contains(&pitot) && wind.length() < 60.0 && error.is_finite()).then_some((wind, pitot, error))
}

/// Three linear equations by Cramer's rule; `None` where they nearly are fewer, `count` being their weight.
fn solve(matrix: [[f64; 3]; 3], right: [f64; 3], count: f64) -> Option<[f64; 3]> {
    let det = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = det(&matrix);
    // The directions flown: as a part of the mean square speed, 1 for all directions alike.
    let spread = whole / (count * count * matrix[2][2].max(1e-9));
    if !spread.is_finite() || spread < 0.01 {
        return None;
    }
    let mut solved = [0.0; 3];
    for (column, value) in solved.iter_mut().enumerate() {
        let mut replaced = matrix;
        for row in 0..3 {
            replaced[row][column] = right[row];
        }
        *value = det(&replaced) / whole;
    }
    Some(solved)
}

/// Each moment with those half of [`RATE_S`] before and after it.
fn around(flown: &[Recorded]) -> impl Iterator<Item = (&Recorded, &Recorded, &Recorded)> {
    let (mut first, mut last) = (0, 0);
    flown.iter().filter_map(move |now| {
        while flown.get(first + 1).is_some_and(|next| next.time_s <= now.time_s - RATE_S / 2.0) {
            first += 1;
        }
        while flown.get(last).is_some_and(|next| next.time_s < now.time_s + RATE_S / 2.0) {
            last += 1;
        }
        let (before, after) = (flown.get(first)?, flown.get(last)?);
        let dt = after.time_s - before.time_s;
        (0.5 * RATE_S..2.0 * RATE_S).contains(&dt).then_some((before, now, after))
    })
}

/// A moment with wings level and the throttle held.
struct Pull {
    throttle: f64,
    airspeed_m_s: f64,
    /// Thrust less drag.
    excess_m_s2: f64,
    power_w: Option<f64>,
}

impl Pull {
    fn of(before: &Recorded, now: &Recorded, after: &Recorded, excess_m_s2: f64) -> Self {
        Self {
            throttle: mean_throttle(before, now, after),
            airspeed_m_s: now.airspeed_m_s,
            excess_m_s2,
            power_w: now.power_w,
        }
    }
}

fn mean_throttle(before: &Recorded, now: &Recorded, after: &Recorded) -> f64 {
    (before.throttle + now.throttle + after.throttle) / 3.0
}

/// Drag in level flight at cruise and thrust at full throttle, m/s², as [`Airframe::thrust`] and [`Airframe::drag`]
/// have them between their known points; values without moments are kept.
///
/// Each comes from moments with its own end of the throttle. In level flight thrust equals drag, so those moments,
/// which are most, determine neither: a line through all of them underestimates both. And a propeller gives more than
/// twice as much at full throttle as at half.
fn drag_and_thrust(pulls: &[Pull], airframe: &Airframe) -> (f64, f64) {
    let cruise = airframe.throttle_cruise;
    let unit = Airframe { drag_m_s2: 1.0, ..*airframe };
    let polar = |pull: &Pull| unit.drag(pull.airspeed_m_s, 1.0);
    let (mut xx, mut xy, mut count) = (0.0, 0.0, 0);
    for pull in pulls {
        let x = polar(pull) - pull.throttle / cruise;
        if x > CLEAR && pull.excess_m_s2 < -SINKS_M_S2 {
            (xx, xy, count) = (xx + x * x, xy - x * pull.excess_m_s2, count + 1);
        }
    }
    let drag = if count >= A_FEW {
        xy / xx
    } else {
        // Without thrust a plane is held back by no less than with some.
        let mut seen: Vec<f64> = pulls.iter().map(|pull| -pull.excess_m_s2 / polar(pull)).collect();
        seen.sort_by(f64::total_cmp);
        seen.get(seen.len() * 19 / 20).copied().unwrap_or(0.0).max(airframe.drag_m_s2)
    };
    let drag = drag.clamp(0.1, 10.0);
    let (mut xx, mut xy, mut count) = (0.0, 0.0, 0);
    for pull in pulls.iter().filter(|pull| pull.excess_m_s2 > CLIMBS_M_S2) {
        let x = (pull.throttle - cruise) / (1.0 - cruise);
        if x > HIGH_PART {
            (xx, xy, count) = (xx + x * x, xy + x * (pull.excess_m_s2 - drag * (1.0 - polar(pull))), count + 1);
        }
    }
    let above = if count >= A_FEW { xy / xx } else { airframe.thrust_full_m_s2 - airframe.drag_m_s2 };
    (drag, drag + above.clamp(0.1 * drag, 30.0))
}

/// Thrust at full throttle at cruise and standing still, m/s², by least squares on the propeller's law of
/// [`Airframe::thrust`]; `None` where the flight shows too little of it, or no propeller.
///
/// In level flight at cruise thrust is drag, so that with the drag known one number is free: the law's T = Ts θ² − (Ts
/// θc − D / θc) θ V / Vc.
fn propeller(pulls: &[Pull], airframe: &Airframe) -> Option<(f64, f64)> {
    if airframe.is_simulated {
        return None; // its thrust is another law's
    }
    let (cruise, drag) = (airframe.throttle_cruise, airframe.drag_m_s2);
    let (mut xx, mut xy, mut count) = (0.0, 0.0, 0);
    for pull in pulls.iter().filter(|pull| pull.throttle > PULLS * cruise) {
        let (throttle, fast) = (pull.throttle, pull.airspeed_m_s / airframe.cruise_m_s);
        let x = throttle * (throttle - cruise * fast);
        let pulled = pull.excess_m_s2 + airframe.drag(pull.airspeed_m_s, 1.0) - drag * fast * throttle / cruise;
        (xx, xy) = (xx + x * x, xy + x * pulled);
        count += usize::from(throttle > cruise + HELD);
    }
    let still = xy / xx;
    let full = still - (still * cruise - drag / cruise);
    let is_propeller = count >= A_FEW && full > 1.1 * drag && still > full && still < MOST_STATIC * GRAVITY_M_S2;
    is_propeller.then_some((full, still))
}

/// Mean deceleration on the ground in addition to drag, m/s²; `None` where the flight shows too little of it.
fn ground_drag(rolled: &[Recorded], airframe: &Airframe) -> Option<f64> {
    let (mut way, mut work, mut count) = (0.0, 0.0, 0);
    for (before, now, after) in around(rolled) {
        let speed = |moment: &Recorded| moment.velocity.length();
        let slows = (speed(before) - speed(after)) / (after.time_s - before.time_s);
        let held_m_s2 = slows - airframe.drag(now.airspeed_m_s, 0.0);
        (way, work, count) = (way + speed(now), work + speed(now) * held_m_s2, count + 1);
    }
    (count >= A_FEW / 2).then(|| (work / way).clamp(0.05, 20.0))
}

/// Exponent of the power over the throttle, by least squares of the logarithms away from cruise; `None` where the
/// flight shows cruise alone.
fn power_exponent(pulls: &[Pull], airframe: &Airframe) -> Option<f64> {
    let cruise_w = airframe.power_cruise_w?;
    let (mut xx, mut xy, mut count) = (0.0, 0.0, 0);
    for (pull, power_w) in pulls.iter().filter_map(|pull| Some((pull, pull.power_w.filter(|power_w| *power_w > 0.0)?)))
    {
        let x = (pull.throttle.max(0.01) / airframe.throttle_cruise).ln();
        if x.abs() > AWAY && pull.throttle > IDLE {
            (xx, xy, count) = (xx + x * x, xy + x * (power_w / cruise_w).ln(), count + 1);
        }
    }
    (count >= A_FEW).then(|| (xy / xx).clamp(1.0, 4.0))
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Sums of a line `y = a + b x`.
#[derive(Default)]
struct Lines {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Lines {
    fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    /// a, and b where x differed enough.
    fn solve(&self) -> (f64, Option<f64>) {
        let (x, y) = (self.x / self.count, self.y / self.count);
        let variance = self.xx / self.count - x * x;
        if variance < 0.005 {
            return (y, None);
        }
        let slope = (self.xy / self.count - x * y) / variance;
        (y - slope * x, Some(slope))
    }
}
