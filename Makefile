# Targets are what CI runs. Everything is installed in .venv; nothing outside this folder is touched.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
READY = $(VENV)/.ready

.PHONY: learn blender test test-slow lint format baselines clean

learn: $(READY)  ## learn to fold the default towel
	$(BIN)/tatamu learn towel --trials 50 --seed 0 --out runs/towel

blender: $(READY)  ## Blender, for `--simulator blender`, in a virtual environment of its own among the user's caches
	$(BIN)/tatamu install blender

test: $(READY)  ## the tests that take minutes
	$(BIN)/python -m pytest -q

test-slow: $(READY)  ## the tests that take longer
	$(BIN)/python -m pytest -q -m slow

lint: $(READY)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

learning: $(READY)  ## the figures of docs/learning.md: five seeds, against random search and baselines
	$(BIN)/python benchmarks/learning.py --out runs/learning

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $(READY)

clean:
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache build
