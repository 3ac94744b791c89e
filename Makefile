# `make fit` runs the main job on the embedded example, `make test` the tests, `make docs` makes the manual; each sets
# up what it needs in .venv; the first two write docs/schemas, by which editors check the examples.
# `make slow` runs the tests that `make test` leaves out: whole diagnoses and studies, as long again as the others.
# `make core` tries every main command without any optional package, `make oldest` the tests with the oldest versions
# that pyproject.toml allows: on Python 3.11, for which each of them has wheels.
# `make machines` diagnoses the same data on other kernels, threads and processes, and compares (MACHINES=--short: some).
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
PLUGINS := $(patsubst %/pyproject.toml,%,$(wildcard plugins/*/pyproject.toml validation/pyproject.toml))

# what `make oldest` runs: all that is about numbers, files and messages; not what takes long for other reasons
# (processes, clusters, diagnoses, browsers)
OLDEST_TESTS := tests/unit tests/analytic tests/contract tests/reference tests/properties tests/schemas \
	tests/simulation/test_file.py tests/simulation/test_figures.py tests/simulation/test_run.py tests/rig/test_two_plate.py \
	$(addprefix tests/cli/test_,$(addsuffix .py,bad_input compare fit layers simulate stack_fit startup tube)) \
	$(addprefix tests/fits/test_,$(addsuffix .py,recovery region result search stack_problem uncertainty))

# tests start many processes, each of which would compile the package anew where the environment has this set
export PYTHONDONTWRITEBYTECODE =

.PHONY: fit test slow core oldest machines lint bench docs clean
fit: .venv/core
	$(BIN)/multilayer schema --out docs/schemas
	$(BIN)/multilayer fit examples/foam_b --out results/foam_b

test: .venv/dev
	$(BIN)/multilayer schema --out docs/schemas
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal -m "not slow" --durations=40 --durations-min=5

slow: .venv/dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal -m slow --durations=0

core: .venv/alone
	.venv-core/bin/python -I tests/core_smoke.py

oldest: .venv/oldest
	OMP_NUM_THREADS=1 .venv-oldest/bin/python -m pytest -n auto --dist worksteal -m "not slow" --durations=20 --durations-min=5 $(OLDEST_TESTS)

machines: .venv/dev
	$(BIN)/python -m validation.machines $(MACHINES)

lint: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: .venv/dev
	OMP_NUM_THREADS=1 $(BIN)/python -m validation.methods

docs: .venv/docs
	OMP_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -n -q -b html docs docs/_build/html
	@echo "written to docs/_build/html: index.html"

.venv/python:
	$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "multilayer needs Python 3.11 or later: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv .venv
	touch $@

.venv/core: .venv/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

.venv/dev: .venv/core $(PLUGINS:=/pyproject.toml)
	$(BIN)/python -m pip install --quiet --editable '.[dev]' $(addprefix --editable ./,$(PLUGINS))
	$(BIN)/multilayer schema --out docs/schemas
	touch $@

.venv/docs: .venv/core plugins/multilayer-campaigns/pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[docs]' --editable ./plugins/multilayer-campaigns
	touch $@

# installed as a user does, not editable: what is missing in the package shows; build/ would keep files that are gone
.venv/alone: .venv/python pyproject.toml $(shell find multilayer -type f -not -name '*.pyc')
	rm -rf .venv-core build
	$(PYTHON) -m venv .venv-core
	.venv-core/bin/python -m pip install --quiet .
	rm -rf build
	touch $@

.venv/oldest: pyproject.toml .venv/python
	rm -rf .venv-oldest
	$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info[:2] == (3, 11) else "make oldest needs Python 3.11")'
	$(PYTHON) -m venv .venv-oldest
	$(PYTHON) tests/lower_bounds.py > .venv-oldest/constraints.txt
	.venv-oldest/bin/python -m pip install --quiet --constraint .venv-oldest/constraints.txt --editable '.[dev]'
	touch $@

clean:
	rm -rf .venv .venv-core .venv-oldest results docs/_build docs/gallery docs/schemas .pytest_cache .mypy_cache .ruff_cache .hypothesis
