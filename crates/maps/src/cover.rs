//! Which tiles of a grid an area on the ground needs: a rectangle, a polygon, or what lies around a route.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::geodesy::{GeoPoint, direct, inverse, wrap_180_deg};

use crate::crs::{Crs, MERCATOR_MAX_LAT_DEG};
use crate::error::{MapError, Result};
use crate::geo::{Bounds, Corner};
use crate::grid::{TileGrid, TileId};

/// Points of a shape at most.
const MAX_POINTS: usize = 5000;
/// Metres around a route at most.
const MAX_BUFFER_M: f64 = 100_000.0;
/// Pieces that a straight edge is cut into, since it is curved in other systems.
const PIECES: u32 = 8;
/// Metres of a route that one piece of its surroundings is made for.
const LEG_M: f64 = 20_000.0;
/// Corners of a half circle.
const HALF_CIRCLE: u32 = 12;

/// An area on the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[schema(as = MapAreaShape)]
pub enum Shape {
    /// Between parallels and meridians; west greater than east: over the date line.
    Box(Bounds),
    /// Three or more corners.
    Polygon {
        /// In order.
        points: Vec<Corner>,
    },
    /// Places near a line.
    Route {
        /// In order; one is enough.
        points: Vec<Corner>,
        /// How near.
        buffer_m: f64,
    },
}

impl Shape {
    /// Checks it.
    ///
    /// # Errors
    /// [`MapError::Request`] with the fault.
    pub fn check(&self) -> Result<()> {
        let wrong = |text: &str| Err(MapError::Request(format!("shape: {text}")));
        let (points, least) = match self {
            Self::Box(bounds) => return bounds.fault().map_or(Ok(()), |fault| wrong(&fault)),
            Self::Polygon { points } => (points, 3),
            Self::Route { points, buffer_m } => {
                if !(1.0..=MAX_BUFFER_M).contains(buffer_m) {
                    return wrong("buffer_m goes from 1 to 100000");
                }
                (points, 1)
            }
        };
        if points.len() < least || points.len() > MAX_POINTS {
            return wrong(&format!("takes {least} to {MAX_POINTS} points"));
        }
        if points.iter().any(|at| GeoPoint::new(at.lat_deg, at.lon_deg).is_err()) {
            return wrong("latitudes go from -90 to 90, longitudes from -180 to 180");
        }
        Ok(())
    }

    /// Polygons whose union it is, as latitude and longitude; longitudes go on beyond ±180.
    fn polygons(&self) -> Vec<Vec<[f64; 2]>> {
        match self {
            Self::Box(Bounds { west_deg, south_deg, east_deg, north_deg }) => {
                let east = if east_deg < west_deg { east_deg + 360.0 } else { *east_deg };
                vec![cut(&[[*south_deg, *west_deg], [*south_deg, east], [*north_deg, east], [*north_deg, *west_deg]])]
            }
            Self::Polygon { points } => {
                let mut lon = points.first().map_or(0.0, |first| first.lon_deg);
                let unrolled: Vec<[f64; 2]> = points
                    .iter()
                    .map(|at| {
                        lon += wrap_180_deg(at.lon_deg - lon);
                        [at.lat_deg, lon]
                    })
                    .collect();
                vec![cut(&unrolled)]
            }
            Self::Route { points, buffer_m } => around(points, *buffer_m),
        }
    }
}

/// The rectangle around a shape.
pub fn bounds(shape: &Shape) -> Option<Bounds> {
    let mut corners = shape.polygons().into_iter().flatten();
    let first = corners.next()?;
    let (low, high) = corners.fold((first, first), |(low, high), corner| {
        ([low[0].min(corner[0]), low[1].min(corner[1])], [high[0].max(corner[0]), high[1].max(corner[1])])
    });
    let (west_deg, east_deg) = (wrap_180_deg(low[1]), wrap_180_deg(high[1]));
    // A west of −180 and an east of 180 are the same meridian; the whole world keeps its two ends.
    let is_world = high[1] - low[1] >= 360.0;
    let (west_deg, east_deg) = if is_world { (-180.0, 180.0) } else { (west_deg, east_deg) };
    Some(Bounds { west_deg, south_deg: low[0].max(-90.0), east_deg, north_deg: high[0].min(90.0) })
}

/// Edges cut into pieces, straight in latitude and longitude.
fn cut(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let next = corners.iter().cycle().skip(1);
    let edge = |(from, to): (&[f64; 2], &[f64; 2])| {
        let (from, to) = (*from, *to);
        (0..PIECES).map(move |piece| {
            let share = f64::from(piece) / f64::from(PIECES);
            [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share]
        })
    };
    corners.iter().zip(next).flat_map(edge).collect()
}

/// Capsules around the pieces of a line.
fn around(points: &[Corner], buffer_m: f64) -> Vec<Vec<[f64; 2]>> {
    let places: Vec<GeoPoint> = points.iter().filter_map(|at| GeoPoint::new(at.lat_deg, at.lon_deg).ok()).collect();
    // Corners of a circle's polygon lie a little farther out, so that the circle is inside.
    let radius_m = buffer_m / (std::f64::consts::PI / f64::from(HALF_CIRCLE) / 2.0).cos();
    let capsule = |from: GeoPoint, to: GeoPoint, start_deg: f64, end_deg: f64| {
        let fan = |centre: GeoPoint, first_deg: f64| {
            (0..=HALF_CIRCLE).map(move |step| {
                let bearing_deg = first_deg + 180.0 * f64::from(step) / f64::from(HALF_CIRCLE);
                direct(centre, bearing_deg, radius_m)
            })
        };
        let mut lon = from.lon_deg();
        fan(to, end_deg - 90.0)
            .chain(fan(from, start_deg + 90.0))
            .map(|at| {
                lon += wrap_180_deg(at.lon_deg() - lon);
                [at.lat_deg(), lon]
            })
            .collect::<Vec<_>>()
    };
    if let [only] = places.as_slice() {
        return vec![capsule(*only, *only, 0.0, 0.0)];
    }
    let mut capsules = Vec::new();
    for pair in places.windows(2) {
        let line = inverse(pair[0], pair[1]);
        let pieces = (line.distance_m / LEG_M).ceil().clamp(1.0, 2000.0);
        let place = |piece: f64| direct(pair[0], line.bearing_start_deg, line.distance_m * piece / pieces);
        for piece in 0..pieces as u32 {
            let (from, to) = (place(f64::from(piece)), place(f64::from(piece) + 1.0));
            let line = inverse(from, to);
            capsules.push(capsule(from, to, line.bearing_start_deg, line.bearing_end_deg));
        }
    }
    capsules
}

/// A polygon in columns and rows of a level, with its bounds.
struct Piece {
    corners: Vec<[f64; 2]>,
    low: [f64; 2],
    high: [f64; 2],
}

impl Piece {
    /// The same shifted by columns to the east.
    fn moved(&self, columns: f64) -> Self {
        let moved = |[column, row]: [f64; 2]| [column + columns, row];
        Self {
            corners: self.corners.iter().copied().map(moved).collect(),
            low: moved(self.low),
            high: moved(self.high),
        }
    }
}

/// Columns and rows: first, and one behind the last.
#[derive(Clone, Copy)]
struct Block {
    low: [i64; 2],
    high: [i64; 2],
}

enum Place {
    Outside,
    Inside,
    Partly,
}

fn place(block: Block, piece: &Piece) -> Place {
    let low = block.low.map(|number| number as f64);
    let high = block.high.map(|number| number as f64);
    if (0..2).any(|axis| piece.high[axis] < low[axis] || piece.low[axis] > high[axis]) {
        return Place::Outside;
    }
    let edges = piece.corners.iter().zip(piece.corners.iter().cycle().skip(1));
    if edges.clone().any(|(from, to)| touches(*from, *to, low, high)) {
        return Place::Partly;
    }
    // No edge comes near: the middle decides for all of it.
    let [x, y] = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
    let mut inside = false;
    for (a, b) in edges {
        if (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0] {
            inside = !inside;
        }
    }
    if inside { Place::Inside } else { Place::Outside }
}

/// Whether a line touches a rectangle (Liang and Barsky, 1984).
fn touches(from: [f64; 2], to: [f64; 2], low: [f64; 2], high: [f64; 2]) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        for (p, q) in [(-step, from[axis] - low[axis]), (step, high[axis] - from[axis])] {
            if p == 0.0 {
                if q < 0.0 {
                    return false;
                }
            } else if p < 0.0 {
                enter = enter.max(q / p);
            } else {
                leave = leave.min(q / p);
            }
        }
    }
    enter <= leave
}

/// The tiles that a shape needs on one level.
struct Level<'a> {
    grid: &'a TileGrid,
    level: u8,
    pieces: Vec<Piece>,
    /// Columns and rows there are.
    size: [i64; 2],
    /// Whether columns go on at the other side of the world.
    is_round: bool,
}

impl<'a> Level<'a> {
    fn new(grid: &'a TileGrid, polygons: &[Vec<[f64; 2]>], level: u8) -> Option<Self> {
        let of = grid.level(level)?;
        let size = of.size.map_or([i64::MAX / 4; 2], |size| size.map(i64::from));
        let width = grid.crs.world_width();
        let across = width.map(|width| width / (of.resolution * f64::from(of.tile_px[0])));
        let is_round = across.is_some_and(|across| (across - size[0] as f64).abs() < 1e-6);
        let mut pieces: Vec<Piece> = polygons
            .iter()
            .map(|polygon| {
                let corners: Vec<[f64; 2]> = polygon
                    .iter()
                    .map(|[lat, lon]| {
                        let lat = if grid.crs == Crs::WebMercator {
                            lat.clamp(-MERCATOR_MAX_LAT_DEG, MERCATOR_MAX_LAT_DEG)
                        } else {
                            *lat
                        };
                        grid.position(of, grid.crs.project(lat, *lon))
                    })
                    .filter(|corner| corner.iter().all(|number| number.is_finite()))
                    .collect();
                let fold = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
                    corners.iter().map(|corner| corner[axis]).fold(start, pick)
                };
                let low = [0, 1].map(|axis| fold(axis, f64::INFINITY, f64::min));
                let high = [0, 1].map(|axis| fold(axis, f64::NEG_INFINITY, f64::max));
                Piece { corners, low, high }
            })
            .filter(|piece| piece.corners.len() > 2)
            .collect();
        if is_round {
            // What reaches farther than once around the world is there at its beginning too: of each column one is
            // looked through.
            let left = pieces.iter().map(|piece| piece.low[0]).fold(f64::INFINITY, f64::min).floor();
            let across = size[0] as f64;
            let again: Vec<Piece> =
                pieces.iter().filter(|piece| piece.high[0] > left + across).map(|piece| piece.moved(-across)).collect();
            pieces.extend(again);
        }
        Some(Self { grid, level, pieces, size, is_round })
    }

    /// The blocks to look through.
    fn block(&self) -> Option<Block> {
        let fold = |axis: usize| {
            let low = self.pieces.iter().map(|piece| piece.low[axis]).fold(f64::INFINITY, f64::min);
            let high = self.pieces.iter().map(|piece| piece.high[axis]).fold(f64::NEG_INFINITY, f64::max);
            (low.floor().max(-1e15) as i64, high.ceil().min(1e15) as i64)
        };
        if self.pieces.is_empty() {
            return None;
        }
        let ((mut left, mut right), (top, bottom)) = (fold(0), fold(1));
        if self.is_round {
            right = right.min(left + self.size[0]);
        } else {
            (left, right) = (left.max(0), right.min(self.size[0]));
        }
        let (top, bottom) = (top.max(0), bottom.min(self.size[1]));
        (left < right && top < bottom).then_some(Block { low: [left, top], high: [right, bottom] })
    }

    /// Goes through the blocks that are wholly inside, and the single tiles on the border; stops when the callback says
    /// so.
    fn visit(&self, block: Block, near: &[usize], found: &mut impl FnMut(Block) -> bool) -> bool {
        let mut next = Vec::new();
        for index in near {
            match place(block, &self.pieces[*index]) {
                Place::Inside => return found(block),
                Place::Partly => next.push(*index),
                Place::Outside => {}
            }
        }
        if next.is_empty() {
            return true;
        }
        let [columns, rows] = [0, 1].map(|axis| block.high[axis] - block.low[axis]);
        if columns <= 1 && rows <= 1 {
            return found(block);
        }
        let axis = usize::from(rows > columns);
        let middle = block.low[axis] + (block.high[axis] - block.low[axis]) / 2;
        let (mut first, mut second) = (block, block);
        first.high[axis] = middle;
        second.low[axis] = middle;
        self.visit(first, &next, found) && self.visit(second, &next, found)
    }

    fn tiles(&self, block: Block) -> impl Iterator<Item = TileId> {
        let columns = self.size[0];
        (block.low[1]..block.high[1]).flat_map(move |row| {
            (block.low[0]..block.high[0]).filter_map(move |column| {
                let column = if self.is_round { column.rem_euclid(columns) } else { column };
                let tile = TileId { level: self.level, column: column.try_into().ok()?, row: row.try_into().ok()? };
                self.grid.contains(tile).then_some(tile)
            })
        })
    }
}

/// Tiles that a shape needs on each level; counting stops when the total passes `most`, and the rest is estimated.
///
/// # Errors
/// [`MapError::Request`] for an invalid shape, or levels that the grid does not have.
pub fn count(
    grid: &TileGrid,
    shape: &Shape,
    levels: std::ops::RangeInclusive<u8>,
    most: u64,
) -> Result<Vec<(u8, u64)>> {
    let polygons = checked(grid, shape, &levels)?;
    let mut total = 0_u64;
    let mut counts: Vec<(u8, u64)> = Vec::new();
    for level in levels {
        let Some(on) = Level::new(grid, &polygons, level) else { continue };
        let mut here = 0_u64;
        let reckoned = counts.last().map_or(0, |(_, before)| before.saturating_mul(4));
        if total <= most {
            if let Some(block) = on.block() {
                let all: Vec<usize> = (0..on.pieces.len()).collect();
                let is_whole = on.visit(block, &all, &mut |block| {
                    let size =
                        (block.high[0] - block.low[0]).unsigned_abs() * (block.high[1] - block.low[1]).unsigned_abs();
                    // Where there is room for doubt the tiles themselves are asked.
                    here += if size <= 4096 { on.tiles(block).count() as u64 } else { size };
                    total + here <= most
                });
                here = if is_whole { here } else { here.max(reckoned) };
            }
        } else {
            here = reckoned;
        }
        total = total.saturating_add(here);
        counts.push((level, here));
    }
    Ok(counts)
}

/// The tiles that a shape needs, coarse to fine, each once.
///
/// # Errors
/// As [`count`], and [`MapError::AreaTooLarge`] beyond `most`.
pub fn tiles(grid: &TileGrid, shape: &Shape, levels: std::ops::RangeInclusive<u8>, most: u64) -> Result<Vec<TileId>> {
    let polygons = checked(grid, shape, &levels)?;
    let mut tiles = Vec::new();
    for level in levels.clone() {
        let Some(on) = Level::new(grid, &polygons, level) else { continue };
        let Some(block) = on.block() else { continue };
        let all: Vec<usize> = (0..on.pieces.len()).collect();
        let is_whole = on.visit(block, &all, &mut |block| {
            tiles.extend(on.tiles(block).take((most as usize + 1).saturating_sub(tiles.len())));
            tiles.len() as u64 <= most
        });
        if !is_whole {
            let all: u64 = count(grid, shape, levels, most)?.iter().map(|(_, count)| count).sum();
            return Err(MapError::AreaTooLarge { tiles: all.max(most + 1), most });
        }
    }
    Ok(tiles)
}

fn checked(grid: &TileGrid, shape: &Shape, levels: &std::ops::RangeInclusive<u8>) -> Result<Vec<Vec<[f64; 2]>>> {
    shape.check()?;
    let (min, max) = (grid.min_level, grid.max_level);
    if levels.is_empty() || *levels.start() < min || *levels.end() > max {
        return Err(MapError::Request(format!(
            "min_level, max_level: go from {min} to {max} here, the first not above the second"
        )));
    }
    Ok(shape.polygons())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    const fn at(lat_deg: f64, lon_deg: f64) -> Corner {
        Corner { lat_deg, lon_deg }
    }

    fn mercator() -> TileGrid {
        TileGrid::standard(Crs::WebMercator, 256, 0, 19)
    }

    fn tile_of(grid: &TileGrid, level: u8, at: GeoPoint) -> TileId {
        let [x, y] = grid.position(&grid.levels[usize::from(level)], grid.crs.project(at.lat_deg(), at.lon_deg()));
        TileId { level, column: x as u32, row: y as u32 }
    }

    #[test]
    fn a_box_has_the_tiles_between_its_corners() {
        let grid = mercator();
        let shape = Shape::Box(Bounds { west_deg: -3.9, south_deg: 40.3, east_deg: -3.7, north_deg: 40.4 });
        let tiles = tiles(&grid, &shape, 12..=12, 1000).expect("tiles");
        let first = tile_of(&grid, 12, GeoPoint::new(40.4, -3.9).expect("a place"));
        let last = tile_of(&grid, 12, GeoPoint::new(40.3, -3.7).expect("a place"));
        let expected = (last.column - first.column + 1) * (last.row - first.row + 1);
        assert_eq!(tiles.len() as u32, expected);
        let whole = Shape::Box(Bounds { west_deg: -180.0, south_deg: -90.0, east_deg: 180.0, north_deg: 90.0 });
        assert_eq!(count(&grid, &whole, 0..=3, 1_000_000).expect("counted"), [(0, 1), (1, 4), (2, 16), (3, 64)]);
        let huge: u64 = count(&grid, &whole, 0..=19, 500_000).expect("reckoned").iter().map(|(_, n)| n).sum();
        assert!(huge > 100_000_000_000, "{huge}");
        assert!(matches!(super::tiles(&grid, &whole, 0..=19, 500_000), Err(MapError::AreaTooLarge { .. })));
    }

    #[test]
    fn over_the_date_line_both_sides_are_had() {
        let grid = mercator();
        for shape in [
            Shape::Box(Bounds { west_deg: 179.0, south_deg: -18.0, east_deg: -179.0, north_deg: -17.0 }),
            Shape::Polygon { points: vec![at(-18.0, 179.0), at(-18.0, -179.0), at(-17.0, -179.0), at(-17.0, 179.0)] },
            Shape::Route { points: vec![at(-17.5, 179.5), at(-17.5, -179.5)], buffer_m: 5000.0 },
        ] {
            let tiles = tiles(&grid, &shape, 8..=8, 1000).expect("tiles");
            let columns: BTreeSet<u32> = tiles.iter().map(|tile| tile.column).collect();
            assert!(columns.contains(&0) && columns.contains(&255) && columns.len() <= 4, "{shape:?} {columns:?}");
        }
    }

    #[test]
    fn a_diagonal_route_is_a_band_not_a_square() {
        let grid = mercator();
        let shape = Shape::Route { points: vec![at(40.0, -4.0), at(40.5, -3.5)], buffer_m: 300.0 };
        let band = tiles(&grid, &shape, 15..=15, 100_000).expect("tiles").len();
        let bounds = Bounds { west_deg: -4.0, south_deg: 40.0, east_deg: -3.5, north_deg: 40.5 };
        let square = tiles(&grid, &Shape::Box(bounds), 15..=15, 100_000).expect("tiles").len();
        assert!(band * 10 < square && band > 60, "{band} {square}");
    }

    #[test]
    fn a_route_over_the_date_line_is_covered_on_both_sides() {
        let shape = Shape::Route { points: vec![at(0.0, -179.989), at(-0.389, 179.823)], buffer_m: 10.0 };
        let covered = tiles(&mercator(), &shape, 11..=11, 100).expect("tiles");
        let unique: BTreeSet<_> = covered.iter().map(|tile| (tile.column, tile.row)).collect();
        assert_eq!(unique.len(), covered.len(), "each once");
        assert!(unique.is_superset(&[(0, 1024), (2047, 1024), (2047, 1025), (2047, 1026)].into()), "{unique:?}");
    }

    #[test]
    fn wrong_shapes_and_levels_are_told() {
        let grid = mercator();
        let route = |points, buffer_m| Shape::Route { points, buffer_m };
        for shape in [
            Shape::Polygon { points: vec![at(0.0, 0.0), at(1.0, 1.0)] },
            route(vec![], 10.0),
            route(vec![at(0.0, 0.0)], f64::NAN),
            route(vec![at(91.0, 0.0)], 10.0),
            Shape::Box(Bounds { west_deg: 0.0, south_deg: 1.0, east_deg: 1.0, north_deg: 0.0 }),
        ] {
            assert!(matches!(tiles(&grid, &shape, 0..=1, 10), Err(MapError::Request(_))), "{shape:?}");
        }
        let shape = route(vec![at(0.0, 0.0)], 10.0);
        assert!(tiles(&grid, &shape, 5..=20, 10).is_err());
        #[allow(clippy::reversed_empty_ranges, reason = "that is what is tested")]
        let reversed = tiles(&grid, &shape, 5..=4, 10);
        assert!(reversed.is_err());
        assert_eq!(tiles(&grid, &shape, 5..=5, 10).expect("tiles").len(), 4, "where four tiles meet");
    }

    proptest! {
        #[test]
        fn every_place_near_a_route_is_covered(
            lat in -70.0..70.0_f64, lon in -180.0..180.0_f64, bearing in 0.0..360.0_f64, length in 0.0..60_000.0_f64,
            share in 0.0..1.0_f64, side in 0.0..360.0_f64, buffer in 10.0..5000.0_f64, utm in any::<bool>(),
        ) {
            let start = GeoPoint::new(lat, lon).expect("a place");
            let end = direct(start, bearing, length);
            let near = direct(direct(start, bearing, length * share), side, buffer * 0.999);
            let zone = ((lon + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u32 + 1;
            let grid = if utm {
                let crs = Crs::from_epsg(if lat < 0.0 { 32_700 } else { 32_600 } + zone).expect("known");
                TileGrid::standard(crs, 256, 0, 12)
            } else {
                mercator()
            };
            let points = [start, end].map(|p| at(p.lat_deg(), p.lon_deg())).to_vec();
            // UTM is not for routes over the equator or far from the zone.
            prop_assume!(!utm || (end.lat_deg() * lat > 0.0 && wrap_180_deg(near.lon_deg() - lon).abs() < 20.0));
            let covered = tiles(&grid, &Shape::Route { points, buffer_m: buffer }, 11..=11, 100_000).expect("tiles");
            let unique: BTreeSet<_> = covered.iter().collect();
            prop_assert_eq!(unique.len(), covered.len());
            let lon_near = lon + wrap_180_deg(near.lon_deg() - lon);
            let place = if utm { grid.crs.project(near.lat_deg(), lon_near) } else { grid.crs.project(near.lat_deg(), near.lon_deg()) };
            let [x, y] = grid.position(&grid.levels[11], place);
            let tile = TileId { level: 11, column: x as u32, row: y as u32 };
            let on_grid = x >= 0.0 && y >= 0.0 && grid.contains(tile);
            prop_assert!(!on_grid || unique.contains(&tile), "{} of {}", tile, covered.len());
        }
    }
}
