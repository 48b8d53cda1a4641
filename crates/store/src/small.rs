//! Reading a file that holds a key, a certificate, tokens or the like, without trusting its size.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Most bytes of such a file.
pub const MAX_SMALL_BYTES: u64 = 4 << 20;

/// The bytes of a small file.
///
/// # Errors
/// As reading, and [`io::ErrorKind::FileTooLarge`] beyond [`MAX_SMALL_BYTES`], of which a device has more too.
pub fn read_small(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_SMALL_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_SMALL_BYTES {
        let problem = format!("it has more than {MAX_SMALL_BYTES} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// The text of a small file.
///
/// # Errors
/// As [`read_small`], and [`io::ErrorKind::InvalidData`] for what is not UTF-8.
pub fn read_small_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_small(path)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_endless_file_is_refused_after_its_limit() {
        assert_eq!(read_small_text(Path::new("/dev/null")).expect("read"), "");
        let error = read_small(Path::new("/dev/zero")).expect_err("endless");
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge, "{error}");
    }
}
