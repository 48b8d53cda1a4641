//! Images and elevations in files: GeoTIFF, and the headers of PNG, JPEG and WebP.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_maps::kinds::geotiff::file::GeoTiff;
use vencejo_maps::sniff::{Picture, check_picture, describe, size_px};

mod on_disk;
use on_disk::on_disk;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    if let Some(kind) = Picture::of(data) {
        let _ = (size_px(kind, data), check_picture(data));
    }
    let _ = describe(data);
    let Ok(raster) = GeoTiff::open(&on_disk(data, "tif")) else { return };
    let _ = (raster.has_numbers(), raster.is_heights(), raster.resolution_m());
    if let Some(bounds) = raster.bounds() {
        let _ = raster.height_m(
            f64::midpoint(bounds.south_deg, bounds.north_deg),
            f64::midpoint(bounds.west_deg, bounds.east_deg),
            true,
        );
    }
}));
