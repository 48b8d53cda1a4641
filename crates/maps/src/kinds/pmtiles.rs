//! PMTiles files, version 3 (github.com/protomaps/PMTiles, spec/v3): a header, directories and tiles in one file.
//!
//! Read with plain reads, not by mapping: a file that is cut while it is read is an error, not the end of the process.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use flate2::read::GzDecoder;
use serde::Deserialize;

use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening};
use crate::live::{About, TileFile};
use crate::memory::{Shelved, lease};
use crate::settings::{Attribution, SourceKind};
use crate::sniff;

const HEADER_BYTES: usize = 127;
/// Bytes of a directory, unpacked, at most; the specification keeps them far below.
const MAX_DIRECTORY: u64 = 4 * 1024 * 1024;
/// Entries of a directory at most: writers stay below 65,536.
const MAX_ENTRIES: u64 = 262_144;
/// Bytes of its notes, unpacked, at most.
const MAX_NOTES: u64 = 1024 * 1024;
/// Bytes of a tile at most.
const MAX_TILE: u64 = 16 * 1024 * 1024;
/// Directories below directories at most.
const MAX_DEPTH: u8 = 4;

/// The metadata used; the rest is skipped, not parsed.
#[derive(Debug, Default, Deserialize)]
struct Notes {
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    attribution: Option<String>,
    #[serde(default, rename = "type")]
    kind: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    tile_id: u64,
    offset: u64,
    length: u32,
    /// 0: a leaf directory.
    run: u32,
}

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "tile_px", "encoding", "below_sea_level"]
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        opening.zoomed(Pmtiles::open(&opening.path(), opening.tile_px()))
    }

    fn file_ends(&self) -> &'static [&'static str] {
        &[".pmtiles"]
    }

    fn look(&self, path: &Path) -> std::result::Result<(SourceKind, About), String> {
        Ok((SourceKind::Pmtiles, Pmtiles::open(path, 256)?.about()))
    }
}

/// A PMTiles file that is open for reading.
#[derive(Debug)]
pub struct Pmtiles {
    path: PathBuf,
    file: Mutex<File>,
    root: Vec<Entry>,
    /// Leaf directories by their offset.
    unpacked: Shelved,
    leaf_offset: u64,
    data_offset: u64,
    is_gzip: bool,
    tiles_gzip: bool,
    grid: TileGrid,
    about: About,
}

impl Pmtiles {
    /// Opens a file.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn open(path: &Path, tile_px: u32) -> std::result::Result<Self, String> {
        let mut file = File::open(path).map_err(|error| error.to_string())?;
        let mut header = [0_u8; HEADER_BYTES];
        file.read_exact(&mut header).map_err(|_| "no PMTiles file: it is too short")?;
        if &header[..7] != b"PMTiles" {
            return Err("no PMTiles file".to_owned());
        }
        if header[7] != 3 {
            return Err(format!("PMTiles version {}; only 3 is read: convert it with `pmtiles convert`", header[7]));
        }
        let long = |at: usize| u64::from_le_bytes(header[at..at + 8].try_into().expect("invariant: eight bytes"));
        let degrees = |at: usize| {
            f64::from(i32::from_le_bytes(header[at..at + 4].try_into().expect("invariant: four bytes"))) / 1e7
        };
        let packed = |what: &str, code: u8| match code {
            0 | 1 => Ok(false),
            2 => Ok(true),
            code => Err(format!("its {what} are packed by method {code}; only none and gzip are read")),
        };
        let is_gzip = packed("directories", header[97])?;
        let tiles_gzip = packed("tiles", header[98])?;
        match header[99] {
            2..=4 | 0 => {}
            1 => return Err("its tiles are vectors; only pictures are shown".to_owned()),
            kind => return Err(format!("its tiles are of type {kind}, which is not shown; png, jpeg and webp are")),
        }
        let root = entries(&mut file, long(8), long(16), is_gzip)?;
        let (min_zoom, max_zoom) = (header[100], header[101].min(26));
        let bounds =
            Bounds { west_deg: degrees(102), south_deg: degrees(106), east_deg: degrees(110), north_deg: degrees(114) };
        let bounds = Some(bounds).filter(|bounds| bounds.fault().is_none());
        let notes = (long(32) <= MAX_NOTES).then(|| bytes_at(&mut file, long(24), long(32), is_gzip, MAX_NOTES).ok());
        let notes: Notes = notes.flatten().and_then(|notes| serde_json::from_slice(&notes).ok()).unwrap_or_default();
        let note = |text: &Option<String>| text.as_ref().map(|text| sniff::words(text.as_bytes()));
        let about = About {
            name: note(&notes.name).filter(|name| !name.is_empty()),
            bounds,
            attribution: note(&notes.attribution)
                .filter(|text| !text.is_empty())
                .map(|text| Attribution { text, url: None }),
            is_overlay: notes.kind.as_deref() == Some("overlay"),
            max_zoom: Some(max_zoom),
        };
        let grid = TileGrid::standard(Crs::WebMercator, tile_px, min_zoom, max_zoom).within(bounds.as_ref());
        Ok(Self {
            path: path.to_owned(),
            file: Mutex::new(file),
            root,
            unpacked: Shelved::unpacked(),
            leaf_offset: long(40),
            data_offset: long(56),
            is_gzip,
            tiles_gzip,
            grid,
            about,
        })
    }

    fn find(&self, tile: TileId) -> std::result::Result<Option<Bytes>, String> {
        let wanted = tile_id(tile);
        let Some(mut entry) = search(&self.root, wanted) else { return Ok(None) };
        for _ in 0..MAX_DEPTH {
            if entry.run > 0 {
                let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
                let at = self.data_offset.checked_add(entry.offset).ok_or("an entry leads nowhere")?;
                let data = bytes_at(&mut file, at, entry.length.into(), self.tiles_gzip, MAX_TILE)?;
                return Ok(Some(data.into()));
            }
            let leaf = self.leaf(entry)?;
            match search(&leaf, wanted) {
                Some(next) => entry = next,
                None => return Ok(None),
            }
        }
        Err("its directories are too deep".to_owned())
    }

    fn leaf(&self, entry: Entry) -> std::result::Result<Arc<Vec<Entry>>, String> {
        if let Some(known) = self.unpacked.get(entry.offset, 0) {
            return Ok(known);
        }
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let at = self.leaf_offset.checked_add(entry.offset).ok_or("an entry leads nowhere")?;
        let leaf = Arc::new(entries(&mut file, at, entry.length.into(), self.is_gzip)?);
        self.unpacked.put(entry.offset, 0, &leaf, leaf.len() * size_of::<Entry>());
        Ok(leaf)
    }
}

impl TileFile for Pmtiles {
    fn grid(&self) -> &TileGrid {
        &self.grid
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn tile(&self, tile: TileId) -> Result<Option<Bytes>> {
        self.find(tile).map_err(|reason| MapError::file(self.path.display().to_string(), reason))
    }
}

fn search(entries: &[Entry], wanted: u64) -> Option<Entry> {
    let after = entries.partition_point(|entry| entry.tile_id <= wanted);
    let entry = *entries.get(after.checked_sub(1)?)?;
    (entry.run == 0 || wanted - entry.tile_id < u64::from(entry.run)).then_some(entry)
}

/// Bytes of the file, unpacked where they are packed; at most `most`, packed or not.
fn bytes_at(
    file: &mut File,
    offset: u64,
    length: u64,
    is_gzip: bool,
    most: u64,
) -> std::result::Result<Vec<u8>, String> {
    if length > most {
        return Err(format!("an entry has {length} bytes"));
    }
    let _lease = lease(Some(length + if is_gzip { 2 * most } else { 0 }))?;
    file.seek(SeekFrom::Start(offset)).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 != length {
        return Err("the file was cut short".to_owned());
    }
    if !is_gzip {
        return Ok(bytes);
    }
    let mut unpacked = Vec::new();
    GzDecoder::new(&*bytes).take(most + 1).read_to_end(&mut unpacked).map_err(|error| error.to_string())?;
    if unpacked.len() as u64 > most {
        return Err("what it packs is too large".to_owned());
    }
    Ok(unpacked)
}

fn entries(file: &mut File, offset: u64, length: u64, is_gzip: bool) -> std::result::Result<Vec<Entry>, String> {
    let bytes = bytes_at(file, offset, length, is_gzip, MAX_DIRECTORY)?;
    read_entries(&bytes).ok_or_else(|| "a directory is broken".to_owned())
}

/// A directory: count, then all ids as differences, runs, lengths, offsets (spec/v3, 4.2).
fn read_entries(bytes: &[u8]) -> Option<Vec<Entry>> {
    let mut rest = bytes;
    let count = varint(&mut rest)?;
    // Each entry takes four bytes at least.
    if count > MAX_ENTRIES || count * 4 > rest.len() as u64 {
        return None;
    }
    let mut entries = vec![Entry { tile_id: 0, offset: 0, length: 0, run: 0 }; usize::try_from(count).ok()?];
    let mut id = 0_u64;
    for entry in &mut entries {
        id = id.checked_add(varint(&mut rest)?)?;
        entry.tile_id = id;
    }
    for entry in &mut entries {
        entry.run = varint(&mut rest)?.try_into().ok()?;
    }
    for entry in &mut entries {
        entry.length = varint(&mut rest)?.try_into().ok()?;
    }
    let mut next = 0_u64;
    for (index, entry) in entries.iter_mut().enumerate() {
        let offset = varint(&mut rest)?;
        entry.offset = if offset == 0 && index > 0 { next } else { offset.checked_sub(1)? };
        next = entry.offset.checked_add(entry.length.into())?;
    }
    Some(entries)
}

fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..64).step_by(7) {
        let (byte, after) = rest.split_first()?;
        *rest = after;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

/// Where a tile is on the Hilbert curve through all zooms.
fn tile_id(tile: TileId) -> u64 {
    let TileId { level, column, row } = tile;
    let before = ((1_u64 << (2 * level)) - 1) / 3;
    let (mut x, mut y) = (u64::from(column), u64::from(row));
    let mut distance = 0_u64;
    let n = 1_u64 << level;
    let mut side = n / 2;
    while side > 0 {
        let (right, down) = (u64::from(x & side > 0), u64::from(y & side > 0));
        distance += side * side * ((3 * right) ^ down);
        // Turn the quadrant.
        if down == 0 {
            if right == 1 {
                x = (n - 1).wrapping_sub(x);
                y = (n - 1).wrapping_sub(y);
            }
            std::mem::swap(&mut x, &mut y);
        }
        side /= 2;
    }
    before + distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::testing::Folder;

    fn varint_bytes(mut value: u64, out: &mut Vec<u8>) {
        while value >= 0x80 {
            out.push(value as u8 | 0x80);
            value >>= 7;
        }
        out.push(value as u8);
    }

    fn directory(entries: &[Entry]) -> Vec<u8> {
        let mut out = Vec::new();
        varint_bytes(entries.len() as u64, &mut out);
        let mut last = 0;
        for entry in entries {
            varint_bytes(entry.tile_id - last, &mut out);
            last = entry.tile_id;
        }
        entries.iter().for_each(|entry| varint_bytes(entry.run.into(), &mut out));
        entries.iter().for_each(|entry| varint_bytes(entry.length.into(), &mut out));
        entries.iter().for_each(|entry| varint_bytes(entry.offset + 1, &mut out));
        out
    }

    /// A file with one leaf directory, as the specification lays it out.
    fn make(tile: TileId, data: &[u8], kind: u8) -> Vec<u8> {
        let leaf = directory(&[Entry { tile_id: tile_id(tile), offset: 0, length: data.len() as u32, run: 2 }]);
        let root = directory(&[Entry { tile_id: 0, offset: 0, length: leaf.len() as u32, run: 0 }]);
        let notes = br#"{"name": "Field", "attribution": "<b>Ana</b>"}"#;
        let mut file = b"PMTiles\x03".to_vec();
        let mut at = HEADER_BYTES as u64;
        for part in [root.len(), notes.len(), leaf.len(), data.len()] {
            file.extend(at.to_le_bytes());
            file.extend((part as u64).to_le_bytes());
            at += part as u64;
        }
        file.extend([0; 24]);
        file.extend([1, 1, 1, kind, 0, 5]);
        for degrees in [-4_i32, 40, -3, 41] {
            file.extend((degrees * 10_000_000).to_le_bytes());
        }
        file.extend([0; 9]);
        assert_eq!(file.len(), HEADER_BYTES);
        [file, root, notes.to_vec(), leaf, data.to_vec()].concat()
    }

    #[test]
    fn ids_follow_the_curve_of_the_specification() {
        for (level, column, row, id) in
            [(0, 0, 0, 0), (1, 0, 0, 1), (1, 0, 1, 2), (1, 1, 1, 3), (1, 1, 0, 4), (2, 0, 0, 5)]
        {
            assert_eq!(tile_id(TileId { level, column, row }), id, "{level}/{column}/{row}");
        }
        // From the tests of go-pmtiles and of the JavaScript reader.
        assert_eq!(tile_id(TileId { level: 12, column: 3423, row: 1763 }), 19_078_479);
        assert_eq!(tile_id(TileId { level: 26, column: 0, row: 0 }), ((1_u64 << 52) - 1) / 3);
    }

    #[test]
    fn tiles_are_found_through_a_leaf_and_runs() {
        let folder = Folder::new();
        let path = folder.path().join("a.pmtiles");
        let png = Raster::filled(1, 1, [9, 9, 9, 255]).to_png();
        let tile = TileId { level: 1, column: 0, row: 1 };
        std::fs::write(&path, make(tile, &png, 2)).expect("written");
        let file = Pmtiles::open(&path, 256).expect("a file");
        assert_eq!(file.about().name.as_deref(), Some("Field"));
        assert_eq!(file.about().attribution.expect("named").text, "Ana");
        assert_eq!(file.grid().max_level, 5);
        for (column, row, there) in [(0, 1, true), (1, 1, true), (1, 0, false), (0, 0, false)] {
            let found = file.tile(TileId { level: 1, column, row }).expect("read");
            assert_eq!(found.as_deref() == Some(&*png), there, "{column}/{row}");
        }
    }

    #[test]
    fn broken_files_are_errors() {
        let folder = Folder::new();
        let path = folder.path().join("a.pmtiles");
        let tile = TileId { level: 1, column: 0, row: 1 };
        let whole = make(tile, b"\x89PNG\r\n\x1a\n", 2);
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).expect("written");
            if let Ok(file) = Pmtiles::open(&path, 256) {
                assert!(file.tile(tile).is_err(), "{cut}");
            }
        }
        for at in 8..whole.len() {
            let mut bad = whole.clone();
            bad[at] ^= 0xff;
            std::fs::write(&path, &bad).expect("written");
            if let Ok(file) = Pmtiles::open(&path, 256) {
                let _ = file.tile(tile);
            }
        }
        std::fs::write(&path, make(tile, b"x", 1)).expect("written");
        assert!(Pmtiles::open(&path, 256).unwrap_err().contains("vectors"));
    }
}
