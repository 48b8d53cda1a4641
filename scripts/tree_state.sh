#!/usr/bin/env bash
# Asserts that a run did not change the checkout: nothing generated, reformatted or left behind.
#   scripts/tree_state.sh save     before the run (in CI the tree must be clean already)
#   scripts/tree_state.sh check    after it
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p .cache
saved=.cache/tree-state

state() { git status --porcelain; git diff HEAD | sha256sum; }

case "${1:-}" in
    save)
        state >"$saved"
        if [ -n "${CI:-}" ] && [ -n "$(git status --porcelain)" ]; then
            git status --short >&2
            echo "tree: not clean before the tests" >&2
            exit 1
        fi
        ;;
    check)
        if ! diff <(state) "$saved" >/dev/null; then
            git status --short >&2
            git --no-pager diff --stat >&2
            echo "tree: the tests changed the checkout (or you did, while they ran)" >&2
            exit 1
        fi
        ;;
    *) echo "tree_state: say save or check" >&2; exit 2 ;;
esac
