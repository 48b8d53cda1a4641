//! Recompiles the crate when the web app, which is embedded in the binary, was rebuilt. While there is no app yet, a
//! change of VENCEJO_APP (to any new value) signals that there is one now: watching a missing folder would recompile
//! every time.

#[allow(clippy::print_stdout, reason = "cargo reads standard output")]
fn main() {
    let dist = "../../gcs/dist";
    let has = |feature| std::env::var_os(feature).is_some();
    // Profiles that inherit from `dev` read the files from disk.
    let is_release = std::env::var_os("PROFILE").is_some_and(|profile| profile == "release");
    let is_embedded = has("CARGO_FEATURE_EMBEDDED") || has("CARGO_FEATURE_APP") && is_release;
    if is_embedded && std::path::Path::new(dist).is_dir() {
        println!("cargo::rerun-if-changed={dist}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=VENCEJO_APP");
}
