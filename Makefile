# Needs make and python3, nothing else: it brings its own uv, and Python 3.12 through it.
SHELL := /bin/sh
VENV := .venv
PYTHON := $(VENV)/bin/python
STAMP := $(VENV)/.ready
UV_VERSION := 0.13.8

.PHONY: demo test check format lint imports types fast slow drake-only sanitize setup lock bench \
        bench-cars bench-kernel bench-mbm bench-regions bench-retime bench-seeds pictures serve clean

setup: $(STAMP)

# uv from the path, else from a private folder; then exactly what requirements.lock says.
$(STAMP): requirements.lock pyproject.toml .python-version CMakeLists.txt $(wildcard planning/kernel/src/*)
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

# What has to hold on a machine without a compiler as well.
drake-only: setup
	@$(PYTHON) -m pytest --no-kernel -m "not slow" tests/contracts tests/search tests/goals \
	  tests/certify tests/pipeline tests/world

# The kernel's own tests with addresses and undefined behaviour checked; needs gcc or clang.
sanitize: setup
	@SANITIZED=$$(mktemp -d) && trap 'rm -rf "$$SANITIZED"' EXIT && \
	$(VENV)/bin/cmake -S . -B "$$SANITIZED" -G Ninja -DWAYPROOF_SANITIZE=ON -DSKBUILD_DATA_DIR=data \
	  -DCMAKE_MAKE_PROGRAM=$(CURDIR)/$(VENV)/bin/ninja -DPython_EXECUTABLE=$(CURDIR)/$(PYTHON) \
	  -Dnanobind_DIR="$$($(PYTHON) -m nanobind --cmake_dir)" > "$$SANITIZED/log" && \
	$(VENV)/bin/cmake --build "$$SANITIZED" >> "$$SANITIZED/log" || { cat "$$SANITIZED/log"; exit 1; } && \
	LD_PRELOAD="$$(g++ -print-file-name=libasan.so) $$(g++ -print-file-name=libubsan.so)" \
	ASAN_OPTIONS=detect_leaks=0 WAYPROOF_NATIVE="$$SANITIZED" \
	$(PYTHON) -m pytest -p no:cacheprovider -m "not slow" tests/kernel \
	  tests/certify/test_native_clearance.py tests/refine/test_nearness.py tests/refine/test_soft_rows.py

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

bench-kernel: setup
	@$(PYTHON) benchmarks/kernel.py

bench-mbm: setup
	@$(PYTHON) benchmarks/mbm.py

bench-cars: setup
	@$(PYTHON) benchmarks/cars.py

bench-retime: setup
	@$(PYTHON) -W ignore benchmarks/retime.py

bench-regions: setup
	@$(PYTHON) benchmarks/regions.py

bench-seeds: setup
	@$(PYTHON) benchmarks/seeds.py

pictures: setup
	@$(PYTHON) benchmarks/seed_pictures.py

# Pins every dependency with its hashes, without the address of an index.
lock:
	@UV=$$(command -v uv || echo .uv/bin/uv); \
	"$$UV" pip compile pyproject.toml --group dev --universal --python-version 3.12 \
	  --generate-hashes --no-emit-index-url --no-header --quiet -o requirements.lock

clean:
	rm -rf $(VENV) .uv .pytest_cache .ruff_cache .hypothesis out
