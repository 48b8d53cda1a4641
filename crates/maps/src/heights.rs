//! Heights of the ground from the sources of heights: at places and along lines. Unknown stays unknown.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError};

use tokio::task::JoinSet;

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
/// Tiles of heights that one question may need.
const MAX_HEIGHT_TILES: usize = 64;
/// Places of one question at most.
pub const MAX_POINTS: usize = 2000;

impl Maps {
    /// The ground's height at places, and why a source failed, if one did. Unknown stays unknown.
    ///
    /// # Errors
    /// [`MapError::Request`] for too many places or places that are none; [`MapError::Closed`].
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
                let height = |at: &Corner| Ok(dem.height(at.lat_deg, at.lon_deg)?.map(|h| (h.alt_m, h.resolution_m)));
                points.iter().map(height).collect()
            });
            let result = read.await;
            match &result {
                Ok(_) => source.succeeded(None, self.now_s()),
                Err(error) => source.failed(None, error, None, self.now_s()),
            }
            return result;
        }
        if let Live::Unusable(reason) = &source.live {
            return Err(source.unusable(reason.clone()));
        }
        let encoding = source.settings.encoding.ok_or_else(|| source.unusable("its encoding is not said"))?;
        let grid = self.known_grid(source).await?;
        // The finest level whose tiles are not too many.
        let mut wanted = None;
        for level in (grid.min_level..=grid.max_level).rev() {
            let places = neighbours(&grid, level, &points);
            let mut tiles: Vec<TileId> =
                places.iter().flatten().flat_map(|near| near.iter().map(|(_, tile, _)| *tile)).collect();
            tiles.sort();
            tiles.dedup();
            let is_enough = tiles.len() <= MAX_HEIGHT_TILES;
            wanted = Some((level, places, tiles));
            if is_enough {
                break;
            }
        }
        let Some((level, places, tiles)) = wanted else { return Ok(vec![None; points.len()]) };
        let mut fetches = JoinSet::new();
        for tile in tiles {
            let (maps, source) = (self.clone(), source.clone());
            fetches.spawn(async move { (tile, maps.height_tile(&source, tile, encoding).await) });
        }
        let mut heights = HashMap::new();
        while let Some(done) = fetches.join_next().await {
            match done {
                Ok((tile, Ok(height))) => {
                    heights.insert(tile, height);
                }
                Ok((_, Err(MapError::NoTile))) | Err(_) => {}
                Ok((_, Err(error))) => *fault = Some(error.to_string()),
            }
        }
        let resolution = grid.levels[usize::from(level)].resolution * grid.crs.metres_per_unit();
        let height = |(at, near): (&Corner, &Option<Neighbours>)| {
            let near = near.as_ref()?;
            let mut sum = 0.0;
            for (weight, tile, [column, row]) in near {
                if *weight > 0.0 {
                    let alt_m = heights.get(tile)?.at(*column, *row)?;
                    sum += weight * elevation::surface_m(alt_m, source.settings.below_sea_level);
                }
            }
            // Web Mercator stretches by the latitude.
            Some((sum, resolution * at.lat_deg.to_radians().cos()))
        };
        Ok(points.iter().zip(&places).map(height).collect())
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

/// For each place the four pixels around it, in whatever tiles they are; `None` off the grid.
fn neighbours(grid: &TileGrid, level: u8, points: &[Corner]) -> Vec<Option<Neighbours>> {
    let Some(of) = grid.level(level) else { return vec![None; points.len()] };
    let size = of.size.unwrap_or([u32::MAX / 4096; 2]);
    let pixels = [size[0] * of.tile_px[0], size[1] * of.tile_px[1]];
    let is_round = grid.crs.world_width().is_some();
    let around = |at: &Corner| {
        let position = grid.position(of, grid.crs.project(at.lat_deg, at.lon_deg));
        // Pixels stand for their middles.
        let column = (position[0] * f64::from(of.tile_px[0]) - 0.5).rem_euclid(f64::from(pixels[0]));
        let row = position[1] * f64::from(of.tile_px[1]) - 0.5;
        if !(-0.5..f64::from(pixels[1])).contains(&row) {
            return None;
        }
        let row = row.clamp(0.0, f64::from(pixels[1] - 1));
        Some(elevation::corners(column, row).map(|(weight, [column, row])| {
            let column = if is_round { column % pixels[0] } else { column.min(pixels[0] - 1) };
            let row = row.min(pixels[1] - 1);
            let tile = TileId { level, column: column / of.tile_px[0], row: row / of.tile_px[1] };
            (weight, tile, [column % of.tile_px[0], row % of.tile_px[1]])
        }))
    };
    points.iter().map(around).collect()
}
