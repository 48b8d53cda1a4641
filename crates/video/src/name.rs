//! Camera names, which are used in URL paths and file names.

/// Longest camera name, characters.
pub const MAX_NAME: usize = 32;

/// Whether a text is a valid camera name.
pub fn is_name(name: &str) -> bool {
    (1..=MAX_NAME).contains(&name.len())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte))
}
