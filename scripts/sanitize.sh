#!/usr/bin/env bash
# Runs the tests of the crates that parse external data under AddressSanitizer (with leak detection), and under Miri
# where installed.
set -euo pipefail
cd "$(dirname "$0")/.."
crates=(-p vencejo-proto -p vencejo-flight -p vencejo-vehicle)

# The sanitizer's runtime comes with stable Rust; its option needs RUSTC_BOOTSTRAP. With an explicit target, build
# scripts are compiled without it.
host=$(rustc -vV | sed -n 's/^host: //p')
RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address CARGO_INCREMENTAL=0 \
  cargo test --quiet --locked "${crates[@]}" --lib --tests --target "$host" --target-dir .cache/sanitize

if cargo +nightly miri --version >/dev/null 2>&1; then
  # Some tests read the machine's files and clocks; Miri is slow, so there are few random cases.
  MIRIFLAGS=-Zmiri-disable-isolation PROPTEST_CASES=2 \
    cargo +nightly miri test --locked "${crates[@]}" --lib --target-dir .cache/miri
else
  printf 'sanitize: Miri is not installed, so it was not tried: rustup +nightly component add miri rust-src\n' >&2
fi
