//! Commanded positions and altitudes that no flight means: out of reach, or under the ground.

use vencejo_flight::checks::{OutOfReach, out_of_reach};
use vencejo_flight::geodesy::{GeoPoint, distance_m};

use super::Context;
use crate::choice::AltFrame;
use crate::error::VehicleError;
use crate::telemetry::Freshness;
use crate::vehicle::raw::invalid;

/// How far below home, or below the ground where the vehicle reports that, a commanded altitude may be, metres: the
/// error of home's own altitude and of terrain maps. An altitude counted from the wrong level is off by far more.
const BELOW_M: f64 = 20.0;
/// Distance from the vehicle within which the ground below it says something about that of a target, metres.
const SAME_GROUND_M: f64 = 500.0;
/// How much lower the ground of a target may be than that below the vehicle, metres for each metre of distance.
const SLOPE: f64 = 0.5;

impl Context<'_> {
    fn home_point(&self) -> Option<GeoPoint> {
        self.telemetry.home.and_then(|home| home.value.point().ok())
    }

    fn here(&self) -> Option<GeoPoint> {
        let position = self.telemetry.position?.value;
        GeoPoint::new(position.lat_deg?, position.lon_deg?).ok()
    }

    /// Refuses a position that is out of reach. Whether it is on Earth is checked where it is sent.
    pub(super) fn in_reach(&self, lat_deg: f64, lon_deg: f64) -> Result<(), VehicleError> {
        let Ok(place) = GeoPoint::new(lat_deg, lon_deg) else { return Ok(()) };
        let Some(OutOfReach { distance_m, is_swapped }) = out_of_reach(place, self.home_point(), self.here()) else {
            return Ok(());
        };
        let expected = if is_swapped {
            "at most 200 km; are latitude and longitude swapped?"
        } else {
            "at most 200 km; check latitude and longitude"
        };
        Err(invalid("the distance from home and the vehicle", format!("{:.0} km", distance_m / 1_000.0), expected))
    }

    /// Refuses an altitude under the ground that the vehicle reports below it (TERRAIN_REPORT), where the target is near,
    /// less what the ground may slope down to there, and otherwise one far below home, unless `below_home` says that it is
    /// meant. `place`: the target's latitude and longitude; `None`: where the vehicle flies.
    pub(super) fn above_ground(
        &self,
        alt_m: f64,
        alt_frame: AltFrame,
        place: Option<(f64, f64)>,
        below_home: bool,
    ) -> Result<(), VehicleError> {
        let home_m = self.telemetry.home.map(|home| home.value.alt_amsl_m);
        let alt_amsl_m = match alt_frame {
            AltFrame::Amsl => Some(alt_m),
            AltFrame::RelHome => home_m.map(|home_m| home_m + alt_m),
            AltFrame::Terrain => None,
        };
        let ground = self.ground_amsl_m(place);
        let (below_m, level, lower_m) = match (alt_frame, alt_amsl_m.zip(ground), alt_amsl_m.zip(home_m)) {
            (AltFrame::Terrain, ..) => (-alt_m, "the ground", 0.0),
            (_, Some((alt_amsl_m, (ground_m, distance_m))), _) => {
                (ground_m - alt_amsl_m, "the ground under the vehicle", distance_m * SLOPE)
            }
            (_, None, Some((alt_amsl_m, home_m))) => (home_m - alt_amsl_m, "home", 0.0),
            (AltFrame::RelHome, None, None) => (-alt_m, "home", 0.0),
            (AltFrame::Amsl, None, None) => return Ok(()),
        };
        if below_home || below_m <= BELOW_M + lower_m || below_m.is_nan() {
            return Ok(());
        }
        let expected = if lower_m > 0.0 {
            "at most 20 m plus half the distance below it, unless below_home is set; is it counted from another level?"
        } else {
            "at most 20 m below it, unless below_home is set; is it counted from another level?"
        };
        Err(invalid("alt_m", format!("{below_m:.0} m below {level}"), expected))
    }

    /// The ground that the vehicle reports below it, and the distance to `place`, if that is recent and `place` is near.
    fn ground_amsl_m(&self, place: Option<(f64, f64)>) -> Option<(f64, f64)> {
        let terrain = self.telemetry.terrain.filter(|terrain| terrain.freshness(self.now) == Freshness::Fresh)?;
        let distance_m = match place {
            Some((lat_deg, lon_deg)) => distance_m(self.here()?, GeoPoint::new(lat_deg, lon_deg).ok()?),
            None => 0.0,
        };
        terrain.value.ground_amsl_m.filter(|_| distance_m <= SAME_GROUND_M).map(|ground_m| (ground_m, distance_m))
    }
}
