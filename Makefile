# `make demo` and `make test` set up all they need; only python3 (>= 3.11, with venv) and make are required.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
# As the programs do for themselves: matrices here are too narrow for BLAS's threads.
export OPENBLAS_NUM_THREADS ?= 1
# Where it is set, as in many containers, every test process would compile all modules and rewrite all assertions anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo demo-control test test-all test-fast test-slow test-realtime test-vcan ci lint faults fuzz hidden-effects watch-alarms fleet-years mutants docs docs-output pictures bench samples lock

setup: $(READY)

$(READY): pyproject.toml requirements.lock
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; set PYTHON=...")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-compile -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

# Records the paper's two motions on the simulated rig, in which an effect unknown to the model is hidden, fits the
# model to the first, validates it on the second, and puts what it lacks and all else into one report.
DEMO := runs/demo
demo: $(READY)
	rm -rf $(DEMO) && mkdir -p $(DEMO)
	$(BIN)/daq record --traj fig5a --hidden 9 --out $(DEMO)/fig5a.mcap
	$(BIN)/daq record --traj fig5b --hidden 9 --out $(DEMO)/fig5b.mcap
	$(BIN)/ident fit $(DEMO)/fig5a.mcap --validate $(DEMO)/fig5b.mcap
	$(BIN)/ident report $(DEMO)/fig5a.model.json $(DEMO)/fig5a.mcap --validate $(DEMO)/fig5b.mcap -o $(DEMO)/report.html
	@echo "open the report:  $(BIN)/python -m webbrowser $(DEMO)/report.html"
	@echo "the program is $(BIN)/ident; to type ident alone:  export PATH=\"\$$PWD/$(BIN):\$$PATH\""

# Records, fits and diagnoses five robots with hidden effects, then feeds the torque of four models forward: a table and
# a picture of the following error. Some minutes.
demo-control: $(READY)
	$(BIN)/python -m benchmarks.control

# A few minutes on two cores: what is worth running after every change.
test: lint test-fast

# All that is checked without root: also before an issue is called resolved.
test-all: SHARE = 1/1
test-all: ONE_IN = 1
test-all: test test-slow test-realtime

# Tests side by side on all cores; a worker that is done takes over from one that is not.
SIDE_BY_SIDE := -n auto --maxprocesses 8 --dist worksteal --max-worker-restart 2

test-fast: $(READY)
	$(BIN)/python -m pytest -q $(SIDE_BY_SIDE) -m "not slow and not realtime"

# A fifth of the modules, with a quarter of the variations of each test, drawn by the commit, and what is essential; the
# draw is printed at the end of `.ci/run`.
SHARE ?= 1/5
ONE_IN ?= 4
DRAW ?= $(shell git rev-parse HEAD 2> /dev/null || echo "without-git")

# One worker more than cores, because many of these tests wait: for a browser, a motion or another program.
test-slow: $(READY)
	$(BIN)/python -m pytest -q $(SIDE_BY_SIDE:auto=$$(($$(nproc) + 1))) -m "slow and not realtime" \
	    --share $(SHARE) --one-in $(ONE_IN) --draw "$(DRAW)"

# Beside nothing else; where this machine does not keep time, what was skipped for that is said with figures.
test-realtime: $(READY)
	$(BIN)/python -m pytest -q -rs -m realtime $$(grep -rl --include='test_*.py' 'mark[.]realtime' tests)

# On the kernel's own SocketCAN, in User-mode Linux where this kernel has no vcan; says what is missing.
VCAN ?=
test-vcan: $(READY)
	tests/vcan/run $(VCAN)

# What decides whether a change counts: `.ci/run` on a fresh clone of this commit. Needs root, for Debian's packages.
ci:
	@test -z "$$(git status --porcelain)" || { echo "make ci: commit first; it runs a clone of the last commit" >&2; exit 2; }
	@test "$$(id -u)" = 0 || { echo "make ci: needs root, to install Debian's packages" >&2; exit 2; }
	rm -f build/ci.passed && mkdir -p build && clone=$$(mktemp -d)/main && git clone --quiet . $$clone && echo "in $$clone" && \
	    (cd $$clone && CI=true REAL_DATA=$${REAL_DATA:-$(abspath ../shared/data)} bash .ci/run < /dev/null) && \
	    cp $$clone/build/ci.passed build/ci.passed && rm -rf $$(dirname $$clone)

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The two sample recordings, made anew (lockstep: the same bytes every time), and files of other programs.
SAMPLES := recordings/samples
samples: $(READY)
	mkdir -p $(SAMPLES)/foreign && rm -f $(SAMPLES)/*.mcap $(SAMPLES)/foreign/*.mcap
	$(BIN)/daq record --traj fig5a --cycles 2 --rate 250 --out $(SAMPLES)/fig5a.mcap
	$(BIN)/daq record --traj fig5b --cycles 2 --rate 250 --out $(SAMPLES)/fig5b.mcap
	$(BIN)/python -m tests.recordings.importing.foreign $(SAMPLES)/foreign

# Everything that can go wrong with bus, drives, machine, host and operator; prints a table.
faults: $(READY)
	$(BIN)/python -m tests.faults

# 100,000 random frames and serial replies; damaged files of all kinds, and diagnoses of random recordings (hours).
# A part, more of it, or one seed again: make fuzz FUZZED="files --start 7 --count 1"
# Damaged recordings and what `daq recover` keeps of them: python -m tests.fuzz.recovery --count 2000
FUZZED ?=
fuzz: $(READY)
	$(BIN)/python -m tests.fuzz $(FUZZED)

# Hides effects in a plant that shares nothing with the identifier, diagnoses blind, prints how often it was right.
# A part alone: make hidden-effects PARTS=locked
PARTS ?= tuned chosen locked
hidden-effects: $(READY)
	for part in $(PARTS); do $(BIN)/python -m benchmarks.hidden_effects --plant foreign --part $$part || exit 1; done

# How soon, and how falsely, `ident watch` raises its alarm. Takes hours, and goes on where it was stopped.
watch-alarms: $(READY)
	$(BIN)/python -m benchmarks.watch --folder build/watch

# What one more night costs after three years of 200 robots, and whether small fleets have the alarms of their whole history.
fleet-years: $(READY)
	$(BIN)/python -m benchmarks.fleet.years build/fleet-years

# Changes one place of the code at a time, and prints which of these changes no fast test notices.
MUTATED ?= ident/diagnosis ident/uncertainty ident/data ident/residuals recordings
SEED ?= 1
COUNT ?= 40
mutants: $(READY)
	for folder in $(MUTATED); do \
	    $(BIN)/python -m benchmarks.mutants --folder $$folder --seed $(SEED) --count $(COUNT) || exit 1; \
	done

# The documentation as a site: build/docs/index.html. Fails at the first warning, as a broken link is.
docs: $(READY) .venv/.docs
	$(BIN)/python -m sphinx -q -W --keep-going docs build/docs
	@echo "build/docs/index.html"

# Runs the commands in the console blocks of README.md and docs/, and writes what they print below them.
docs-output: $(READY)
	$(BIN)/python -m tests.constants_page
	$(BIN)/python -m tests.documents

# The pictures of README.md and docs/, taken in a real browser: of the demo's report, and of the workbench by its own test.
PICTURES := import where-it-fails at-the-floor
pictures: demo
	$(BIN)/python -m tests.pictures $(DEMO)/report.html docs/pictures/error-falls.png
	$(BIN)/python -m pytest -q tests/ident/workbench/test_mission.py tests/ident/workbench/test_dropped.py -k "mouse or dropped"
	cp $(PICTURES:%=runs/workbench-screenshots/%.png) docs/pictures/

bench: $(READY)
	env -u OPENBLAS_NUM_THREADS $(BIN)/python -m benchmarks

# What builds the documentation.
.venv/.docs: requirements-docs.lock $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-compile -r requirements-docs.lock
	touch $@

# Pins for every platform, without addresses; needs network.
lock: $(READY)
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes \
	    --no-emit-index-url --no-header pyproject.toml lock.in -o requirements.lock
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra docs --constraint requirements.lock \
	    --generate-hashes --no-emit-index-url --no-header pyproject.toml -o requirements-docs.lock
