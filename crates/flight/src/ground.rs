//! Ground heights in memory, for callers that cannot wait for a map: squares of a fixed lattice, filled in advance.
//!
//! A rehearsal asks for the ground tens of thousands of times in some milliseconds. [`squares_around`] says which
//! squares a plan needs, [`SquareId::places`] where their heights are wanted, and a [`GroundMap`] of the [`Square`]s
//! answers: bilinearly between the four heights around a place, and `None` where one of them is not known. The lattice
//! does not move with the plan, so that a square that is known remains useful while a point is dragged.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::geodesy::{GeoPoint, direct, inverse};
use crate::plan::{Command, Home, Plan};

/// Heights from one edge of a square to the other, less one.
const CELLS: usize = 30;
/// Heights along an edge.
const SIDE: usize = CELLS + 1;
/// Heights of a square.
pub const SQUARE_HEIGHTS: usize = SIDE * SIDE;
/// Squares of the finest level in a degree: their heights are one second of arc apart, some 30 m, as those of SRTM and
/// Copernicus are.
const PER_DEGREE: i32 = 120;
/// The coarsest level; each has twice the spacing of the one before.
const LEVELS: u8 = 7;
/// Squares of one layer at most: 15 km by 15 km at the finest level and 45° of latitude.
const MOST_SQUARES: usize = 256;
/// How far from a plan's lines and circles ground is wanted, m: turns are wide, and a wind is strong.
const MARGIN_M: f64 = 600.0;

/// A square of the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SquareId {
    level: u8,
    /// From the south pole northward.
    row: i32,
    /// From the date line eastward.
    column: i32,
}

impl SquareId {
    /// Squares in a degree.
    fn per_degree(level: u8) -> f64 {
        f64::from(PER_DEGREE) / f64::from(1_u32 << level)
    }

    /// Squares around the globe.
    fn around(level: u8) -> i32 {
        (360 * PER_DEGREE) >> level
    }

    /// The square that a place lies in, and where in it, in cells northward and eastward.
    fn of(level: u8, point: GeoPoint) -> (Self, [f64; 2]) {
        let along = |degrees: f64| degrees * Self::per_degree(level);
        let (north, east) = (along(point.lat_deg() + 90.0), along(point.lon_deg() + 180.0));
        let id =
            Self { level, row: north.floor() as i32, column: (east.floor() as i32).rem_euclid(Self::around(level)) };
        (id, [north - north.floor(), east - east.floor()].map(|part| part * CELLS as f64))
    }

    /// Where its heights are wanted, latitude and longitude in degrees: rows from south to north, each from west to
    /// east.
    pub fn places(self) -> impl Iterator<Item = (f64, f64)> {
        let step_deg = 1.0 / (Self::per_degree(self.level) * CELLS as f64);
        let at = move |square: i32, cell: usize| (f64::from(square) * CELLS as f64 + cell as f64) * step_deg;
        (0..SQUARE_HEIGHTS).map(move |index| {
            let lat_deg = at(self.row, index / SIDE) - 90.0;
            (lat_deg.clamp(-90.0, 90.0), (at(self.column, index % SIDE) - 180.0).clamp(-180.0, 180.0))
        })
    }
}

/// The heights of a square.
#[derive(Debug, Clone, PartialEq)]
pub struct Square {
    heights: Vec<Option<f32>>,
}

impl Square {
    /// Heights above mean sea level in the order of [`SquareId::places`]; those that are missing or no numbers are not
    /// known.
    pub fn new(heights: impl IntoIterator<Item = Option<f64>>) -> Self {
        let known =
            |height_m: Option<f64>| height_m.filter(|height_m| height_m.is_finite()).map(|height_m| height_m as f32);
        let mut heights: Vec<_> = heights.into_iter().take(SQUARE_HEIGHTS).map(known).collect();
        heights.resize(SQUARE_HEIGHTS, None);
        Self { heights }
    }

    /// Whether all of it is known.
    pub fn is_whole(&self) -> bool {
        self.heights.iter().all(Option::is_some)
    }

    /// Height at a place given in cells northward and eastward.
    fn height_m(&self, [north, east]: [f64; 2]) -> Option<f64> {
        let cell = |along: f64| (along as usize).min(CELLS - 1);
        let (row, column) = (cell(north), cell(east));
        let (up, right) = (north - row as f64, east - column as f64);
        let at = |row: usize, column: usize| self.heights[row * SIDE + column].map(f64::from);
        // A corner without weight need not be known.
        let mix = |a: Option<f64>, b: Option<f64>, part: f64| match part {
            0.0 => a,
            part if part >= 1.0 => b,
            part => Some(a? * (1.0 - part) + b? * part),
        };
        let south = mix(at(row, column), at(row, column + 1), right);
        let north = if up > 0.0 { mix(at(row + 1, column), at(row + 1, column + 1), right) } else { None };
        mix(south, north, up)
    }
}

/// Squares of one level over a part of the Earth.
#[derive(Debug, Clone)]
struct Layer {
    first: SquareId,
    size: [i32; 2],
    squares: Vec<Option<Arc<Square>>>,
}

impl Layer {
    fn index(&self, id: SquareId) -> Option<usize> {
        let row = id.row - self.first.row;
        let column = (id.column - self.first.column).rem_euclid(SquareId::around(id.level));
        let is_inside = (0..self.size[0]).contains(&row) && column < self.size[1];
        is_inside.then_some((row * self.size[1] + column) as usize)
    }
}

/// The ground over a part of the Earth, as far as it is known.
#[derive(Debug, Clone, Default)]
pub struct GroundMap {
    /// The finest first.
    layers: Vec<Layer>,
}

impl GroundMap {
    /// Of what is known of these squares.
    pub fn new(wanted: &[SquareId], mut known: impl FnMut(SquareId) -> Option<Arc<Square>>) -> Self {
        let mut layers = Vec::new();
        for level in 0..LEVELS {
            let ids: Vec<SquareId> = wanted.iter().copied().filter(|id| id.level == level).collect();
            let Some(layer) = Self::layer(&ids, &mut known) else { continue };
            layers.push(layer);
        }
        Self { layers }
    }

    fn layer(ids: &[SquareId], known: &mut impl FnMut(SquareId) -> Option<Arc<Square>>) -> Option<Layer> {
        let any = *ids.first()?;
        let around = SquareId::around(any.level);
        // Columns count from half-way round the globe, so that the date line splits nothing.
        let turned = |id: &SquareId| (id.column - any.column + around / 2).rem_euclid(around);
        let rows = (ids.iter().map(|id| id.row).min()?, ids.iter().map(|id| id.row).max()?);
        let columns = (ids.iter().map(turned).min()?, ids.iter().map(turned).max()?);
        let column = (columns.0 + any.column - around / 2).rem_euclid(around);
        let size = [rows.1 - rows.0 + 1, columns.1 - columns.0 + 1];
        let mut layer = Layer { first: SquareId { row: rows.0, column, ..any }, size, squares: Vec::new() };
        layer.squares.resize((size[0] * size[1]) as usize, None);
        for id in ids {
            if let Some(index) = layer.index(*id) {
                layer.squares[index] = known(*id);
            }
        }
        Some(layer)
    }

    /// Height of the ground, m above mean sea level; `None` where it is not known.
    pub fn height_m(&self, point: GeoPoint) -> Option<f64> {
        self.layers.iter().find_map(|layer| {
            let (id, cells) = SquareId::of(layer.first.level, point);
            layer.squares[layer.index(id)?].as_ref()?.height_m(cells)
        })
    }
}

/// The squares that a plan needs: along its lines as fine as there can be, and between them, where a return or a glide
/// may lead, as fine as their number allows. At most some hundreds; none without a place.
pub fn squares_around(plan: &Plan, home: Option<Home>) -> Vec<SquareId> {
    let home = home.or(plan.mission.home).and_then(|home| home.point().ok());
    let mut line: Vec<GeoPoint> = home.into_iter().collect();
    line.extend(plan.mission.items.iter().filter(|item| leads_somewhere(item.command)).filter_map(|item| item.point()));
    line.extend(home);
    for rally in &plan.rally.points {
        line.extend([Some(rally.point), home].into_iter().flatten());
    }
    let radius_m = plan.mission.items.iter().map(|item| match item.command {
        Command::NAV_LOITER_TO_ALT => item.param(2).unwrap_or(0.0).abs(),
        Command::NAV_LOITER_TURNS | Command::NAV_LOITER_UNLIM => item.param(3).unwrap_or(0.0).abs(),
        _ => 0.0,
    });
    let margin_m = MARGIN_M + radius_m.fold(0.0, f64::max).min(5_000.0);
    let Some(fine) = finest(|level| along(&line, margin_m, level)) else { return Vec::new() };
    let Some(whole) = finest(|level| between(&line, margin_m, level)) else { return fine };
    let is_same = fine.first().map(|id| id.level) == whole.first().map(|id| id.level);
    if is_same { whole } else { fine.into_iter().chain(whole).collect() }
}

/// Whether a plane may fly to the place of a command: not what is looked at, or becomes home.
fn leads_somewhere(command: Command) -> bool {
    let begins_sequence =
        [Command::DO_LAND_START, Command::DO_RETURN_PATH_START, Command::DO_GO_AROUND].contains(&command);
    command.is_destination() || command.is_takeoff() || begins_sequence
}

/// The squares of the finest level that needs not too many of them.
fn finest(squares: impl Fn(u8) -> Option<Vec<SquareId>>) -> Option<Vec<SquareId>> {
    (0..LEVELS).find_map(|level| squares(level).filter(|ids| !ids.is_empty() && ids.len() <= MOST_SQUARES))
}

/// The squares within a margin of a line of geodesics; `None` when they are too many.
fn along(line: &[GeoPoint], margin_m: f64, level: u8) -> Option<Vec<SquareId>> {
    // Half a square, so that none is stepped over.
    let step_m = 55_000.0 / SquareId::per_degree(level);
    let mut ids = BTreeSet::new();
    let mut take = |point: GeoPoint| {
        ids.extend(between(&[point], margin_m, level)?);
        (ids.len() <= MOST_SQUARES).then_some(())
    };
    take(*line.first()?)?;
    for pair in line.windows(2) {
        let leg = inverse(pair[0], pair[1]);
        let steps = (leg.distance_m / step_m).ceil();
        for step in 1..=steps as u32 {
            take(direct(pair[0], leg.bearing_start_deg, leg.distance_m * f64::from(step) / steps))?;
        }
    }
    Some(ids.into_iter().collect())
}

/// The squares of the box around places, with a margin; `None` when they are too many.
fn between(points: &[GeoPoint], margin_m: f64, level: u8) -> Option<Vec<SquareId>> {
    let first = *points.first()?;
    let east_of = |point: &GeoPoint| crate::geodesy::wrap_180_deg(point.lon_deg() - first.lon_deg());
    let least = |of: &dyn Fn(&GeoPoint) -> f64| points.iter().map(of).fold(f64::INFINITY, f64::min);
    let (south, north) = (least(&|point| point.lat_deg()), -least(&|point| -point.lat_deg()));
    let (west, east) = (least(&east_of), -least(&|point| -east_of(point)));
    let lat_margin_deg = margin_m / 110_600.0;
    let lon_margin_deg = lat_margin_deg / south.abs().max(north.abs()).to_radians().cos().max(0.05);
    let per_degree = SquareId::per_degree(level);
    let square = |degrees: f64| (degrees * per_degree).floor() as i32;
    let rows =
        square((south - lat_margin_deg + 90.0).max(0.0))..=square((north + lat_margin_deg + 90.0).min(179.999_999));
    let columns = square(first.lon_deg() + west - lon_margin_deg + 180.0)
        ..=square(first.lon_deg() + east + lon_margin_deg + 180.0);
    let count = rows.clone().count() * columns.clone().count();
    (count <= MOST_SQUARES).then(|| {
        let around = SquareId::around(level);
        rows.flat_map(|row| {
            columns.clone().map(move |column| SquareId { level, row, column: column.rem_euclid(around) })
        })
        .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Mission, MissionItem};

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    fn slope(lat_deg: f64, lon_deg: f64) -> f64 {
        600.0 + (lat_deg - 40.0) * 5_000.0 + (lon_deg + 3.8) * 3_000.0
    }

    fn plan(home: GeoPoint, places: &[GeoPoint]) -> Plan {
        let items = places.iter().map(|at| MissionItem::waypoint(at.lat_deg(), at.lon_deg(), 80.0)).collect();
        let home = Home { lat_deg: home.lat_deg(), lon_deg: home.lon_deg(), alt_amsl_m: 600.0 };
        Plan::from_mission(Mission { home: Some(home), items })
    }

    fn filled(ids: &[SquareId], height: impl Fn(f64, f64) -> Option<f64>) -> GroundMap {
        GroundMap::new(ids, |id| Some(Arc::new(Square::new(id.places().map(|(lat, lon)| height(lat, lon))))))
    }

    #[test]
    fn the_ground_around_a_plan_is_at_hand() {
        let (home, far) = (at(40.3332, -3.7978), at(40.36, -3.75));
        let ids = squares_around(&plan(home, &[far]), None);
        assert!(ids.iter().all(|id| id.level == 0) && ids.len() < 80, "{}", ids.len());
        let map = filled(&ids, |lat, lon| Some(slope(lat, lon)));
        for point in [home, far, at(40.35, -3.795), direct(home, 200.0, 550.0), direct(far, 45.0, 550.0)] {
            let off_m = map.height_m(point).unwrap() - slope(point.lat_deg(), point.lon_deg());
            assert!(off_m.abs() < 0.001, "{point:?}: {off_m}");
        }
        assert_eq!(map.height_m(direct(far, 45.0, 5_000.0)), None, "outside");
        let holed = filled(&ids, |lat, lon| (lat < 40.34).then(|| slope(lat, lon)));
        assert!(holed.height_m(home).is_some() && holed.height_m(far).is_none());
        assert_eq!(GroundMap::new(&ids, |_| None).height_m(home), None);
        assert_eq!(GroundMap::default().height_m(home), None);
        assert!(squares_around(&Plan::default(), None).is_empty());
        // What is looked at is not flown to.
        let mut looking = plan(home, &[far]);
        let (lat_deg, lon_deg) = (far.lat_deg() + 0.5, far.lon_deg());
        for command in [Command::DO_SET_ROI, Command::DO_SET_ROI_LOCATION, Command::DO_SET_HOME] {
            looking.mission.items.push(MissionItem::at(command, [0.0; 4], lat_deg, lon_deg, 0.0));
        }
        assert_eq!(squares_around(&looking, None), ids);
    }

    #[test]
    fn a_long_way_is_fine_along_its_lines_and_coarse_beside_them() {
        let (home, far) = (at(40.0, -3.8), at(40.4, -3.2));
        let ids = squares_around(&plan(home, &[far]), None);
        let levels: BTreeSet<u8> = ids.iter().map(|id| id.level).collect();
        assert!(levels.len() == 2 && ids.len() <= 2 * MOST_SQUARES, "{levels:?} {}", ids.len());
        let map = filled(&ids, |lat, lon| Some(slope(lat, lon)));
        for point in [home, far, at(40.05, -3.3), at(40.35, -3.7)] {
            assert!((map.height_m(point).unwrap() - slope(point.lat_deg(), point.lon_deg())).abs() < 0.01, "{point:?}");
        }
        // Half-way round the globe fine squares are too many, and in the end all are.
        assert!(squares_around(&plan(home, &[at(-40.0, 170.0)]), None).len() <= 2 * MOST_SQUARES);
    }

    #[test]
    fn neither_the_date_line_nor_a_pole_parts_the_ground() {
        let ids = squares_around(&plan(at(-17.0, 179.99), &[at(-17.0, -179.99)]), None);
        let map = filled(&ids, |lat, _| Some(lat));
        for lon_deg in [179.985, 179.999_9, 180.0, -180.0, -179.999_9, -179.985] {
            assert!((map.height_m(at(-17.0, lon_deg)).unwrap() + 17.0).abs() < 1e-4, "{lon_deg}");
        }
        let ids = squares_around(&plan(at(89.99, 0.0), &[at(89.99, 90.0)]), None);
        assert!(
            ids.iter().flat_map(|id| id.places()).all(|(lat_deg, lon_deg)| GeoPoint::new(lat_deg, lon_deg).is_ok())
        );
    }
}
