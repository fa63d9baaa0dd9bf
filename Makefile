# One or two lines a target. `make help` lists them.
VENV ?= .venv
PYTHON ?= python3
BIN = $(VENV)/bin
PREFIX ?= /usr/local
VERSION = $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
# Everything that makes the extension module out of date.
SOURCES = pyproject.toml Cargo.toml Cargo.lock $(shell find crates -name '*.rs' -o -name Cargo.toml)

.PHONY: help setup demo test test-rust test-python lint format bench bench-library bench-generate bench-fit devices-report stack-report install-c gallery web web-core web-test web-bench docs clean

help: ## List the targets
	@grep -E '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /\t/' | expand -t 16

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/.installed: $(BIN)/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --editable '.[plot,radiance]' --group dev
	touch $@

setup: $(VENV)/.installed ## Make .venv with bsdftree and everything that it and its tests need

demo: setup ## Generate three devices, write XML and pictures to demo/, print a table
	$(BIN)/python examples/demo.py demo

test: lint test-rust test-python web-test ## Set up everything and run all tests

test-rust: ## Rust tests
	cargo test --workspace --quiet

test-python: setup ## Python tests
	$(BIN)/python -m pytest -q

lint: setup ## Formatting, clippy, ruff, mypy: warnings are errors
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --quiet
	$(BIN)/ruff check && $(BIN)/ruff format --check
	$(BIN)/mypy

format: setup ## Format all code
	cargo fmt --all
	$(BIN)/ruff format && $(BIN)/ruff check --fix

bench: setup ## Measure, with Radiance beside it
	cargo bench --workspace
	$(BIN)/python benches/beside_radiance.py

bench-library: setup ## Look-ups, samples, files: Rust, NumPy and Radiance beside their targets; 4 minutes
	$(BIN)/python -m benches.library

bench-generate: setup ## Errors of generated trees beside Radiance's, at equal cost; 40 minutes
	$(BIN)/python -m benches.generate

bench-fit: setup ## Fits of known BSDFs beside pabopto2bsdf, on directions left out; an hour, minutes with a cache
	$(BIN)/python -m benches.fit
	$(BIN)/python -m benches.fit.real

install-c: ## Install bsdftree.h and the C library under PREFIX (/usr/local)
	cargo build --release --quiet -p bsdftree-c
	install -d $(PREFIX)/include $(PREFIX)/lib/pkgconfig
	install -m 644 crates/bsdftree-c/include/bsdftree.h $(PREFIX)/include
	install -m 644 target/release/libbsdftree_c.a $(PREFIX)/lib/libbsdftree.a
	install -m 755 target/release/libbsdftree_c.so $(PREFIX)/lib/libbsdftree.so.0
	ln -sf libbsdftree.so.0 $(PREFIX)/lib/libbsdftree.so
	sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(VERSION)|' crates/bsdftree-c/bsdftree.pc.in > $(PREFIX)/lib/pkgconfig/bsdftree.pc

devices-report: setup ## Devices of every kind beside Radiance, patch by patch, into docs/devices.md; 5 minutes
	$(BIN)/python -m benches.devices

stack-report: setup ## Stacks beside tracing all layers, by resolution and gap, for docs/stack.md; 10 minutes
	$(BIN)/python -m benches.stack

gallery: setup ## Draw the pictures of docs/gallery.md
	$(BIN)/python docs/gallery.py

web-core: ## The core for browsers, web/src/core.wasm
	web/core.sh

web: web-core web/node_modules ## The viewer, in web/dist and in the Python package
	cd web && npm run --silent build

web-bench: web ## How fast the viewer opens a large file and follows a drag, on this machine
	cd web && node tests/speed.mjs

web-test: setup ## The viewer in a real browser; CHROMIUM names it, else /usr/bin/chromium; says what is missing
	web/test.sh

web/node_modules: web/package-lock.json
	cd web && npm ci --silent --no-fund --no-audit
	touch $@

docs: ## API documentation of the crates, in target/doc
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

clean: ## Remove what was built
	rm -rf target $(VENV) demo python/bsdftree/_viewer/page web/dist web/node_modules web/src/core.wasm
