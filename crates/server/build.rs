//! Has the crate compiled anew when the web app was built anew. Where there is none yet, VENCEJO_APP (any value that was not
//! there before) says that there is one now: watching for a folder that is not there would compile every time.

#[allow(clippy::print_stdout, reason = "that is how cargo is told")]
fn main() {
    let dist = "../../gcs/dist";
    if std::env::var_os("CARGO_FEATURE_APP").is_some() && std::path::Path::new(dist).is_dir() {
        println!("cargo::rerun-if-changed={dist}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=VENCEJO_APP");
}
