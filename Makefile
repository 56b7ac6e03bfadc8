# make demo   the main job: install, build the FMUs of a closed loop, run it, write a report
# make test   the tests
# Both need only Python 3.11+, make and git: the compiler is a Python package.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# not compiled to bytecode: Python does that to what is used, when it is used
PIP = $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
SOURCES_CXX = $(shell git ls-files '*.hpp' '*.cpp' 'orchestration/engine/*.c' 'orchestration/engine/*.h')

.DEFAULT_GOAL := help
.PHONY: help demo test lint format fmus check bench attack conformance mutants sanitize fuzz lock dist release installed clean

help:
	@sed -n 's/^# \{0,1\}//p' Makefile | head -3
	@echo "make lint (needs a C++ compiler) | format | fmus (all platforms; COMPONENTS="RigidBody ..." for some) | dist | installed | release | check | sanitize, fuzz (need a C++ compiler) | bench | attack | conformance | mutants | lock | clean"

$(VENV)/installed: requirements/run.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed, this is " + sys.version.split()[0] + "; try: make PYTHON=python3.12" if sys.version_info < (3, 11) else 0)'
	@echo "installing into $(VENV) ..."
	@began=$$(date +%s) && $(PYTHON) -m venv $(VENV) && $(PIP) --require-hashes -r requirements/run.lock \
	    && $(PIP) --no-deps --editable . && echo "installed in $$(($$(date +%s) - began)) s"
	@touch $@

$(VENV)/installed-dev: $(VENV)/installed requirements/dev.lock
	$(PIP) --require-hashes -r requirements/dev.lock
	@touch $@

demo: $(VENV)/installed
	@began=$$(date +%s) && $(BIN)/adcs run observer-pd && echo "built what it needs and ran in $$(($$(date +%s) - began)) s"
	@$(BIN)/adcs open

test: $(VENV)/installed-dev
	$(BIN)/adcs build
	$(BIN)/python -m pytest -n auto --dist loadfile

fmus: $(VENV)/installed
	$(BIN)/adcs build --all-platforms $(COMPONENTS)

# A wheel for all platforms, which needs no compiler where it is installed.
dist: $(VENV)/installed
	rm -rf build/carried dist
	$(BIN)/python -m adcs.wheel build/carried
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .
	@ls -l dist

# What a person could publish, in dist/: the wheel, the sdist, all FMUs, a bill of materials (CycloneDX), checksums.
release: $(VENV)/installed-dev dist
	$(BIN)/python -m build --sdist --outdir dist . >/dev/null
	$(BIN)/cyclonedx-py requirements requirements/run.lock --pyproject pyproject.toml --mc-type library --output-reproducible -o dist/bill-of-materials.cdx.json
	$(BIN)/python -m adcs.bill dist/bill-of-materials.cdx.json
	$(BIN)/python -m adcs.release dist

# That wheel in an environment of its own, without a compiler and out of reach of this folder; prints sizes and times.
installed: $(VENV)/installed-dev dist
	ADCS_WHEEL=$$(ls dist/*.whl) $(BIN)/python -m pytest -q -s tests/installed

check: $(VENV)/installed
	$(BIN)/adcs check $(COMPONENTS)

ROOMS = adcs fmus orchestration hil_bridge references
lint: $(VENV)/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 $(ROOMS)
	$(BIN)/mypy --platform darwin $(ROOMS)
	$(BIN)/lint-imports
	$(BIN)/clang-format --dry-run --Werror $(SOURCES_CXX)
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset release
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --build --preset release

format: $(VENV)/installed-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(BIN)/clang-format -i $(SOURCES_CXX)

# Needs a system C++ compiler with the sanitizers' libraries, GCC or Clang; of all components it takes half an hour.
sanitize: $(VENV)/installed-dev
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset sanitize -DADCS_COMPONENTS="$(COMPONENTS)"
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --build --preset sanitize
	$(BIN)/ctest --preset sanitize
	$(BIN)/adcs build $(COMPONENTS)
	$(BIN)/python tests/sanitized.py

# Random calls and damaged saved states against sanitized components: make fuzz TRIES=100000 COMPONENTS="RigidBody Quest".
TRIES ?= 100000
fuzz: $(VENV)/installed-dev
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset sanitize -DADCS_COMPONENTS="$(COMPONENTS)" -DADCS_FUZZ_LONG=$(TRIES)
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --build --preset sanitize --target fuzz

bench: $(VENV)/installed-dev
	$(BIN)/adcs build
	$(BIN)/python -m benchmarks
	$(BIN)/python -m benchmarks.elementary
	$(BIN)/python -m benchmarks.ring
	$(BIN)/python -m benchmarks.backstepping
	$(BIN)/python -m benchmarks.coupled
	$(BIN)/python -m benchmarks.lockstep
	$(BIN)/python -m benchmarks.mavlink
	$(BIN)/python -m benchmarks.isolation
	$(BIN)/python -m benchmarks.opening
	$(BIN)/python -m benchmarks.commands
	$(BIN)/python -m benchmarks.building

# What is attacked and what survives, the tables of docs/robustness.md and docs/mavlink.md: components and disks (small ones are
# made by root only), readers, both servers, calls and saved states (where there is a C++ compiler). Half an hour.
attack: $(VENV)/installed-dev
	$(BIN)/adcs build
	$(BIN)/python -m tests.robustness
	$(BIN)/python -m tests.attack 200
	ADCS_FUZZ=100000 $(BIN)/python -m pytest -q -s tests/bridge/test_security.py tests/bridge/test_attacks.py tests/hil/test_attacks.py
	if command -v "$${CXX:-c++}" >/dev/null; then $(MAKE) fuzz TRIES=5000 COMPONENTS="RigidBody StarTracker"; fi

# The standard's own Reference-FMUs from a folder of their source: make conformance SOURCES=DIR; writes docs/conformance.md.
conformance: $(VENV)/installed-dev
	$(BIN)/python -m tests.conformance $(SOURCES)

# Headers changed in one place at a time: would the law's test see it? Of all components 20 minutes; writes docs/mutants.md.
mutants: $(VENV)/installed-dev
	$(BIN)/python -m tests.mutants $(COMPONENTS)

# Names, versions and hashes of everything that is installed, for all platforms and Python versions.
lock:
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile pyproject.toml --extra build --extra mavlink --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-index-url --quiet -o requirements/run.lock
	$(BIN)/uv pip compile pyproject.toml --extra build --extra mavlink --extra test --extra dev --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-index-url --quiet -o requirements/dev.lock

clean:
	rm -rf build dist fmus/dist results
