//! The names that cameras may have: they stand in paths and in names of files.

/// Characters of a camera's name at most.
pub const MAX_NAME: usize = 32;

/// Whether a camera may be called so.
pub fn is_name(name: &str) -> bool {
    (1..=MAX_NAME).contains(&name.len())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte))
}
