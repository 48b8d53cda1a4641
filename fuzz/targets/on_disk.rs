//! For readers that take a file: one in memory, written anew each time.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The bytes in a file with this ending.
pub fn file(data: &[u8], ending: &str) -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    let path = PATH.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        folder.join(format!("vencejo-fuzz-{}.{ending}", std::process::id()))
    });
    fs::write(path, data).expect("room for a file");
    path
}
