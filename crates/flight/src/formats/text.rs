//! Files as text: bounded, UTF-8, and shown safely in messages.

use vencejo_proto::is_plain;

use crate::error::{FlightError, Result};
use crate::plan::MAX_ITEMS;

/// Largest file that is read, bytes.
pub const MAX_FILE_BYTES: usize = 16 * 1024 * 1024;

/// The text of a file: bounded, UTF-8, without byte-order mark, not empty.
pub(super) fn text_of(bytes: &[u8]) -> Result<&str> {
    if bytes.len() > MAX_FILE_BYTES {
        return Err(FlightError::BadFile(format!(
            "the file has {} bytes; files up to {MAX_FILE_BYTES} bytes are read, so split it",
            bytes.len()
        )));
    }
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) || bytes.contains(&0) {
        return Err(FlightError::BadFile(
            "the file is UTF-16 or binary, not text in UTF-8; save it again as UTF-8".into(),
        ));
    }
    let bytes = bytes.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        FlightError::BadFile(format!(
            "the file is not UTF-8 text from byte {} on; save it again as UTF-8",
            error.valid_up_to()
        ))
    })?;
    if text.trim().is_empty() {
        return Err(FlightError::BadFile("the file is empty; choose another or save it again".into()));
    }
    Ok(text)
}

/// Text of a file in an error message: cut, and without control characters.
pub(super) fn shown(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    let mut short: String = text.chars().take(MAX_CHARS).map(|c| if is_plain(c) { c } else { '?' }).collect();
    if text.chars().nth(MAX_CHARS).is_some() {
        short.push('…');
    }
    short
}

/// Parses a number of a text file; the error is a sentence.
pub(super) fn number(text: &str, column: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.contains(',') => {
            Err(format!("has \"{}\" as its {column}; write decimals with a point, not a comma", shown(text)))
        }
        _ => Err(format!("has \"{}\" as its {column}; a finite number belongs there", shown(text))),
    }
}

/// Why a list of items is too long, if it is.
pub(super) fn too_many(count: usize) -> Option<String> {
    (count > MAX_ITEMS).then(|| format!("has {count} items; at most {MAX_ITEMS} are read, so split the plan"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_text_is_short_and_clean() {
        assert_eq!(shown("a\x1b[31m"), "a?[31m");
        assert_eq!(shown(&"x".repeat(1000)).chars().count(), 41);
    }
}
