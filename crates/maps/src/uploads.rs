//! Uploaded files: written to a temporary file, examined, and only then moved into the maps folder.

use std::path::{Path, PathBuf};

use tokio::fs::File;
use tokio::io::AsyncWriteExt;

use crate::error::{MapError, Result};
use crate::kinds::{file_ends, kind_of};
use crate::live::About;
use crate::service::Maps;
use crate::settings::{Role, SourceKind, SourceSettings};
use crate::task::blocking;

/// Bytes of a file at most.
pub const MAX_FILE_BYTES: u64 = 8 * 1024 * 1024 * 1024;

/// Every how many bytes of a file it is looked whether the disk still has room.
const LOOK_EVERY: u64 = 8 * 1024 * 1024;

/// An upload in progress. It is removed unless it is finished.
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
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Where it is being written.
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

impl Maps {
    /// Starts an upload.
    ///
    /// # Errors
    /// [`MapError::MapFile`] for an invalid name, or one with an unknown ending.
    pub async fn begin_upload(&self, name: &str) -> Result<Upload> {
        let is_plain = |c: char| !c.is_control() && !"/\\:*?\"<>|".contains(c);
        if name.is_empty() || name.len() > 150 || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(MapError::file("name", "takes a file's plain name, of 150 characters at most"));
        }
        if kind_of(name).is_none() {
            let reason = format!("ends in none of {}", file_ends().join(", "));
            return Err(MapError::file(name, reason));
        }
        let folder = self.folder().join("tmp");
        self.room()?;
        tokio::fs::create_dir_all(&folder).await?;
        // The name's ending stays: it determines the kind.
        static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let path = folder.join(format!("{}-{count}-{name}", std::process::id()));
        let file = File::create_new(&path).await?;
        Ok(Upload { name: name.to_owned(), path, file, bytes: 0, maps: self.clone() })
    }

    /// Examines a complete file and moves it into the folder. Returns its path, its size and matching settings.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when its content does not match its name; [`MapError::Storage`].
    pub async fn end_upload(&self, upload: Upload) -> Result<(String, u64, SourceSettings)> {
        let folder = self.folder().to_owned();
        blocking(move || {
            let kind = kind_of(&upload.name).ok_or_else(|| MapError::file(&*upload.name, "is of no known kind"))?;
            let looked = kind.driver().look(&upload.path);
            let (kind, about) = looked.map_err(|reason| MapError::file(&*upload.name, reason))?;
            let shelf = kind.driver().shelf();
            let place = shelf.as_ref().map_or_else(|| "files".to_owned(), |shelf| format!("files/{}", shelf.folder));
            vencejo_store::make_folder(&folder.join(&place))?;
            let name = free_name(&folder.join(&place), &upload.name, shelf.is_some());
            vencejo_store::install(&upload.path, &folder.join(&place).join(&name))?;
            let path = if shelf.is_some() { place } else { format!("{place}/{name}") };
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
                    let as_kind = |kind: &SourceKind| Some((*kind, kind.driver().folder_bytes(&entry.path())?));
                    if let Some((kind, bytes)) = SourceKind::ALL.iter().find_map(as_kind) {
                        files.push((format!("files/{name}"), bytes, Some(kind)));
                    }
                }
            }
            files.sort_by(|a, b| a.0.cmp(&b.0));
            Ok(files)
        })
        .await
    }
}

/// A free name; on a shelf a file replaces the one of the same name.
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
    let (id, shown) = kind.driver().shelf().map_or((stem, stem), |shelf| (shelf.folder, shelf.name));
    let id: String = id
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .take(40)
        .collect();
    let mut settings = SourceSettings::new(id, about.name.unwrap_or_else(|| shown.to_owned()), kind);
    if settings.role == Role::Base && about.is_overlay {
        settings.role = Role::Overlay;
    }
    settings.path = Some(path);
    settings.attribution = about.attribution.into_iter().collect();
    settings
}
