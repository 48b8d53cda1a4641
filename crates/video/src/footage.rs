//! Footage: camera recordings and images in a folder. File names contain camera and time; other files are not shown.
//! Names from clients are compared with existing ones, never used as paths.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::hub::VideoHub;
use crate::name::is_name;

/// Limit of listed files; the newest are listed.
const MAX_LISTED: usize = 1000;
/// Size of the beginning of a file that contains its duration, if it was closed properly, bytes.
const HEAD: u64 = 4096;

/// Kind of a footage file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(rename_all = "snake_case"))]
pub enum FootageKind {
    /// A recording (Matroska).
    Video,
    /// A still image (JPEG).
    Picture,
}

/// A camera recording or image on the server's disk.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct Footage {
    /// File name.
    pub name: String,
    /// Kind of the file.
    pub kind: FootageKind,
    /// Name of the camera.
    pub camera: String,
    /// Start of the recording, or time of capture, to the second: seconds since 1970, UTC.
    pub begin_unix_s: u64,
    /// Duration of a recording; null for images, while it is being recorded, and when it was not closed properly.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub duration_s: Option<f64>,
    /// File size.
    pub bytes: u64,
    /// Whether it is being recorded.
    pub is_current: bool,
}

/// Files of a folder, newest first; empty if the folder does not exist yet. Reads the disk.
///
/// # Errors
/// When the folder cannot be read.
pub fn list(folder: &Path, hub: &VideoHub) -> io::Result<Vec<Footage>> {
    let mut found = scan(folder, hub)?;
    for footage in found.iter_mut().filter(|one| one.kind == FootageKind::Video && !one.is_current) {
        let beginning = File::open(folder.join(&footage.name)).and_then(|file| {
            let mut beginning = Vec::new();
            file.take(HEAD).read_to_end(&mut beginning)?;
            Ok(beginning)
        });
        footage.duration_s = beginning.ok().and_then(|bytes| matroska_duration_s(&bytes));
    }
    Ok(found)
}

/// The same without opening files, hence without durations.
fn scan(folder: &Path, hub: &VideoHub) -> io::Result<Vec<Footage>> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let current = hub.being_recorded();
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let Some(mut footage) = read_name(&name) else { continue };
        // Skips files deleted meanwhile, and symbolic links, which are not ours.
        let Ok(metadata) = entry.metadata() else { continue };
        if metadata.is_file() {
            footage.bytes = metadata.len();
            footage.is_current = current.contains(&name);
            found.push(footage);
        }
    }
    found.sort_by(|a, b| (b.begin_unix_s, &b.name).cmp(&(a.begin_unix_s, &a.name)));
    found.truncate(MAX_LISTED);
    Ok(found)
}

/// A footage file by name, if it exists, without its duration. Reads the disk.
///
/// # Errors
/// When the folder cannot be read.
pub fn find(folder: &Path, hub: &VideoHub, name: &str) -> io::Result<Option<(PathBuf, Footage)>> {
    let found = scan(folder, hub)?.into_iter().find(|footage| footage.name == name);
    Ok(found.map(|footage| (folder.join(&footage.name), footage)))
}

/// Parses a name like `2026-11-21_16-00-00_nose.mkv`, or `…_nose.2.mkv` for the second file of that second.
fn read_name(name: &str) -> Option<Footage> {
    let (stem, extension) = name.rsplit_once('.')?;
    let kind = match extension {
        "mkv" => FootageKind::Video,
        "jpg" => FootageKind::Picture,
        _ => return None,
    };
    let (stem, more) = stem.split_once('.').unwrap_or((stem, "2"));
    let mut parts = stem.splitn(3, '_');
    let begin_unix_s = unix_s(parts.next()?, parts.next()?)?;
    let camera = parts.next()?;
    let is_number = (1..=3).contains(&more.len()) && more.bytes().all(|byte| byte.is_ascii_digit());
    (is_name(camera) && is_number).then(|| Footage {
        name: name.to_owned(),
        kind,
        camera: camera.to_owned(),
        begin_unix_s,
        duration_s: None,
        bytes: 0,
        is_current: false,
    })
}

/// Seconds since 1970 of a date `2026-11-21` and a time `16-00-00`, UTC.
fn unix_s(date: &str, time: &str) -> Option<u64> {
    let numbers = |text: &str, lengths: [usize; 3]| -> Option<[u64; 3]> {
        let mut parts = text.split('-');
        let mut found = [0; 3];
        for (number, length) in found.iter_mut().zip(lengths) {
            let part = parts.next().filter(|part| part.len() == length && part.bytes().all(|b| b.is_ascii_digit()))?;
            *number = part.parse().ok()?;
        }
        parts.next().is_none().then_some(found)
    };
    let [year, month, day] = numbers(date, [4, 2, 2])?;
    let [hour, minute, second] = numbers(time, [2, 2, 2])?;
    if year < 1970 || !(1..=12).contains(&month) || !(1..=31).contains(&day) || hour > 23 || minute > 59 || second > 59
    {
        return None;
    }
    // Days since 1970 of the proleptic Gregorian calendar: H. Hinnant, "chrono-Compatible Low-Level Date Algorithms",
    // days_from_civil, for years from 1970 on. The year begins in March.
    let year = if month <= 2 { year - 1 } else { year };
    let (era, year_of_era) = (year / 400, year % 400);
    let day_of_year = (153 * (if month > 2 { month - 3 } else { month + 9 }) + 2) / 5 + day - 1;
    let days = era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468;
    Some(((days * 24 + hour) * 60 + minute) * 60 + second)
}

/// Duration according to the beginning of a Matroska file (RFC 9559).
fn matroska_duration_s(bytes: &[u8]) -> Option<f64> {
    const SEGMENT: u32 = 0x1853_8067;
    const INFO: u32 = 0x1549_A966;
    const TIMESTAMP_SCALE: u32 = 0x002A_D7B1;
    const DURATION: u32 = 0x4489;
    let segment = elements(bytes).find(|(id, _)| *id == SEGMENT)?.1;
    let info = elements(segment).find(|(id, _)| *id == INFO)?.1;
    let mut scale_ns = 1_000_000.0;
    let mut duration = None;
    for (id, payload) in elements(info) {
        match id {
            TIMESTAMP_SCALE if payload.len() <= 8 => {
                scale_ns = payload.iter().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte)) as f64;
            }
            DURATION => {
                duration = match *payload {
                    [a, b, c, d] => Some(f64::from(f32::from_be_bytes([a, b, c, d]))),
                    _ => payload.try_into().ok().map(f64::from_be_bytes),
                };
            }
            _ => {}
        }
    }
    duration.map(|ticks| ticks * scale_ns / 1e9).filter(|duration_s| duration_s.is_finite() && *duration_s >= 0.0)
}

/// Consecutive EBML elements (RFC 8794): id and payload. An element of unknown size, or a truncated one, has the
/// remaining bytes as its payload.
fn elements(mut bytes: &[u8]) -> impl Iterator<Item = (u32, &[u8])> {
    std::iter::from_fn(move || {
        let id_length = bytes.first()?.leading_zeros() as usize + 1;
        let id = bytes.get(..id_length).filter(|id| id.len() <= 4)?;
        let id = id.iter().fold(0_u32, |id, byte| id << 8 | u32::from(*byte));
        let rest = &bytes[id_length..];
        let size_length = rest.first()?.leading_zeros() as usize + 1;
        let size = rest.get(..size_length).filter(|size| size.len() <= 8)?;
        let size = size.iter().fold(0_u64, |size, byte| size << 8 | u64::from(*byte)) & ((1 << (7 * size_length)) - 1);
        let rest = &rest[size_length..];
        let end = usize::try_from(size).map_or(rest.len(), |size| size.min(rest.len()));
        bytes = &rest[end..];
        Some((id, &rest[..end]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_camera_and_time() {
        let read = |name| read_name(name).map(|footage| (footage.camera, footage.begin_unix_s, footage.kind));
        // `date -ud '2026-11-21 16:00:00' +%s`, and likewise the others.
        assert_eq!(read("2026-11-21_16-00-00_nose.mkv"), Some(("nose".into(), 1_795_276_800, FootageKind::Video)));
        assert_eq!(read("2000-02-29_23-59-59_a_b-2.3.jpg"), Some(("a_b-2".into(), 951_868_799, FootageKind::Picture)));
        assert_eq!(read("1970-01-01_00-00-00_x.mkv"), Some(("x".into(), 0, FootageKind::Video)));
        for no in [
            "",
            "..",
            "nose.mkv",
            "2026-11-21_16-00-00_.mkv",
            "2026-11-21_16-00-00_../x.mkv",
            "2026-13-21_16-00-00_nose.mkv",
            "2026-1-21_16-00-00_nose.mkv",
            "2026-11-21_16-00-00_nose.x.mkv",
            "2026-11-21_16-00-00_nose.mkv.part",
            "2026-11-21_16-00-00_nose.tlog",
        ] {
            assert_eq!(read(no), None, "{no}");
        }
    }

    /// An element with a one-byte size.
    fn element(id: &[u8], payload: &[u8]) -> Vec<u8> {
        [id, &[0x80 | u8::try_from(payload.len()).expect("short")], payload].concat()
    }

    #[test]
    fn a_length_is_read_where_there_is_one() {
        let scale = element(&[0x2A, 0xD7, 0xB1], &[0x0F, 0x42, 0x40]);
        let duration = element(&[0x44, 0x89], &1500.0_f64.to_be_bytes());
        let head = [element(&[0x1A, 0x45, 0xDF, 0xA3], &[]), vec![0x18, 0x53, 0x80, 0x67, 0x01]].concat();
        let file = |info: Vec<u8>| {
            let info = element(&[0x15, 0x49, 0xA9, 0x66], &info);
            [head.clone(), vec![0xFF; 7], info, vec![0x1F, 0x43, 0xB6, 0x75]].concat()
        };
        assert_eq!(matroska_duration_s(&file([scale.clone(), duration.clone()].concat())), Some(1.5));
        assert_eq!(matroska_duration_s(&file(scale)), None);
        assert_eq!(matroska_duration_s(&file(element(&[0x44, 0x89], &f64::NAN.to_be_bytes()))), None);
        let whole = file(duration);
        for end in 0..whole.len() {
            // No truncation causes a panic.
            let _ = matroska_duration_s(&whole[..end]);
        }
        assert_eq!(matroska_duration_s(&[0; 100]), None);
    }
}
