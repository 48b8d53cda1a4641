//! The kinds of map sources. What there is to a kind is in its module of `kinds/`.

/// Gives the list to a macro: of each kind its documentation, its name (in files and in the API in small letters) and
/// its module.
macro_rules! every_kind {
    ($take:ident) => {
        $take! {
            /// Tiles by an address with `{z}`, `{x}` and `{y}`.
            Xyz => xyz,
            /// A Web Map Service, 1.1.1 or 1.3.0.
            Wms => wms,
            /// A Web Map Tile Service, 1.0.0.
            Wmts => wmts,
            /// Google's Map Tiles API.
            Google => google,
            /// A file of tiles in SQLite.
            Mbtiles => mbtiles,
            /// A file of tiles, PMTiles version 3.
            Pmtiles => pmtiles,
            /// A folder of tiles, a file each: `{z}/{x}/{y}.png`, `.jpg` or `.webp`.
            Folder => folder,
            /// A GeoTIFF: a file, with overviews or without, or a cloud-optimised one (COG) by its address.
            Geotiff => geotiff,
            /// A picture whose four corners are known.
            Image => image,
            /// Heights: a file or a folder of SRTM `.hgt`, `.hgt.gz` or GeoTIFF.
            Dem => dem,
        }
    };
}
