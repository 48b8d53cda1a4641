//! Writes the API description to standard output: `cargo run -p vencejo-server --example openapi >
//! schemas/openapi.json`.

#![allow(clippy::print_stdout, reason = "that is what it is for")]

fn main() {
    print!("{}", vencejo_server::openapi());
}
