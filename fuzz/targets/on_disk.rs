//! For readers that take a file: one in memory while they have it.

use std::fs;
use std::path::{Path, PathBuf};

/// A file with these bytes and this ending, as long as this is kept.
pub struct OnDisk(PathBuf);

impl OnDisk {
    /// Writes it.
    pub fn new(data: &[u8], ending: &str) -> Self {
        // The folder is scripts/fuzz.sh's own: what a crash leaves there goes with it.
        let path = std::env::temp_dir().join(format!("vencejo-fuzz-{}.{ending}", std::process::id()));
        fs::write(&path, data).expect("room for a file");
        Self(path)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for OnDisk {
    fn drop(&mut self) {
        fs::remove_file(&self.0).expect("the file that was written");
    }
}
