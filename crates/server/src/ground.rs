//! The ground around plans, kept at hand from the maps' elevation: a rehearsal cannot wait for a network while a point is dragged.

use std::time::Duration;

use tokio::time::timeout;
use vencejo_flight::ground::{GroundMap, Square, SquareId, squares_around};
use vencejo_flight::plan::{Home, Plan};
use vencejo_maps::Maps;
use vencejo_maps::geo::Corner;

use crate::state::{App, closed};

/// How long somebody who can wait does.
const PATIENCE: Duration = Duration::from_secs(5);

impl App {
    /// What is known of the ground around a plan, and whether more is on its way. Nothing is waited for.
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

    /// Waits until all is known of the ground around a plan that the maps can tell within some seconds.
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
        // What is late is not known: a rehearsal says so.
        let _ = timeout(PATIENCE, wait).await;
    }

    /// Looks a square up in the background.
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
                        tracing::debug!(%error, "the ground of a rehearsal cannot be looked up");
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
