# Every target does the set-up it needs, in .venv; nothing outside this folder is touched.
PYTHON ?= python3
BIN := .venv/bin
SITE := build/_build/html
JOBS ?= 2
BASE ?= HEAD
export OMP_NUM_THREADS ?= 1
ifneq ($(shell grep -m1 -ow avx2 /proc/cpuinfo 2>/dev/null),)
# the kernels of linear algebra that have recorded the rows
export OPENBLAS_CORETYPE ?= Haswell
endif
export PYTHONDONTWRITEBYTECODE :=  # or each worker compiles all tests again
ifdef ROBOT_PERCEPTION_DATA  # kernels run in book/: a relative folder would be another one there
export ROBOT_PERCEPTION_DATA := $(abspath $(ROBOT_PERCEPTION_DATA))
endif

.DEFAULT_GOAL := help
.PHONY: help setup book test test-all check test-portable mutants minutes lint lab serve reproduce bench clean

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 15

setup: .venv/.book ## install the book and its tests into .venv

.venv/.book: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[book,test]'
	@touch $@

.venv/.bench: .venv/.book
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[bench,lab]'
	@touch $@

.venv/.lab: .venv/.book
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[lab]'
	@touch $@

book: .venv/.book ## build the site into build/_build/html; warnings are errors
	STUDIES_WORKERS=$(JOBS) $(BIN)/jupyter-book build book --config _config.yml --path-output build -W --keep-going
	@echo "The book is at $(SITE)/index.html"

lint: .venv/.book ## ruff on code and notebooks, import contract
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

PYTEST = ROBOT_PERCEPTION_SITE=$(SITE) $(BIN)/python -m pytest -n $(JOBS) --dist loadfile
NOTEBOOKS = --nbval-lax --ignore-glob='tests/*.ipynb' book
TYPES = --jaxtyping-packages=robot_perception,tests.checked
UNTYPED = __pycache__ book chapters day explorables hostile site studies teaching tools
TYPED = $(filter-out $(UNTYPED:%=tests/%/),$(wildcard tests/*/)) \
	$(filter-out %_cli.py %_commands.py %_data.py %_trackers.py,$(wildcard tests/test_*.py))

test: lint book ## lint, laws, claims, one drawn trial a study, every notebook, pages that changed
	$(PYTEST) -m 'not slow' tests $(NOTEBOOKS)

test-all: lint book ## everything: types of every call, more trials, all pages, JupyterLab, other processors, planted errors
	ROBOT_PERCEPTION_PROOF=all ROBOT_PERCEPTION_LAB_PAGES=all $(PYTEST) tests $(NOTEBOOKS)
	ROBOT_PERCEPTION_PROOF=all $(PYTEST) -m 'not slow' $(TYPES) $(TYPED)
	$(MAKE) test-portable mutants

check: lint ## lint and what a change reaches: against HEAD, or BASE=main; tests, notebooks, pages
	$(BIN)/python -m tests.tools.reached --base $(BASE) --jobs $(JOBS)

test-portable: .venv/.book ## unit tests and notebooks by other BLAS kernels, with and without this machine's vector units
	$(BIN)/python -m tests.tools.portable -n $(JOBS) --dist loadfile

mutants: .venv/.book ## plant errors in a copy of the code and count what the tests notice
	$(BIN)/python -m tests.tools.mutants -n $(JOBS) $(ROOMS)

lab: .venv/.lab ## open the notebooks in JupyterLab
	$(BIN)/jupyter lab book $(if $(filter 0,$(shell id -u)),--allow-root)

serve: book ## serve the built site on http://localhost:8000
	$(BIN)/python -m http.server 8000 --bind 127.0.0.1 --directory $(SITE)

reproduce: .venv/.book ## recompute rows, stored results and claims in full, of all or of CHAPTERS='walls monobot'
	$(BIN)/robot-perception store --anew $(CHAPTERS:%=--chapter %) --workers $(JOBS)
	$(BIN)/robot-perception claims --run $(CHAPTERS:%=--chapter %) --write book/_data/claims.json --workers $(JOBS)

minutes: .venv/.book ## time setup, book, test and check on a new clone; writes tests/tools/minutes.json
	$(BIN)/python -m tests.tools.minutes --write

bench: .venv/.bench book ## ratios against other libraries; writes book/_data/performance.json
	$(BIN)/python -m tests.tools.benchmarks.run --write book/_data/performance.json
	$(BIN)/robot-perception store --anew --only arm_tracking.timed # rows that are made of that record
	$(BIN)/robot-perception claims --run --claim observing --write book/_data/claims.json

clean: ## remove what was built; keeps .venv
	rm -rf build book/_build
