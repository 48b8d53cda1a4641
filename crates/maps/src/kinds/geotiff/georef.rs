//! Where a GeoTIFF lies, and what its numbers mean as heights: coordinate system, transformation, vertical system and
//! unit.

use tiff::tags::Tag;

use super::input::{TiffDecoder, doubles};
use crate::crs::Crs;
use crate::grid::{Level, MAX_LEVELS, TileGrid};
use crate::xml::Element;

/// Pixels of the side of the tiles that are made.
pub(super) const TILE_PX: u32 = 256;
/// So many times as high as wide, or the other way, may a pixel be. Near the poles those of equal angles are stretched.
const MOST_STRETCHED: f64 = 1000.0;

/// A grid whose finest level has the file's own pixels and whose coarsest holds it in one tile.
pub(super) fn own_grid(crs: Crs, origin: [f64; 2], pixel: [f64; 2], size: [u32; 2], extent: [f64; 4]) -> TileGrid {
    let finest = pixel[0].min(pixel[1]);
    let sides = [f64::from(size[0]) * pixel[0] / finest, f64::from(size[1]) * pixel[1] / finest];
    let tiles = (sides[0].max(sides[1]) / f64::from(TILE_PX)).max(1.0);
    let count = (tiles.log2().ceil() as usize + 1).min(MAX_LEVELS);
    let levels = (0..count).map(|level| {
        let coarser = f64::from(1_u32 << (count - 1 - level));
        let tiles = sides.map(|side| (side / coarser / f64::from(TILE_PX)).ceil().max(1.0) as u32);
        Level { resolution: finest * coarser, origin, tile_px: [TILE_PX, TILE_PX], size: Some(tiles) }
    });
    let mut grid = TileGrid::new(crs, levels.collect());
    grid.extent = Some(extent);
    grid
}

/// The system by the GeoKey directory (tag 34735): keys of four numbers each behind a header of four.
pub(super) fn crs_of(decoder: &mut TiffDecoder) -> Result<Crs, String> {
    let keys = decoder
        .get_tag_u16_vec(Tag::GeoKeyDirectoryTag)
        .map_err(|_| "it is not georeferenced; use it as kind image, with its corners".to_owned())?;
    let key = |wanted: u16| keys.chunks_exact(4).skip(1).find(|key| key[0] == wanted && key[1] == 0).map(|key| key[3]);
    const PROJECTED: u16 = 3072;
    const GEOGRAPHIC: u16 = 2048;
    let code = if key(1024) == Some(2) { key(GEOGRAPHIC) } else { key(PROJECTED).or_else(|| key(GEOGRAPHIC)) };
    match code {
        Some(code) if code != 32_767 => Crs::from_epsg(code.into()).ok_or_else(|| {
            format!("it is in EPSG:{code}, which is not known here; make it with gdalwarp -t_srs EPSG:3857")
        }),
        _ => Err("its system has no EPSG code; make it with gdalwarp -t_srs EPSG:3857".to_owned()),
    }
}

/// Whether its vertical system (key 4096) is an ellipsoid: 5000 to 5099 (GeoTIFF 1.0, section 6.3.4.1).
pub(super) fn is_ellipsoidal(decoder: &mut TiffDecoder) -> bool {
    const VERTICAL: u16 = 4096;
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    keys.chunks_exact(4).skip(1).any(|key| key[..2] == [VERTICAL, 0] && (5000..5100).contains(&key[3]))
}

/// Corner of the top left pixel, and a pixel's size.
pub(super) fn transform_of(decoder: &mut TiffDecoder) -> Result<([f64; 2], [f64; 2]), String> {
    const RASTER_TYPE: u16 = 1025;
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let is_point = keys.chunks_exact(4).skip(1).any(|key| key[0] == RASTER_TYPE && key[3] == 2);
    let turned = || "it is turned against north; make it with gdalwarp".to_owned();
    let (mut origin, pixel) = if let Some(matrix) = doubles(decoder, 34_264) {
        let [a, b, _, d, e, f, _, h, ..] = matrix.as_slice() else {
            return Err("its transformation is broken".to_owned());
        };
        if *b != 0.0 || *e != 0.0 || *a <= 0.0 || *f >= 0.0 {
            return Err(turned());
        }
        ([*d, *h], [*a, -*f])
    } else {
        let scale =
            doubles(decoder, 33_550).ok_or("it does not say where it lies; use it as kind image, with its corners")?;
        let tie =
            doubles(decoder, 33_922).ok_or("it does not say where it lies; use it as kind image, with its corners")?;
        let ([sx, sy, ..], [i, j, _, x, y, ..]) = (scale.as_slice(), tie.as_slice()) else {
            return Err("its tie point is broken".to_owned());
        };
        ([x - i * sx, y + j * sy], [*sx, *sy])
    };
    if is_point {
        origin = [origin[0] - pixel[0] / 2.0, origin[1] + pixel[1] / 2.0];
    }
    let is_right =
        origin.iter().all(|number| number.is_finite()) && pixel.iter().all(|size| size.is_finite() && *size > 0.0);
    if !is_right {
        return Err(turned());
    }
    if pixel[0].max(pixel[1]) > pixel[0].min(pixel[1]) * MOST_STRETCHED {
        return Err(format!(
            "its pixels are {:e} by {:e}: those of the ground are about as high as wide",
            pixel[0], pixel[1]
        ));
    }
    Ok((origin, pixel))
}

/// How heights above mean sea level come of the numbers of a file: `number * scale + offset`, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measure {
    pub(super) scale: f64,
    pub(super) offset_m: f64,
}

impl Measure {
    /// By the unit of the vertical system (GeoKeys 4096 and 4099) and what GDAL notes of the first band in its own tag
    /// (42112): unit, scale and offset.
    ///
    /// # Errors
    /// For a unit that is not known, in words.
    pub(super) fn of(decoder: &mut TiffDecoder) -> Result<Self, String> {
        let noted = decoder.get_tag_ascii_string(Tag::Unknown(GDAL_METADATA)).unwrap_or_default();
        let noted = Element::parse(noted.trim_end_matches('\0').as_bytes()).ok();
        let note = |role: &str| {
            let of_first = |item: &&Element| item.attribute("sample").is_none_or(|sample| sample == "0");
            let mut items = noted.iter().flat_map(|root| root.all("Item")).filter(of_first);
            items.find(|item| item.attribute("role") == Some(role)).map(|item| item.text.trim().to_owned())
        };
        let number = |role: &str, usual: f64| match note(role) {
            None => Ok(usual),
            Some(text) => text.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
                format!("the {role} of its heights is \"{text}\", not a number; make it with gdal_translate -unscale")
            }),
        };
        let (scale, offset) = (number("scale", 1.0)?, number("offset", 0.0)?);
        let unit_m = match note("unittype").filter(|unit| !unit.is_empty()) {
            Some(unit) => unit_m(&unit)?,
            None => key_unit_m(decoder)?,
        };
        Ok(Self { scale: scale * unit_m, offset_m: offset * unit_m })
    }
}

/// GDAL's own tag: XML with what TIFF has no tags for.
const GDAL_METADATA: u16 = 42_112;
/// The international foot, and that of the surveys of the United States, m.
const FOOT_M: f64 = 0.304_8;
const SURVEY_FOOT_M: f64 = 1_200.0 / 3_937.0;

/// Metres of a unit by its name, as GDAL and PROJ write it.
fn unit_m(name: &str) -> Result<f64, String> {
    match name.to_ascii_lowercase().replace(['-', '_'], " ").as_str() {
        "m" | "metre" | "meter" | "metres" | "meters" => Ok(1.0),
        "ft" | "foot" | "feet" | "international foot" => Ok(FOOT_M),
        "us ft" | "ftus" | "us survey foot" | "foot us" => Ok(SURVEY_FOOT_M),
        "cm" | "centimetre" | "centimeter" => Ok(0.01),
        _ => Err(unknown_unit(&format!("\"{name}\""))),
    }
}

/// Metres of the unit that the keys of a file name; 1 without such keys.
fn key_unit_m(decoder: &mut TiffDecoder) -> Result<f64, String> {
    const VERTICAL: u16 = 4096;
    const VERTICAL_UNITS: u16 = 4099;
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let key = |wanted: u16| keys.chunks_exact(4).skip(1).find(|key| key[..2] == [wanted, 0]).map(|key| key[3]);
    match (key(VERTICAL_UNITS), key(VERTICAL)) {
        (Some(9001), _) => Ok(1.0),
        (Some(9002), _) => Ok(FOOT_M),
        (Some(9003), _) => Ok(SURVEY_FOOT_M),
        (Some(unit), _) if unit != 0 && unit != 32_767 => Err(unknown_unit(&format!("EPSG:{unit}"))),
        // NAVD88 in feet and in survey feet.
        (_, Some(8228)) => Ok(FOOT_M),
        (_, Some(6360)) => Ok(SURVEY_FOOT_M),
        _ => Ok(1.0),
    }
}

fn unknown_unit(unit: &str) -> String {
    format!("its heights are in {unit}, a unit that is not known here; convert them to metres with gdal_calc")
}
