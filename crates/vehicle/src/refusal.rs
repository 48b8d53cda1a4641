//! Reasons of an autopilot's refusals, recognised by its texts, and their remedies.
//!
//! ArduPilot gives its reasons only as texts (`STATUSTEXT`: "PreArm: …", "Arm: …"), defined in `AP_Arming` and
//! `AP_Arming_Plane`.

use vencejo_flight::plan::Command;

use crate::command::CommandResult;

/// Declares the reasons with a known remedy.
macro_rules! refusals {
    ($($name:ident, $code:literal, $remedy:literal, [$([$($word:literal),+]),+];)+) => {
        /// The reason of a refusal.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Refusal {
            $(#[doc = $remedy] $name,)+
        }

        impl Refusal {
            /// All reasons; the first that matches a text applies.
            pub const ALL: &'static [Self] = &[$(Self::$name),+];

            /// A stable name for programs.
            pub const fn code(self) -> &'static str {
                match self { $(Self::$name => $code,)+ }
            }

            /// The remedy, in English.
            pub const fn remedy(self) -> &'static str {
                match self { $(Self::$name => $remedy,)+ }
            }

            /// Patterns of its texts: words in this order.
            const fn texts(self) -> &'static [&'static [&'static str]] {
                match self { $(Self::$name => &[$(&[$($word),+]),+],)+ }
            }
        }
    };
}

refusals! {
    LandingNeedsRtlAutoland, "landing-needs-rtl-autoland", "set parameter RTL_AUTOLAND to 2 (or 1), or take DO_LAND_START out of the mission",
        [["do_land_start", "rtl_autoland"]];
    NoMission, "no-mission", "send a mission",
        [["no mission"], ["mission", "missing"], ["mission", "empty"], ["missing", "mission"], ["auto", "mission"]];
    ModeNotArmable, "mode-not-armable", "prepare the flight (it changes to a mode that arms), or choose MANUAL or FBWA",
        [["not armable"]];
    LandingSequence, "landing-sequence", "prepare the flight: it changes to MANUAL and sets the mission back to its beginning",
        [["in landing sequence"]];
    GpsAccuracy, "gps-accuracy", "wait until the GPS is more accurate, away from buildings and trees",
        [["gps", "accuracy"], ["gps", "hdop"], ["gps", "speed error"], ["gps", "horiz error"], ["gps", "vert"]];
    GpsNoFix, "gps-no-fix", "wait until the GPS has a 3D fix, under open sky",
        [["gps", "bad fix"], ["gps", "no fix"], ["gps", "not healthy"], ["gps", "unhealthy"], ["gps", "waiting"], ["gps", "not found"],
         ["gps", "no gps"], ["gps", "3d"], ["bad gps"], ["need 3d fix"]];
    PositionUnknown, "position-unknown", "wait for GPS and position estimate: up to a minute after the start",
        [["need position"], ["position estimate"], ["waiting for home"], ["home not set"], ["no position"], ["ekf", "not started"], ["ekf", "pos"]];
    CompassInconsistent, "compass-inconsistent", "move away from metal and magnets; calibrate all compasses if it stays",
        [["compass", "inconsistent"], ["compass", "disagree"]];
    CompassCalibrate, "compass-calibrate", "move away from metal and magnets; calibrate the compass if it stays",
        [["compass"], ["mag field"]];
    AccelsInconsistent, "accels-inconsistent", "let the plane stand still for a minute; calibrate the accelerometers if it stays",
        [["accel", "inconsistent"]];
    AccelsCalibrate, "accels-calibrate", "calibrate the accelerometers and reboot", [["accel"]];
    Gyros, "gyros", "let the plane stand still; reboot if it stays", [["gyro"]];
    AhrsWaiting, "ahrs-waiting", "let the plane stand still for a minute", [["ahrs"], ["ekf"], ["attitude"]];
    Airspeed, "airspeed", "cover the pitot tube and calibrate; check the tube and its wiring", [["airspeed"]];
    Barometer, "barometer", "reboot; check that the sensor is not blocked", [["baro"]];
    BoardVoltage, "board-voltage", "check power module, BEC and plugs", [["board", "voltage"], ["servo voltage"], ["vcc"]];
    BatteryLow, "battery-low", "check the battery: charge, connection, and the failsafe's limits", [["batt"]];
    ThrottleNotZero, "throttle-not-zero", "bring the throttle stick to its lowest position",
        [["throttle", "not"], ["throttle", "too high"], ["throttle", "zero"], ["throttle", "idle"], ["throttle", "neutral"]];
    RcNotCalibrated, "rc-not-calibrated", "switch the pilot's radio on; calibrate it", [["=rc"], ["radio calib"]];
    SafetySwitch, "safety-switch", "press the safety switch on the plane until it stops blinking", [["safety"]];
    Failsafe, "failsafe", "look for the failsafe's cause: radio, battery or ground-station link", [["failsafe"]];
    Logging, "logging", "check the autopilot's memory card", [["logging"], ["=log"], ["=logger"], ["sd card"]];
    Fence, "fence", "bring the plane inside the fence, wait for its position, or correct the fence", [["fence"]];
    Rally, "rally", "send rally points within reach, or none", [["rally"]];
    AlreadyArmed, "already-armed", "there is nothing to do", [["already armed"]];
    SystemInitialising, "system-initialising", "wait half a minute", [["initialis"], ["initializ"]];
}

impl Refusal {
    /// The reason that a text of an autopilot gives; `None` when no remedy is known.
    pub fn of(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        Self::ALL.iter().copied().find(|refusal| refusal.texts().iter().any(|words| holds(&text, words)))
    }
}

/// The remedy for a command that an autopilot refused without a text, where one reason is almost certain.
///
/// An ArduPlane takes DO_FENCE_ENABLE when a fence of those asked for is present (`GCS_Fence.cpp`), and loads the one
/// that is stored once it has an origin (`AC_PolyFence_loader.cpp`). It denies a DO_REPOSITION to outside its enabled
/// fences (`AC_Fence::check_destination_within_fence`), and one that `Location::sanitize` completes.
pub(crate) fn remedy_of_silence(command: Command, result: CommandResult) -> Option<&'static str> {
    match (command, result) {
        (Command::DO_FENCE_ENABLE, CommandResult::FAILED) => Some(
            "send a fence, or set FENCE_TYPE; after its start, wait until the plane knows where it is: it loads its fence then",
        ),
        (Command::DO_REPOSITION, CommandResult::DENIED) => Some(
            "choose a position inside the fence (its area, its circle, FENCE_ALT_MIN and FENCE_ALT_MAX), and an altitude above home that is not 0",
        ),
        (Command::DO_CHANGE_SPEED, CommandResult::FAILED | CommandResult::DENIED) => {
            Some("choose a speed in metres per second; an ArduPlane takes airspeeds from AIRSPEED_MIN to AIRSPEED_MAX")
        }
        _ => None,
    }
}

/// The remedies for an autopilot's texts, each once, in the order of the texts.
pub(crate) fn remedies(texts: &[String]) -> Vec<&'static str> {
    let mut found: Vec<&str> = Vec::new();
    for remedy in texts.iter().filter_map(|text| Refusal::of(text)).map(Refusal::remedy) {
        if !found.contains(&remedy) {
            found.push(remedy);
        }
    }
    found
}

/// Whether a lower-case text holds these words in order. A word that begins with `=` has to stand alone, numbered or
/// not.
fn holds(text: &str, words: &[&str]) -> bool {
    let mut rest = text;
    words.iter().all(|word| {
        let found = match word.strip_prefix('=') {
            Some(alone) => rest
                .split(|c: char| !c.is_alphanumeric())
                .any(|one| one.trim_end_matches(|c: char| c.is_ascii_digit()) == alone)
                .then_some(0),
            None => rest.find(word).map(|at| at + word.len()),
        };
        rest = &rest[found.unwrap_or(0)..];
        found.is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_autopilots_are_recognised() {
        // The first two are from a recording of an ArduPlane (arm-refused-and-modes.tlog); the others as ArduPilot
        // writes them.
        for (text, code) in [
            ("Arm: RTL mode not armable", Some("mode-not-armable")),
            ("PreArm: In landing sequence", Some("landing-sequence")),
            ("PreArm: DO_LAND_START set and RTL_AUTOLAND disabled", Some("landing-needs-rtl-autoland")),
            ("PreArm: GPS 1: Bad fix", Some("gps-no-fix")),
            ("PreArm: GPS 1: not healthy", Some("gps-no-fix")),
            ("PreArm: GPS horiz error 5.1m", Some("gps-accuracy")),
            ("PreArm: Need Position Estimate", Some("position-unknown")),
            ("PreArm: AHRS: waiting for home", Some("position-unknown")),
            ("PreArm: Compass not calibrated", Some("compass-calibrate")),
            ("PreArm: Compasses inconsistent", Some("compass-inconsistent")),
            ("PreArm: Accels inconsistent", Some("accels-inconsistent")),
            ("PreArm: 3D Accel calibration needed", Some("accels-calibrate")),
            ("PreArm: Gyros inconsistent", Some("gyros")),
            ("PreArm: Battery 1 below minimum arming voltage", Some("battery-low")),
            ("PreArm: Board (4.1v) out of range 4.3-5.8v voltage", Some("board-voltage")),
            ("PreArm: Throttle (RC3) is not neutral", Some("throttle-not-zero")),
            ("Arm: Throttle too high", Some("throttle-not-zero")),
            ("PreArm: RC not calibrated", Some("rc-not-calibrated")),
            ("PreArm: RC3_MIN is greater than RC3_TRIM", Some("rc-not-calibrated")),
            ("PreArm: Hardware safety switch", Some("safety-switch")),
            ("PreArm: Radio failsafe on", Some("failsafe")),
            ("PreArm: Logging failed", Some("logging")),
            ("PreArm: Search for the source", None),
            ("PreArm: An unknown reason", None),
            ("", None),
        ] {
            assert_eq!(Refusal::of(text).map(Refusal::code), code, "{text}");
        }
    }

    #[test]
    fn each_has_a_name_of_its_own() {
        let mut codes: Vec<_> = Refusal::ALL.iter().map(|refusal| refusal.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), Refusal::ALL.len());
    }
}
