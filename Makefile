# `make help` lists the targets. Builds are in target/ (Rust) and .venv/ (Python).
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.SUFFIXES:
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
MAKEFLAGS += --no-print-directory

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
TRUNDLE := $(BIN)/trundle

# Absolute paths, so that maturin and clippy use the same interpreter and pyo3 is not rebuilt.
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python

# One more than there are processors, because some tests wait.
PROCESSES = $(shell expr $$(getconf _NPROCESSORS_ONLN) + 1)

RUST := $(shell find env adaptive python/src -type f -not -path '*/tests/*' -not -path '*/benches/*') \
	python/Cargo.toml Cargo.toml Cargo.lock pyproject.toml

say = @printf '\n\033[1m==> %s\033[0m\n' $(1)

.PHONY: help build demo test test-slow test-rl test-browser lint lint-rust lint-python format lock bench wheel sdist docs notebooks rust-docs clean

help: ## show this text
	@echo "trundle: push unknown objects, estimate their physics, and diagnose what a simulation misses."
	@echo
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' Makefile | expand -t 22
	@echo
	@echo "Needs $(PYTHON) >= 3.10 with venv, cargo (rustup.rs) and a C linker; PYTHON=... chooses another Python."

build: ## build the package and the command .venv/bin/trundle
	@$(MAKE) --jobs 2 $(VENV)/.built

demo: build ## simulate a recording of a table with hidden defects and diagnose it (about 8 minutes in a new clone)
	$(call say,"1/2 simulating pushes of a table with a locked wheel and hidden dry friction")
	$(TRUNDLE) simulate --demo --out demo/recording
	$(call say,"2/2 diagnosing the recording")
	$(TRUNDLE) diagnose demo/recording --out demo/diagnosis
	$(call say,"report: demo/diagnosis/report.html")

test: build ## build and run the Rust and Python tests (about 25 minutes in a new clone)
	$(call say,"1/2 Rust tests (most of the time is compilation)")
	cargo test --release --locked --workspace
	$(call say,"2/2 Python tests")
	$(BIN)/python -m pytest --ignore tests/rl -m "not slow and not browser" --numprocesses $(PROCESSES) --dist loadfile

test-slow: build ## run the slow tests, each of a minute or more
	cargo test --release --locked --workspace -- --ignored
	$(BIN)/python -m pytest --ignore tests/rl -m slow

test-browser: build ## run the tests that render pages in Chromium (skipped where there is none)
	$(call say,"Python tests of pages in a browser")
	$(BIN)/python -m pytest --ignore tests/rl -m browser

test-rl: build $(VENV)/.rl ## run the tests of the extra [rl]; installs PyTorch (5 GB on disk)
	$(call say,"Python tests of the extra [rl]")
	$(BIN)/python -m pytest tests/rl

lint: $(VENV)/.packages ## check formatting, clippy, ruff and mypy
	@$(MAKE) --jobs 2 lint-rust lint-python

lint-rust: $(VENV)/.created
	$(call say,"Rust: rustfmt and clippy")
	cargo fmt --all --check
	cargo clippy --release --locked --workspace --all-targets -- --deny warnings

lint-python: $(VENV)/.packages
	$(call say,"Python: ruff and mypy")
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

format: $(VENV)/.packages ## reformat Rust and Python
	cargo fmt --all
	$(BIN)/ruff check --fix --quiet
	$(BIN)/ruff format

bench: build ## run the Criterion benchmarks and time `import trundle`
	$(BIN)/python benches/import_time.py
	cargo bench --locked

wheel: $(VENV)/.packages ## build dist/*.whl, install it into a new environment and run the first diagnosis there
	$(call say,"1/2 building the wheel")
	rm -rf dist
	$(BIN)/maturin build --release --locked --out dist
	$(call say,"2/2 first diagnosis in a new environment with the core dependencies")
	$(BIN)/python .ci/check_wheel.py dist/trundle-*.whl

sdist: $(VENV)/.packages ## build dist/*.tar.gz, and a wheel from it (compiles everything)
	$(BIN)/maturin sdist --out dist
	$(PIP) wheel --no-deps --wheel-dir dist/from-sdist dist/trundle-*.tar.gz

rust-docs: $(VENV)/.created ## build the reference of the Rust crates in target/doc; warnings are errors
	RUSTDOCFLAGS="--deny warnings" cargo doc --release --locked --workspace --no-deps

docs: build rust-docs $(VENV)/.docs ## build the documentation site in site/ (no network)
	$(call say,"documentation site")
	$(BIN)/python -m mkdocs build --strict

notebooks: build $(VENV)/.docs ## execute the tutorials in docs/tutorials, in place
	$(BIN)/python docs/tutorials/run.py

lock: $(VENV)/.packages ## update requirements*.lock from pyproject.toml; UPGRADE=--upgrade takes the newest versions
	$(PIP) install uv
	$(BIN)/uv $(COMPILE) --extra dev --output-file requirements.lock pyproject.toml
	$(BIN)/uv $(COMPILE) --extra rl --constraint requirements.lock --output-file requirements-rl.lock pyproject.toml
	$(BIN)/uv $(COMPILE) --extra docs --constraint requirements.lock --output-file requirements-docs.lock pyproject.toml

UPGRADE ?=
COMPILE = pip compile --quiet $(UPGRADE) --universal --python-version 3.10 --generate-hashes \
	--no-annotate --no-emit-index-url --no-header

clean: ## remove builds and the output of the demo
	rm -rf $(VENV) target demo dist site

$(VENV)/.created:
	$(call say,"Python environment in $(VENV)")
	@command -v $(PYTHON) > /dev/null || { echo "$(PYTHON) is missing: install Python 3.10 or newer"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
		{ echo "$$($(PYTHON) --version) is too old: 3.10 or newer is needed; PYTHON=python3.12 make ... chooses another"; exit 1; }
	@command -v cargo > /dev/null || { echo "cargo is missing: install Rust from rustup.rs"; exit 1; }
	@command -v cc > /dev/null || { echo "a C linker (cc) is missing: on Debian, apt install gcc"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
		{ echo "$(PYTHON) cannot create environments: on Debian, apt install python3-venv"; exit 1; }
	@touch $@

# maturin is installed first, so that Rust is compiled while pip fetches the other packages.
$(VENV)/.maturin: requirements.lock | $(VENV)/.created
	@sed -nE '/^(maturin|tomli)==/,/[^\\]$$/p' requirements.lock > $(VENV)/maturin.lock
	$(PIP) install --require-hashes -r $(VENV)/maturin.lock
	@touch $@

$(VENV)/.packages: requirements.lock $(VENV)/.maturin
	$(call say,"Python packages from requirements.lock (download of 350 MB)")
	$(PIP) install --require-hashes -r requirements.lock
	@touch $@

$(VENV)/.compiled: $(RUST) $(VENV)/.maturin
	$(call say,"compiling the Rust half: some minutes the first time")
	$(BIN)/maturin develop --release --locked --skip-install
	@touch $@

$(VENV)/.built: $(VENV)/.compiled $(VENV)/.packages
	$(BIN)/maturin develop --release --locked
	@touch $@

$(VENV)/.rl: requirements-rl.lock $(VENV)/.packages
	$(call say,"PyTorch and stable-baselines3 from requirements-rl.lock: 3 GB to fetch")
	$(PIP) install --require-hashes -r requirements-rl.lock
	@touch $@

$(VENV)/.docs: requirements-docs.lock $(VENV)/.packages
	$(call say,"packages of the documentation site from requirements-docs.lock")
	$(PIP) install --require-hashes -r requirements-docs.lock
	@touch $@
