//! Writes the API description to standard output: `cargo run -p vencejo-server --example openapi >
//! schemas/openapi.json`.

#![allow(clippy::print_stdout, reason = "its purpose is to print")]

fn main() {
    print!("{}", vencejo_server::openapi());
}
