//! Writes the core's constants for the page to standard output: `cargo run -p vencejo-server --example core_facts >
//! gcs/src/lib/domain/core.json`.

#![allow(clippy::print_stdout, reason = "its purpose is to print")]

fn main() {
    print!("{}", vencejo_server::core_facts());
}
