//! Heights of the ground from pictures and files: interpolation, encodings, and what is not known.

use serde::Serialize;
use utoipa::ToSchema;

use crate::geo::Corner;
use crate::raster::Raster;
use crate::settings::Encoding;

/// No land lies lower: the shore of the Dead Sea is 430 m below sea level.
pub const LOWEST_LAND_M: f64 = -500.0;
/// Nor higher: Mount Everest's top is at 8,849 m.
pub const HIGHEST_LAND_M: f64 = 9_000.0;
/// How rasters mark ground that is not known, whether or not they say so.
const USUAL_VOIDS: [f64; 3] = [-9_999.0, -32_767.0, -32_768.0];
/// Pixels of a tile of heights at most.
const MAX_PX: u64 = 2048 * 2048;

/// Height of the ground at a place, as far as it is known.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct ElevationPoint {
    /// Height of the ground above mean sea level; null: unknown.
    #[schema(required = true)]
    pub alt_amsl_m: Option<f64>,
    /// Id of the source that it comes from.
    #[schema(required = true)]
    pub source: Option<String>,
    /// How far apart heights are in that source.
    #[schema(required = true)]
    pub resolution_m: Option<f64>,
    /// Datum of the heights: the geoid model of mean sea level.
    #[schema(required = true)]
    pub datum: Option<String>,
}

/// Whether a number of a raster marks ground that is not known.
pub fn is_usual_void(number: f64) -> bool {
    USUAL_VOIDS.contains(&number)
}

/// A height above mean sea level, where there can be land: what lies outside is a void.
pub fn land_m(alt_amsl_m: f64) -> Option<f64> {
    (LOWEST_LAND_M..=HIGHEST_LAND_M).contains(&alt_amsl_m).then_some(alt_amsl_m)
}

/// The ground below a plane, from a model that may contain the sea floor: over water the water's surface.
/// Heights alone do not distinguish them, so land below sea level counts only where the settings say so.
pub fn surface_m(alt_amsl_m: f64, has_land_below_sea: bool) -> f64 {
    let is_land = alt_amsl_m >= 0.0 || has_land_below_sea && alt_amsl_m >= LOWEST_LAND_M;
    if is_land { alt_amsl_m } else { 0.0 }
}

/// Weights of the four neighbours of a place between pixels. A neighbour without weight stands on the first, so that
/// all exist.
pub fn corners(column: f64, row: f64) -> [(f64, [u32; 2]); 4] {
    // A millionth of a pixel is the arithmetic's, not the ground's: it must not draw in a void neighbour.
    let snap = |at: f64| if (at - at.round()).abs() < 1e-6 { at.round() } else { at };
    let (column, row) = (snap(column), snap(row));
    let (left, top) = (column.floor(), row.floor());
    let (right, down) = (column - left, row - top);
    let at = |dx: f64, dy: f64| {
        [if right > 0.0 { left + dx } else { left } as u32, if down > 0.0 { top + dy } else { top } as u32]
    };
    [
        ((1.0 - right) * (1.0 - down), at(0.0, 0.0)),
        (right * (1.0 - down), at(1.0, 0.0)),
        ((1.0 - right) * down, at(0.0, 1.0)),
        (right * down, at(1.0, 1.0)),
    ]
}

/// The heights of a tile.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightTile {
    width: u32,
    height: u32,
    values: Vec<Option<f32>>,
}

impl HeightTile {
    /// Reads a tile.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn read(bytes: &[u8], encoding: Encoding) -> Result<Self, String> {
        let raster = Raster::read(bytes, MAX_PX)?;
        let values = raster.rgba.chunks_exact(4).map(|pixel| decode(pixel, encoding)).collect();
        Ok(Self { width: raster.width, height: raster.height, values })
    }

    /// Pixels a row and a column.
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The height of a pixel; `None` where it is void or outside.
    pub fn at(&self, column: u32, row: u32) -> Option<f64> {
        let inside = column < self.width && row < self.height;
        let value = inside.then(|| self.values[row as usize * self.width as usize + column as usize]).flatten();
        value.map(f64::from)
    }
}

/// A height from a colour. Black, transparent, and what lies outside Earth's range are void.
fn decode(pixel: &[u8], encoding: Encoding) -> Option<f32> {
    let [red, green, blue, alpha] = *pixel else { return None };
    if alpha == 0 || (red, green, blue) == (0, 0, 0) {
        return None;
    }
    let [red, green, blue] = [red, green, blue].map(f32::from);
    let alt_m = match encoding {
        // github.com/tilezen/joerd, docs/formats.md.
        Encoding::Terrarium => red * 256.0 + green + blue / 256.0 - 32_768.0,
        // Mapbox, "Terrain-RGB v1".
        Encoding::TerrainRgb => -10_000.0 + (red * 65_536.0 + green * 256.0 + blue) * 0.1,
    };
    (-12_000.0..=HIGHEST_LAND_M as f32).contains(&alt_m).then_some(alt_m)
}

/// A place of a profile.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = ElevationProfileSample)]
pub struct ProfileSample {
    /// Along the line.
    pub distance_m: f64,
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height of the ground above mean sea level; null: unknown.
    #[schema(required = true)]
    pub alt_amsl_m: Option<f64>,
}

/// The ground under a line.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = ElevationProfile)]
pub struct Profile {
    /// Of the line.
    pub length_m: f64,
    /// Evenly between the line's points, which are all among them.
    pub samples: Vec<ProfileSample>,
    /// Ids of the sources that heights come from.
    pub sources: Vec<String>,
    /// Datum of the heights.
    #[schema(required = true)]
    pub datum: Option<String>,
    /// The highest ground that is known.
    #[schema(required = true)]
    pub max_alt_amsl_m: Option<f64>,
    /// Samples without a height.
    pub unknown: u32,
    /// Why a source failed.
    #[schema(required = true)]
    pub error: Option<String>,
}

/// Samples of a profile at most.
pub const MAX_SAMPLES: usize = 2000;

/// Places along a line of geodesics, with their distance from its start. All points of the line are among them.
pub fn along(points: &[Corner], spacing_m: f64) -> Vec<(f64, Corner)> {
    use vencejo_flight::geodesy::{GeoPoint, direct, inverse};
    let point = |at: &Corner| GeoPoint::new(at.lat_deg, at.lon_deg).ok();
    let legs: Vec<_> = points
        .windows(2)
        .filter_map(|pair| Some((point(&pair[0])?, pair[1], inverse(point(&pair[0])?, point(&pair[1])?))))
        .collect();
    let total: f64 = legs.iter().map(|(_, _, line)| line.distance_m).sum();
    let room = MAX_SAMPLES.saturating_sub(points.len()).max(1) as f64;
    let spacing_m = spacing_m.max(total / room).max(0.1);
    let mut samples: Vec<_> = points.first().map(|first| (0.0, *first)).into_iter().collect();
    let mut before = 0.0;
    for (from, to, line) in legs {
        let pieces = (line.distance_m / spacing_m).ceil().max(1.0);
        for piece in 1..pieces as u32 {
            let distance_m = line.distance_m * f64::from(piece) / pieces;
            let at = direct(from, line.bearing_start_deg, distance_m);
            samples.push((before + distance_m, Corner { lat_deg: at.lat_deg(), lon_deg: at.lon_deg() }));
        }
        before += line.distance_m;
        samples.push((before, to));
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_heights_or_void() {
        for (pixel, encoding, height) in [
            ([137, 219, 68, 255], Encoding::Terrarium, Some(2_523.265_6)),
            ([128, 0, 0, 255], Encoding::Terrarium, Some(0.0)),
            ([0, 0, 0, 255], Encoding::Terrarium, None),
            ([255, 255, 255, 255], Encoding::Terrarium, None),
            ([128, 0, 0, 0], Encoding::Terrarium, None),
            ([1, 134, 160, 255], Encoding::TerrainRgb, Some(0.0)),
            ([0, 0, 0, 255], Encoding::TerrainRgb, None),
        ] {
            assert_eq!(decode(&pixel, encoding), height, "{pixel:?}");
        }
    }

    #[test]
    fn over_water_the_ground_is_the_water() {
        for (alt_m, plain, said) in [(12.5, 12.5, 12.5), (-3.0, 0.0, -3.0), (-430.0, 0.0, -430.0), (-4000.0, 0.0, 0.0)]
        {
            assert_eq!((surface_m(alt_m, false), surface_m(alt_m, true)), (plain, said));
        }
    }

    #[test]
    fn weights_sum_to_one_and_neighbours_exist() {
        for (column, row) in [(0.0, 0.0), (255.0, 255.0), (3.25, 7.75), (255.0, 1.5)] {
            let corners = corners(column, row);
            let sum: f64 = corners.iter().map(|(weight, _)| weight).sum();
            let x: f64 = corners.iter().map(|(weight, [x, _])| weight * f64::from(*x)).sum();
            assert!((sum - 1.0).abs() < 1e-12 && (x - column).abs() < 1e-12);
            assert!(corners.iter().all(|(_, [x, y])| *x <= 255 && *y <= 255));
        }
    }

    #[test]
    fn a_profile_has_all_points_and_bounded_samples() {
        let points =
            [(40.0, -4.0), (40.0, -3.99), (40.01, -3.99)].map(|(lat_deg, lon_deg)| Corner { lat_deg, lon_deg });
        let samples = along(&points, 100.0);
        assert_eq!((samples.len(), samples[0].1, samples.last().expect("some").1), (22, points[0], points[2]));
        assert!(samples.iter().any(|(_, at)| *at == points[1]));
        assert!(samples.windows(2).all(|pair| pair[1].0 - pair[0].0 <= 100.0 + 1e-6));
        assert!(along(&points, 0.001).len() <= MAX_SAMPLES);
        assert_eq!(along(&points[..1], 10.0).len(), 1);
        assert!(along(&[], 10.0).is_empty());
    }
}
