//! Fences and rally points as older programs keep them: a line for each point, without a heading.
//!
//! A fence (`.fen`, `fence.txt` of Mission Planner, APM Planner and MAVProxy) is latitude and longitude: first the
//! point to return to, then the corners, of which the last is the first again. Rally points (`.ral`, `rally.txt`) begin
//! with `RALLY`, then latitude, longitude, height, break altitude, landing direction and flags (`RALLY_FLAGS`). Lines
//! that begin with `#` are comments.

use crate::error::{FlightError, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::text::{number, shown, too_many};
use crate::geodesy::GeoPoint;
use crate::plan::{Fence, FenceShape, FenceZone, MavFrame, Rally, RallyPoint};

/// `RALLY_FLAGS`: land at once, which current rally points do not support.
const LAND_IMMEDIATELY: u8 = 2;
/// `RALLY_FLAGS`: what the height is counted from is said.
const ALT_FRAME_VALID: u8 = 4;
/// `RALLY_FLAGS`: what it is counted from.
const ALT_FRAME: u8 = 24;

/// What begins like a list of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PointList {
    /// Latitude and longitude.
    Fence,
    /// `RALLY` and what belongs to it.
    Rally,
}

/// Which list of points a text is, if it is one, by its first line that is not a comment.
pub(super) fn point_list_of(text: &str) -> Option<PointList> {
    let (_, first) = lines(text).next()?;
    let mut words = first.split_whitespace();
    match (words.next()?, words.next(), words.next()) {
        ("RALLY", Some(_), _) => Some(PointList::Rally),
        (lat, Some(lon), None) => {
            let is_number = |word: &str| word.replacen(',', ".", 1).parse::<f64>().is_ok_and(f64::is_finite);
            (is_number(lat) && is_number(lon)).then_some(PointList::Fence)
        }
        _ => None,
    }
}

fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn bad(line: usize, problem: impl Into<String>) -> FlightError {
    FlightError::BadLine { line, problem: problem.into() }
}

fn point(line: usize, lat: &str, lon: &str) -> Result<GeoPoint> {
    let degrees = |text, name| number(text, name).map_err(|problem| bad(line, problem));
    GeoPoint::new(degrees(lat, "latitude")?, degrees(lon, "longitude")?).map_err(|error| bad(line, error.to_string()))
}

/// Reads a fence: one polygon to stay inside, and the point to return to.
pub(super) fn read_fence_points(text: &str) -> Result<Fence> {
    let mut points = Vec::new();
    let mut last = 1;
    for (line, row) in lines(text) {
        let words: Vec<&str> = row.split_whitespace().take(3).collect();
        let [lat, lon] = words.as_slice() else {
            return Err(bad(
                line,
                format!("is \"{}\" where latitude and longitude of a fence point belong", shown(row)),
            ));
        };
        points.push(point(line, lat, lon)?);
        if let Some(problem) = too_many(points.len()) {
            return Err(bad(line, problem));
        }
        last = line;
    }
    match points.as_slice() {
        [return_point, corners @ .., closing] if corners.first() == Some(closing) => {
            let fence = Fence {
                zones: vec![FenceZone { inclusion: true, shape: FenceShape::Polygon { vertices: corners.to_vec() } }],
                return_point: Some((*return_point, 0.0)),
            };
            fence.validate().map_err(|error| match error {
                FlightError::BadFence { problem, .. } => bad(last, problem),
                other => other,
            })?;
            Ok(fence)
        }
        [first, .., closing] if first == closing => Err(bad(
            last,
            "is the first point again: that is the outline of an area (.poly), not a fence; a fence begins with the point to return to, so insert it",
        )),
        _ => Err(bad(
            last,
            "ends the fence, but it is not the first corner (the second point) again; a fence is the point to return to, then its corners, closed by the first",
        )),
    }
}

/// Reads rally points. Landing instructions, which current rally points do not support, become a note.
pub(super) fn read_rally_points(text: &str, notes: &mut Notes) -> Result<Rally> {
    let mut rally = Rally::default();
    for (line, row) in lines(text) {
        let words: Vec<&str> = row.split_whitespace().take(8).collect();
        let ["RALLY", lat, lon, alt, break_alt, landing_direction, flags] = words.as_slice() else {
            return Err(bad(
                line,
                format!(
                    "is \"{}\"; a rally point is RALLY, latitude, longitude, height, break altitude, landing direction, flags",
                    shown(row)
                ),
            ));
        };
        let value = |text, name| number(text, name).map_err(|problem| bad(line, problem));
        let flags = value(flags, "flags")?;
        if flags.fract() != 0.0 || !(0.0..256.0).contains(&flags) {
            return Err(bad(line, format!("has {flags} as its flags; that is a whole number from 0 to 255")));
        }
        let flags = flags as u8;
        if flags & LAND_IMMEDIATELY != 0 {
            return Err(bad(
                line,
                "asks to land at the rally point (flag 2), which no rally point can today; clear the flag and give the mission a landing",
            ));
        }
        let landing = [value(break_alt, "break altitude")?, value(landing_direction, "landing direction")?];
        let says_more = landing != [0.0; 2] || flags & !(ALT_FRAME_VALID | ALT_FRAME) != 0;
        notes.add(NoteCode::RallyLandingsNotKept, usize::from(says_more));
        let frame = match (flags & ALT_FRAME_VALID != 0, (flags & ALT_FRAME) >> 3) {
            (true, 0) => MavFrame::Global,
            (true, 2) => {
                return Err(bad(line, "counts its height from the origin; count it from home, the sea or the terrain"));
            }
            (true, 3) => MavFrame::GlobalTerrainAlt,
            _ => MavFrame::GlobalRelativeAlt,
        };
        let point = RallyPoint { point: point(line, lat, lon)?, alt_m: value(alt, "height")?, frame };
        point.fault().map_or(Ok(()), |fault| Err(bad(line, fault)))?;
        rally.points.push(point);
        if let Some(problem) = too_many(rally.points.len()) {
            return Err(bad(line, problem));
        }
    }
    Ok(rally)
}
