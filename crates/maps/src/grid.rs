//! The grid that a source's tiles lie on: levels, each with a resolution, an origin at its top left and a tile size.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::crs::{Crs, MERCATOR_HALF_M};
use crate::geo::Bounds;

/// Which tile of a source: `level` of its grid, column from the left, row from the top.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileId {
    /// Index in the grid's levels; for Web Mercator grids the zoom.
    pub level: u8,
    /// From the left.
    pub column: u32,
    /// From the top.
    pub row: u32,
}

impl std::fmt::Display for TileId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}", self.level, self.column, self.row)
    }
}

/// One level of a grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MapLevel)]
pub struct Level {
    /// Units of the grid's system a pixel.
    pub resolution: f64,
    /// Top left corner of tile 0/0: easting or longitude, northing or latitude.
    pub origin: [f64; 2],
    /// Width and height of a tile.
    pub tile_px: [u32; 2],
    /// Columns and rows.
    #[schema(required = true)]
    pub size: Option<[u32; 2]>,
}

/// A grid of tiles in the source's own coordinate reference system.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapTileGrid)]
pub struct TileGrid {
    /// Its system, such as `EPSG:25830`. Coordinates are easting or longitude first, always.
    #[serde(serialize_with = "browser_code")]
    #[schema(value_type = String)]
    pub crs: Crs,
    /// Definition of the system for proj4; null for EPSG:3857 and 4326, which browsers know.
    #[schema(required = true)]
    pub proj4: Option<String>,
    /// Where there is something: least x and y, greatest x and y.
    #[schema(required = true)]
    pub extent: Option<[f64; 4]>,
    /// The levels, coarse to fine; `z` of a tile's address is the index.
    pub levels: Vec<Level>,
    /// Coarsest level with tiles.
    pub min_level: u8,
    /// Finest level with tiles.
    pub max_level: u8,
}

fn browser_code<S: serde::Serializer>(crs: &Crs, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&crs.browser_code())
}

/// Levels of a grid at most.
pub const MAX_LEVELS: usize = 31;

impl TileGrid {
    /// A grid of levels, with tiles on all of them.
    pub fn new(crs: Crs, levels: Vec<Level>) -> Self {
        let max_level = u8::try_from(levels.len().clamp(1, MAX_LEVELS) - 1).unwrap_or(u8::MAX);
        Self { crs, proj4: crs.proj4(), extent: None, levels, min_level: 0, max_level }
    }

    /// The usual grid of a system: that of all XYZ services for Web Mercator, two square tiles that hold the world for
    /// degrees, and for UTM a square of 10,000 km whose top left is at 10,000 km north of the equator or of its false
    /// origin.
    pub fn standard(crs: Crs, tile_px: u32, min_level: u8, max_level: u8) -> Self {
        let (origin, side, columns, rows) = match crs {
            Crs::WebMercator => ([-MERCATOR_HALF_M, MERCATOR_HALF_M], 2.0 * MERCATOR_HALF_M, 1, 1),
            Crs::Geographic { .. } | Crs::Crs84 => ([-180.0, 90.0], 180.0, 2, 1),
            Crs::Utm { .. } => ([0.0, 10_000_000.0], 10_000_000.0, 1, 1),
        };
        let max_level = max_level.min(30);
        let levels = (0..=max_level).map(|level| Level {
            resolution: side / f64::from(tile_px) / f64::from(1_u32 << level),
            origin,
            tile_px: [tile_px, tile_px],
            size: Some([columns << level, rows << level]),
        });
        let mut grid = Self::new(crs, levels.collect());
        grid.min_level = min_level.min(max_level);
        grid
    }

    /// With the extent of geographic bounds.
    #[must_use]
    pub fn within(mut self, bounds: Option<&Bounds>) -> Self {
        if let Some(bounds) = bounds {
            self.extent = Some(bounds.extent_in(self.crs));
        }
        self
    }

    /// The level of an index, when it has tiles.
    pub fn level(&self, level: u8) -> Option<&Level> {
        (self.min_level..=self.max_level).contains(&level).then(|| self.levels.get(usize::from(level))).flatten()
    }

    /// The rectangle of a tile: least x and y, greatest x and y. `None` off the grid.
    pub fn tile_extent(&self, tile: TileId) -> Option<[f64; 4]> {
        let level = self.level(tile.level)?;
        if level.size.is_some_and(|[columns, rows]| tile.column >= columns || tile.row >= rows) {
            return None;
        }
        let [width, height] = level.tile_px.map(|px| f64::from(px) * level.resolution);
        let x = level.origin[0] + f64::from(tile.column) * width;
        let y = level.origin[1] - f64::from(tile.row) * height;
        Some([x, y - height, x + width, y])
    }

    /// Whether a tile is on the grid and touches what the source shows.
    pub fn contains(&self, tile: TileId) -> bool {
        let Some([min_x, min_y, max_x, max_y]) = self.tile_extent(tile) else { return false };
        let Some([left, bottom, right, top]) = self.extent else { return true };
        let overlaps = |shift: f64| min_x < right + shift && max_x > left + shift && min_y < top && max_y > bottom;
        let width = self.crs.world_width().unwrap_or(0.0);
        overlaps(0.0) || (width > 0.0 && (overlaps(width) || overlaps(-width)))
    }

    /// Column and row, with fractions, of coordinates on a level.
    pub fn position(&self, level: &Level, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - level.origin[0]) / (level.resolution * f64::from(level.tile_px[0])),
            (level.origin[1] - y) / (level.resolution * f64::from(level.tile_px[1])),
        ]
    }

    /// The extent's middle as a tile of a level, or the tile at the middle of the grid.
    pub fn middle(&self, level: u8) -> Option<TileId> {
        let of = self.level(level)?;
        let position = match self.extent {
            Some([left, bottom, right, top]) => {
                self.position(of, [f64::midpoint(left, right), f64::midpoint(bottom, top)])
            }
            None => of.size.map_or([0.0, 0.0], |size| size.map(|count| f64::from(count) / 2.0)),
        };
        let [column, row] = [0, 1].map(|axis| {
            let last = of.size.map_or(f64::from(u32::MAX), |size| f64::from(size[axis]) - 1.0);
            position[axis].floor().clamp(0.0, last.max(0.0)) as u32
        });
        Some(TileId { level, column, row })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_where_everybody_puts_them() {
        let grid = TileGrid::standard(Crs::WebMercator, 256, 0, 19);
        assert!((grid.levels[0].resolution - 156_543.033_928_041).abs() < 1e-6);
        // Tile 15/16038/12394 holds 40.3332 N, 3.7978 W (the formulas of the OpenStreetMap wiki).
        let position = grid.position(&grid.levels[15], Crs::WebMercator.project(40.3332, -3.7978));
        assert_eq!(position.map(|p| p.floor() as u32), [16_038, 12_365]);
        let extent = grid.tile_extent(TileId { level: 0, column: 0, row: 0 }).expect("there");
        assert!((extent[3] - MERCATOR_HALF_M).abs() < 1e-6 && (extent[0] + MERCATOR_HALF_M).abs() < 1e-6);
        assert_eq!(grid.tile_extent(TileId { level: 1, column: 2, row: 0 }), None);
        assert_eq!(grid.tile_extent(TileId { level: 20, column: 0, row: 0 }), None);
        let degrees = TileGrid::standard(Crs::Geographic { epsg: 4326 }, 256, 0, 3);
        let extent = degrees.tile_extent(TileId { level: 1, column: 3, row: 1 }).expect("there");
        assert_eq!(extent, [90.0, -90.0, 180.0, 0.0]);
    }

    #[test]
    fn what_lies_outside_the_bounds_is_not_asked_for() {
        let spain = Bounds { west_deg: -18.5, south_deg: 27.0, east_deg: 4.6, north_deg: 44.0 };
        let grid = TileGrid::standard(Crs::WebMercator, 256, 0, 19).within(Some(&spain));
        assert!(grid.contains(TileId { level: 15, column: 16_038, row: 12_365 }));
        assert!(!grid.contains(TileId { level: 15, column: 30_000, row: 12_365 }));
        let middle = grid.middle(6).expect("there");
        assert!(grid.contains(middle), "{middle}");
        let fiji = Bounds { west_deg: 176.0, south_deg: -20.0, east_deg: -178.0, north_deg: -15.0 };
        let grid = TileGrid::standard(Crs::WebMercator, 256, 0, 19).within(Some(&fiji));
        let at = |lon: f64| {
            let [x, y] = grid.position(&grid.levels[8], Crs::WebMercator.project(-17.0, lon));
            grid.contains(TileId { level: 8, column: x as u32, row: y as u32 })
        };
        assert!(at(179.5) && at(-179.5) && !at(0.0));
    }
}
