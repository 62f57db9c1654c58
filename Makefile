# SPDX-License-Identifier: Apache-2.0
# Needs only CPython 3.10 to 3.13 with venv, make and PyPI. All goes into .venv and build.

PYTHON ?= python3
BIN := .venv/bin
COLCON := $(BIN)/colcon --log-base build/colcon/log
SPACES := --build-base build/colcon/build --install-base build/colcon/install

# The environment is complete in itself: a sourced ROS, or another environment, stays out of it.
ifdef AMENT_PREFIX_PATH
unexport LD_LIBRARY_PATH
endif
unexport AMENT_PREFIX_PATH COLCON_PREFIX_PATH CMAKE_PREFIX_PATH PYTHONPATH PYTHONHOME
unexport RMW_IMPLEMENTATION VIRTUAL_ENV _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: help demo view test quick browser bench soak check docs workspace clean

help:  ## list the targets
	@sed -n 's/^\([a-z]*\):[^#]*##/\1:/p' $(MAKEFILE_LIST)

demo: .venv/.made  ## run the node on recorded motion and show its topics
	@$(BIN)/linkedplane_demo

view: .venv/.made  ## show the muscle in a browser, at the address it prints, and move the arm
	@$(BIN)/muscle_viewer --node

test: .venv/.rivals check docs workspace  ## run all checks and tests
	$(BIN)/python -m pytest -m 'not workspace and not browser' --numprocesses 2
	@$(MAKE) --no-print-directory browser

# Of each package something: what another Python, or another version of a library, could break.
QUICK := linked_planes joints muscle solver recordings processing drawing commands \
  cases documentation/test_blocks.py node/test_end_to_end.py node/test_topics.py node/test_parameters_checked.py

quick: .venv/.made $(if $(OLDEST),,check) demo  ## checks, demo, a part of the tests; OLDEST=1: no checks, oldest libraries
	$(BIN)/python -m pytest -m 'not workspace and not browser' --numprocesses 2 $(QUICK:%=test/%)

# Alone: the browser draws without a graphics card, and takes the machine for itself.
browser: .venv/.made  ## test the viewer in Chromium; part of make test
	$(BIN)/python -m pytest -m browser test/viewer

bench: .venv/.rivals  ## measure the solver beside MuJoCo and OpenSim, the node beside a pass-through
	@$(BIN)/python bench/bench.py

SECONDS ?= 300
POSES ?= 1000000
soak: .venv/.made  ## solve wild muscles; read damaged bags and tables; feed, storm and flood the node
	@$(BIN)/python bench/wild.py $(POSES)
	@$(BIN)/python bench/moments.py $(POSES)
	@$(BIN)/python bench/bag_fuzz.py
	@$(BIN)/python bench/table_fuzz.py
	@$(BIN)/python bench/soak.py $(SECONDS)
	@$(BIN)/python bench/storm.py

# NumPy for Python 3.10 has other, looser types.
OLD_NUMPY := import sys; sys.exit(sys.version_info >= (3, 11))

check: .venv/.made  ## style, types, and who imports whom
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python doc/house.py
	$(BIN)/python -c '$(OLD_NUMPY)' || $(BIN)/mypy

docs: .venv/.made  ## build the documentation into build/doc; any warning fails
	$(BIN)/python -m sphinx -E -W --keep-going -n -q doc build/doc
	@echo 'build/doc/index.html'

# colcon test runs only what has to be seen from a built workspace (executables, installed files);
# the other tests would find the same sources a second time.
workspace: .venv/.made  ## build the package with colcon and test what it installs
	rm -rf build/colcon
	$(COLCON) build --paths . $(SPACES) --event-handlers console_direct- console_cohesion-
	$(COLCON) test --paths . $(SPACES) --event-handlers console_direct+ \
	  --pytest-args -m workspace test/packaging/test_workspace.py
	$(COLCON) test-result --test-result-base build/colcon/build --verbose

clean:  ## remove all that make has made
	rm -rf .venv build .mypy_cache .pytest_cache .ruff_cache .hypothesis *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

SUITABLE := import sys, ensurepip, venv; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))

# With OLDEST=1, each library that the package runs on is as old as setup.py allows; a constraint
# is dask, not dask[distributed].
.venv/.made: setup.py test/requirements.txt
	@$(PYTHON) -c '$(SUITABLE)' 2>/dev/null || { echo "make: $(PYTHON)" \
	  "is not a CPython 3.10 to 3.13 with venv; name one with make PYTHON=..." >&2; exit 1; }
	$(PYTHON) -m venv --clear .venv
	touch .venv/COLCON_IGNORE
	grep --only-matching '[][a-zA-Z-]\+>=[0-9.]*[0-9]' setup.py \
	  | sed 's/\[.*\]//; s/>=/==/' > .venv/oldest.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[all,cluster]' \
	  --requirement test/requirements.txt $(if $(OLDEST),--constraint .venv/oldest.txt)
	touch $@

# Each rival where it can be had; what compares with a missing one is skipped, and says so.
.venv/.rivals: .venv/.made
	@for rival in 'mujoco>=3.6' opensim; do \
	  $(BIN)/python -m pip install --quiet --disable-pip-version-check "$$rival" \
	  || echo "make: $$rival cannot be installed here; comparisons with it are left out"; done
	touch $@
