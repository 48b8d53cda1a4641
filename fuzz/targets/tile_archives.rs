//! Archives of tiles: PMTiles and MBTiles.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_maps::grid::TileId;
use vencejo_maps::kinds::mbtiles::Mbtiles;
use vencejo_maps::kinds::pmtiles::Pmtiles;
use vencejo_maps::live::TileFile;

mod on_disk;
use on_disk::on_disk;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let path = &on_disk(data, "tiles");
    if data.starts_with(b"SQLite") {
        if let Ok(tiles) = Mbtiles::open(path, 256) {
            look(&tiles);
        }
    } else if let Ok(tiles) = Pmtiles::open(path, 256) {
        look(&tiles);
    }
}));

fn look(tiles: &dyn TileFile) {
    let _ = tiles.about();
    for level in 0..4 {
        let _ = tiles.tile(TileId { level, column: 0, row: 0 });
    }
}
