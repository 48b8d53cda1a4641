//! Times and positions.

use vencejo_flight::FlightError;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_proto::MonoTime;

use crate::dto;

/// Seconds on the station's clock.
pub(crate) fn seconds(moment: MonoTime) -> f64 {
    moment.as_duration().as_secs_f64()
}

pub(crate) fn point(place: dto::LatLon) -> Result<GeoPoint, FlightError> {
    GeoPoint::new(place.lat_deg, place.lon_deg)
}
