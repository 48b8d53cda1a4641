#!/usr/bin/env bash
# Fuzzing: builds fuzz/ with libFuzzer's counters on stable Rust, repeats all crashers, then runs each target for a
# time. See fuzz/README.md.
#   scripts/fuzz.sh SECONDS [TARGET...]
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(sed -n 's/^path = "targets\/\(.*\)\.rs"/\1/p' fuzz/Cargo.toml)

host=$(rustc -vV | sed -n 's/^host: //p')
# With an explicit target, build scripts and macros are compiled without the counters.
RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
-Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing" \
  cargo build --quiet --locked --profile fuzz --package vencejo-fuzz --bins --features fuzzer --target "$host" --target-dir .cache/fuzz/build

# Files that targets read are in memory, and are removed at the end.
TMPDIR=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" vencejo-fuzz.XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

failed=()
for target in "${targets[@]}"; do
  program=.cache/fuzz/build/$host/fuzz/$target
  mkdir -p ".cache/fuzz/$target" "fuzz/crashers/$target"
  limits=(-rss_limit_mb=2048 -timeout=10 -artifact_prefix="fuzz/crashers/$target/")
  mapfile -t crashers < <(find "fuzz/crashers/$target" -type f ! -name .gitkeep | sort)
  if [ ${#crashers[@]} -gt 0 ] && ! "$program" "${limits[@]}" "${crashers[@]}" > ".cache/fuzz/$target.log" 2>&1; then
    failed+=("$target (a crasher)")
    continue
  fi
  corpus=()
  [ ! -d "fuzz/corpus/$target" ] || corpus=("fuzz/corpus/$target")
  if "$program" "${limits[@]}" -max_total_time="$seconds" -print_final_stats=1 ".cache/fuzz/$target" "${corpus[@]}" \
    > ".cache/fuzz/$target.log" 2>&1; then
    sed -n "s/^stat::number_of_executed_units: */$target: executions: /p" ".cache/fuzz/$target.log"
  else
    failed+=("$target")
    tail -n 5 ".cache/fuzz/$target.log" >&2
  fi
done
rmdir --ignore-fail-on-non-empty fuzz/crashers/* fuzz/crashers 2> /dev/null || true
if [ ${#failed[@]} -gt 0 ]; then
  printf 'fuzz: failed: %s; what broke it is in fuzz/crashers/\n' "${failed[@]}" >&2
  exit 1
fi
