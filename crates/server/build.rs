//! Has the crate compiled anew when the web app was built anew, where it is put into the binary. Where there is none yet,
//! VENCEJO_APP (any value that was not there before) says that there is one now: watching for a folder that is not there would
//! compile every time.

#[allow(clippy::print_stdout, reason = "that is how cargo is told")]
fn main() {
    let dist = "../../gcs/dist";
    let has = |feature| std::env::var_os(feature).is_some();
    // profiles that inherit from `dev` read the files where they are
    let is_release = std::env::var_os("PROFILE").is_some_and(|profile| profile == "release");
    let is_embedded = has("CARGO_FEATURE_EMBEDDED") || has("CARGO_FEATURE_APP") && is_release;
    if is_embedded && std::path::Path::new(dist).is_dir() {
        println!("cargo::rerun-if-changed={dist}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=VENCEJO_APP");
}
