# CI runs `lint` and `test`. All is installed in .venv and .venv-newton, but Blender: that goes among the user's caches.
PYTHON ?= python3
PYTHON312 ?= python3.12
VENV ?= .venv
BIN = $(VENV)/bin
CONSTRAINTS ?= --constraint constraints.txt
PIP = $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check $(CONSTRAINTS)
READY = $(VENV)/.ready
DEV = $(VENV)/.ready-dev
NEWTON = .venv-newton/.ready
LEROBOT = .venv-lerobot/.ready

.PHONY: help learn blender test test-slow same-bytes oldest lint wheel docs learning gains measured-folds \
        times folds garments calibration validate real-cloth presets photographs foreign own-garments tangle \
        bench gallery datasets abuse fuzz lerobot simulators crosscheck paper format clean

help:  ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1: /'

learn: $(READY)  ## learn to fold the default towel
	$(BIN)/tatamu learn towel --trials 50 --seed 0 --out runs/towel

blender: $(READY)  ## Blender, for `--simulator blender`, in a virtual environment of its own among the user's caches
	$(BIN)/tatamu install blender

test: $(DEV)  ## the tests that take minutes, files side by side; the slowest are named
	$(BIN)/python -m pytest -q -n auto --dist loadfile --durations 15

test-slow: $(DEV)  ## the tests that take longer
	$(BIN)/python -m pytest -q -m slow

same-bytes: $(DEV)  ## kernels compiled for other x86 processors make the same bytes; minutes
	$(BIN)/python -m pytest -q -m slow tests/test_native_cache.py -k other_processors

oldest: $(DEV)  ## the tests with the oldest packages that pyproject.toml allows, in .venv-oldest
	rm -rf .venv-oldest && $(PYTHON) -m venv .venv-oldest
	$(BIN)/python -m tests.oldest > .venv-oldest/constraints.txt
	.venv-oldest/bin/python -m pip install --quiet --constraint .venv-oldest/constraints.txt --editable '.[test]'
	.venv-oldest/bin/python -m pytest -q -n auto --dist loadfile

lint: $(DEV)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

wheel: $(DEV)  ## the wheel and the sdist in dist/, tried in an empty virtual environment
	rm -rf dist .venv-wheel
	$(BIN)/python -m build --quiet
	$(PYTHON) -m venv .venv-wheel
	.venv-wheel/bin/python -m pip install --quiet --constraint constraints.txt dist/*.whl
	du -sm --exclude='pip*' --exclude='setuptools*' .venv-wheel/lib | cut -f1  # MB without extras
	cd / && $(CURDIR)/.venv-wheel/bin/tatamu simulate $(CURDIR)/examples/sheet.json --out $(CURDIR)/.venv-wheel/sheet.npz
	! .venv-wheel/bin/tatamu learn towel --out .venv-wheel/fold 2> .venv-wheel/said.txt
	grep -q "pip install 'tatamu.learn.'" .venv-wheel/said.txt
	.venv-wheel/bin/python -m pip install --quiet --constraint constraints.txt "$$(echo dist/*.whl)[learn]"
	cd / && $(CURDIR)/.venv-wheel/bin/tatamu learn towel --size 0.16x0.30 --spacing 0.02 --trials 2 --disturbances none --no-baselines --out $(CURDIR)/.venv-wheel/fold
	grep -q "<html" .venv-wheel/fold/report.html
	du -sm --exclude='pip*' --exclude='setuptools*' .venv-wheel/lib | cut -f1  # MB with what learning needs

docs: $(DEV)  ## the documentation site, strictly: docs/_build/html/index.html
	$(BIN)/python -m sphinx --fail-on-warning --keep-going -q -b html docs docs/_build/html

format: $(DEV)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

learning: $(READY)  ## the figures of docs/notes/learning.md: five seeds, against random search and baselines
	$(BIN)/python -m benchmarks.learning --out runs/learning --write-docs

gains: $(DEV)  ## learned folds against a hand-designed curve: the table of README.md; an hour
	$(BIN)/python -m benchmarks.gains --out runs/gains --write-docs

measured-folds: $(DEV)  ## hidden set-ups measured and corrected: the table of docs/notes/observation.md; an hour
	$(BIN)/python -m benchmarks.measured_folds --write-docs

times: $(READY)  ## how long whole commands take: the table of docs/notes/learning.md; minutes, `--cases shop` longer
	$(BIN)/python -m benchmarks.times --out runs/times --write-docs

folds: $(READY)  ## the figures of docs/notes/folds.md: T-shirt, trousers and towel in all their folds; hours
	$(BIN)/python -m benchmarks.folds --out runs/folds --write-docs

garments: $(DEV)  ## the pictures of docs/guide/garments.md
	for name in tshirt trousers; do $(BIN)/tatamu show $$name --fold half --out docs/images/$$name.png; done
	mkdir -p runs/garments
	$(BIN)/python examples/05_your_own_garment.py runs/garments
	$(BIN)/python -m tests.photos runs/garments/photo.png
	$(BIN)/tatamu outline runs/garments/photo.png --width 0.54 --out runs/garments/shirt.svg
	cp runs/garments/skirt.png runs/garments/shirt-on-photo.jpg docs/images

calibration: $(DEV)  ## the proofs of docs/notes/calibration.md: hidden materials, other simulators as the real cloth; hours; needs `make blender`
	$(BIN)/python -m benchmarks.calibration drawings
	$(BIN)/python -m benchmarks.calibration pinch --write-docs
	$(BIN)/python -m benchmarks.calibration recovery --write-docs
	$(BIN)/python -m benchmarks.readings --out runs/readings --write-docs
	$(BIN)/python -m benchmarks.cloths --write-docs

validate: $(DEV)  ## every textbook check: docs/notes/validation.md, and a page in runs/validation; minutes
	$(BIN)/python -m tests.physics --out runs/validation --write-docs

real-cloth: $(DEV)  ## the tables of docs/notes/real-cloth.md: published measurements of real cloth in the folder DATA; an hour
	$(BIN)/python -m studies.real_cloth --data $(DATA) --out runs/real-cloth --write-docs

presets: $(DEV)  ## the robots that tatamu knows against the models of their makers, from PyPI, 1 GB
	rm -rf .models && mkdir .models
	$(BIN)/python -m pip install --quiet --no-deps --target .models example-robot-data==6.0.0 robosuite==1.5.2 gym-aloha==0.1.5
	$(BIN)/python -m pip download --quiet --no-deps --no-binary :all: --dest .models openarm-mujoco==2.3.0
	tar -xzf .models/openarm_mujoco-2.3.0.tar.gz -C .models
	TATAMU_MODELS=.models $(BIN)/python -m pytest -q tests/robots/test_presets.py

photographs: $(DEV)  ## the tables of docs/notes/photographs.md and the guide's pictures: where cloth lies, how folds ended; a quarter of an hour
	$(BIN)/python -m benchmarks.photographs --write-docs

foreign: $(DEV)  ## the table of docs/notes/garments.md: outlines and meshes from elsewhere; minutes
	$(BIN)/python -m benchmarks.foreign --out runs/foreign --trials 25 --write-docs

own-garments: $(DEV)  ## the table of docs/notes/own-garments.md: garments drawn by hand, by the plans that are proposed; hours
	$(BIN)/python -m benchmarks.own_garments --out runs/own-garments --write-docs

tangle: $(READY)  ## 1,200 folds of limp cloth: in how many anything passes through; a quarter of an hour
	$(BIN)/python -m benchmarks.tangle --write-docs

gallery: $(DEV)  ## docs/gallery.md, the moving picture and the captures of the guide; minutes; films need OpenGL
	MUJOCO_GL=$(or $(MUJOCO_GL),egl) $(BIN)/python -m benchmarks.gallery --out runs/gallery

bench: $(DEV) $(NEWTON)  ## native, Blender, MuJoCo and Newton side by side: docs/notes/benchmarks.md; hours
	$(BIN)/tatamu install blender
	$(BIN)/python -m benchmarks.speed --out runs/speed --write-docs

datasets: $(DEV)  ## what an episode of a dataset costs, and a policy cloned from 200: docs/notes/datasets.md; minutes
	$(BIN)/python -m benchmarks.datasets --out runs/datasets --write-docs

abuse: $(READY)  ## ten thousand random scenes: each a rollout or a clear error
	$(BIN)/python -m benchmarks.abuse --out runs/abuse.json --write-docs

fuzz: $(DEV)  ## broken files of every kind for ten minutes, or MINUTES=..: each one clean line; a short form is among the tests
	$(BIN)/python -m benchmarks.fuzz --minutes $(or $(MINUTES),10)

$(NEWTON):
	$(PYTHON) -m venv $(dir $(NEWTON))
	$(dir $(NEWTON))bin/python -m pip install --quiet 'newton==1.8.*'
	touch $(NEWTON)

lerobot: $(LEROBOT)  ## LeRobot, tatamu's environment for it and Stable-Baselines3, in .venv-lerobot, for slow tests; gigabytes, needs Python 3.12

$(LEROBOT): packages/lerobot_env_tatamu/pyproject.toml
	$(PYTHON312) -m venv $(dir $(LEROBOT))
	$(dir $(LEROBOT))bin/python -m pip install --quiet --editable '.[gym]' 'lerobot[dataset,evaluation]>=0.6,<0.7' 'stable-baselines3>=2.9,<3'
	$(dir $(LEROBOT))bin/python -m pip install --quiet --no-deps --editable packages/lerobot_env_tatamu
	touch $(LEROBOT)

simulators: $(DEV)  ## the figures of docs/notes/simulators.md: minutes; needs `make blender`
	$(BIN)/python -m benchmarks.simulators --out runs/simulators --write-docs

crosscheck: $(DEV)  ## the figures of docs/notes/second-opinion.md: hours; needs `make blender`
	$(BIN)/python -m benchmarks.crosscheck --out runs/crosscheck --write-docs

paper: $(READY)  ## section VI of the paper in Blender, all garments and seeds, and docs/notes/reproduction.md: hours; needs `make blender`
	$(BIN)/python -m studies.paper --out runs/paper
	$(BIN)/python -m studies.paper.numbers --run runs/paper --write-docs

$(VENV):
	$(PYTHON) -m venv $(VENV)

$(READY): pyproject.toml constraints.txt | $(VENV)
	$(PIP) numba scipy pydantic
	PYTHONPATH=src $(BIN)/python -c "from tatamu.simulation import native; native.prepare()" & \
	  $(PIP) --editable '.[learn]' && wait
	touch $(READY)

$(DEV): pyproject.toml constraints.txt | $(VENV)
	$(PIP) --editable '.[dev]'
	touch $(READY) $(DEV)

clean:
	rm -rf $(VENV) .venv-newton .venv-lerobot .pytest_cache .mypy_cache .ruff_cache build
