//! Changes to the sources: each is written to their file, which is then read as if it had been edited by hand.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::PoisonError;

use crate::error::{MapError, Result};
use crate::listing::MapSource;
use crate::service::{Maps, is_cache_of, is_inside};
use crate::settings::SourceSettings;
use crate::task::blocking;

impl Maps {
    /// Puts a source in the place of that of its id, or adds it. A key that is absent stays as it was.
    ///
    /// # Errors
    /// [`MapError::Settings`] with all faults, [`MapError::SourcesFile`] when the file is wrong as it is.
    pub async fn put(&self, settings: SourceSettings) -> Result<MapSource> {
        let edit = self.shared.edits.lock().await;
        let (file, id) = (self.shared.file.clone(), settings.id.clone());
        let (files, known) = (self.folder().join("files"), self.source(&id).ok());
        blocking(move || {
            // The settings before are read from the file under its lock: another instance may have changed them.
            let result = file.change(&settings.id, |before| checked(settings.clone(), before, &files));
            if matches!(result, Err(MapError::SourcesFile { .. })) {
                // Its own faults are reported first, also when the file is invalid.
                checked(settings, known.as_ref().map(|known| &known.settings), &files)?;
            }
            result
        })
        .await?;
        self.reload_held().await?;
        drop(edit);
        let source = self.source(&id)?;
        // Its state says why when this fails; the settings are kept all the same: the network may be away.
        let _ = self.known_grid(&source).await;
        self.describe(&id).await
    }

    /// Sets the order of sources to that of a list; those that it does not name keep theirs.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::SourcesFile`].
    pub async fn set_order(&self, ids: &[String]) -> Result<()> {
        let _edit = self.begin_edit().await?;
        let mut orders = BTreeMap::new();
        for (index, id) in (1_i32..).zip(ids) {
            self.source(id)?;
            orders.insert(id.clone(), index * 10);
        }
        let file = self.shared.file.clone();
        blocking(move || file.set_orders(&orders)).await?;
        self.reload_held().await
    }

    /// Removes a source, and on request its cache.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::SourcesFile`].
    pub async fn remove(&self, id: &str, forget_cache: bool) -> Result<()> {
        let _edit = self.begin_edit().await?;
        let source = self.source(id)?;
        self.stop_areas_of(id).await;
        let (file, name) = (self.shared.file.clone(), id.to_owned());
        blocking(move || file.remove(&name)).await?;
        self.reload_held().await?;
        drop(source);
        if forget_cache {
            let (folder, name) = (self.shared.config.folder.join("cache"), id.to_owned());
            blocking(move || Ok(remove_cache(&folder, &name)?)).await?;
        }
        Ok(())
    }

    /// Forgets what is cached of a source but for its offline areas.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::Storage`].
    pub async fn clear_cache(&self, id: &str) -> Result<()> {
        let source = self.source(id)?;
        self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner).clear();
        match source.cache.clone() {
            Some(cache) => {
                blocking(move || cache.clear()).await?;
                source.shown.clear();
                Ok(())
            }
            None => Ok(()),
        }
    }
}

/// Removes the cache of a source. Where nothing was ever cached there is no folder, and SQLite's journals come and go
/// by themselves.
fn remove_cache(folder: &Path, id: &str) -> io::Result<()> {
    let unless_gone = |error: io::Error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) };
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return unless_gone(error),
    };
    for entry in entries.flatten() {
        if is_cache_of(&entry.file_name().to_string_lossy(), id) {
            std::fs::remove_file(entry.path()).or_else(unless_gone)?;
        }
    }
    Ok(())
}

/// Settings that may take the place of others, with the key that they keep.
fn checked(mut settings: SourceSettings, before: Option<&SourceSettings>, files: &Path) -> Result<SourceSettings> {
    let is_kept_key = settings.key.is_none();
    if is_kept_key {
        settings.key = before.and_then(|before| before.key.clone());
    }
    settings.key = settings.key.filter(|key| !key.is_empty());
    settings.has_key = None;
    let mut faults = settings.faults();
    // Not of a file that has it already: its other sources are used.
    faults.extend(settings.datum_fault());
    if let Some(before) = before
        && settings.key.is_some()
        && settings.key == before.key
        && is_kept_key
    {
        let (old, new) = (before.key_hosts(), settings.key_hosts());
        let strange: Vec<&str> = new.difference(&old).map(String::as_str).collect();
        if !strange.is_empty() {
            faults.push(format!(
                "key: it was given for {}; enter it once more to have it sent to {}, or leave it out with an empty key",
                old.iter().map(String::as_str).collect::<Vec<_>>().join(", "),
                strange.join(", ")
            ));
        }
    }
    let is_same_path = before.is_some_and(|before| before.path == settings.path);
    if let Some(path) = &settings.path
        && !is_same_path
        && !is_inside(path)
    {
        faults.push(format!(
            "path: by this way only files of the maps folder are taken, such as files/NAME; put the file into {}, send it \
             with POST /api/v1/maps/files, or write its path into sources.toml by hand",
            files.display()
        ));
    }
    if faults.is_empty() { Ok(settings) } else { Err(MapError::Settings { source_id: settings.id, faults }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Folder;

    #[test]
    fn the_cache_of_a_source_goes_also_where_there_is_none() {
        let folder = Folder::new();
        remove_cache(&folder.path().join("cache"), "chart").expect("nothing was ever cached");
        for name in
            ["chart-0123456789abcdef.mbtiles", "chart-0123456789abcdef.mbtiles-wal", "other-0123456789abcdef.mbtiles"]
        {
            std::fs::write(folder.path().join(name), "").expect("written");
        }
        remove_cache(folder.path(), "chart").expect("removed");
        let left: Vec<_> =
            std::fs::read_dir(folder.path()).expect("there").flatten().map(|entry| entry.file_name()).collect();
        assert_eq!(left, ["other-0123456789abcdef.mbtiles"]);
    }
}
