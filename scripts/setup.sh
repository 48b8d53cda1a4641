#!/usr/bin/env bash
# Prepares a checkout for running: system packages, the project's own Python environment (.venv) with locked packages,
# and the native module. Does nothing when nothing has changed.
#
#   scripts/setup.sh demo     for `vencejo demo`, the camera's packages included
#   scripts/setup.sh dev      that, the tools, the test peers, Chromium, MapServer and libfaketime
#   scripts/setup.sh docs     for building the site with `make docs`
#   scripts/setup.sh app      the web app (gcs/dist), embedded in the native module; `app-packages` only its build requirements
#   scripts/setup.sh native   the Rust core as vencejo._native, and the `vencejo` command; `native as-tested` builds it as `make test` does:
#                             quick to build, with assertions, slower in use; `native demo` as `make demo` does: quick to build,
#                             without fleets, reading the web app from gcs/dist; an existing build of the other two is used instead
#   scripts/setup.sh ready    all of that for `make demo` (`ready demo`) or `make native` (`ready native`), in parallel, with progress
#   scripts/setup.sh ice      ZeroC Ice and everything else for the tests of the JdeRobot interfaces
#   scripts/setup.sh soak     everything else for `make soak`: strace, and `ros`
#   scripts/setup.sh ros      readers of ROS 2: with Python 3.11 its own serialisation (.cache/ros), and one in Rust (.cache/ros2-hiroz)
#   scripts/setup.sh rust     only check that Rust and a C linker are installed
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH="$HOME/.cargo/bin:$PATH"
export PIP_DISABLE_PIP_VERSION_CHECK=1 CARGO_NET_RETRY=5
# Cargo chooses its own parallelism, also when `make` runs several things side by side.
unset MAKEFLAGS MFLAGS MAKELEVEL

VENV=.venv
STAMPS=$VENV/.house
NODE_MIN=20.19.0
RUST_MIN=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)

say() { printf '\033[2m· %s\033[0m\n' "$*" >&2; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

# apt PACKAGE…: installs Debian packages when root, else prints the command that does.
apt() {
    if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
        fail "missing system package: sudo apt-get install -y $*  (or your system's equivalent), then run this again"
    fi
    say "installing system packages: $*"
    local log
    log=$(mktemp)
    # One at a time: apt-get fails while dpkg is locked, and this may run twice in parallel.
    mkdir -p .cache
    exec 9>.cache/apt.lock
    flock 9
    if [ -z "${APT_UPDATED:-}" ]; then
        apt-get update -qq >"$log" 2>&1 || { cat "$log" >&2; fail "apt-get update failed"; }
        APT_UPDATED=1
    fi
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >"$log" 2>&1 \
        || { cat "$log" >&2; fail "apt-get install $* failed"; }
    exec 9>&-
    rm -f "$log"
}

# The first Python >= 3.10, even if its venv module is incomplete.
find_python() {
    local candidate
    for candidate in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11 python3.10; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
            command -v "$candidate"
            return
        fi
    done
    return 1
}

need_python() {
    PYTHON_FOUND=$(find_python) || apt python3
    PYTHON_FOUND=$(find_python) || fail "Python >= 3.10 is missing; set PYTHON=/path/to/python3"
    if ! "$PYTHON_FOUND" -c 'import ensurepip, venv' 2>/dev/null; then
        # Debian packages these separately from its own Python; other Pythons include them.
        apt "python$("$PYTHON_FOUND" -c 'import sys; print("%d.%d" % sys.version_info[:2])')-venv"
    fi
}

need_rust() {
    command -v cc >/dev/null || apt build-essential
    # Only when one of our crates actually links against it.
    if [ -f Cargo.lock ] && grep -q '^name = "libudev-sys"' Cargo.lock; then
        command -v pkg-config >/dev/null || apt pkg-config
        pkg-config --exists libudev || apt libudev-dev
    fi
    command -v cargo >/dev/null \
        || fail "Rust >= $RUST_MIN is missing (Debian's own is too old): see https://rustup.rs, then run this again"
    local have
    have=$(rustc --version | cut -d' ' -f2)
    [ "$(printf '%s\n%s\n' "$RUST_MIN" "${have%%-*}" | sort -V | head -n1)" = "$RUST_MIN" ] \
        || fail "Rust $have is too old, $RUST_MIN or newer is needed: rustup update stable"
}

# The browser for tests/browser: the system's, never a downloaded one. VENCEJO_CHROMIUM names another. Debian's
# headless-only Chromium is preferred where available: the tests take a quarter less time.
need_chromium() {
    local candidate
    for candidate in ${VENCEJO_CHROMIUM:-} chromium-headless-shell; do
        if command -v "$candidate" >/dev/null; then return; fi
    done
    if [ "$(id -u)" = 0 ] && apt-cache show chromium-headless-shell >/dev/null 2>&1; then
        if (apt chromium-headless-shell); then return; fi
    fi
    for candidate in chromium chromium-browser google-chrome-stable google-chrome; do
        if command -v "$candidate" >/dev/null; then return; fi
    done
    apt chromium
}

# The map server used by tests/maps and tests/browser.
need_mapserver() {
    if [ -x /usr/lib/cgi-bin/mapserv ] || command -v mapserv >/dev/null; then return; fi
    apt cgi-mapserver
}

# The faked clock of tests/faults/test_clocks.py.
need_faketime() {
    compgen -G '/usr/lib/*/faketime/libfaketime.so.1' >/dev/null || compgen -G '/usr/lib*/faketime/libfaketime.so.1' >/dev/null || apt libfaketime
}

# logged NAME PROBLEM COMMAND…: runs a command with its output in .cache/NAME.log, which is printed without progress
# bars on failure.
logged() {
    local log=.cache/$1.log problem=$2
    shift 2
    mkdir -p .cache
    "$@" >"$log" 2>&1 && return
    tr '\r' '\n' <"$log" | grep -avE '^ *(Building|Downloading) \[[=> ]*\]' >&2 || true
    fail "$problem"
}

# Hash of the content of the files named on standard input, one per line.
fingerprint() { tr '\n' '\0' | xargs -0 sha256sum | sha256sum | cut -d' ' -f1; }

python_env() { # demo | dev | docs
    local lock=requirements/$1.lock want
    want=$(printf '%s\n' "$lock" | fingerprint)
    # dev includes everything of demo: a second install would only switch back and forth.
    if [ "$1" = demo ] && [ "$(cat "$STAMPS/dev" 2>/dev/null)" = "$(printf 'requirements/dev.lock\n' | fingerprint)" ]; then
        return
    fi
    [ "$(cat "$STAMPS/$1" 2>/dev/null)" = "$want" ] && "$VENV/bin/python" -c '' 2>/dev/null && return
    if ! "$VENV/bin/python" -m pip --version >/dev/null 2>&1; then
        need_python
        say "creating $VENV with $("$PYTHON_FOUND" --version)"
        "$PYTHON_FOUND" -m venv --clear "$VENV"
    fi
    say "installing $lock into $VENV"
    # --no-deps: the lock is complete; what it omits, it omits on purpose (requirements/overrides.txt).
    # --no-compile: modules are compiled on first import; of most packages, only a small part ever is.
    logged "pip-$1" "$lock could not be installed" \
        "$VENV/bin/python" -m pip install --no-compile --require-hashes --no-deps --progress-bar off -r "$lock"
    mkdir -p "$STAMPS"
    echo "$want" >"$STAMPS/$1"
}

# Links Debian's own ZeroC Ice into the environment, if it was built for this Python version: 20 seconds instead of
# minutes of compiling. Fails otherwise.
debian_ice() {
    local system=/usr/lib/python3/dist-packages site suffix part
    suffix=$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))')
    [ -x /usr/bin/python3 ] && [ -r /etc/debian_version ] || return 1
    [ "$(/usr/bin/python3 -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))')" = "$suffix" ] || return 1
    if [ ! -e "$system/IcePy$suffix" ]; then
        [ "$(id -u)" = 0 ] || return 1
        apt python3-zeroc-ice
        [ -e "$system/IcePy$suffix" ] || return 1
    fi
    site=$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    for part in Ice IceMX "IcePy$suffix"; do ln -sfn "$system/$part" "$site/$part"; done
    "$VENV/bin/python" -c 'import Ice' 2>/dev/null
}

# Builds ZeroC Ice from source as a wheel, once on a machine for each Python and lock.
compiled_ice() {
    local cache build tag site
    tag=$("$VENV/bin/python" -c 'import sys, sysconfig; print(sys.implementation.cache_tag + "-" + sysconfig.get_platform())')
    cache=${XDG_CACHE_HOME:-$HOME/.cache}/vencejo/wheels/$tag-$(printf 'requirements/ice.lock\n' | fingerprint | cut -c1-12)
    if ! compgen -G "$cache/zeroc_ice-*.whl" >/dev/null; then
        command -v c++ >/dev/null || apt build-essential
        say "compiling ZeroC Ice (once on this machine, five to ten minutes)"
        build=$(mktemp -d)
        "$VENV/bin/python" -m venv "$build/venv"
        "$build/venv/bin/python" -m pip install --quiet --require-hashes --no-deps -r requirements/ice-build.lock
        # Not optimised for speed: compiling takes half the time, and the critical parts are not affected. Without debug
        # information: a third less time again, and a wheel of 3 MB instead of 35.
        CFLAGS='-O1 -g0' "$build/venv/bin/python" -m pip wheel --quiet --require-hashes --no-deps --no-build-isolation \
            --wheel-dir "$build/wheels" -r requirements/ice.lock >"$build/log" 2>&1 \
            || { cat "$build/log" >&2; fail "ZeroC Ice did not compile; it needs the headers of OpenSSL and bzip2 (libssl-dev, libbz2-dev)"; }
        mkdir -p "$cache"
        mv "$build"/wheels/zeroc_ice-*.whl "$cache/"
        rm -rf "$build"
    fi
    site=$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    # Through links to Debian's packages, pip would write into the system.
    find "$site" -maxdepth 1 -type l -name 'Ice*' -delete
    "$VENV/bin/python" -m pip install --quiet --no-deps --no-index --force-reinstall "$cache"/zeroc_ice-*.whl
}

# VENCEJO_ICE=compiled: do not use Debian's package even where installed.
ice() {
    if [ "${VENCEJO_ICE:-}" = compiled ]; then
        compiled_ice
    else
        "$VENV/bin/python" -c 'import Ice' 2>/dev/null || debian_ice || compiled_ice
    fi
    npm_packages examples/jderobot
}

# ROS 2's own serialisation in a separate Python environment, 270 MB, for tests/fleet/test_ros2_rclpy.py; there are
# wheels for one version only.
ros_python() {
    local want
    want=$(printf 'requirements/ros.lock\n' | fingerprint)
    [ "$(cat .cache/ros/lock 2>/dev/null)" != "$want" ] || return 0
    "$VENV/bin/python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || return 0
    say "installing ROS 2's own serialisation"
    "$VENV/bin/python" -m venv --clear .cache/ros
    .cache/ros/bin/python -m pip install --quiet --require-hashes --no-deps -r requirements/ros.lock
    echo "$want" >.cache/ros/lock
}

# Some 400 crates, minutes and 1.6 GB the first time, for tests/fleet/test_ros2_hiroz.py.
ros_reader() {
    need_rust
    cargo build --quiet --locked --manifest-path tests/fleet/ros2_hiroz/Cargo.toml --target-dir .cache/ros2-hiroz
}

need_node() {
    local have
    command -v node >/dev/null && command -v npm >/dev/null \
        || fail "Node.js >= $NODE_MIN with npm is missing (Debian's own is too old): see https://nodejs.org, then run this again"
    have=$(node --version)
    [ "$(printf '%s\n%s\n' "$NODE_MIN" "${have#v}" | sort -V | head -n1)" = "$NODE_MIN" ] \
        || fail "Node.js ${have#v} is too old, $NODE_MIN or newer is needed: see https://nodejs.org"
}

# Hash of the files in these folders, except those ignored by git.
content() {
    git ls-files -co --exclude-standard -- "$@" | while read -r path; do if [ -f "$path" ]; then echo "$path"; fi; done | fingerprint
}

# npm_packages FOLDER: installs the packages of its lock in FOLDER/node_modules.
npm_packages() {
    local folder=$1 want
    want=$(printf '%s\n' "$folder/package.json" "$folder/package-lock.json" | fingerprint)
    [ "$(cat "$folder/node_modules/.house" 2>/dev/null)" = "$want" ] && return
    need_node
    say "installing $folder/package-lock.json"
    logged "npm-${folder//\//-}" "$folder/package-lock.json could not be installed" \
        npm --prefix "$folder" ci --fetch-retries 5 --loglevel http
    echo "$want" >"$folder/node_modules/.house"
}

app() {
    local want
    need_node
    want=$(content gcs)
    [ "$(cat .cache/app 2>/dev/null)" = "$want" ] && [ -f gcs/dist/index.html ] && return
    npm_packages gcs
    say "building the web app"
    logged app "the web app did not build" npm --prefix gcs run --silent build
    echo "$want" >.cache/app
}

# Inputs of the native module, and how it is built.
native_fingerprint() { # HOW
    { git ls-files -co --exclude-standard -- crates Cargo.toml Cargo.lock pyproject.toml; echo .cache/app; } \
        | while read -r path; do if [ -f "$path" ]; then echo "$path"; fi; done | fingerprint | tr '\n' -
    rustc --version | sha256sum | cut -c1-12 | tr '\n' -
    echo "$1"
}

has_native() { # HOW…: it is there, built in one of these ways
    local have how
    have=$(cat "$STAMPS/native" 2>/dev/null) || return 1
    [ -x "$VENV/bin/vencejo" ] && compgen -G 'python/vencejo/_native*.so' >/dev/null || return 1
    for how in "$@"; do [ "$have" != "$(native_fingerprint "$how")" ] || return 0; done
    return 1
}

# Shows progress even in a log, where scripts/get_ready.py reads it.
export CARGO_TERM_PROGRESS_WHEN=always CARGO_TERM_PROGRESS_WIDTH=100

native() { # release | as-tested | demo
    local how
    case $1 in
        release) how=(--release) ;;
        # The same Python as in cargo's tests (.cargo/config.toml).
        as-tested) how=(--profile dev --features as-tested,fleet); export PYO3_CONFIG_FILE=$PWD/crates/py/any-python.txt ;;
        # A feature that is on anyhow, in place of those in pyproject.toml.
        demo) how=(--profile demo --features vencejo-server/app) ;;
        *) fail "native: release, as-tested or demo" ;;
    esac
    if [ "$1" = demo ]; then has_native demo release as-tested && return; else has_native "$1" && return; fi
    # The demo's module reads the pages from disk, with the folder set at compile time: the folder must exist by then,
    # the pages need not.
    mkdir -p gcs/dist
    say "building the native module (the first time takes minutes)"
    VIRTUAL_ENV=$PWD/$VENV logged native "the native module did not build" "$VENV/bin/maturin" develop "${how[@]}" --locked
    mkdir -p "$STAMPS"
    native_fingerprint "$1" >"$STAMPS/native"
}

case "${1:-}" in
    demo) python_env demo ;;
    dev) need_chromium; need_mapserver; need_faketime; python_env dev ;;
    docs) python_env docs ;;
    soak) command -v strace >/dev/null || apt strace; ros_python; ros_reader ;;
    ros) ros_python; ros_reader ;;
    app) app; npm_packages gcs ;;
    app-packages) need_node; npm_packages gcs ;;
    native) need_rust; native "${2:-release}" ;;
    ready) need_python; exec "$PYTHON_FOUND" scripts/get_ready.py "${2:-native}" ;;
    ice) ice ;;
    rust) need_rust ;;
    *) fail "say what: demo, dev, docs, app, app-packages, native, ready, ice, soak, ros or rust" ;;
esac
