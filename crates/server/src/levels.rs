//! Conversion of the altitudes of a plan's items to another frame.

use vencejo_flight::plan::{Levels, MavFrame, counted_from};
use vencejo_station::VehicleHandle;

use crate::convert;
use crate::dto::{CountedItems, FrameChange, Unconverted};
use crate::problem::Problem;
use crate::state::App;

/// The items with their altitudes in `frame`, over the terrain of the maps, and those that could not be converted.
///
/// # Errors
/// For an invalid plan.
pub(crate) async fn counted(app: &App, asked: &FrameChange) -> Result<CountedItems, Problem> {
    let plan = convert::core_plan(&asked.plan)?;
    let home = plan.mission.home.or_else(|| app.vehicle(asked.vehicle).as_ref().and_then(VehicleHandle::home));
    let to = MavFrame::from(asked.frame.mav_frame());
    let needs_ground = |frame| frame == MavFrame::GlobalTerrainAlt;
    if needs_ground(to) || plan.mission.items.iter().any(|item| needs_ground(item.frame)) {
        app.wait_for_ground(&plan, home).await;
    }
    let (map, _) = app.ground_around(&plan, home);
    let (mut items, mut unconverted) = (Vec::new(), Vec::new());
    for (index, item) in plan.mission.items.iter().enumerate() {
        let ground_amsl_m = item.point().and_then(|point| map.height_m(point));
        let levels = Levels { home_amsl_m: home.map(|home| home.alt_amsl_m), ground_amsl_m };
        let (counted, unknown) = counted_from(item, to, levels);
        items.push(convert::item(&counted));
        unconverted.extend(unknown.map(|level| Unconverted { item: index + 1, level }));
    }
    Ok(CountedItems { items, unconverted })
}
