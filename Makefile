# `make test` and `make demo` need only Python 3.11 or newer: they set up .venv by themselves, and again only when
# pyproject.toml has changed. Nothing is installed elsewhere.

VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# The first Python that runs and is new enough; a name on PATH may be a shim with nothing behind it, so each is tried.
CANDIDATES := python3.11 python3.12 python3.13 python3.14 python3 python
NEW_ENOUGH := import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))

.PHONY: demo test lint typings docs clean
.DELETE_ON_ERROR:

demo: $(STAMP)
	$(BIN)/estexp demo --out out/demo --force

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist worksteal

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports

# Stubs of mujoco's compiled modules, which bring none; again after every change of mujoco's version.
typings: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --target build/stubgen 'pybind11-stubgen>=3,<4'
	PYTHONPATH=build/stubgen $(BIN)/python typings/generate.py

# The pages land in build/docs; Sphinx is installed only for them.
docs: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	$(BIN)/python -m sphinx -W -b html docs build/docs

clean:
	rm -rf $(VENV) build dist .pytest_cache .ruff_cache .import_linter_cache

$(STAMP): pyproject.toml
	@if ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
	    found="$(PYTHON)"; \
	    for candidate in $(CANDIDATES); do \
	        if [ -z "$$found" ] && $$candidate -c '$(NEW_ENOUGH)' >/dev/null 2>&1; then found=$$candidate; fi; \
	    done; \
	    if [ -z "$$found" ]; then \
	        echo "make: no Python 3.11 or newer with venv and pip found; tried: $(CANDIDATES)." >&2; \
	        echo "      Install one (on Debian and Ubuntu also python3-venv), or name it: make PYTHON=/path/to/python3" >&2; \
	        exit 1; \
	    fi; \
	    echo "Setting up $(VENV) with $$found ($$($$found --version))"; \
	    "$$found" -m venv --clear "$(VENV)" || exit 1; \
	fi
	@echo "Installing estexp_jax and what it needs into $(VENV); this takes a minute or two"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,video]'
	@touch $@
