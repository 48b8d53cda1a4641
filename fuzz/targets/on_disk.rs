//! For readers of files: one file in memory, rewritten for each input.

use std::fs;
use std::path::PathBuf;

/// A file with these bytes and this extension; valid until the next call.
pub fn on_disk(data: &[u8], ending: &str) -> PathBuf {
    // The folder belongs to scripts/fuzz.sh, which removes it: creating and removing a file for each input takes longer
    // than reading it.
    let path = std::env::temp_dir().join(format!("vencejo-fuzz-{}.{ending}", std::process::id()));
    fs::write(&path, data).expect("room for a file");
    path
}
