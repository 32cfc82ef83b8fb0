# Everything from a bare checkout: `make demo`, `make test`. The set-up runs first and is quick when nothing has changed.

SHELL := /bin/bash
PYTHON ?=
BIN := .venv/bin
DEMO := specs/perception/vision/shape_room.wms specs/prediction/mechanistic/collide.wms

.PHONY: dist newton sbom constraints help setup browser inspect lmms-eval training demo quick lowest installed test test-all coverage generate check format docs conformance oracles agreement clean

help:
	@echo "make setup     system packages (as root) and .venv with every engine that can be had"
	@echo "make demo      two tasks in every engine, and a picture of what came out"
	@echo "make quick     the language, the stage, physics in one engine: a minute on two cores, for every change"
	@echo "make lowest    the same with the oldest versions that are allowed, in build/lowest"
	@echo "make check     style, types, architecture, dependencies, words"
	@echo "make test      that and all tests but the slow ones, on an installed wheel"
	@echo "make test-all  the same with the slow tests"
	@echo "make installed an environment that has wmspec from a wheel, in build/installed"
	@echo "make inspect   Inspect in an environment of its own, for the slow tests of exports"
	@echo "make lmms-eval  lmms-eval in an environment of its own, for the same"
	@echo "make training   TRL in an environment of its own (PyTorch: gigabytes), for the slow tests of training data"
	@echo "make newton    the tests of the engine Newton, on wheels, in build/newton"
	@echo "make coverage  the lines and branches that the tests of make test run, in out/coverage"
	@echo "make generate  everything that is made from the code: tables, grammars, schema"
	@echo "make format    rewrite the sources in the house style"
	@echo "make sbom      a bill of materials of .venv (CycloneDX), in out/sbom.json"
	@echo "make constraints  the versions that CI installs, in constraints.txt; pins that still fit stay"
	@echo "make dist      wheels and source archives of the distributions, in dist"
	@echo "make docs      the documentation as a site, in out/site"
	@echo "make conformance every engine on the cases of usdphysics-conformance, into docs/benchmarks/conformance.md"
	@echo "make oracles   every engine against analytic answers, into docs/benchmarks/oracles.md"
	@echo "make agreement 200 instances of every task in every engine, into docs/benchmarks/agreement.md"
	@echo "make clean     remove what was made, except .venv"

setup:
	@PYTHON='$(PYTHON)' tools/setup.sh

browser: setup
	@tools/setup.sh --browser

inspect: build/inspect/bin/inspect

build/inspect/bin/inspect: | setup
	$(BIN)/python -m venv build/inspect
	build/inspect/bin/pip install --quiet inspect-ai openai mistralai pyarrow

lmms-eval: build/lmms-eval/bin/python

build/lmms-eval/bin/python: | setup
	$(BIN)/uv venv --quiet --python $(BIN)/python build/lmms-eval
	$(BIN)/uv pip install --quiet --python build/lmms-eval/bin/python lmms-eval openai

training: build/training/bin/python

build/training/bin/python: | setup
	$(BIN)/uv venv --quiet --python $(BIN)/python build/training
	$(BIN)/uv pip install --quiet --python build/training/bin/python trl torchvision pillow

newton: setup
	rm -rf build/newton build/newton-wheels
	$(BIN)/python -m hatchling build -t wheel -d build/newton-wheels
	cd plugins/wmspec-newton && ../../$(BIN)/python -m hatchling build -t wheel -d ../../build/newton-wheels
	cd conformance && ../$(BIN)/python -m hatchling build -t wheel -d ../build/newton-wheels
	$(BIN)/python -m venv build/newton
	build/newton/bin/pip install --quiet pytest 'mujoco>=4,<5' 'pyopengl>=3.1.6,<4' $(CURDIR)/build/newton-wheels/*.whl
	cd plugins/wmspec-newton && PYTHONSAFEPATH=1 ../../build/newton/bin/python -m pytest -q -p no:cacheprovider tests

demo: setup
	$(BIN)/wmspec generate $(DEMO) -o out/demo --per-task 6 --backend all --seed 0
	$(BIN)/wmspec view out/demo -o out/demo/sheet.png
	@echo "The picture: $(CURDIR)/out/demo/sheet.png"

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/deptry .
	cd conformance && ../$(BIN)/deptry .
	$(BIN)/python -m tools.prose

ONE_ENGINE := -n auto --dist loadgroup --one-engine tests/language tests/stage tests/physics

quick: setup
	$(BIN)/pytest $(ONE_ENGINE) -m "not (slow or broad or pixels or browser or build)"

# Every extra that users may have, but the models on this machine: PyTorch is gigabytes, and no quick test needs it.
EXTRAS := audit,clips,engines,evaluate,lsp,meshes,photo,ray,report,video
LOWEST := $(BIN)/uv pip install --quiet --python build/lowest/bin/python

lowest: setup
	$(BIN)/uv venv --quiet --clear --python $(BIN)/python build/lowest
	$(LOWEST) --resolution lowest-direct -e '.[$(EXTRAS)]' -e ./conformance
	$(LOWEST) filelock hypothesis pytest pytest-timeout pytest-xdist usd-validation-nvidia
	build/lowest/bin/pytest $(ONE_ENGINE) -m "not (slow or pixels or browser or build)"

# The tests of the checkout, run on an installed wheel: what only a checkout can do fails here. Bytecode is kept: without
# it every process compiles 40,000 lines of tests.
TEST := PYTHONSAFEPATH=1 PYTHONDONTWRITEBYTECODE= build/installed/bin/python -m pytest --installed -n auto --dist loadgroup --durations=50

installed: setup
	$(BIN)/python -m tools.installed

test: check browser installed
	$(TEST)

test-all: check browser inspect newton installed
	$(TEST) -m "" --hypothesis-profile long

# Tracing more than doubles the time of Python code, so it is no part of `make test`.
coverage: browser
	@mkdir -p out
	$(BIN)/pytest -n auto --dist loadgroup --cov --cov-report=html --cov-report=term:skip-covered

generate: setup
	$(BIN)/python tools/reference.py
	$(BIN)/python tools/grammars.py
	$(BIN)/python tools/looks.py
	$(BIN)/python tools/replies.py
	$(BIN)/python tools/gallery.py
	@mkdir -p out
	$(BIN)/wmspec schema > out/generated && mv out/generated docs/schema.json

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

sbom: setup
	@mkdir -p out
	$(BIN)/cyclonedx-py environment $(BIN)/python --pyproject pyproject.toml --output-reproducible -o out/sbom.json
	@echo "The bill of materials: $(CURDIR)/out/sbom.json"

constraints: setup
	$(BIN)/uv pip compile pyproject.toml --extra $(EXTRAS) --extra dev --quiet --no-annotate \
		--custom-compile-command 'make constraints' -o constraints.txt

dist: setup
	rm -rf dist
	$(BIN)/python -m hatchling build -d dist/wmspec
	cd conformance && ../$(BIN)/python -m hatchling build -d ../dist/usdphysics-conformance
	cd plugins/wmspec-newton && ../../$(BIN)/python -m hatchling build -d ../../dist/wmspec-newton

docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "The site: $(CURDIR)/out/site/index.html"

# OTHERS: scores of engines that are not in .venv, and their versions: OTHERS='out/newton.json newton=1.8.0'.
conformance: setup
	@mkdir -p out
	-$(BIN)/wmspec conformance --json > out/conformance.json
	$(BIN)/python -m tools.conformance out/conformance.json $(OTHERS)

oracles: setup
	$(BIN)/python -m tools.oracles

agreement: setup
	-$(BIN)/wmspec crosscheck specs/perception specs/prediction --sample 200 --json out/crosscheck.json
	$(BIN)/python -m tools.agreement out/crosscheck.json

clean:
	rm -rf out build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
