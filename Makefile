# Sets up .venv and uses it. Needs make, a POSIX shell, Python 3.11 to 3.13 and PyPI; no root.
#
#   make demo    render the showcase scene
#   make test    run the tests
#   make lint    ruff and mypy
#   make reliability   the long proofs, and docs/reliability.md with their figures
#   make clean   remove what the above made
#
# PYTHON=/path/to/python chooses the interpreter, TESTS="tests/test_cli.py -x" what pytest gets (JOBS= runs tests
# one after the other), CLRT_DEVICE (a part of a name that `clrt devices` prints) the driver; by default it is the
# one from PyPI.

VENV := .venv
BIN := $(VENV)/bin
TESTS ?=
JOBS ?= --numprocesses logical --maxprocesses 4
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Of all drivers on the machine only the one that pip installed, so that everybody runs the same.
PIP_POCL = if [ -z "$$CLRT_DEVICE" ]; then \
	for icd in "$$PWD"/$(VENV)/lib/python3*/site-packages/pyopencl/.libs/pocl.icd; do \
	if [ -f "$$icd" ]; then export OCL_ICD_VENDORS="$$icd"; fi; done; fi

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

.PHONY: demo test lint reliability clean
.DELETE_ON_ERROR:

demo: $(VENV)/demo-ready
	@mkdir -p out
	@$(PIP_POCL); $(BIN)/clrt render showcase -o out/showcase.png

test: $(VENV)/test-ready
	@$(PIP_POCL); $(BIN)/python -m pytest $(JOBS) -m "$(EXPRESSION)" $(TESTS); status=$$?; \
	$(foreach marker,$(ELSEWHERE),echo "not run here: tests marked $(marker): $(REASON_$(marker))";) \
	exit $$status

lint: $(VENV)/test-ready
	$(BIN)/ruff check .
	$(BIN)/mypy

reliability: $(VENV)/test-ready
	@$(BIN)/python -m validation.reliability

clean:
	rm -rf $(VENV) out build dist

$(VENV)/demo-ready: pyproject.toml $(VENV)/made
	@echo "installing clrt into $(VENV) ..."
	@$(INSTALL) --editable '.[pocl]'
	@touch $@

$(VENV)/test-ready: pyproject.toml $(VENV)/made
	@echo "installing clrt and its tools into $(VENV) ..."
	@$(INSTALL) --editable '.[pocl,mesh,validation,bench,dev]'
	@touch $@ $(VENV)/demo-ready

$(VENV)/made:
	@for python in $(if $(PYTHON),"$(PYTHON)",python3 python3.13 python3.12 python3.11); do \
		if "$$python" -c 'import ensurepip, sys, venv; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
			2>/dev/null; then \
			"$$python" -m venv --clear $(VENV) && touch $@; exit; \
		fi; \
	done; \
	echo "make: no Python from 3.11 to 3.13 with its venv module among: $(or $(PYTHON),python3 python3.13 python3.12" \
		"python3.11); install one (Debian: apt-get install python3-venv) or say PYTHON=/path/to/python" >&2; exit 1
