//! Writes the core's constants for the page to standard output: `cargo run -p vencejo-server --example core_facts >
//! gcs/src/lib/domain/core.json`.

#![allow(clippy::print_stdout, reason = "that is what it is for")]

fn main() {
    print!("{}", vencejo_server::core_facts());
}
