#!/usr/bin/env bash
# Runs one named check and ends it with one plain line, so that a reader of a long log sees at a
# glance what ran and how long it took.   scripts/check.sh NAME COMMAND…
set -euo pipefail
# How much each of them does at once is its own affair, also where `make` runs several side by side.
unset MAKEFLAGS MFLAGS MAKELEVEL
name=$1
shift
began=$SECONDS
printf '\n== %s: %s\n' "$name" "$*"
if "$@"; then
    printf '== %s: passed (%d s)\n' "$name" $((SECONDS - began))
else
    code=$?
    printf '== %s: FAILED with %d (%d s)\n' "$name" "$code" $((SECONDS - began))
    exit "$code"
fi
