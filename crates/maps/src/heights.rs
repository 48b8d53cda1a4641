//! Heights of the ground from the sources of heights: at places and along lines. Unknown stays unknown.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, PoisonError};

use tokio::task::JoinSet;

use crate::crs::Crs;
use crate::elevation::{self, ElevationPoint, HeightTile, Profile, ProfileSample};
use crate::error::{MapError, Result};
use crate::geo::Corner;
use crate::grid::{TileGrid, TileId};
use crate::live::Live;
use crate::service::Maps;
use crate::settings::Role;
use crate::source::Source;
use crate::task::blocking;

/// Heights that are kept unpacked, eight bytes each.
const KEPT_HEIGHTS: usize = 8 * 1024 * 1024;
/// Largest pixels, metres at the equator, of a level that stands in for a finer one that failed: about the spacing of a
/// vehicle's terrain grid (100 m).
const MAX_STAND_IN_M: f64 = 160.0;
/// Tiles of heights that one question may need.
const MAX_HEIGHT_TILES: usize = 64;
/// Places of one question at most.
pub const MAX_POINTS: usize = 2000;

impl Maps {
    /// Heights of the ground at places, and the error of a source that failed. Unknown heights stay unknown.
    ///
    /// # Errors
    /// [`MapError::Request`] for too many or invalid places; [`MapError::Closed`].
    pub async fn heights(&self, points: &[Corner]) -> Result<(Vec<ElevationPoint>, Option<String>)> {
        if points.len() > MAX_POINTS {
            return Err(MapError::Request(format!("points: at most {MAX_POINTS} are taken")));
        }
        let is_place = |at: &Corner| vencejo_flight::geodesy::GeoPoint::new(at.lat_deg, at.lon_deg).is_ok();
        if !points.iter().all(is_place) {
            return Err(MapError::Request(
                "points: latitudes go from -90 to 90, longitudes from -180 to 180".to_owned(),
            ));
        }
        self.refresh().await?;
        let mut found = vec![ElevationPoint::default(); points.len()];
        let mut fault = None;
        for source in self.sources().into_iter().filter(|source| source.settings.role == Role::Elevation) {
            let open: Vec<usize> = (0..points.len()).filter(|index| found[*index].alt_amsl_m.is_none()).collect();
            if open.is_empty() {
                break;
            }
            let asked: Vec<Corner> = open.iter().map(|index| points[*index]).collect();
            let heights = match self.heights_of(&source, asked, &mut fault).await {
                Ok(heights) => heights,
                Err(error) => {
                    fault = Some(error.to_string());
                    continue;
                }
            };
            for (index, height) in open.into_iter().zip(heights) {
                if let Some((alt_m, resolution_m)) = height {
                    found[index] = ElevationPoint {
                        alt_amsl_m: Some(alt_m),
                        source: Some(source.settings.id.clone()),
                        resolution_m: Some(resolution_m),
                        datum: Some(source.settings.datum.clone().unwrap_or_else(|| "EGM96".to_owned())),
                    };
                }
            }
        }
        Ok((found, fault))
    }

    async fn heights_of(
        &self,
        source: &Arc<Source>,
        points: Vec<Corner>,
        fault: &mut Option<String>,
    ) -> Result<Vec<Option<(f64, f64)>>> {
        if let Live::Heights(dem) = &source.live {
            let (dem, reading) = (dem.clone(), source.reading());
            let _turn = self.shared.readers.acquire().await.map_err(|_| MapError::Closed)?;
            let read = blocking(move || {
                let _reading = reading;
                let mut fault = None;
                let height = |at: &Corner| match dem.height(at.lat_deg, at.lon_deg) {
                    Ok(height) => height.map(|height| (height.alt_m, height.resolution_m)),
                    Err(error) => {
                        fault = Some(error);
                        None
                    }
                };
                let heights: Vec<_> = points.iter().map(height).collect();
                Ok((heights, fault))
            });
            let (heights, failed) = read.await?;
            match failed {
                None => source.succeeded(None, self.now_s()),
                Some(error) => {
                    source.failed(None, &error, None, self.now_s());
                    *fault = Some(error.to_string());
                }
            }
            return Ok(heights);
        }
        if let Live::Unusable(reason) = &source.live {
            return Err(source.unusable(reason.clone()));
        }
        let encoding = source.settings.encoding.ok_or_else(|| source.unusable("its encoding is not said"))?;
        let grid = self.known_grid(source).await?;
        let mut found = vec![None; points.len()];
        let mut open: Vec<usize> = (0..points.len()).collect();
        let mut is_stand_in = false;
        for level in (grid.min_level..=grid.max_level).rev() {
            let pixel_m = grid.levels[usize::from(level)].resolution * grid.crs.metres_per_unit();
            if is_stand_in && pixel_m > MAX_STAND_IN_M {
                // Averaged over so much, a ridge is gone: the place stays unknown, and the next source is asked.
                break;
            }
            let asked: Vec<Corner> = open.iter().map(|index| points[*index]).collect();
            let places = neighbours(&grid, level, &asked);
            let mut tiles: Vec<TileId> =
                places.iter().flatten().flat_map(|near| near.iter().map(|(_, tile, _)| *tile)).collect();
            tiles.sort();
            tiles.dedup();
            // The finest level whose tiles are not too many.
            if tiles.len() > MAX_HEIGHT_TILES && level > grid.min_level {
                continue;
            }
            is_stand_in = true;
            let mut heights = HashMap::new();
            let mut failed = BTreeSet::new();
            let mut fetches = JoinSet::new();
            for tile in tiles {
                let (maps, source) = (self.clone(), source.clone());
                fetches.spawn(async move { (tile, maps.height_tile(&source, tile, encoding).await) });
            }
            while let Some(done) = fetches.join_next().await {
                match done {
                    Ok((tile, Ok(height))) => {
                        heights.insert(tile, height);
                    }
                    Ok((_, Err(MapError::NoTile))) | Err(_) => {}
                    Ok((tile, Err(error))) => {
                        failed.insert(tile);
                        fault.get_or_insert_with(|| error.to_string());
                    }
                }
            }
            let mut left = Vec::new();
            for (index, near) in open.into_iter().zip(places) {
                let Some(near) = near else { continue };
                let below_sea = source.settings.below_sea_level;
                found[index] = between(&near, &heights, below_sea)
                    .map(|alt_m| (alt_m, metres_per_pixel(&grid, level, points[index].lat_deg)));
                if near.iter().any(|(weight, tile, _)| *weight > 0.0 && failed.contains(tile)) {
                    left.push(index);
                }
            }
            // Without the network an area may have a coarser level of what failed.
            open = left;
            if open.is_empty() {
                break;
            }
        }
        Ok(found)
    }

    async fn height_tile(
        &self,
        source: &Arc<Source>,
        tile: TileId,
        encoding: crate::settings::Encoding,
    ) -> Result<Arc<HeightTile>> {
        let key = (source.settings.id.clone(), tile);
        {
            let mut kept = self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(at) = kept.iter().position(|(known, _)| *known == key) {
                let found = kept.remove(at);
                kept.push(found.clone());
                return Ok(found.1);
            }
        }
        let picture = self.serve(source, tile).await?;
        let unusable = |reason: String| source.unusable(format!("tile {tile}: {reason}"));
        let turn = self.shared.readers.acquire().await.map_err(|_| MapError::Closed)?;
        let reading = source.reading();
        let read = blocking(move || {
            let _reading = reading;
            HeightTile::read(&picture.data, encoding).map_err(MapError::Storage)
        })
        .await;
        drop(turn);
        let height = read.map_err(|error| unusable(error.to_string()))?;
        let size = self.known_grid(source).await?.level(tile.level).map(|level| level.tile_px);
        if size.is_some_and(|size| size != height.size()) {
            return Err(unusable(format!("it has {:?} pixels; set tile_px", height.size())));
        }
        let height = Arc::new(height);
        let mut kept = self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push((key, height.clone()));
        let count = |(_, tile): &(_, Arc<HeightTile>)| tile.size().map(|side| side as usize).iter().product::<usize>();
        while kept.len() > 1 && kept.iter().map(count).sum::<usize>() > KEPT_HEIGHTS {
            kept.remove(0);
        }
        Ok(height)
    }

    /// The ground under a line of geodesics.
    ///
    /// # Errors
    /// [`MapError::Request`] for fewer than one or too many points.
    pub async fn profile(&self, points: &[Corner], spacing_m: Option<f64>) -> Result<Profile> {
        if points.is_empty() || points.len() > MAX_POINTS / 2 {
            return Err(MapError::Request(format!("points: takes 1 to {}", MAX_POINTS / 2)));
        }
        if spacing_m.is_some_and(|spacing| !(spacing.is_finite() && spacing > 0.0)) {
            return Err(MapError::Request("spacing_m: must be greater than 0".to_owned()));
        }
        let places = elevation::along(points, spacing_m.unwrap_or(30.0));
        let asked: Vec<Corner> = places.iter().map(|(_, at)| *at).collect();
        let (heights, error) = self.heights(&asked).await?;
        let mut sources: Vec<String> = heights.iter().filter_map(|height| height.source.clone()).collect();
        sources.sort();
        sources.dedup();
        let known = heights.iter().filter_map(|height| height.alt_amsl_m);
        Ok(Profile {
            length_m: places.last().map_or(0.0, |(distance_m, _)| *distance_m),
            max_alt_amsl_m: known.reduce(f64::max),
            unknown: u32::try_from(heights.iter().filter(|height| height.alt_amsl_m.is_none()).count())
                .unwrap_or(u32::MAX),
            datum: heights.iter().find_map(|height| height.datum.clone()),
            samples: places
                .into_iter()
                .zip(heights)
                .map(|((distance_m, at), height)| ProfileSample {
                    distance_m,
                    lat_deg: at.lat_deg,
                    lon_deg: at.lon_deg,
                    alt_amsl_m: height.alt_amsl_m,
                })
                .collect(),
            sources,
            error,
        })
    }
}

/// The pixels around a place with their weights.
type Neighbours = [(f64, TileId, [u32; 2]); 4];

/// Distance of two pixels of a level, m; Web Mercator stretches by the latitude.
fn metres_per_pixel(grid: &TileGrid, level: u8, lat_deg: f64) -> f64 {
    let stretch = if grid.crs == Crs::WebMercator { lat_deg.to_radians().cos() } else { 1.0 };
    grid.levels[usize::from(level)].resolution * grid.crs.metres_per_unit() * stretch
}

/// The height between four pixels; `None` where one of them is void or was not read.
fn between(near: &Neighbours, heights: &HashMap<TileId, Arc<HeightTile>>, has_land_below_sea: bool) -> Option<f64> {
    let mut sum = 0.0;
    for (weight, tile, [column, row]) in near {
        if *weight > 0.0 {
            sum += weight * elevation::surface_m(heights.get(tile)?.at(*column, *row)?, has_land_below_sea);
        }
    }
    Some(sum)
}

/// For each place the four pixels around it, in whatever tiles they are; `None` off the grid.
fn neighbours(grid: &TileGrid, level: u8, points: &[Corner]) -> Vec<Option<Neighbours>> {
    let Some(of) = grid.level(level) else { return vec![None; points.len()] };
    let size = of.size.unwrap_or([u32::MAX / 4096; 2]);
    let pixels = [0, 1].map(|axis| u64::from(size[axis]) * u64::from(of.tile_px[axis]));
    let world = grid.crs.world_width().map(|width| width / of.resolution);
    let is_whole = world.is_some_and(|world| (world - pixels[0] as f64).abs() < 0.5);
    let around = |at: &Corner| {
        let position = grid.position(of, grid.crs.project(at.lat_deg, at.lon_deg));
        // Pixels stand for their middles, and half a pixel beyond the outermost is still the grid's own ground.
        let on_grid = |place: f64, count: u64| {
            let last = count as f64 - 1.0;
            (-0.5..=last + 0.5).contains(&place).then(|| place.clamp(0.0, last))
        };
        let column = position[0] * f64::from(of.tile_px[0]) - 0.5;
        let wrapped = world.map_or(column, |world| column.rem_euclid(world));
        let column =
            if is_whole { wrapped } else { on_grid(column, pixels[0]).or_else(|| on_grid(wrapped, pixels[0]))? };
        let row = on_grid(position[1] * f64::from(of.tile_px[1]) - 0.5, pixels[1])?;
        Some(elevation::corners(column, row).map(|(weight, [column, row])| {
            let (column, row) = (u64::from(column), u64::from(row));
            let column = if is_whole { column % pixels[0] } else { column.min(pixels[0] - 1) } as u32;
            let row = row.min(pixels[1] - 1) as u32;
            let tile = TileId { level, column: column / of.tile_px[0], row: row / of.tile_px[1] };
            (weight, tile, [column % of.tile_px[0], row % of.tile_px[1]])
        }))
    };
    points.iter().map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crs::Crs;
    use crate::grid::Level;

    fn column(grid: &TileGrid, level: u8, [x, y]: [f64; 2]) -> Option<u32> {
        let at = grid.crs.unproject([x, y]).expect("on Earth");
        let near = neighbours(grid, level, &[Corner { lat_deg: at.lat_deg(), lon_deg: at.lon_deg() }])[0]?;
        let (_, tile, [column, _]) = near[0];
        Some(tile.column * 256 + column)
    }

    #[test]
    fn a_sheet_has_no_ground_beside_it() {
        // 2 × 2 tiles of 10 m, in UTM and in Web Mercator.
        let utm = Crs::from_epsg(25_830).expect("known");
        for (crs, origin) in [(utm, [430_000.0, 4_470_000.0]), (Crs::WebMercator, [-420_000.0, 4_920_000.0])] {
            let level = Level { resolution: 10.0, origin, tile_px: [256, 256], size: Some([2, 2]) };
            let grid = TileGrid::new(crs, vec![level]);
            let at = |x: f64, y: f64| column(&grid, 0, [origin[0] + x, origin[1] - y]);
            assert_eq!(at(1_005.0, 1_005.0), Some(100));
            assert_eq!((at(1.0, 1_005.0), at(5_119.0, 1_005.0)), (Some(0), Some(511)));
            for (x, y) in [(-1_000.0, 1_000.0), (6_120.0, 1_000.0), (1_000.0, -1_000.0), (1_000.0, 6_120.0)] {
                assert_eq!(at(x, y), None, "{crs:?} {x} {y}");
            }
        }
    }

    #[test]
    fn the_finest_levels_go_round_the_whole_world() {
        let grid = TileGrid::standard(Crs::WebMercator, 256, 0, 24);
        let half_m = 0.5 * Crs::WebMercator.world_width().expect("round");
        let resolution = grid.levels[24].resolution;
        assert_eq!(column(&grid, 24, [100.5 * resolution, 0.0]), Some((1 << 31) + 100));
        assert_eq!(column(&grid, 2, [half_m - 0.25 * grid.levels[2].resolution, 0.0]), Some(1023));
    }
}
