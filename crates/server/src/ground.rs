//! Terrain around plans, cached from the maps' elevation sources: a rehearsal cannot wait for a network while a point
//! is dragged.

use std::time::Duration;

use tokio::time::timeout;
use vencejo_flight::ground::{GroundMap, Square, SquareId, squares_around};
use vencejo_flight::plan::{Home, Plan};
use vencejo_maps::Maps;
use vencejo_maps::geo::Corner;

use crate::state::{App, closed};

/// Time limit for callers that can wait.
const PATIENCE: Duration = Duration::from_secs(5);

impl App {
    /// Terrain around a plan as loaded so far, and whether more is being loaded. Does not wait.
    pub fn ground_around(&self, plan: &Plan, home: Option<Home>) -> (GroundMap, bool) {
        let Ok(maps) = self.maps() else { return (GroundMap::default(), false) };
        let ids = squares_around(plan, home);
        let grounds = self.grounds();
        let (map, open) = grounds.take(&ids);
        for id in open {
            self.look_up(maps.clone(), id);
        }
        (map, grounds.is_pending(&ids))
    }

    /// Waits, for at most some seconds, until the terrain around a plan is loaded.
    pub async fn wait_for_ground(&self, plan: &Plan, home: Option<Home>) {
        let mut arrived = self.grounds().arrived.subscribe();
        let (_, mut is_pending) = self.ground_around(plan, home);
        if !is_pending {
            return;
        }
        let ids = squares_around(plan, home);
        let wait = async {
            while is_pending && arrived.changed().await.is_ok() {
                is_pending = self.grounds().is_pending(&ids);
            }
        };
        // Terrain that is late counts as unknown, which a rehearsal reports.
        let _ = timeout(PATIENCE, wait).await;
    }

    /// Loads a square in the background.
    fn look_up(&self, maps: Maps, id: SquareId) {
        let Some(alive) = self.alive() else {
            self.grounds().keep(id, None);
            return;
        };
        let (app, mut closing) = (self.clone(), self.closing());
        let turns = self.grounds().turns.clone();
        tokio::spawn(async move {
            let look = async {
                let _turn = turns.acquire_owned().await;
                let places: Vec<_> = id.places().map(|(lat_deg, lon_deg)| Corner { lat_deg, lon_deg }).collect();
                match maps.heights(&places).await {
                    Ok((points, _)) => Square::new(points.into_iter().map(|point| point.alt_amsl_m)),
                    Err(error) => {
                        tracing::debug!(%error, "the terrain of a rehearsal cannot be loaded");
                        Square::new([])
                    }
                }
            };
            let square = tokio::select! {
                square = look => Some(square),
                () = closed(&mut closing) => None,
            };
            app.grounds().keep(id, square);
            drop(alive);
        });
    }
}
