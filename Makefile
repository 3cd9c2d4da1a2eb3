# The commands of the project; `make help` lists them. Each does the set-up it needs by itself.
SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -c
.DEFAULT_GOAL := help

# Variables a user may set on the command line.
CASE ?= 1m1ma
SEED ?= 3
DEMO = $(if $(filter coursework,$(CASE)),coursework,run_experiment --case $(CASE)$(if $(CONSOLE), --console))
CONSOLE ?=
TESTS ?=
KNOWN := CASE CONSOLE SEED TESTS
GIVEN := $(foreach name,$(.VARIABLES),$(if $(filter command line,$(origin $(name))),$(name)))
UNKNOWN := $(filter-out $(KNOWN),$(GIVEN))
$(if $(UNKNOWN),$(error unknown variable $(UNKNOWN): make knows $(KNOWN); see `make help`))

.PHONY: help setup build demo test test-fast bench lint reproduce docs clean

help:
	@echo 'make setup      install Debian packages and the virtual environment (quick when done)'
	@echo 'make build      build messages, perception and its tests'
	@echo 'make demo       run one experiment end to end, headless: CASE=1m1ma|2m1ma|1m1ma_bin|2m1ma_bin|3m6_bin|3m|single|1m1ma_target|explore|inspect|coursework SEED=3; CONSOLE=1 shows the cell in a browser'
	@echo 'make test       everything: unit, rostest and system tests; TESTS="-k name" narrows it'
	@echo 'make test-fast  the tests that need no ROS, under a minute'
	@echo 'make lint       formatters, linters, type checks, launch files, boundaries'
	@echo 'make bench      every benchmark, with plots (long)'
	@echo 'make reproduce  the published figures and table, N >= 30 trials a cell (long; resumes)'
	@echo 'make docs       regenerate the generated pages of docs/'

setup:
	@tools/setup.sh

build: setup
	@tools/build.sh

demo: build
	@source tools/env.sh && rosrun yarm $(DEMO) --seed $(SEED)

test: setup
	@tools/build.sh tests
	@source tools/env.sh && tools/test.sh $(TESTS)

test-fast: setup
	@source tools/env.sh && tools/test.sh fast $(TESTS)

lint: build
	@source tools/env.sh && tools/lint.sh

bench: build
	@source tools/env.sh && python3 bench/run_all.py

reproduce: build
	@source tools/env.sh && rosrun yarm reproduce && python3 bench/localisation.py --sets one_turn one_turn_fine walls walls_fine given given_fine given_odo2 && python3 bench/localisation.py --sets tours tours_odo2 tours_fine --rooms 3 --count 2

docs: build
	@source tools/env.sh && python3 tools/generate_docs.py

clean:
	rm -rf build devel install log
