//! Landings: design of one, alternatives to choose from, and moving a part of one.

use vencejo_flight::approaches::{self, Runway, Site, landing_alternatives, move_landing, options_of};
use vencejo_flight::ending::{comes_from, towards_end};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::ground::GroundMap;
use vencejo_flight::landing::{LandingOptions, Wind};
use vencejo_flight::plan::{Home, Mission, Plan};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions};

use crate::assess::way_of;
use crate::convert;
use crate::dto::{Landing, LandingAlternative, LandingMove, LandingRequest};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::in_turn;

/// Largest number of items of a landing.
const MOST_ITEMS: usize = 3;

/// Designs a landing, over the terrain of the maps if home is known.
///
/// # Errors
/// When both or neither of point and runway are given, and as for [`approaches::design`].
pub(crate) async fn designed(app: &App, asked: &LandingRequest) -> Result<Landing, Problem> {
    let site = site(asked)?;
    let options = with_plane(app, asked.vehicle, asked.wind, |usual, _| usual);
    let options = convert::landing_options(asked, options)?;
    let options = match plan(asked)? {
        Some(plan) => towards_end(&plan.mission, &way_of(app.vehicle(asked.vehicle).as_ref(), &plan.mission), options),
        None => options,
    };
    let Some(home) = home(app, asked)? else {
        return Ok(convert::landing(&approaches::design(site, &options, None)?));
    };
    let map = ground(app, asked, site, home).await;
    let below = |at| Some(map.height_m(at)? - map.height_m(home)?);
    Ok(convert::landing(&approaches::design(site, &options, Some(&below))?))
}

/// Landings to choose from, the best first, over the terrain of the maps if home is known.
///
/// # Errors
/// As for [`designed`].
pub(crate) async fn alternatives(app: App, asked: LandingRequest) -> Result<Vec<LandingAlternative>, Problem> {
    let site = site(&asked)?;
    let at = home(&app, &asked)?;
    let map = match at {
        Some(home) => Some(ground(&app, &asked, site, home).await),
        None => None,
    };
    let mission = plan(&asked)?.map(|plan| plan.mission);
    let way = |mission: &Mission| way_of(app.vehicle(asked.vehicle).as_ref(), mission);
    let from = mission.and_then(|mission| comes_from(&mission, &way(&mission)));
    in_turn(move || {
        let below = |point| map.as_ref().and_then(|map| map.height_m(point));
        let found = with_plane(&app, asked.vehicle, asked.wind, |usual, conditions| {
            let alt_amsl_m = at.and_then(below).unwrap_or(0.0);
            let home = at.map(|at| Home { lat_deg: at.lat_deg(), lon_deg: at.lon_deg(), alt_amsl_m });
            let conditions = Conditions { home: conditions.home.or(home), ground: Some(&below), ..*conditions };
            let options = convert::landing_options(&asked, usual)?;
            landing_alternatives(
                site,
                &LandingOptions { coming_from: from.or(options.coming_from), ..options },
                &conditions,
            )
        })?;
        Ok(found.iter().map(convert::landing_alternative).collect())
    })
    .await
}

/// Home position: from the request, else its plan, else the vehicle.
fn home(app: &App, asked: &LandingRequest) -> Result<Option<GeoPoint>, Problem> {
    let vehicle = app.vehicle(asked.vehicle);
    let planned = asked.plan.as_ref().and_then(|plan| plan.home);
    let known = || planned.or_else(|| vehicle.and_then(|vehicle| vehicle.home())).and_then(|home| home.point().ok());
    Ok(asked.home.map(convert::point).transpose()?.or_else(known))
}

/// Plan that the landing is to end.
fn plan(asked: &LandingRequest) -> Result<Option<Plan>, Problem> {
    Ok(asked.plan.as_ref().map(convert::core_plan).transpose()?)
}

/// Terrain around a landing position. It is loaded first if the request names home or a plan.
async fn ground(app: &App, asked: &LandingRequest, site: Site, home: GeoPoint) -> GroundMap {
    let plan = site.surroundings();
    let place = Home { lat_deg: home.lat_deg(), lon_deg: home.lon_deg(), alt_amsl_m: 0.0 };
    if asked.home.is_some() || asked.plan.is_some() {
        app.wait_for_ground(&plan, Some(place)).await;
    }
    app.ground_around(&plan, Some(place)).0
}

/// Moves one part of a landing.
///
/// # Errors
/// As for [`move_landing`].
pub(crate) fn moved(app: &App, asked: &LandingMove) -> Result<Landing, Problem> {
    // A longer list is not a landing and is not examined.
    let items: Vec<_> = asked.items.iter().take(MOST_ITEMS + 1).map(convert::core_item).collect();
    let usual = with_plane(app, asked.vehicle, asked.wind, |usual, _| usual);
    let options = LandingOptions { wind: asked.wind, ground_rel_home_m: asked.ground_rel_home_m, ..usual };
    Ok(convert::landing(&move_landing(&items, asked.part, convert::point(asked.to)?, &options)?))
}

fn site(asked: &LandingRequest) -> Result<Site, Problem> {
    match (asked.at, asked.runway) {
        (Some(at), None) => Ok(Site::Point(convert::point(at)?)),
        (None, Some(runway)) => {
            Ok(Site::Runway(Runway::new(convert::point(runway.begin)?, convert::point(runway.end)?)?))
        }
        _ => Err(Problem::invalid("a landing needs a point or a runway: give either `at` or `runway`")),
    }
}

/// Design defaults and rehearsal data of a landing: the vehicle's, else a small plane's.
fn with_plane<T>(
    app: &App,
    vehicle: Option<u16>,
    wind: Option<Wind>,
    something: impl FnOnce(LandingOptions, &Conditions<'_>) -> T,
) -> T {
    let blows = wind.unwrap_or_default();
    let Some(vehicle) = app.vehicle(vehicle) else {
        return something(LandingOptions::default(), &Conditions::new(&Aircraft::default(), Air::from(blows)));
    };
    let (plane, air) = vehicle.flies_in(blows);
    let conditions = Conditions { home: vehicle.home(), ..Conditions::new(&plane, air) };
    something(options_of(&plane, wind), &conditions)
}
