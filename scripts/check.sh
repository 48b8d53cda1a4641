#!/usr/bin/env bash
# Runs one named check and ends it with one plain line, so that a long log shows at a
# glance what ran and how long it took.   scripts/check.sh [--of 'PATHS'] NAME COMMAND…
#
# With --of, the check depends on these paths only: it is skipped while all files there that git tracks, or would track,
# are as they were when the check last passed. `make clean` resets that.
set -euo pipefail
# Each check chooses its own parallelism, also when `make` runs several side by side.
unset MAKEFLAGS MFLAGS MAKELEVEL
passed=
if [ "$1" = --of ]; then
    read -ra paths <<<"$2"
    shift 2
    passed=.cache/passed/$1
    state=$(git ls-files -z -co --exclude-standard -- "${paths[@]}" | sort -zu | while IFS= read -rd '' path; do
        if [ -f "$path" ]; then printf '%s\0' "$path"; fi
    done | xargs -0 sha256sum | cat - <(printf '%s\n' "$*" "$(node --version)") | sha256sum)
fi
name=$1
shift
if [ -n "$passed" ] && [ "$(cat "$passed" 2>/dev/null)" = "$state" ]; then
    printf '\n== %s: passed before, and nothing of it has changed\n' "$name"
    exit
fi
began=$SECONDS
printf '\n== %s: %s\n' "$name" "$*"
if "$@"; then
    if [ -n "$passed" ]; then
        mkdir -p .cache/passed
        printf '%s\n' "$state" >"$passed"
    fi
    printf '== %s: passed (%d s)\n' "$name" $((SECONDS - began))
else
    code=$?
    printf '== %s: FAILED with %d (%d s)\n' "$name" "$code" $((SECONDS - began))
    exit "$code"
fi
