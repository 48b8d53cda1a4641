//! GPX 1.0 and 1.1 (<https://www.topografix.com/GPX/1/1/>): routes, tracks and points of satellite receivers.
//!
//! `ele` is metres above mean sea level. There are no areas, no commands and no other heights.

use std::fmt::Write as _;

use crate::error::{FlightError, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::places::{Feature, Heights, Place, Shape, height_of, plan_of, point_of};
use crate::formats::xml::Element;
use crate::plan::{Command, MavFrame, Plan};
use crate::progress::alt_amsl_m;

/// Reads the routes of a `.gpx`, else its tracks, else its points.
///
/// # Errors
/// [`FlightError::BadFile`] with the point, what is wrong with it and what to do.
pub(super) fn read_gpx(root: &Element, notes: &mut Notes) -> Result<Plan> {
    let (mut routes, mut tracks, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for (number, route) in root.all("rte").enumerate() {
        routes.push(line(route, "rtept", &format!("route {}", number + 1))?);
    }
    for (number, track) in root.all("trk").enumerate() {
        for segment in track.all("trkseg") {
            tracks.push(line(segment, "trkpt", &format!("track {}", number + 1))?);
        }
    }
    for (number, point) in root.all("wpt").enumerate() {
        let name = format!("point {}", number + 1);
        let place = place(point, &name)?;
        points.push(feature(Shape::Point(place), name, is_named(point)));
    }
    // skip lines without points
    let is_there = |feature: &Feature| matches!(&feature.shape, Shape::Line(line) if !line.is_empty());
    routes.retain(is_there);
    tracks.retain(is_there);
    let features = match (routes.is_empty(), tracks.is_empty()) {
        (false, _) => {
            notes.add(NoteCode::TracksLeftOut, tracks.len());
            notes.add(NoteCode::PointsLeftOut, points.len());
            routes
        }
        (true, false) => {
            notes.add(NoteCode::PointsLeftOut, points.len());
            tracks
        }
        (true, true) => points,
    };
    plan_of(&features, notes)
}

fn feature(shape: Shape, name: String, is_named: bool) -> Feature {
    Feature { shape, heights: Heights::Sea, data: Vec::new(), name, is_named }
}

fn is_named(element: &Element) -> bool {
    ["name", "desc", "cmt"].iter().any(|key| element.text_of(key).is_some())
}

fn line(element: &Element, of: &str, name: &str) -> Result<Feature> {
    let mut places = Vec::new();
    let mut has_names = is_named(element);
    for (number, point) in element.all(of).enumerate() {
        places.push(place(point, &format!("{name}, point {}", number + 1))?);
        has_names |= is_named(point);
    }
    Ok(feature(Shape::Line(places), name.to_owned(), has_names))
}

fn place(element: &Element, name: &str) -> Result<Place> {
    let degrees = |key| element.attribute(key).unwrap_or_default();
    let read = || -> std::result::Result<Place, String> {
        let point = point_of(degrees("lat"), degrees("lon"))?;
        Ok(Place { point, alt_m: height_of(element.text_of("ele").unwrap_or_default())? })
    };
    read().map_err(|problem| FlightError::BadFile(format!("{name}: {problem}")))
}

/// Writes the places that a mission flies to as a route.
///
/// # Errors
/// [`FlightError::BadFile`] for a plan without such a place.
pub(super) fn write_gpx(plan: &Plan, notes: &mut Notes) -> Result<String> {
    let Plan { mission, fence, rally } = plan;
    let home_alt_m = mission.home.map(|home| home.alt_amsl_m);
    let mut points = String::new();
    for (index, item) in mission.items.iter().enumerate() {
        let Some(point) = item.point().filter(|_| item.command.is_destination() || item.command.is_takeoff()) else {
            notes.add(NoteCode::ItemsNotWritten, 1);
            continue;
        };
        let _ = write!(points, "<rtept lat=\"{}\" lon=\"{}\">", point.lat_deg(), point.lon_deg());
        match alt_amsl_m(item, home_alt_m).filter(|alt_m| alt_m.is_finite()) {
            Some(alt_m) => {
                let _ = write!(points, "<ele>{alt_m}</ele>");
                let is_changed = item.frame == MavFrame::GlobalRelativeAlt;
                notes.add(NoteCode::HeightsWrittenAboveSeaLevel, usize::from(is_changed));
            }
            None => notes.add(NoteCode::HeightsNotWritten, usize::from(item.alt_m().is_some())),
        }
        let is_plain = item.command == Command::NAV_WAYPOINT
            && item.params[..4].iter().all(|param| param.is_none_or(|value| value == 0.0));
        notes.add(NoteCode::CommandsNotWritten, usize::from(!is_plain));
        let _ = writeln!(points, "<name>{}</name><type>{}</type></rtept>", index + 1, item.command);
    }
    if points.is_empty() {
        return Err(FlightError::BadFile(
            "a .gpx file holds the places of a mission, and this plan has none; save it as .plan".into(),
        ));
    }
    notes.add(NoteCode::HomeNotWritten, usize::from(mission.home.is_some()));
    notes.add(NoteCode::FenceNotWritten, fence.zones.len() + usize::from(fence.return_point.is_some()));
    notes.add(NoteCode::RallyNotWritten, rally.points.len());
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Vencejo\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n\
         <rte><name>Plan</name>\n{points}</rte>\n</gpx>\n"
    ))
}
