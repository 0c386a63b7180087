# Each target sets up what it needs: see scripts/setup.sh. PYTHON=python3.13 or python3.11 chooses the interpreter.
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.ONESHELL:
.DEFAULT_GOAL := help
.PHONY: help setup render test lint bench stability package clean

SCENE ?= sample_blends/cornell_caustics.blend
OUT ?= out/$(basename $(notdir $(SCENE))).exr
ARGS ?=
JOBS ?= 2

export PYTHON
ENTER = python="$$(scripts/setup.sh)"; export PYTHONPATH="$(CURDIR)"; cd "$(CURDIR)"

help:
	@echo "make render   render SCENE (default $(SCENE)) to an EXR and a PNG sheet in out/"
	@echo "make test     run the tests (ARGS='-k name' for some of them)"
	@echo "make lint     ruff, the layer contract, types, file sizes"
	@echo "make bench    measure speed, as JSON"
	@echo "make stability  extreme scenes, each with its law (ARGS='lights camera': some families, --markdown: into the docs)"
	@echo "make package  build the extension's zip in dist/"

setup:
	@$(ENTER)
	echo "$$python"

render:
	@$(ENTER)
	mkdir -p "$(dir $(OUT))"
	"$$python" -m photon_engine render "$(SCENE)" -o "$(OUT)" $(ARGS)
	echo "EXR:   $(OUT)"
	echo "Sheet: $(basename $(OUT)).png"

test:
	@$(ENTER)
	"$$python" -m pytest -n $(JOBS) --dist worksteal $(ARGS)

lint:
	@$(ENTER)
	bin="$$(dirname "$$python")"
	"$$python" -m ruff check .
	"$$bin/lint-imports"
	"$$bin/basedpyright"
	"$$python" -m pytest -q tests/test_structure.py

bench:
	@$(ENTER)
	"$$python" -m benchmarks.run $(ARGS)

stability:
	@$(ENTER)
	"$$python" -m tests.stability $(ARGS)

package:
	@$(ENTER)
	"$$python" scripts/package.py $(ARGS)

clean:
	rm -rf out dist build .pytest_cache .ruff_cache .import_linter_cache
