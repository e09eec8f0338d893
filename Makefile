# serve: build everything and run the service.   test: everything that CI runs.
# Needs Python 3.11+ and make. Node comes from PyPI; `make test` also needs Chromium and installs it where it can.

PYTHON ?= python3
VENV   := .venv
# Whoever names tests (make test PYTEST=tests/mapper) may name none of a kind; otherwise both kinds have to be there.
NONE_IS_FINE = $(if $(PYTEST),|| [ $$? -eq 5 ])
BIN    := $(VENV)/bin
NPM    := $(BIN)/python static/build_pages.py

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
	$(NPM)

check: setup ## lint, types, import rule: Python and TypeScript
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(NPM) run check

browser:
	$(BIN)/python tests/browser/find_chromium.py

test: check browser ## what CI runs
	$(NPM) test
	$(BIN)/python -m pytest --numprocesses 2 -m 'not browser' $(PYTEST) $(NONE_IS_FINE)
	$(BIN)/python -m pytest -m browser $(PYTEST) $(NONE_IS_FINE)

bench: setup ## figures beside the peers, as ratios
	$(BIN)/python -m tests.bench

dev: setup ## the service, and beside it the pages from their sources, which reload as they change
	$(BIN)/gridbloom serve $(ARGS) & trap "kill $$!" EXIT; $(NPM) run dev

clean:
	rm -rf $(VENV) static/node_modules static/dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
