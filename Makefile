# Sets up .venv and uses it. Needs make, a POSIX shell, Python 3.11 or newer and PyPI; no root.
#
#   make demo    render the showcase scene
#   make test    run the tests
#   make lint    ruff and mypy
#   make docs    the documentation as a site, in out/docs
#   make reliability   the long proofs, and docs/reliability.md with their figures
#   make release   lint, figures that are not stale, all tests, all exercises, all of validation and its mutants; long,
#                  but what validation has kept of the same code and inputs it does not do again
#   make clean   remove what the above made
#
# PYTHON=/path/to/python chooses the interpreter, TESTS="tests/cli/test_cli.py -x" what pytest gets (JOBS= runs tests
# one after the other), CLRT_DEVICE (a part of a name that `clrt devices` prints) the device. By default it is that
# of PyPI's PoCL, or where that builds nothing for the processor, of Intel's runtime from PyPI.

VENV := .venv
BIN := $(VENV)/bin
PYTHONS := python3.15 python3.14 python3.13 python3.12 python3.11
TESTS ?=
JOBS ?= --numprocesses logical --maxprocesses 4
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Of all drivers on the machine only the one that pip installed, so that everybody runs the same.
PIP_POCL = "$$PWD"/$(VENV)/lib/python3*/site-packages/pyopencl/.libs/pocl.icd
USE_DRIVER = if [ -z "$$CLRT_DEVICE$$CLRT_DRIVER" ]; then case "$$(cat $(VENV)/driver)" in \
	pocl) OCL_ICD_VENDORS=$$(echo $(PIP_POCL)); export OCL_ICD_VENDORS;; \
	intel) export CLRT_DRIVER=intel;; esac; fi

# PoCL has to build one kernel; Intel's runtime is installed only where it does not.
FIND_DRIVER = icd=$$(echo $(PIP_POCL)); if ! [ -f "$$icd" ]; then echo system >$(VENV)/driver; \
	elif fault=$$(OCL_ICD_VENDORS="$$icd" CLRT_DRIVER=pocl $(BIN)/python -m clrt.device.attempt 0 2>/dev/null); then \
	echo pocl >$(VENV)/driver; \
	else echo "PyPI's PoCL does not work here ($${fault:-it ends the process}): installing Intel's runtime," \
	"266 MB, under Intel's licence ..."; \
	$(INSTALL) --editable '.[pocl,intel]' && echo intel >$(VENV)/driver; fi

# What `make test` leaves out, each with the reason that it prints.
ELSEWHERE := debian_pocl oclgrind browser embree
REASON_debian_pocl := needs Debian's PoCL 3.1 beside the pip one
REASON_oclgrind := needs Oclgrind, a memory checker for kernels
REASON_browser := needs a headless browser
REASON_embree := needs g++ and Debian's libembree-dev, a yardstick of speed
REASON_shared := needs the published scenes and pictures in ../shared
ifeq ($(wildcard ../shared/data),)
ELSEWHERE += shared
endif
EXPRESSION = not $(subst $(space), and not ,$(strip $(ELSEWHERE)))
empty :=
space := $(empty) $(empty)

# What kernels and drivers decide: `release` runs it on Debian's PoCL, too.
DRIVERS := tests/device tests/diagnosis tests/engine tests/layout tests/bench/test_bench.py \
	tests/validation/test_proofs.py tests/validation/test_twin.py

.PHONY: demo test lint docs reliability release clean
.DELETE_ON_ERROR:

demo: $(VENV)/demo-ready
	@mkdir -p out
	@$(USE_DRIVER); $(BIN)/clrt render showcase -o out/showcase.png

test: $(VENV)/test-ready
	@$(USE_DRIVER); $(BIN)/python -m pytest $(JOBS) -m "$(EXPRESSION)" $(TESTS); status=$$?; \
	$(foreach marker,$(ELSEWHERE),echo "not run here: tests marked $(marker): $(REASON_$(marker))";) \
	exit $$status

lint: $(VENV)/test-ready
	$(BIN)/ruff check .
	$(BIN)/mypy

docs: $(VENV)/docs-ready
	@$(USE_DRIVER); $(BIN)/python -m sphinx -q -W --keep-going -b html -d out/doctrees docs out/docs
	@$(BIN)/python -m docs.site.links out/docs

reliability: $(VENV)/test-ready
	@$(BIN)/python -m validation.reliability

# What takes seconds comes first.
release: $(VENV)/test-ready
	@$(MAKE) --no-print-directory lint
	@$(BIN)/python -m validation.reliability --check
	@CLRT_EDITS=120 CLRT_FAULTS=all $(MAKE) --no-print-directory test TESTS= JOBS='$(JOBS)'
	@$(USE_DRIVER); CLRT_EXERCISES=all $(BIN)/python -m pytest -q -m debian_pocl tests/exercises
	@CLRT_DEVICE="PoCL 3.1" $(BIN)/python -m pytest $(JOBS) -m "not oclgrind and not browser" $(DRIVERS)
	@mkdir -p out
	@$(USE_DRIVER); $(BIN)/clrt validate --full --mutants --report out/validation.html
	@$(USE_DRIVER); $(BIN)/python -m validation.deletion_run --all --check
	@$(USE_DRIVER); $(BIN)/python -m validation.mutants.generated_run
	@$(BIN)/python docs/make_mutants.py

clean:
	rm -rf $(VENV) out build dist

$(VENV)/demo-ready: pyproject.toml $(VENV)/made
	@echo "installing clrt into $(VENV) ..."
	@$(INSTALL) --editable '.[pocl]'
	@if [ -z "$$CLRT_DEVICE$$CLRT_DRIVER" ]; then $(FIND_DRIVER); fi
	@touch $@

$(VENV)/test-ready: pyproject.toml $(VENV)/demo-ready
	@echo "installing clrt and its tools into $(VENV) ..."
	@$(INSTALL) --editable '.[mesh,validation,bench,video,dev]'
	@touch $@

$(VENV)/docs-ready: pyproject.toml $(VENV)/demo-ready
	@echo "installing what makes the site into $(VENV) ..."
	@$(INSTALL) --editable '.[mesh,docs]'
	@touch $@

$(VENV)/made:
	@for python in $(if $(PYTHON),"$(PYTHON)",python3 $(PYTHONS)); do \
		if "$$python" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
			"$$python" -m venv --clear $(VENV) && touch $@; exit; \
		fi; \
	done; \
	echo "make: no Python 3.11 or newer with its venv module among: $(or $(PYTHON),python3 $(PYTHONS)); install" \
		"one (Debian: apt-get install python3-venv) or say PYTHON=/path/to/python" >&2; exit 1
