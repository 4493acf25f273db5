# Everything that a fresh machine with Python 3.11, make and git needs to run, test and measure tandem.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
BENCH_READY := $(VENV)/.bench-ready
REQUIREMENTS := deploy/requirements
PIP := $(BIN)/python -m pip --disable-pip-version-check -q
# uv takes an eighth of pip's time; pip knows settings of this machine (an index, a certificate) that uv may not.
install = $(BIN)/uv pip install -q --python $(BIN)/python --require-hashes -r $(REQUIREMENTS)/$(1).txt \
	|| $(PIP) install --require-hashes -r $(REQUIREMENTS)/$(1).txt
# Tests that share the cores; those of one module stay together.
SHARED := --numprocesses auto --maxprocesses 4 --dist loadscope
# Tests with a robot of ROS behind a bridge: each takes the cores alone.
BEHIND := bridge_ros or bridge_cut or enabling
# What fails in real time is tried once more with the cores to itself, and both are printed: only 1 is "tests failed".
in_real_time = $(BIN)/python -m pytest -m processes $(1) $(2) || { [ $$? -eq 1 ] && \
	$(BIN)/python -m pytest -m processes $(1) --last-failed --last-failed-no-failures none; }
APART := --ignore tests/system --ignore tests/deploy
COMPILE := $(BIN)/uv pip compile -q --generate-hashes --python-version 3.11 --no-emit-index-url \
	--custom-compile-command "make lock"

ROS2DDS := build/ros2dds/release/zenoh-bridge-ros2dds

.PHONY: help setup demo test simulated realtime lint format bench ros2dds lock clean
.NOTPARALLEL:

help: ## show this list
	@grep -hE '^[a-z0-9]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z0-9]+):.*## /\1\t/' | expand -t 10

setup: $(READY) ## make .venv with everything pinned (the other targets do it by themselves)

$(READY): pyproject.toml $(REQUIREMENTS)/all.txt $(REQUIREMENTS)/uv.txt
	@python=""; bare=""; \
	for candidate in "$${PYTHON:-}" python3.11 python3 python /usr/bin/python3.11 \
			"$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/3.11*/bin/python "$$(uv python find 3.11 2>/dev/null)"; do \
		[ -n "$$candidate" ] || continue; \
		"$$candidate" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || continue; \
		if "$$candidate" -c 'import ensurepip' 2>/dev/null; then python="$$candidate"; break; fi; \
		bare="$$candidate"; \
	done; \
	if [ -z "$$python" ] && [ -n "$$bare" ]; then \
		echo "make setup: $$bare has no ensurepip; install it: apt-get install python3.11-venv" >&2; exit 2; \
	elif [ -z "$$python" ]; then \
		echo "make setup: no Python 3.11 found (the only one that pybullet, the simulation's physics, has wheels for);" \
			"get it: apt-get install python3.11 python3.11-venv, or: uv python install 3.11, or: pyenv install 3.11;" \
			"or name one: make setup PYTHON=/path/to/python3.11; all but the simulation runs with a newer one too:" \
			"pip install '.[controller,task,experiment,cli]'" >&2; exit 2; \
	fi; \
	if ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
		echo "setup: $(VENV) with $$($$python --version)"; "$$python" -m venv --clear $(VENV); \
	fi
	@echo "setup: installing the pinned requirements"
	@$(PIP) install --require-hashes -r $(REQUIREMENTS)/uv.txt
	@$(call install,all)
	@$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@

$(BENCH_READY): $(READY) $(REQUIREMENTS)/bench.txt
	@$(call install,bench)
	@touch $@

demo: $(READY) ## robot and person carry a panel, with real processes, in real time
	@$(BIN)/tandem run carry

test: $(READY) ## every test, or those that PYTEST_ARGS names
ifdef PYTEST_ARGS
	@$(BIN)/python -m pytest $(PYTEST_ARGS)
else
test: simulated realtime
endif

simulated: $(READY)
	@$(BIN)/python -m pytest -m "not processes" $(SHARED) --no-loadscope-reorder  # in the order of tests/conftest.py

realtime: $(READY)
	@$(call in_real_time,$(APART) -k "not ($(BEHIND))",$(SHARED))
	@$(call in_real_time,$(APART) -k "$(BEHIND)")
	@$(call in_real_time,tests/system tests/deploy)  # no other test beside it

lint: $(READY) ## style, layers and types
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/lint-imports --no-logo
	@$(BIN)/mypy

format: $(READY) ## rewrite the sources in the project's style
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

bench: $(BENCH_READY) ## the benchmarks, as one table
	@$(BIN)/python -m benchmarks

ros2dds: $(ROS2DDS) ## build Eclipse's zenoh-bridge-ros2dds, for robots under DDS and for the tests with it

$(ROS2DDS): deploy/ros2dds/Cargo.toml deploy/ros2dds/src/main.rs
	@missing=""; for tool in cargo cmake clang; do command -v $$tool >/dev/null || missing="$$missing $$tool"; done; \
	if [ -n "$$missing" ]; then \
		echo "make ros2dds: no$$missing; get what is missing:" \
			"apt-get install cmake clang libclang-dev, and cargo by rustup" >&2; exit 2; \
	fi
	@echo "ros2dds: building $@, which takes all cores for some minutes"
	@cargo build --quiet --release --manifest-path $(dir $<)Cargo.toml --target-dir build/ros2dds
	@touch $@

lock: $(READY) ## pin the requirements anew
	@echo uv | $(COMPILE) - -o $(REQUIREMENTS)/uv.txt
	@$(COMPILE) --extra all --extra test --extra lint --group build pyproject.toml -o $(REQUIREMENTS)/all.txt
	@for stage in core: cli:cli controller:controller task:task sim:sim ros_robot:ros_robot bridge_ros1:bridge bridge_ros2:bridge_ros2 tools:experiment,recorder viewer:viewer; do \
		$(COMPILE) $$(printf '%s' "$${stage#*:}" | sed -E 's/[a-z0-9_]+,?/--extra &/g; s/,/ /g') \
			-c $(REQUIREMENTS)/all.txt pyproject.toml -o $(REQUIREMENTS)/$${stage%%:*}.txt; \
	done
	@$(COMPILE) --extra bench -c $(REQUIREMENTS)/all.txt pyproject.toml -o $(REQUIREMENTS)/bench.txt

clean: ## remove .venv, caches and results
	@rm -rf $(VENV) .pytest_cache .ruff_cache .mypy_cache .import_linter_cache .hypothesis build dist *.egg-info runs/*
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
