//! Files that claim more than they hold, read under an allocator that counts: what they cost is measured, not assumed.
//! Each was once the end of the process, or gigabytes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_maps::crs::Crs;
use vencejo_maps::geo::Corner;
use vencejo_maps::grid::TileId;
use vencejo_maps::kinds::dem::Dem;
use vencejo_maps::kinds::geotiff::file::GeoTiff;
use vencejo_maps::kinds::image::Overlay;
use vencejo_maps::kinds::mbtiles::Mbtiles;
use vencejo_maps::kinds::pmtiles::Pmtiles;
use vencejo_maps::live::HeightFile;
use vencejo_maps::live::TileFile;
use vencejo_maps::memory::MAX_READING;
use vencejo_maps::raster::Raster;

/// Counts what is held, and the most that ever was.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

#[allow(unsafe_code, reason = "an allocator is unsafe by its interface; this one hands everything on")]
// SAFETY: every call is the system allocator's own, with the same arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One test measures at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long this process has computed: on a machine that is busy with other things, what the clock says is not what
/// work takes.
fn computed() -> Duration {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = text.rsplit(')').next().unwrap_or_default();
    // Hundredths of a second for the program, and for the system on its behalf (proc(5), fields 14 and 15).
    let ticks: u64 = after_name.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    Duration::from_millis(ticks * 10)
}

/// What work gives, the most bytes it held, and how long it took.
fn measured<T>(work: impl FnOnce() -> T) -> (T, usize, Duration) {
    let before = HELD.load(Ordering::SeqCst);
    MOST.store(before, Ordering::SeqCst);
    let begun = computed();
    let given = work();
    (given, MOST.load(Ordering::SeqCst).saturating_sub(before), computed().saturating_sub(begun))
}

const MIB: usize = 1024 * 1024;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("vencejo-memory-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A tag: number, type, count and its value or where its values are.
type TagValue = (u16, u16, u32, u32);

/// A GeoTIFF of one image: its tags beside those that say where it lies, and what stands behind them.
fn tiff(tags: &[TagValue], data: &[u8]) -> Vec<u8> {
    let keys: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 25_830];
    let doubles = [2.0_f64, 2.0, 0.0, 0.0, 0.0, 0.0, 432_000.0, 4_465_000.0, 0.0];
    let count = tags.len() + 3;
    let behind = u32::try_from(8 + 2 + 12 * count + 4).expect("short");
    let mut all = tags.to_vec();
    all.extend([(33_550, 12, 3, behind + 32), (33_922, 12, 6, behind + 56), (34_735, 3, 16, behind)]);
    all.sort_unstable();
    let mut file = b"II*\0\x08\0\0\0".to_vec();
    file.extend(u16::try_from(count).expect("few").to_le_bytes());
    for (tag, kind, values, value) in all {
        file.extend(tag.to_le_bytes());
        file.extend(kind.to_le_bytes());
        file.extend(values.to_le_bytes());
        file.extend(value.to_le_bytes());
    }
    file.extend([0; 4]);
    file.extend(keys.iter().flat_map(|key| key.to_le_bytes()));
    file.extend(doubles.iter().flat_map(|number| number.to_le_bytes()));
    file.extend(data);
    file
}

/// Offset of the data in a [`tiff`] of `count` tags.
fn data_at(tags: usize) -> u32 {
    u32::try_from(8 + 2 + 12 * (tags + 3) + 4 + 32 + 72).expect("short")
}

/// Grey pixels of 8 bits in one strip, or one tile when `tile` is given.
fn claimed(width: u32, height: u32, packing: u32, tile: Option<u32>, bytes: u32) -> Vec<u8> {
    let mut tags: Vec<TagValue> =
        vec![(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 8), (259, 3, 1, packing), (262, 3, 1, 1)];
    let at = data_at(tags.len() + if tile.is_some() { 4 } else { 3 });
    match tile {
        Some(side) => tags.extend([(322, 4, 1, side), (323, 4, 1, side), (324, 4, 1, at), (325, 4, 1, bytes)]),
        None => tags.extend([(273, 4, 1, at), (278, 4, 1, height), (279, 4, 1, bytes)]),
    }
    tiff(&tags, &[0; 600])
}

/// Opens a file and reads its coarsest tile and a height.
fn look(path: &Path) -> Result<(), String> {
    let file = GeoTiff::open(path)?;
    let told = |error: vencejo_maps::MapError| error.to_string();
    file.tile(TileId { level: 0, column: 0, row: 0 }).map_err(told)?;
    let _ = file.height_m(40.33, -3.8, false).map_err(told);
    Ok(())
}

// fault 49: 11 GeoTIFFs that claim up to 18 exabytes: refused within 1 s and 4 MiB
#[test]
fn a_tiff_that_claims_much_is_refused_before_room_is_made() {
    let _alone = alone();
    let folder = Folder::new("tiff");
    const HUGE: u32 = 524_288;
    let mut seen = 0;
    for (name, bytes) in [
        ("one strip of nothing", claimed(HUGE, HUGE, 1, None, 0)),
        ("one strip", claimed(HUGE, HUGE, 1, None, 600)),
        ("one packed strip", claimed(HUGE, HUGE, 5, None, 600)),
        ("one packed tile", claimed(HUGE, HUGE, 5, Some(HUGE), 600)),
        ("one deflated tile", claimed(HUGE, HUGE, 8, Some(HUGE), 600)),
        ("one tile of a small picture", claimed(16, 16, 5, Some(HUGE), 600)),
        ("the largest", claimed(u32::MAX, u32::MAX, 5, Some(u32::MAX - 15), 600)),
        ("thirty thousand", claimed(30_000, 30_000, 5, None, 600)),
        ("rows without end", {
            let tags = [
                (256, 4, 1, 4096),
                (257, 4, 1, HUGE),
                (258, 3, 1, 8),
                (259, 3, 1, 1),
                (262, 3, 1, 1),
                (273, 4, 1, data_at(8)),
                (278, 4, 1, u32::MAX),
                (279, 4, 1, 600),
            ];
            tiff(&tags, &[0; 600])
        }),
        ("many numbers a pixel", {
            let tags = [
                (256, 4, 1, 1024),
                (257, 4, 1, 1024),
                (258, 3, 1, 8),
                (259, 3, 1, 1),
                (262, 3, 1, 1),
                (273, 4, 1, data_at(9)),
                (277, 3, 1, 65_535),
                (278, 4, 1, 1024),
                (279, 4, 1, 600),
            ];
            tiff(&tags, &[0; 600])
        }),
        ("a list of eight million", {
            let tags = [
                (256, 4, 1, 1024),
                (257, 4, 1, 1024),
                (258, 3, 1, 8),
                (259, 3, 1, 1),
                (262, 3, 1, 1),
                (273, 4, 8_000_000, 8),
                (278, 4, 1, 1),
                (279, 4, 8_000_000, 8),
            ];
            tiff(&tags, &[0; 600])
        }),
    ] {
        let path = folder.file("a.tif", &bytes);
        let (result, most, took) = measured(|| look(&path));
        assert!(most < 4 * MIB, "{name}: {most} bytes for {}", bytes.len());
        assert!(took < Duration::from_secs(1), "{name}: {took:?}");
        let reason = result.expect_err(name);
        assert!(reason.len() > 20, "{name}: {reason}");
        seen += 1;
    }
    assert_eq!(seen, 11);
    // Tiles that were never written cost nothing.
    let path = folder.file("b.tif", &claimed(2048, 2048, 5, Some(2048), 0));
    let (result, most, _) = measured(|| look(&path));
    assert!(result.is_ok() && most < 4 * MIB, "{result:?} {most}");
}

#[test]
fn a_jpeg_inside_a_tiff_may_not_be_larger_than_its_tile() {
    let _alone = alone();
    let folder = Folder::new("jpeg");
    let mut tags: Vec<TagValue> =
        vec![(256, 4, 1, 256), (257, 4, 1, 256), (258, 3, 1, 8), (259, 3, 1, 7), (262, 3, 1, 1)];
    tags.extend([(322, 4, 1, 256), (323, 4, 1, 256), (324, 4, 1, data_at(9)), (325, 4, 1, 600)]);
    let mut data =
        vec![0xff, 0xd8, 0xff, 0xc2, 0, 17, 8, 0xff, 0xff, 0xff, 0xff, 3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0];
    data.resize(600, 0);
    let path = folder.file("a.tif", &tiff(&tags, &data));
    let (result, most, _) = measured(|| look(&path));
    assert!(result.expect_err("refused").contains("65535 × 65535"));
    assert!(most < 4 * MIB, "{most}");
}

#[test]
fn many_pictures_at_once_share_one_allowance() {
    let _alone = alone();
    let folder = Folder::new("pictures");
    // 25 million pixels each: a hundred megabytes unpacked.
    let path = folder.file("a.png", &Raster::filled(5000, 5000, [1, 2, 3, 255]).to_png());
    let corner = |lat_deg, lon_deg| Corner { lat_deg, lon_deg };
    let corners = [corner(40.01, -4.0), corner(40.01, -3.99), corner(40.0, -3.99), corner(40.0, -4.0)];
    let (drawn, most, _) = measured(|| {
        let pictures: Vec<Overlay> = (0..12).map(|_| Overlay::open(&path, &corners).expect("a picture")).collect();
        std::thread::scope(|scope| {
            let grid = pictures[0].grid();
            let level = grid.max_level;
            let [x, y] = grid.position(&grid.levels[usize::from(level)], Crs::WebMercator.project(40.005, -3.995));
            let tile = TileId { level, column: x as u32, row: y as u32 };
            let drawn: Vec<_> = pictures.iter().map(|picture| scope.spawn(move || picture.tile(tile))).collect();
            let is_drawn =
                |drawn: std::thread::ScopedJoinHandle<'_, _>| matches!(drawn.join().expect("ended"), Ok(Some(_)));
            drawn.into_iter().filter_map(|drawn| is_drawn(drawn).then_some(())).count()
        })
    });
    assert_eq!(drawn, 12, "all are drawn, one after the other where there is no room");
    // What is decoded or drawn, what is kept, and their files and tiles; all twelve would be 1.2 GB.
    let bar = usize::try_from(MAX_READING).expect("small") + (192 + 16) * MIB;
    assert!(most < bar, "{} MB", most / 1_000_000);
}

/// A database of a file's own making.
fn database(folder: &Folder, sql: &str) -> PathBuf {
    let path = folder.0.join("a.mbtiles");
    let _ = std::fs::remove_file(&path);
    let file = rusqlite::Connection::open(&path).expect("a database");
    file.execute_batch("CREATE TABLE metadata (name TEXT, value TEXT); CREATE TABLE real (z, x, y, d, n)")
        .expect("tables");
    file.execute("INSERT INTO real VALUES (0, 0, 0, ?, 1)", [Raster::filled(1, 1, [1; 4]).to_png()]).expect("a tile");
    file.execute_batch(sql).expect("what is asked for");
    path
}

#[test]
fn a_database_runs_nothing_of_its_own() {
    let _alone = alone();
    let folder = Folder::new("sql");
    const AS: &str = "CREATE VIEW tiles AS SELECT z AS zoom_level, x AS tile_column, y AS tile_row,";
    let rows = "INSERT INTO real SELECT 0,0,0,d,n FROM real;".repeat(12);
    let mut seen = 0;
    for (name, sql) in [
        ("zeros", format!("{AS} zeroblob(900000000) AS tile_data FROM real")),
        ("random", format!("{AS} randomblob(900000000) AS tile_data FROM real")),
        (
            "endless",
            "CREATE VIEW tiles AS WITH RECURSIVE n(z) AS (SELECT 0 UNION ALL SELECT z + 1 FROM n) SELECT z AS zoom_level, 0 AS \
             tile_column, 0 AS tile_row, NULL AS tile_data FROM n"
                .to_owned(),
        ),
        ("doubled", {
            let views: String = (1..20)
                .map(|i| format!("CREATE VIEW v{i} AS SELECT a.z, a.x, a.y, a.d FROM v{0} a, v{0} b;", i - 1))
                .collect();
            format!("CREATE VIEW v0 AS SELECT * FROM real; {views} {AS} d AS tile_data FROM v19")
        }),
        ("joined", {
            let joins: String = (0..8).map(|i| format!(", real r{i}")).collect();
            let sum: String = (0..8).map(|i| format!(" + r{i}.n")).collect();
            format!("{rows} {AS} d AS tile_data FROM (SELECT real.* FROM real {joins} WHERE real.n {sum} = 0)")
        }),
        ("virtual", "CREATE VIRTUAL TABLE tiles USING fts5(zoom_level, tile_column, tile_row, tile_data)".to_owned()),
        (
            "generated",
            "CREATE TABLE tiles (zoom_level, tile_column, tile_row, tile_data GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL); \
             INSERT INTO tiles VALUES (0, 0, 0)"
                .to_owned(),
        ),
        ("large", format!("UPDATE real SET d = zeroblob(20000000); {AS} d AS tile_data FROM real")),
        ("pieces", format!("{AS} hex(d) || hex(d) AS tile_data FROM real")),
    ] {
        let path = database(&folder, &sql);
        // SQLite's memory is its own affair: that of the process is looked at.
        let before = resident();
        let begun = computed();
        let result = Mbtiles::open(&path, 256).map(|file| file.tile(TileId { level: 0, column: 0, row: 0 }));
        let (grown, took) = (resident().saturating_sub(before), computed().saturating_sub(begun));
        assert!(grown < 64 * MIB, "{name}: {grown} bytes");
        assert!(took < Duration::from_secs(8), "{name}: {took:?}");
        let reason = result.expect_err(name);
        assert!(reason.contains("MBTiles"), "{name}: {reason}");
        seen += 1;
    }
    assert_eq!(seen, 9);
    // As others write them: a view that joins two tables.
    let join = "CREATE TABLE images (tile_id, tile_data); CREATE TABLE map (zoom_level, tile_column, tile_row, tile_id); \
                INSERT INTO images SELECT 1, d FROM real; INSERT INTO map VALUES (0, 0, 0, 1); CREATE VIEW tiles AS SELECT \
                map.zoom_level AS zoom_level, map.tile_column AS tile_column, map.tile_row AS tile_row, images.tile_data AS \
                tile_data FROM map JOIN images ON images.tile_id = map.tile_id";
    let file = Mbtiles::open(&database(&folder, join), 256).expect("a file");
    assert!(file.tile(TileId { level: 0, column: 0, row: 0 }).expect("read").is_some());
}

/// Bytes of this process that are in memory at their most since the last look, where the system reports it.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("0 kB");
    line.trim().trim_end_matches("kB").trim().parse::<usize>().unwrap_or(0) * 1024
}

// fault 53: map files changed at random
#[test]
fn what_is_changed_at_random_ends_nothing() {
    let _alone = alone();
    let folder = Folder::new("random");
    let mut random = SmallRng::seed_from_u64(49);
    let tiles = claimed(64, 64, 5, Some(64), 600);
    let strips = claimed(64, 64, 1, None, 600);
    let picture = Raster::filled(20, 20, [1, 2, 3, 255]).to_png();
    let plain =
        database(&folder, "CREATE VIEW tiles AS SELECT z zoom_level, x tile_column, y tile_row, d tile_data FROM real");
    let base = std::fs::read(plain).expect("read");
    let corner = |lat_deg, lon_deg| Corner { lat_deg, lon_deg };
    let corners = [corner(40.01, -4.0), corner(40.01, -3.99), corner(40.0, -3.99), corner(40.0, -4.0)];
    let tile = TileId { level: 0, column: 0, row: 0 };
    let mut tried = 0;
    let (_, most, took) = measured(|| {
        for round in 0..4000_u32 {
            let (name, whole) = match round % 4 {
                0 => ("a.tif", &tiles),
                1 => ("b.tif", &strips),
                2 => ("c.png", &picture),
                _ if round % 16 == 3 => ("d.mbtiles", &base),
                _ => continue,
            };
            let mut bytes = whole.clone();
            for _ in 0..random.random_range(1..6) {
                let at = random.random_range(0..bytes.len());
                bytes[at] =
                    *[0, 1, 0x7f, 0x80, 0xff, random.random()].get(random.random_range(0..6)).expect("one of six");
            }
            let path = folder.file(name, &bytes);
            match name {
                "c.png" => drop(Overlay::open(&path, &corners).map(|picture| picture.tile(tile))),
                "d.mbtiles" => drop(Mbtiles::open(&path, 256).map(|file| file.tile(tile))),
                _ => {
                    let _ = look(&path);
                    let _ = Dem::open(&path, false).map(|dem| dem.height(40.33, -3.8));
                }
            }
            let _ = Pmtiles::open(&path, 256);
            tried += 1;
        }
    });
    assert!(tried > 3000, "{tried}");
    assert!(most < usize::try_from(MAX_READING).expect("small"), "{most} bytes");
    assert!(took < Duration::from_secs(60), "{took:?}");
}
