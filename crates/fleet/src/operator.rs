//! A ground station's own key, in a file that only its owner reads.

use std::path::Path;

use vencejo_store::Access;

use crate::error::FleetError;
use crate::signature::{PublicKey, Signer};

/// The key of a file; a new one where there is no file.
///
/// # Errors
/// [`FleetError::File`].
pub fn key_of_file(path: &Path) -> Result<Signer, FleetError> {
    let bad = |problem: String| FleetError::File { path: path.display().to_string(), problem };
    if !path.exists() {
        let seed = PublicKey(random()?);
        let made = vencejo_store::create(path, format!("{seed}\n").as_bytes(), Access::Owner);
        made.map_err(|error| bad(error.to_string()))?;
    }
    let text = vencejo_store::read_small_text(path).map_err(|error| bad(error.to_string()))?;
    let seed = text.trim().parse::<PublicKey>();
    // The secret is not shown, wrong or not.
    let seed = seed.map_err(|_| bad("it holds no key; move it away, and a new one is made".to_owned()))?;
    Ok(Signer::from_seed(&seed.0))
}

/// Random bytes.
///
/// # Errors
/// [`FleetError::NoRandom`].
pub fn random<const N: usize>() -> Result<[u8; N], FleetError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| FleetError::NoRandom(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_made_once_and_a_broken_file_is_told_of() {
        let folder = std::env::temp_dir().join(format!("vencejo-fleet-key-{}", std::process::id()));
        let path = folder.join("fleet").join("acme.key");
        let made = key_of_file(&path).expect("made").public();
        assert_eq!(key_of_file(&path).expect("read").public(), made);
        let text = std::fs::read_to_string(&path).expect("a file");
        assert_eq!(
            (text.len(), text.contains(&made.to_string())),
            (65, false),
            "the secret, not the key that people see"
        );
        std::fs::write(&path, "secret-ish").expect("written");
        let error = key_of_file(&path).expect_err("no key").to_string();
        assert!(error.contains("acme.key") && !error.contains("secret-ish"), "{error}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
