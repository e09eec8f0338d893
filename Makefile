# serve: build everything and run the service.   test: everything that CI runs.
# Needs Python 3.11+ and make. Node comes from PyPI; without Chromium `make test` leaves out the browser tests.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
NPM    := $(BIN)/python static/build_pages.py
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check
LOCK   := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
          --no-emit-index-url --no-emit-find-links --custom-compile-command 'make lock'

# Each worker of the tests has a service, a Chromium and a PostgreSQL of its own. With one for each core the cores are
# idle for half of the time, because browsers and processes are waited for.
WORKERS ?= 3
RUN_TESTS = $(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal

# Bytecode is kept, whatever the environment says: compiling the tests with pytest's assertions takes each worker 5 s,
# and each service that a test starts would be compiled anew.
export PYTHONDONTWRITEBYTECODE =

# Where the home folder cannot be written, logs are kept in the checkout.
DATA_DIR = $(shell home="$${XDG_DATA_HOME:-$$HOME/.local/share}"; test -n "$$GRIDBLOOM_DATA_DIR" || \
             { mkdir -p "$$home" && test -w "$$home"; } 2>/dev/null || echo env GRIDBLOOM_DATA_DIR=.data)

.PHONY: serve setup lock audit sbom docs pages wire check check-python check-pages test-pages test-python kernels programs test test-long test-shell bench dev clean

serve: $(VENV)/.runtime ## build and run; ARGS="--port 9000" goes to `gridbloom serve`
	$(MAKE) --jobs 2 pages $(VENV)/.lab
	$(DATA_DIR) $(BIN)/gridbloom serve $(ARGS)

setup: $(VENV)/.installed pages ## .venv with the gridbloom command and all that the tests need

# Everything that is installed has its version and hashes in requirements/, the build tools too. Most of it is never
# imported: Python compiles the rest when it is, in less time than pip compiles all.
$(VENV)/.runtime: pyproject.toml requirements/runtime.txt requirements/build.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Gridbloom needs Python 3.11 or newer: make PYTHON=python3.12 ...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) --no-compile --require-hashes --requirement requirements/runtime.txt --requirement requirements/build.txt
	touch $@

# It makes the pages.
$(VENV)/.command: $(VENV)/.runtime
	$(PIP) --no-deps --no-build-isolation --editable .
	touch $@

$(VENV)/.installed: $(VENV)/.command requirements/dev.txt
	$(PIP) --no-compile --require-hashes --requirement requirements/dev.txt
	touch $@

lock: $(VENV)/.installed ## renew requirements/*.txt: the newest versions that pyproject.toml allows, for Python 3.11 and later
	$(PIP) uv
	$(LOCK) --upgrade --all-extras --group build pyproject.toml --output-file requirements/dev.txt
	$(LOCK) --upgrade --constraint requirements/dev.txt --extra postgres --extra pdf pyproject.toml --output-file requirements/runtime.txt
	$(LOCK) --upgrade --constraint requirements/dev.txt --group build --output-file requirements/build.txt
	$(LOCK) --upgrade --constraint requirements/dev.txt --group docs --output-file requirements/docs.txt

audit: $(VENV)/.installed ## locked dependencies against known advisories; ADVISORIES="FILE..." names records of OSV, else registries are asked
	test -n "$(ADVISORIES)" || $(PIP) pip-audit || echo "pip-audit cannot be installed"
	$(BIN)/python -m tests.audit $(ADVISORIES)

sbom: $(VENV)/.installed ## build/sbom.json: what the service is made of, as CycloneDX, from requirements/runtime.txt
	$(PIP) cyclonedx-bom
	mkdir -p build
	$(BIN)/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible --output-file build/sbom.json requirements/runtime.txt

$(VENV)/.docs: $(VENV)/.installed requirements/docs.txt
	$(PIP) --require-hashes --requirement requirements/docs.txt
	touch $@

docs: $(VENV)/.docs ## the documentation as a site in build/docs, which needs no other host
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet

pages: $(VENV)/.command ## static/dist, where its sources changed
	$(NPM)

wire: $(VENV)/.installed ## renew what is generated from the messages of the stream and the routes of the HTTP interface
	$(BIN)/python -m server.stream.generate
	$(BIN)/python -m server.http_types

check: check-python check-pages ## lint, types, import rule: Python and TypeScript

# The cache of lint-imports names modules that were moved since.
check-python: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python -m server.stream.generate --check
	$(BIN)/python -m server.http_types --check

check-pages: setup
	$(NPM) run check

test-pages: setup
	$(NPM) test

# Otherwise the first visitor waits for it.
$(VENV)/.lab: $(VENV)/.runtime $(wildcard mapper/*/kernels/*.py)
	$(BIN)/python -m mapper.tools.precompile --lab
	touch $@

kernels: setup ## compile every kernel once, so that no test waits for it
	$(BIN)/python -m mapper.tools.precompile

programs: setup ## find browsers, PostgreSQL and HAProxy, or install them where that is possible
	$(BIN)/python -m tests.browser.find_chromium
	$(BIN)/python -m tests.browser.engines.programs
	$(BIN)/python -m tests.server.library.postgresql
	$(BIN)/python -m tests.haproxy

test: setup ## what CI runs; PYTEST=tests/mapper names some of the tests
	$(MAKE) --jobs 2 kernels check-python programs
	$(MAKE) --jobs 2 test-python check-pages test-pages

test-python: setup # needs kernels and programs; waits for browsers and processes while Node checks the pages beside it
	$(RUN_TESTS) -m 'not long' $(PYTEST)

test-long: setup kernels programs ## what takes too long for `make test`, and all cases of what it samples: hours
	GRIDBLOOM_EXAMPLES=1000 GRIDBLOOM_FUZZ=10000 $(RUN_TESTS) --timeout 14400 -m 'long or sampled' $(PYTEST)
	$(MAKE) test-shell

test-shell: export GRIDBLOOM_CHROMIUM = chromium-headless-shell
test-shell: setup kernels ## the browser tests of `make test` in the headless shell, where that can be had
	if $(BIN)/python -m tests.browser.find_chromium; then \
	  $(RUN_TESTS) -m 'browser and not long' --ignore tests/browser/engines $(or $(PYTEST),tests/browser); \
	else test -z "$$CI"; fi

bench: setup ## figures beside the peers, as ratios
	$(BIN)/python -m tests.bench

dev: setup ## the service, and beside it the pages from their sources, which reload as they change
	$(BIN)/gridbloom serve $(ARGS) & trap "kill $$!" EXIT; $(NPM) run dev

clean:
	rm -rf $(VENV) build static/node_modules static/dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
