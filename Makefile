# Everything a person does with this checkout. Each target does its own set-up on a clean Debian 12
# (Python >= 3.10, Rust and Node.js present) and redoes none of it when nothing changed.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

export PATH := $(HOME)/.cargo/bin:$(PATH)
# Each Python module is compiled once, not by each of the hundred programs that the tests start, also where the environment asks for that.
export PYTHONDONTWRITEBYTECODE :=
export PYTHONPYCACHEPREFIX := $(CURDIR)/.cache/pycache
PY := .venv/bin/python
CHECK := scripts/check.sh
# The binding too, though it is tested from Python: with it all of `make test` asks the same features of each crate.
# Aircraft far away are in it as in wheels; who works elsewhere builds without, and minutes faster.
CARGO_TEST := --workspace --locked --features vencejo-py/fleet
# Several times as long as they take beside pytest.
CARGO_TEST_WITHIN := 40m
DEMO_ARGS ?=
PYTEST_ARGS ?=
# Three times as many as there are cores: most tests wait for a plane or a page most of their time.
PYTEST_WORKERS ?= $(shell echo $$(( 3 * $$(nproc) )))
# What of `make test` runs side by side: compilers and checkers leave gaps in which the others go on.
SIDE_BY_SIDE := --no-print-directory --jobs=3 --output-sync IS_SIDE_BY_SIDE=yes
BENCH_ARGS ?=
TRUTH_ARGS ?=
AUDIT_ARGS ?=
# How long and how often `make soak` does what: seconds of mixed faults, seeds and uploads, frames, kills, hours of recording.
SOAK_S ?= 3600
SOAK_TIMES ?= 1000
SOAK_FRAMES ?= 10000000
SOAK_CALLS ?= 1000000
SOAK_HOURS ?= 72
# How long `make fuzz` gives each target, and which (all by default).
FUZZ_SECONDS ?= 60
FUZZ_TARGETS ?=
SCREENSHOT_ARGS ?=

.PHONY: help demo test lint soak ros faults fuzz sanitize audit fmt bench truth screenshots docs wheel lock clean rust-env dev-env app native

help: ## Show this list
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-8s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: ## The ground station with a simulated plane that flies the demo mission; yours after the landing
	@scripts/setup.sh ready demo
	@.venv/bin/vencejo demo $(DEMO_ARGS)

# The arrows are checked by tests/house too.
LINT_CHECKS := clippy rustdoc arrows rustfmt ruff-format ruff mypy
test: ## Everything that CI runs: layout, format, lints, types, Rust and Python tests
	@scripts/tree_state.sh save
	@$(MAKE) $(SIDE_BY_SIDE) dev-env native-as-tested $(filter-out arrows,$(LINT_CHECKS)) cargo-test-built gcs-check gcs-test
	@$(MAKE) $(SIDE_BY_SIDE) --output-sync=none cargo-test pytest
	@$(CHECK) tree scripts/tree_state.sh check
	@printf '\nmake test: all passed\n'

lint: ## Only the layout, format, lint and type checks
	@$(MAKE) $(SIDE_BY_SIDE) dev-env lint-checks

.PHONY: lint-checks $(LINT_CHECKS) cargo-test-built cargo-test pytest native-as-tested gcs-check gcs-test
lint-checks: $(LINT_CHECKS)
arrows: dev-env
	@$(CHECK) arrows $(PY) scripts/check_arrows.py
rustfmt: rust-env
	@$(CHECK) rustfmt cargo fmt --all --check
ruff-format: dev-env
	@$(CHECK) ruff-format .venv/bin/ruff format --check --quiet .
ruff: dev-env
	@$(CHECK) ruff .venv/bin/ruff check --quiet .
mypy: dev-env
	@$(CHECK) mypy .venv/bin/mypy
clippy: rust-env
	@$(CHECK) clippy cargo clippy --quiet $(CARGO_TEST) --all-targets -- -D warnings
# These two after clippy, for whose folder they would wait.
rustdoc: clippy
	@$(CHECK) rustdoc env RUSTDOCFLAGS='-D warnings' cargo doc --quiet $(CARGO_TEST) --no-deps --document-private-items
cargo-test-built: clippy
	@$(CHECK) cargo-test-built cargo test --quiet --no-run $(CARGO_TEST)
# Beside pytest, which tells how far it is: this one tells all when it is done. A test that never ends is named in what it
# tells, as one that runs for over a minute, and waited for no longer.
cargo-test:
	@mkdir -p .cache
	@code=0; $(CHECK) cargo-test timeout --foreground --verbose $(CARGO_TEST_WITHIN) cargo test --quiet $(CARGO_TEST) >.cache/cargo-test.log 2>&1 || code=$$?; \
	cat .cache/cargo-test.log; exit $$code
pytest:
	@$(CHECK) pytest $(PY) -m pytest -q -n $(PYTEST_WORKERS) --dist worksteal $(PYTEST_ARGS)
# From what the Rust tests are compiled from, with their assertions and without link-time optimisation: minutes less.
native-as-tested: app clippy
	@scripts/setup.sh native as-tested
# What the checks of the web app read, fixtures and what is generated from Rust included.
GCS_READS := --of 'gcs schemas crates tests/fixtures'
gcs-check: app
	@$(CHECK) $(GCS_READS) gcs-check npm --prefix gcs run --silent check
gcs-test: app
	@$(CHECK) $(GCS_READS) gcs-test npm --prefix gcs test --silent

faults: dev-env ## Write tests/faults/REPORT.md: which fault is proven by which tests
	@$(PY) scripts/fault_report.py

soak: dev-env native ## The long forms of the fault tests, hours of them (SOAK_S=259200 is three days)
	@scripts/setup.sh soak
	VENCEJO_TEST_SEEDS=$(SOAK_TIMES) VENCEJO_TEST_KILLS=$(SOAK_TIMES) VENCEJO_TEST_FRAMES=$(SOAK_FRAMES) \
	VENCEJO_TEST_HOURS=$(SOAK_HOURS) VENCEJO_TEST_CALLS=$(SOAK_CALLS) PROPTEST_CASES=$$(( 100 * $(SOAK_TIMES) )) \
		cargo test $(CARGO_TEST) --lib --test frames --test plan_files -- --nocapture \
		real_files lossy:: faults:: mixed:: recorder::tests what_is_sent intact_frames schedules:: every_whole no_bytes_panic no_payload_panics
	VENCEJO_TEST_FRAMES=$(SOAK_FRAMES) $(PY) -m pytest -q --timeout=0 tests/peers/test_c_parser.py
	VENCEJO_SOAK_S=$(SOAK_S) VENCEJO_SOAK_TIMES=$(SOAK_TIMES) $(PY) -m pytest -q -s -m soak tests

ros: dev-env native ## A plane in ROS 2 read by rclpy's own serialisation and by hiroz, which is built first (400 crates): the nightly form
	@scripts/setup.sh ros
	$(PY) -m pytest -q -m soak tests/fleet/test_ros2_rclpy.py tests/fleet/test_ros2_hiroz.py

audit: dev-env ## Licences, sources, duplicates and known faults of everything that is not ours
	@$(PY) scripts/audit.py $(AUDIT_ARGS)

fuzz: rust-env ## Every fuzz target for FUZZ_SECONDS, 60 by default (fuzz/README.md)
	@scripts/fuzz.sh $(FUZZ_SECONDS) $(FUZZ_TARGETS)

sanitize: rust-env ## The tests of what reads other people's bytes under AddressSanitizer, and Miri where it is installed
	@scripts/sanitize.sh

fmt: dev-env ## Format Rust and Python
	cargo fmt --all
	.venv/bin/ruff check --quiet --fix --exit-zero .
	.venv/bin/ruff format --quiet .

bench: dev-env native ## Measure, side by side with the peers, into bench/RESULTS.md (about 20 minutes)
	cargo build --release --locked -p vencejo-bench-load -p vencejo-link -p vencejo-station --bins --examples
	cargo build --release --locked -p vencejo-py -p vencejo-fleet --features vencejo-py/fleet --example crowd --example listen --example bare_router
	$(PY) bench/run.py $(BENCH_ARGS)
	$(PY) bench/tiles.py
	$(PY) bench/station/paint.py
	$(PY) bench/station/frames.py
	$(PY) bench/station/dragging.py

truth: dev-env native ## How true rehearsals are, beside recorded flights of an ArduPlane and flights of the simulated plane (bench/README.md)
	@$(PY) bench/truth.py $(TRUTH_ARGS)

screenshots: dev-env native ## Take the pictures of the ground station into docs/images
	@$(PY) scripts/screenshots.py $(SCREENSHOT_ARGS)

docs: native ## The documentation site into dist/site: open dist/site/index.html, no server and no network needed
	@scripts/setup.sh docs
	@NO_MKDOCS_2_WARNING=1 $(PY) -m mkdocs build --strict --quiet
	@echo 'docs: dist/site/index.html'

wheel: dev-env app ## Build the wheel into dist/, with the list of all that is in it (CycloneDX)
	@scripts/setup.sh rust
	rm -f dist/vencejo-*.whl dist/vencejo-*.cdx.json
	$(PY) scripts/sbom.py parts .cache/sbom
	VIRTUAL_ENV=$(CURDIR)/.venv .venv/bin/maturin build --release --locked --quiet --out dist \
		--sbom-include .cache/sbom/vencejo-gcs.cyclonedx.json --sbom-include .cache/sbom/vencejo-python.cyclonedx.json
	$(PY) scripts/sbom.py merge dist/vencejo-*.whl
	@ls dist/vencejo-*

lock: ## Pin and hash the Python packages anew (needs uv)
	scripts/lock.sh

clean: ## Remove everything that was built
	rm -rf target dist .venv .cache bench/out python/vencejo/_native*.so gcs/dist gcs/node_modules
	find python scripts tests bench -name __pycache__ -type d -prune -exec rm -rf {} +

rust-env:
	@scripts/setup.sh rust
dev-env:
	@scripts/setup.sh rust
	@scripts/setup.sh dev
	@scripts/setup.sh ice
app:
	@scripts/setup.sh app
native: ## The optimised native module, with fleets, as wheels have it
	@scripts/setup.sh ready native

# Otherwise one thing after the other, in the order in which a target names what it needs.
ifdef IS_SIDE_BY_SIDE
native-as-tested: dev-env
else
.NOTPARALLEL:
endif
