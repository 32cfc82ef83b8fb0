# Everything from a bare checkout: `make demo`, `make test`. The set-up runs first and is quick when nothing has changed.

SHELL := /bin/bash
PYTHON ?=
BIN := .venv/bin
DEMO := specs/perception/motion/speed.wms specs/prediction/mechanistic/collide.wms

.PHONY: help setup demo test test-all check format clean

help:
	@echo "make setup     system packages (as root) and .venv with every engine that can be had"
	@echo "make demo      two tasks in every engine, and a picture of what came out"
	@echo "make test      style, types, architecture, dependencies, quick tests"
	@echo "make test-all  the same with the slow tests"
	@echo "make format    rewrite the sources in the house style"
	@echo "make clean     remove what was made, except .venv"

setup:
	@PYTHON='$(PYTHON)' tools/setup.sh

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

test: check
	$(BIN)/pytest -n auto

test-all: check
	$(BIN)/pytest -n auto -m ""

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf out build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
