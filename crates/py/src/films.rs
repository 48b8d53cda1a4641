//! Formats of recordings that the fleet adds to those of the station.

use std::sync::Arc;

use vencejo_fleet::carrier::open_film;
use vencejo_station::Station;

/// Makes the histories of a fleet's aircraft replayable.
pub fn add(station: &Station) {
    station.add_film_format("mcap", Arc::new(open_film));
}
