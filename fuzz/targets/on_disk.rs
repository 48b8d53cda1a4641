//! For readers that take a file: one in memory, written anew for each input.

use std::fs;
use std::path::PathBuf;

/// A file with these bytes and this ending, until the next one.
pub fn on_disk(data: &[u8], ending: &str) -> PathBuf {
    // The folder is scripts/fuzz.sh's own, and the file goes with it: to make and remove one each time takes longer than to read it.
    let path = std::env::temp_dir().join(format!("vencejo-fuzz-{}.{ending}", std::process::id()));
    fs::write(&path, data).expect("room for a file");
    path
}
