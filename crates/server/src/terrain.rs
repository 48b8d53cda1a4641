//! Answers a vehicle's terrain requests from the maps. Requests for unknown terrain stay unanswered.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use vencejo_link::LinkAddress;
use vencejo_maps::Maps;
use vencejo_maps::geo::Corner;
use vencejo_station::{DropOldest, Received, Taken, VehicleHandle};
use vencejo_vehicle::{TERRAIN_REQUEST, TerrainBlock, TerrainRequests};

/// Largest number of waiting requests; the oldest are dropped, and the vehicle repeats them.
const REQUESTS: usize = 16;
/// Interval between answers over a serial port or a radio: an answer's 55 bytes are then less than 8 % of a 57,600 baud
/// line.
const SLOW_PACE: Duration = Duration::from_millis(125);
/// Interval between answers over a network. A grid's 56 are sent in about the 2 s after which ArduPilot requests the
/// next.
const PACE: Duration = Duration::from_millis(40);

/// Subscribes to a vehicle's terrain requests.
pub fn listen(vehicle: &VehicleHandle) -> Arc<DropOldest<Received>> {
    vehicle.subscribe_messages(Some(BTreeSet::from([TERRAIN_REQUEST])), REQUESTS)
}

/// Answers a vehicle's requests until it is gone; without maps all terrain is unknown.
pub async fn serve(maps: Option<&Maps>, vehicle: &VehicleHandle, queue: &DropOldest<Received>) {
    let mut requests = TerrainRequests::default();
    while let Some(received) = queue.take().await {
        let mut next = Some(received);
        let mut all_known = true;
        loop {
            while let Some(received) = next {
                // Undecodable messages are ignored.
                if let Ok(message) = received.frame.decode() {
                    requests.ask(&message);
                    all_known = true;
                }
                next = ready(queue);
            }
            let Some(block) = requests.next() else { break };
            if !vehicle.answer_terrain(&block, heights(maps, &block).await) {
                all_known = false;
                vehicle.tell_terrain(false);
            }
            tokio::time::sleep(pace(vehicle)).await;
            next = ready(queue);
        }
        if all_known {
            vehicle.tell_terrain(true);
        }
    }
}

/// Ground elevations at a block's positions, as far as a map contains them.
async fn heights(maps: Option<&Maps>, block: &TerrainBlock) -> Vec<Option<f64>> {
    let Some(maps) = maps else { return vec![None] };
    let places = block.places().map(|(lat_deg, lon_deg)| Corner { lat_deg, lon_deg });
    match maps.heights(&places).await {
        Ok((points, _)) => points.into_iter().map(|point| point.alt_amsl_m).collect(),
        // Over the pole, or the maps are being closed.
        Err(error) => {
            tracing::debug!(%error, "the terrain for a vehicle cannot be loaded");
            vec![None]
        }
    }
}

fn ready(queue: &DropOldest<Received>) -> Option<Received> {
    match queue.take_ready() {
        Taken::Item(received) => Some(received),
        Taken::TimedOut | Taken::Closed => None,
    }
}

fn pace(vehicle: &VehicleHandle) -> Duration {
    let is_serial = vehicle.link().is_some_and(|(link, ..)| matches!(link.address, LinkAddress::Serial { .. }));
    if is_serial || vehicle.telemetry().0.radio.is_some() { SLOW_PACE } else { PACE }
}
