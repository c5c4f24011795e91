# Needs make and python3, nothing else: it brings its own uv, and Python 3.12 through it.
SHELL := /bin/sh
VENV := .venv
PYTHON := $(VENV)/bin/python
STAMP := $(VENV)/.ready
UV_VERSION := 0.13.8

.PHONY: demo test check format lint imports types fast slow setup lock bench serve clean

setup: $(STAMP)

# uv from the path, else from a private folder; then exactly what requirements.lock says.
$(STAMP): requirements.lock pyproject.toml .python-version
	@set -e; \
	UV=$$(command -v uv || true); \
	if [ -z "$$UV" ]; then \
	  if [ ! -x .uv/bin/uv ]; then \
	    echo "fetching uv into .uv"; \
	    { python3 -m venv .uv && .uv/bin/python -m pip install --quiet uv==$(UV_VERSION); } \
	    || { rm -rf .uv; python3 -m pip install --quiet --target .uv uv==$(UV_VERSION); } \
	    || { echo "cannot install uv: python3 needs either its venv or its pip module" >&2; exit 1; }; \
	  fi; \
	  UV=.uv/bin/uv; \
	fi; \
	[ -x $(PYTHON) ] || "$$UV" venv --quiet --python 3.12 $(VENV); \
	"$$UV" pip sync --quiet --python $(PYTHON) requirements.lock; \
	"$$UV" pip install --quiet --python $(PYTHON) --no-deps --editable .; \
	touch $(STAMP)

demo: setup
	@$(VENV)/bin/wayproof demo

serve: setup
	@$(VENV)/bin/wayproof serve

test: setup
	@$(PYTHON) -m pytest

fast: setup
	@$(PYTHON) -m pytest -m "not slow"

slow: setup
	@$(PYTHON) -m pytest -m slow

check: format lint imports types

format: setup
	@$(VENV)/bin/ruff format --check .

lint: setup
	@$(VENV)/bin/ruff check .
	@$(VENV)/bin/deptry . --no-ansi

imports: setup
	@$(VENV)/bin/lint-imports

types: setup
	@$(VENV)/bin/basedpyright

bench: setup
	@$(PYTHON) benchmarks/pipeline.py

# Pins every dependency with its hashes, without the address of an index.
lock:
	@UV=$$(command -v uv || echo .uv/bin/uv); \
	"$$UV" pip compile pyproject.toml --group dev --universal --python-version 3.12 \
	  --generate-hashes --no-emit-index-url --no-header --quiet -o requirements.lock

clean:
	rm -rf $(VENV) .uv .pytest_cache .ruff_cache .hypothesis out
