#!/usr/bin/env bash
# Turns pyproject.toml into requirements/*.lock: every version pinned, every file hashed, for every
# Python that we support, and no index address inside. Needs `uv` (pip install uv).
# `scripts/lock.sh --upgrade` takes newer versions.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v uv >/dev/null || { echo "lock: uv is missing: python3 -m pip install uv" >&2; exit 1; }

compile() { # output, arguments
    local output=$1
    shift
    uv pip compile --quiet --universal --python-version "${PYTHON_FLOOR:-3.10}" --generate-hashes --no-annotate \
        --no-emit-index-url --no-emit-find-links --custom-compile-command "make lock" \
        --override requirements/overrides.txt --output-file "$output" "$@" >/dev/null
}

# run: what `vencejo` needs. demo: that and the camera, for `make demo`. dev: that and the tools. Constrained to be
# consistent.
compile requirements/run.lock pyproject.toml --group build "$@"
compile requirements/demo.lock pyproject.toml --group build --extra camera --constraint requirements/run.lock "$@"
compile requirements/dev.lock pyproject.toml --group tools --extra camera --constraint requirements/demo.lock "$@"
# docs: for building the site, in addition to what `vencejo` needs, whose help it shows.
compile requirements/docs.lock pyproject.toml --group build --group docs --constraint requirements/dev.lock "$@"
# ice: compiled by the tests where Debian has no ZeroC Ice for this Python; ice-build: its build requirements.
sed -n 's/^ice = \["\(zeroc-ice[^"]*\)".*/\1/p' pyproject.toml | compile requirements/ice.lock - "$@"
echo 'setuptools>=77' | compile requirements/ice-build.lock - "$@"
# ros: ROS 2's own serialisation and type hashes, for `make soak`; there are wheels for one Python version only.
printf '%s\n' 'ros-rclpy[fastrtps]==9.1.2' ros-{sensor,nav,geometry,diagnostic}-msgs==5.5.1 ros-std-srvs==5.5.1 \
    | PYTHON_FLOOR=3.11 compile requirements/ros.lock - "$@"
# audit: the tool with which `make audit` looks up known faults.
echo 'pip-audit>=2.10,<3' | compile requirements/audit.lock - "$@"
