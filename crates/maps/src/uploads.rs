//! Files that are handed in: written beside, looked at, and only then put into the maps folder.

use std::path::{Path, PathBuf};

use tokio::fs::File;
use tokio::io::AsyncWriteExt;

use crate::error::{MapError, Result};
use crate::files::dem::is_height_file;
use crate::files::geotiff::GeoTiff;
use crate::files::mbtiles::Mbtiles;
use crate::files::overlay::MAX_PX;
use crate::files::pmtiles::Pmtiles;
use crate::files::{About, TileFile};
use crate::geo::{Bounds, Corner};
use crate::raster::Raster;
use crate::service::Maps;
use crate::settings::{Role, SourceKind, SourceSettings};
use crate::task::blocking;

/// Bytes of a file at most.
pub const MAX_FILE_BYTES: u64 = 8 * 1024 * 1024 * 1024;

/// Every how many bytes of a file it is looked whether the disk still has room.
const LOOK_EVERY: u64 = 8 * 1024 * 1024;

/// A file on its way in. What is not ended is removed.
#[derive(Debug)]
pub struct Upload {
    name: String,
    path: PathBuf,
    file: File,
    bytes: u64,
    maps: Maps,
}

impl Upload {
    /// Bytes that came so far.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Where it is being written.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the next piece.
    ///
    /// # Errors
    /// [`MapError::LowSpace`] when too little of the disk would stay free, [`MapError::Storage`] when it takes no more.
    pub async fn write(&mut self, data: &[u8]) -> Result<()> {
        let before = self.bytes / LOOK_EVERY;
        if self.bytes == 0 || (self.bytes + data.len() as u64) / LOOK_EVERY != before {
            self.maps.room()?;
        }
        self.file.write_all(data).await?;
        // So that what follows finds it whole.
        self.file.flush().await?;
        self.bytes += data.len() as u64;
        Ok(())
    }
}

impl Drop for Upload {
    fn drop(&mut self) {
        // Gone already when it was ended.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// What a file can be by its name.
#[must_use]
pub fn kind_of(name: &str) -> Option<SourceKind> {
    let lower = name.to_ascii_lowercase();
    let ends = |ends: &[&str]| ends.iter().any(|end| lower.ends_with(end));
    Some(match () {
        () if ends(&[".mbtiles"]) => SourceKind::Mbtiles,
        () if ends(&[".pmtiles"]) => SourceKind::Pmtiles,
        () if ends(&[".tif", ".tiff"]) => SourceKind::Geotiff,
        () if ends(&[".png", ".jpg", ".jpeg", ".webp"]) => SourceKind::Image,
        () if ends(&[".hgt", ".hgt.gz"]) => SourceKind::Dem,
        () => return None,
    })
}

impl Maps {
    /// Begins to take a file.
    ///
    /// # Errors
    /// [`MapError::MapFile`] for a name whose end says nothing, or that is none.
    pub async fn begin_upload(&self, name: &str) -> Result<Upload> {
        let is_plain = |c: char| !c.is_control() && !"/\\:*?\"<>|".contains(c);
        if name.is_empty() || name.len() > 150 || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(MapError::file("name", "takes a file's plain name, of 150 characters at most"));
        }
        if kind_of(name).is_none() {
            let reason = "ends in none of .mbtiles, .pmtiles, .tif, .png, .jpg, .webp, .hgt, .hgt.gz";
            return Err(MapError::file(name, reason));
        }
        let folder = self.folder().join("tmp");
        self.room()?;
        tokio::fs::create_dir_all(&folder).await?;
        // The name's end stays: kinds are told by it.
        static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let path = folder.join(format!("{}-{count}-{name}", std::process::id()));
        let file = File::create_new(&path).await?;
        Ok(Upload { name: name.to_owned(), path, file, bytes: 0, maps: self.clone() })
    }

    /// Looks at a file that came whole and puts it into the folder. Gives its path, its size and settings that fit it.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when it is not what its name says; [`MapError::Storage`].
    pub async fn end_upload(&self, upload: Upload) -> Result<(String, u64, SourceSettings)> {
        let folder = self.folder().to_owned();
        blocking(move || {
            let kind = kind_of(&upload.name).ok_or_else(|| MapError::file(&*upload.name, "is of no known kind"))?;
            let (kind, about) = look(&upload.path, kind).map_err(|reason| MapError::file(&*upload.name, reason))?;
            // Heights lie together: their names say where they belong.
            let place = if kind == SourceKind::Dem { "files/heights" } else { "files" };
            vencejo_store::make_folder(&folder.join(place))?;
            let name = free_name(&folder.join(place), &upload.name, kind == SourceKind::Dem);
            vencejo_store::install(&upload.path, &folder.join(place).join(&name))?;
            let path = if kind == SourceKind::Dem { place.to_owned() } else { format!("{place}/{name}") };
            Ok((path.clone(), upload.bytes, propose(&name, kind, path, about)))
        })
        .await
    }

    /// The files of the maps folder, with what each can be.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub async fn files(&self) -> Result<Vec<(String, u64, Option<SourceKind>)>> {
        let folder = self.folder().join("files");
        blocking(move || {
            let mut files = Vec::new();
            for entry in std::fs::read_dir(&folder)?.flatten().take(1000) {
                let name = entry.file_name().to_string_lossy().into_owned();
                let about = entry.metadata()?;
                if about.is_file() {
                    files.push((format!("files/{name}"), about.len(), kind_of(&name)));
                } else if about.is_dir() {
                    let inside: Vec<_> = std::fs::read_dir(entry.path())?.flatten().collect();
                    let heights: Vec<_> = inside.iter().filter(|entry| is_height_file(&entry.path())).collect();
                    let bytes = heights.iter().filter_map(|entry| entry.metadata().ok()).map(|about| about.len()).sum();
                    if !heights.is_empty() {
                        files.push((format!("files/{name}"), bytes, Some(SourceKind::Dem)));
                    }
                }
            }
            files.sort_by(|a, b| a.0.cmp(&b.0));
            Ok(files)
        })
        .await
    }
}

/// Opens a file as what it should be; a GeoTIFF of numbers is one of heights.
fn look(path: &Path, kind: SourceKind) -> std::result::Result<(SourceKind, About), String> {
    Ok(match kind {
        SourceKind::Mbtiles => (kind, Mbtiles::open(path, 256)?.about()),
        SourceKind::Pmtiles => (kind, Pmtiles::open(path, 256)?.about()),
        SourceKind::Geotiff => {
            let file = GeoTiff::open(path)?;
            let about = file.about();
            (if file.is_heights() { SourceKind::Dem } else { kind }, about)
        }
        SourceKind::Image => {
            Raster::read(&crate::files::overlay::read_file(path)?, MAX_PX)?;
            (kind, About { is_overlay: true, ..About::default() })
        }
        _ => (kind, About::default()),
    })
}

/// A name that is not taken; heights replace those of the same name, which lie at the same place.
fn free_name(folder: &Path, name: &str, may_replace: bool) -> String {
    if may_replace || !folder.join(name).exists() {
        return name.to_owned();
    }
    let (stem, end) = name.rsplit_once('.').unwrap_or((name, ""));
    let mut numbered = (2..).map(|number| format!("{stem}-{number}.{end}"));
    numbered.find(|name| !folder.join(name).exists()).unwrap_or_else(|| name.to_owned())
}

fn propose(name: &str, kind: SourceKind, path: String, about: About) -> SourceSettings {
    let stem = name.split('.').next().unwrap_or(name);
    let (id, shown) = if kind == SourceKind::Dem { ("heights", "Heights from files") } else { (stem, stem) };
    let id: String = id
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .take(40)
        .collect();
    let corners = match (kind, about.bounds) {
        (SourceKind::Image, Some(Bounds { west_deg, south_deg, east_deg, north_deg })) => {
            [(north_deg, west_deg), (north_deg, east_deg), (south_deg, east_deg), (south_deg, west_deg)]
                .map(|(lat_deg, lon_deg)| Corner { lat_deg, lon_deg })
                .to_vec()
        }
        _ => Vec::new(),
    };
    let mut settings = SourceSettings::new(id, about.name.unwrap_or_else(|| shown.to_owned()), kind);
    if settings.role == Role::Base && about.is_overlay {
        settings.role = Role::Overlay;
    }
    (settings.path, settings.corners) = (Some(path), corners);
    settings.attribution = about.attribution.into_iter().collect();
    settings
}
