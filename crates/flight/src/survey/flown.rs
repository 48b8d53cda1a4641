//! Coverage of a survey by its rehearsed flight: where each picture is taken, how much of the area they show, and the
//! holes.

use super::design::Survey;
use super::layout::SurveyLine;
use super::region::{Region, range};
use crate::geodesy::{GeoPoint, direct};
use crate::guidance::NorthEast;
use crate::plan::{Home, Mission, Plan};
use crate::progress::Circled;
use crate::rehearsal::{Aircraft, Conditions, Doing, Ground, Rehearsal, Sample, Start, rehearse};

/// Cells that an area is divided into, about.
const CELLS: f64 = 30_000.0;
/// Half of the width that a corridor has at least, in cells: a line between the middles of two rows is half a cell away
/// from both.
const LINE_CELLS: f64 = 0.51;
/// Most holes reported, the largest first.
const MOST_HOLES: usize = 20;
/// A line of sight that goes down by less than this part of its length shows no ground to speak of.
const LEAST_DOWN: f64 = 0.17;
/// Distance from its line within which it is never missed, m.
const FINE_M: f64 = 5.0;

/// A picture, with the plane at that moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photo {
    /// Since the start, s.
    pub time_s: f64,
    /// Where the plane is.
    pub point: GeoPoint,
    /// Height above home, m.
    pub height_m: f64,
    /// Heading of the nose, degrees from true north.
    pub heading_deg: f64,
    /// Bank, degrees, right positive.
    pub bank_deg: f64,
    /// Pitch, degrees.
    pub pitch_deg: f64,
}

/// The pictures of a rehearsed flight, as ArduPilot's camera takes them (`AP_Camera_Backend::update`): one when the
/// straight distance from the last is the one that was ordered, none sooner than `min_interval_s` after it, and where
/// `bank_max_deg` (`CAM_MAX_ROLL`) is above 0, none with more bank than that.
pub fn photographs(flown: &Rehearsal, min_interval_s: f64, bank_max_deg: f64) -> Vec<Photo> {
    let Some(first) = flown.track.first() else { return Vec::new() };
    let plane = Region::around(first.point);
    let mut photos: Vec<Photo> = Vec::new();
    let mut orders = flown.camera.iter().peekable();
    let mut every_m = 0.0;
    // Where distance counts from, and whether a picture that came too soon is still to be taken.
    let (mut counted, mut is_pending): (Option<NorthEast>, bool) = (None, false);
    for pair in flown.track.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        let (start, end) = (plane.at(from.point), plane.at(to.point));
        let span_s = to.time_s - from.time_s;
        let mut part = 0.0;
        loop {
            let order = orders.peek().filter(|order| order.time_s <= to.time_s);
            let until = order.map_or(1.0, |order| ((order.time_s - from.time_s) / span_s).clamp(part, 1.0));
            // Pictures before the next order.
            while part < until || is_pending {
                let allowed = photos.last().map_or(0.0, |photo| (photo.time_s + min_interval_s - from.time_s) / span_s);
                let due = match counted {
                    _ if is_pending => part,
                    Some(last) if every_m > 0.0 => match reaches(start - last, end - start, every_m, part) {
                        Some(due) => due,
                        None => break,
                    },
                    _ => break,
                };
                let at = due.max(allowed);
                if at > until {
                    is_pending |= due <= until;
                    break;
                }
                let photo = between(from, to, at);
                if bank_max_deg > 0.0 && photo.bank_deg.abs() > bank_max_deg && !is_pending {
                    // The next moment of the track looks again.
                    break;
                }
                is_pending = false;
                counted = Some(start + (end - start) * at);
                photos.push(photo);
                part = at;
            }
            part = until;
            let Some(order) = order else { break };
            if let Some(distance_m) = order.every_m {
                every_m = distance_m;
                counted = if distance_m > 0.0 { counted.or(Some(start + (end - start) * part)) } else { None };
            }
            is_pending |= order.is_at_once;
            orders.next();
        }
    }
    photos
}

/// The part of a piece of track, at `from` of it or later, at which its distance from a place is reached; `offset`
/// leads from the place to its start, `way` from its start to its end.
fn reaches(offset: NorthEast, way: NorthEast, distance_m: f64, from: f64) -> Option<f64> {
    if (offset + way * from).length() >= distance_m {
        return Some(from);
    }
    // |offset + way t| = distance, the later of the two.
    let (a, b, c) = (way.dot(way), offset.dot(way), offset.dot(offset) - distance_m * distance_m);
    let root = b * b - a * c;
    let part = (-b + root.max(0.0).sqrt()) / a;
    (a > 0.0 && root >= 0.0 && part <= 1.0).then_some(part)
}

fn between(from: &Sample, to: &Sample, part: f64) -> Photo {
    let mix = |a: f64, b: f64| a + (b - a) * part;
    let turn = |a: f64, b: f64| crate::geodesy::wrap_360_deg(a + crate::geodesy::wrap_180_deg(b - a) * part);
    let lon_deg = from.point.lon_deg() + crate::geodesy::wrap_180_deg(to.point.lon_deg() - from.point.lon_deg()) * part;
    Photo {
        time_s: mix(from.time_s, to.time_s),
        point: GeoPoint::new(mix(from.point.lat_deg(), to.point.lat_deg()), crate::geodesy::wrap_180_deg(lon_deg))
            .unwrap_or(from.point),
        height_m: mix(from.height_m, to.height_m),
        heading_deg: turn(from.heading_deg, to.heading_deg),
        bank_deg: mix(from.bank_deg, to.bank_deg),
        pitch_deg: mix(from.pitch_deg, to.pitch_deg),
    }
}

/// Ground that no picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// Its middle.
    pub point: GeoPoint,
    /// Its size, m².
    pub area_m2: f64,
}

/// A line of the survey as it was flown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlownLine {
    /// Farthest from the line while pictures are taken, m; `None`: it is not flown.
    pub off_m: Option<f64>,
    /// Pictures on it.
    pub photos: usize,
    /// Whether it is not flown, or flown so far aside that no overlap with the next remains.
    pub is_missed: bool,
}

/// Coverage by the pictures of a survey's rehearsed flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// The pictures, in order.
    pub photos: Vec<Photo>,
    /// Corners of the ground that each picture shows, in order around it; `None` for one that looks beyond the horizon,
    /// and without a camera.
    pub footprints: Vec<Option<[GeoPoint; 4]>>,
    /// Part of the area that one picture or more show, 0 to 1; `None` without a camera.
    pub covered: Option<f64>,
    /// Part of the area that as many pictures show as the overlap promises, 0 to 1; `None` without a camera.
    pub overlapped: Option<f64>,
    /// How many that is: a point lies on `⌈1/(1−p)⌉ − 1` pictures of a line and on as many lines, at the least.
    pub views_promised: usize,
    /// The largest holes, at most 20.
    pub holes: Vec<Hole>,
    /// The lines, as [`Survey::lines`].
    pub lines: Vec<FlownLine>,
}

/// Coverage of a survey flown as rehearsed.
///
/// `first_item` is the index in `mission.items` where the survey's items begin. The ground is that of the rehearsal,
/// with the height of home above the sea; `None`: level, at the height that the survey was laid out for. The camera is
/// fixed in the plane and looks down when it flies level: bank and pitch move what it shows.
pub fn coverage(
    survey: &Survey,
    first_item: usize,
    flown: &Rehearsal,
    plane: &Aircraft,
    ground: Option<(&Ground<'_>, f64)>,
) -> Coverage {
    let options = &survey.options;
    let min_interval_s = options.camera.map_or(0.0, |camera| camera.min_interval_s);
    let photos = photographs(flown, min_interval_s, 0.0);
    let lines = survey.lines.iter().map(|line| line_flown(survey, line, first_item, flown, &photos)).collect();
    let mut coverage = Coverage {
        footprints: vec![None; photos.len()],
        photos,
        covered: None,
        overlapped: None,
        views_promised: 0,
        holes: Vec::new(),
        lines,
    };
    let Some((camera, print)) = options.camera.zip(survey.footprint) else { return coverage };
    // A survey was laid out from its shape, so that it is sound.
    let Ok(region) = Region::new(&survey.shape) else { return coverage };
    let level_m = if options.is_above_terrain { 0.0 } else { options.ground_rel_home_m.unwrap_or(0.0) };
    let half = {
        let at_1_m = camera.footprint(1.0, options.is_landscape);
        (0.5 * at_1_m.along_m, 0.5 * at_1_m.across_m)
    };
    let mut grid = Grid::over(&region);
    for (photo, footprint) in coverage.photos.iter().zip(&mut coverage.footprints) {
        let ground_m = ground
            .and_then(|(ground, home_amsl_m)| ground(photo.point).map(|amsl_m| amsl_m - home_amsl_m))
            .unwrap_or(level_m);
        let Some(corners) = shown(photo, region.plane.at(photo.point), photo.height_m - ground_m, half, plane) else {
            continue;
        };
        grid.see(&corners);
        *footprint = Some(corners.map(|corner| region.plane.point(corner)));
    }
    let promised = |size_m: f64, apart_m: f64| ((size_m / apart_m - 1e-9).ceil() - 1.0).max(1.0) as usize;
    let of_a_line = promised(print.along_m, survey.trigger_m.unwrap_or(print.along_m));
    let of_lines = if survey.lines.len() > 1 { promised(print.across_m, survey.spacing_m) } else { 1 };
    coverage.views_promised = of_a_line * of_lines;
    coverage.covered = grid.part_seen(1);
    coverage.overlapped = grid.part_seen(coverage.views_promised);
    coverage.holes = grid.holes(&region);
    coverage
}

/// Flies a survey alone, as it will be flown, and looks at its pictures: from the air, three turns' radii before its
/// first waypoint, at its height and on its course.
///
/// Heights count from the conditions' home; `None`: where the survey is, at the height above the sea that it was laid out
/// for. `None` without a place to begin at.
pub fn rehearse_survey(survey: &Survey, conditions: &Conditions<'_>) -> Option<(Rehearsal, Coverage)> {
    let Conditions { plane, ground, .. } = *conditions;
    let first = survey.items.iter().find_map(|item| item.point())?;
    let home = conditions.home.unwrap_or(Home {
        lat_deg: first.lat_deg(),
        lon_deg: first.lon_deg(),
        alt_amsl_m: survey.options.home_amsl_m,
    });
    let start = Start::Air {
        point: direct(first, survey.course_deg + 180.0, 3.0 * survey.turn_radius_m),
        height_m: survey.height_m + survey.options.ground_rel_home_m.unwrap_or(0.0),
        heading_deg: survey.course_deg,
        airspeed_m_s: survey.options.airspeed_m_s.unwrap_or(plane.airspeed_cruise_m_s),
        index: 0,
        doing: Doing::Mission,
        circled: Circled::Nothing,
    };
    let plan = Plan::from_mission(Mission { home: Some(home), items: survey.items.clone() });
    let level_m = survey.options.ground_rel_home_m;
    let flown = rehearse(&plan, &Conditions { home: Some(home), start, level_m, ..*conditions }).ok()?;
    let coverage = coverage(survey, 0, &flown, plane, ground.map(|ground| (ground, home.alt_amsl_m)));
    Some((flown, coverage))
}

/// A line between the moments when its first and its last waypoint count.
fn line_flown(survey: &Survey, line: &SurveyLine, first_item: usize, flown: &Rehearsal, photos: &[Photo]) -> FlownLine {
    let reached = |item: usize| {
        let mut passages = flown.passages.iter();
        passages.find(|passage| passage.item == first_item + item).and_then(|passage| passage.reached_s)
    };
    let Some((begins_s, ends_s)) = reached(line.entry).zip(reached(line.exit)) else {
        return FlownLine { off_m: None, photos: 0, is_missed: true };
    };
    let Some(first) = line.points.first() else { return FlownLine { off_m: None, photos: 0, is_missed: true } };
    let plane = Region::around(*first);
    let points: Vec<NorthEast> = line.points.iter().map(|point| plane.at(*point)).collect();
    let off_m = |at: NorthEast| {
        let sides = points.windows(2).map(|pair| {
            let side = pair[1] - pair[0];
            let along = ((at - pair[0]).dot(side) / side.dot(side).max(1e-9)).clamp(0.0, 1.0);
            (pair[0] + side * along - at).length()
        });
        range(sides).0
    };
    let is_within = |time_s: f64| (begins_s..=ends_s).contains(&time_s);
    let samples = flown.track.iter().filter(|sample| is_within(sample.time_s));
    let (_, worst_m) = range(samples.map(|sample| off_m(plane.at(sample.point))));
    let worst_m = worst_m.max(0.0);
    let spare_m = survey.footprint.map_or(0.5 * survey.spacing_m, |print| print.across_m - survey.spacing_m);
    FlownLine {
        off_m: Some(worst_m),
        photos: photos.iter().filter(|photo| is_within(photo.time_s)).count(),
        is_missed: worst_m > (0.5 * spare_m).max(FINE_M),
    }
}

/// The corners of the ground that a picture shows, from a height above it; `half` is half a picture along and across at
/// 1 m.
///
/// Rays through the corners of the sensor, turned by heading, pitch above that of level flight, and bank (the aerospace
/// sequence 3-2-1: B. L. Stevens, F. L. Lewis, "Aircraft Control and Simulation", eq. 1.3-20), down to level ground.
/// `None` where one does not go down.
fn shown(
    photo: &Photo,
    at: NorthEast,
    above_m: f64,
    (half_along, half_across): (f64, f64),
    plane: &Aircraft,
) -> Option<[NorthEast; 4]> {
    let (sin_yaw, cos_yaw) = photo.heading_deg.to_radians().sin_cos();
    let (sin_pitch, cos_pitch) = (photo.pitch_deg.to_radians() - plane.airframe.level_pitch_rad).sin_cos();
    let (sin_bank, cos_bank) = photo.bank_deg.to_radians().sin_cos();
    let corner = |(ahead, right): (f64, f64)| {
        let (right_1, down_1) = (right * cos_bank - sin_bank, right * sin_bank + cos_bank);
        let (ahead_2, down_2) = (ahead * cos_pitch + down_1 * sin_pitch, down_1 * cos_pitch - ahead * sin_pitch);
        let length = (ahead_2 * ahead_2 + right_1 * right_1 + down_2 * down_2).sqrt();
        let ray = NorthEast::new(cos_yaw * ahead_2 - sin_yaw * right_1, sin_yaw * ahead_2 + cos_yaw * right_1);
        (down_2 > LEAST_DOWN * length && above_m > 0.0).then(|| at + ray * (above_m / down_2))
    };
    let (a, c) = (half_along, half_across);
    Some([corner((a, -c))?, corner((a, c))?, corner((-a, c))?, corner((-a, -c))?])
}

/// An area in cells, with how many pictures show each.
struct Grid {
    origin: NorthEast,
    cell_m: f64,
    rows: usize,
    columns: usize,
    /// `None` outside the area.
    views: Vec<Option<u32>>,
}

impl Grid {
    fn over(region: &Region) -> Self {
        let wide_m = 0.5 * region.width_m.unwrap_or(0.0);
        let (south, north) = range(region.points.iter().map(|at| at.north));
        let (west, east) = range(region.points.iter().map(|at| at.east));
        let origin = NorthEast::new(south - wide_m, west - wide_m);
        let (tall_m, broad_m) = (north - south + 2.0 * wide_m, east - west + 2.0 * wide_m);
        let cell_m = (tall_m * broad_m / CELLS).sqrt().max(tall_m.max(broad_m) / CELLS).max(0.1);
        let count = |size_m: f64| (size_m / cell_m).ceil().max(1.0) as usize;
        let (rows, columns) = (count(tall_m), count(broad_m));
        let mut grid = Self { origin, cell_m, rows, columns, views: Vec::new() };
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        grid.views = cells
            .map(|(row, column)| region.contains(grid.middle(row, column), LINE_CELLS * cell_m).then_some(0))
            .collect();
        grid
    }

    fn middle(&self, row: usize, column: usize) -> NorthEast {
        self.origin + NorthEast::new(row as f64 + 0.5, column as f64 + 0.5) * self.cell_m
    }

    /// Counts a picture in all cells whose middle it shows.
    fn see(&mut self, corners: &[NorthEast; 4]) {
        let cells = |(low, high): (f64, f64), origin: f64, count: usize| {
            let index = |at: f64| ((at - origin) / self.cell_m - 0.5).clamp(-1.0, count as f64);
            (index(low).ceil().max(0.0) as usize)..((index(high).floor() + 1.0).max(0.0) as usize).min(count)
        };
        let rows = cells(range(corners.iter().map(|at| at.north)), self.origin.north, self.rows);
        let columns = cells(range(corners.iter().map(|at| at.east)), self.origin.east, self.columns);
        for row in rows {
            for column in columns.clone() {
                let at = self.middle(row, column);
                // Its corners go round it, one way or the other.
                let turns = (0..4).map(|index| (corners[(index + 1) % 4] - corners[index]).cross(at - corners[index]));
                let (low, high) = range(turns);
                if (low >= 0.0 || high <= 0.0)
                    && let Some(views) = &mut self.views[row * self.columns + column]
                {
                    *views += 1;
                }
            }
        }
    }

    /// Part of the cells that at least `least` pictures show; `None` where the area is narrower than a cell.
    fn part_seen(&self, least: usize) -> Option<f64> {
        let inside = || self.views.iter().flatten();
        let seen = inside().filter(|views| **views as usize >= least).count();
        Some(inside().count()).filter(|count| *count > 0).map(|count| seen as f64 / count as f64)
    }

    /// Cells that no picture shows, as far as they touch.
    fn holes(&self, region: &Region) -> Vec<Hole> {
        let mut is_open: Vec<bool> = self.views.iter().map(|views| *views == Some(0)).collect();
        let mut holes = Vec::new();
        for first in 0..is_open.len() {
            if !is_open[first] {
                continue;
            }
            is_open[first] = false;
            let (mut left, mut sum, mut count) = (vec![first], NorthEast::default(), 0_usize);
            while let Some(cell) = left.pop() {
                let (row, column) = (cell / self.columns, cell % self.columns);
                sum = sum + self.middle(row, column);
                count += 1;
                let beside = [
                    (row > 0).then(|| cell - self.columns),
                    (row + 1 < self.rows).then(|| cell + self.columns),
                    (column > 0).then(|| cell - 1),
                    (column + 1 < self.columns).then(|| cell + 1),
                ];
                for next in beside.into_iter().flatten() {
                    if std::mem::take(&mut is_open[next]) {
                        left.push(next);
                    }
                }
            }
            let middle = sum * (1.0 / count as f64);
            holes.push(Hole { point: region.plane.point(middle), area_m2: count as f64 * self.cell_m * self.cell_m });
        }
        holes.sort_by(|one, other| other.area_m2.total_cmp(&one.area_m2));
        holes.truncate(MOST_HOLES);
        holes
    }
}
