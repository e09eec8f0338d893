# serve: build everything and run the service.   test: everything that CI runs.
# Needs Python 3.11+ and make. Node comes from PyPI; `make test` also needs Chromium and installs it where it can.

PYTHON ?= python3
VENV   := .venv
# Whoever names tests (make test PYTEST=tests/mapper) may name none of a kind; otherwise both kinds have to be there.
NONE_IS_FINE = $(if $(PYTEST),|| [ $$? -eq 5 ])
BIN    := $(VENV)/bin
NPM    := $(BIN)/python static/build_pages.py
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check
LOCK   := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
          --no-emit-index-url --no-emit-find-links --custom-compile-command 'make lock'

.PHONY: serve setup lock pages test check bench dev browser clean

serve: setup ## build and run; ARGS="--port 9000" goes to `gridbloom serve`
	$(BIN)/gridbloom serve $(ARGS)

setup: $(VENV)/.installed pages ## .venv with the gridbloom command in it

# Everything that is installed has its version and hashes in requirements/dev.txt, the build tools too.
$(VENV)/.installed: pyproject.toml requirements/dev.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Gridbloom needs Python 3.11 or newer: make PYTHON=python3.12 ...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) --require-hashes --requirement requirements/dev.txt
	$(PIP) --no-deps --no-build-isolation --editable .
	touch $@

lock: $(VENV)/.installed ## renew requirements/*.txt: the newest versions that pyproject.toml allows, for Python 3.11 and later
	$(PIP) uv
	$(LOCK) --upgrade --all-extras --group build pyproject.toml --output-file requirements/dev.txt
	$(LOCK) --upgrade --constraint requirements/dev.txt pyproject.toml --output-file requirements/runtime.txt
	$(LOCK) --upgrade --constraint requirements/dev.txt --group build --output-file requirements/build.txt

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
