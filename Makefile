# make help lists the targets. Choose another Python with: make PYTHON=python3.12 setup
.DEFAULT_GOAL := help
# A graph is seven interpreters: without bytecode on disk each compiles every module anew.
unexport PYTHONDONTWRITEBYTECODE
.PHONY: help setup demo runs test lint bench fuzz hydrodynamics lock clean distclean

VENV := .venv/bin
# Tests hand in wrong types on purpose, and strings where a choice is meant.
TEST_TYPES := --allow-untyped-defs --allow-incomplete-defs --allow-untyped-calls --allow-any-generics \
	--no-warn-return-any --no-warn-unused-ignores --disable-error-code arg-type --disable-error-code misc
HYDRODYNAMICS := .venv-hydrodynamics
VESSELS := cybership3 drillship
LOCK_HYDRODYNAMICS := --quiet --upgrade --no-config --universal --python-version 3.11 --fork-strategy fewest \
	--generate-hashes --group hydrodynamics --custom-compile-command "make lock" --output-file locks/hydrodynamics.txt
LOCK_FUZZ := --quiet --upgrade --no-config --universal --python-version 3.11 --fork-strategy fewest \
	--generate-hashes --group fuzz --custom-compile-command "make lock" --output-file locks/fuzz.txt
FUZZED := vessel scenario parameters propeller open_water wave_response bag chunk
SECONDS := 60
SETUP := PYTHON="$(PYTHON)" sh scripts/setup.sh

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: ## install what is needed into .venv and build the packages into install/; skipped if nothing changed
	@$(SETUP) setup

demo: setup ## set up, sail Run A, leave runs/run_a/bag and runs/run_a/report.html
	$(VENV)/dp up --scenario run_a --lockstep --record --report --overwrite

# Runs in process over SEEDS seeds each; with GRAPH=1 once each on the lockstep graph, compared with in process.
SEEDS := 4
RUNS := $(if $(GRAPH),--compare,--inprocess --repeat $(SEEDS))

runs: setup ## set up, sail every run of the thesis (GRAPH=1: on the graph), leave runs/index.html
	$(VENV)/dp scenario run all $(RUNS) --overwrite

test: setup ## set up and run all tests
	$(VENV)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -rsR tests

lint: setup ## ruff and mypy
	$(VENV)/ruff check .
	$(VENV)/ruff format --check .
	$(VENV)/mypy
	$(VENV)/mypy --cache-dir .mypy_cache/tests $(TEST_TYPES) tests

bench: ## measure against the aims and peers; writes benchmarks/results.json
	@$(SETUP) setup --bench
	$(VENV)/python -m benchmarks

fuzz: setup ## fuzz what reads files, guided by coverage (atheris), SECONDS=60 a kind
	$(VENV)/uv pip install --quiet --require-hashes --python $(VENV)/python --target .cache/fuzz -r locks/fuzz.txt
	set -e; for kind in $(FUZZED); do PYTHONPATH=.cache/fuzz:tests $(VENV)/python tests/fuzz/fuzz_files.py $$kind $(SECONDS); done

hydrodynamics: setup ## compute motion and drift in waves of VESSELS anew, with capytaine; some minutes each
	$(VENV)/uv venv --quiet --allow-existing --python $(VENV)/python $(HYDRODYNAMICS)
	$(VENV)/uv pip install --quiet --require-hashes --python $(HYDRODYNAMICS) --requirement locks/hydrodynamics.txt
	set -e; for vessel in $(VESSELS); do $(HYDRODYNAMICS)/bin/python scripts/hydrodynamics $$vessel; done

lock: ## resolve the dependencies in pyproject.toml anew and write locks/
	@$(SETUP) lock
	$(VENV)/uv pip compile $(LOCK_HYDRODYNAMICS)
	$(VENV)/uv pip compile $(LOCK_FUZZ)

clean: ## remove what the build and the tools made
	@$(SETUP) clean

distclean: ## also remove .venv and the download cache
	@$(SETUP) distclean
	@rm -rf $(HYDRODYNAMICS)
