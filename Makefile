# make demo   build, bake a furnished room, render and compare: see README.md
# make check  what has to hold before a commit: format, lints, unit tests, structure, docs
# make test   everything that has to hold: Rust and Python
# make notebooks   the notebooks, executed on a small run
# make blender   the Blender extension as out/rrf-blender.zip
# make wheel   the Python package as a wheel in out/wheel
# make docs   the pages of docs/ as a web site in out/book

OUT ?= out/demo
SALON = scenes/salon/salon.glb
SKY = scenes/salon/sky.exr
RRF = $(or $(CARGO_TARGET_DIR),target)/release/rrf
VENV = .venv
NOTEBOOKS = .venv-notebooks
ENGINES = .venv-engines
BLENDER = .venv-blender
PACKAGE = .venv-package

.PHONY: demo check test setup test-setup build report rust-tests python-tests run-tests engine-tests \
	blender-tests blender wheel package-tests notebook-tests python notebooks engines docs clean

setup:
	@sh tests/setup.sh

test-setup:
	@sh tests/setup.sh test

build: setup
	cargo build --release --locked

# rrf and what rrf inspect, chart, sweep and report start; its polars takes as long as all the rest
report: setup
	cargo build --release --locked -p rrf -p rrf-report

# cloud stores are a part of the build that the demo does not need
demo: setup
	cargo build --release --locked --no-default-features
	@rm -rf $(OUT)
	@mkdir -p $(OUT)
	$(RRF) bake $(SALON) --sky $(SKY) --preset preview -o $(OUT)/run
	$(RRF) render $(OUT)/run --size 480x320 -o $(OUT)/model.exr -o $(OUT)/model.png
	$(RRF) trace $(SALON) --sky $(SKY) --size 480x320 --spp 64 -o $(OUT)/traced.exr -o $(OUT)/traced.png
	$(RRF) compare $(OUT)/model.exr $(OUT)/traced.exr
	@echo "The pictures: $(OUT)/model.png (baked) and $(OUT)/traced.png (path traced);"
	@echo "the same as EXR with the layers direct, indirect and cell beside them."

# minutes when warm: what a change can break without a bake
check: setup
	cargo fmt --all --check
	python3 tests/structure.py
	cargo clippy --release --locked --workspace --all-targets -- -D warnings
	cargo test --release --locked --workspace --lib --quiet
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --workspace --no-deps --quiet

test: test-setup check rust-tests python-tests run-tests engine-tests blender-tests package-tests notebook-tests

# cargo test builds the programs and the examples that the Python checks call
rust-tests: check
	cargo test --release --locked --workspace

PROGRAM = RRF=$(abspath $(RRF)) RRF_EXAMPLES=$(abspath $(dir $(RRF))examples)

python-tests: rust-tests python
	$(PROGRAM) $(VENV)/bin/python -m pytest -q tests/python

# kills, lost workers, conflicts, damages, hostile command lines, signals, the page under load, bounds of
# memory, full disks, object stores
run-tests: rust-tests python
	$(PROGRAM) python3 tests/runs/workers.py
	$(PROGRAM) python3 tests/runs/kernels.py
	$(PROGRAM) python3 tests/runs/kill.py --kills 10
	$(PROGRAM) python3 tests/runs/conflicts.py --pairs 20
	$(PROGRAM) $(VENV)/bin/python tests/runs/damage.py --damages 40 --resumes 5
	$(PROGRAM) $(VENV)/bin/python tests/runs/damage.py --damages 24 --resumes 8 --method transfer
	$(PROGRAM) python3 tests/cases.py
	$(PROGRAM) python3 tests/runs/hostile.py
	$(PROGRAM) python3 tests/runs/halt.py
	$(PROGRAM) python3 tests/runs/batch.py
	$(PROGRAM) python3 tests/runs/page.py
	$(PROGRAM) python3 tests/runs/memory.py
	$(PROGRAM) python3 tests/runs/full_disk.py
	$(PROGRAM) python3 tests/runs/store.py --server $(VENV)/bin/moto_server

engine-tests: rust-tests engines
	$(PROGRAM) $(ENGINES)/bin/python tests/engines/ray_cluster.py

# the extension within Blender itself, without a window
blender-tests: rust-tests $(BLENDER)/installed
	cd tests/blender && $(PROGRAM) $(abspath $(BLENDER))/bin/python -m pytest -q

$(BLENDER)/installed: tests/blender/requirements.txt
	python3 -m venv $(BLENDER)
	$(BLENDER)/bin/python -m pip install --quiet --requirement tests/blender/requirements.txt
	@touch $@

# the Python package as a wheel that carries OpenBLAS: out/wheel/*.whl
wheel: setup $(PACKAGE)/installed
	rm -rf out/wheel
	$(abspath $(PACKAGE))/bin/maturin build --release --locked --quiet --manifest-path pipeline/python/Cargo.toml \
		--auditwheel skip --out out/wheel/plain
	PATH="$(abspath $(PACKAGE))/bin:$$PATH" $(PACKAGE)/bin/auditwheel repair --wheel-dir out/wheel out/wheel/plain/*.whl

package-tests: wheel rust-tests
	$(PACKAGE)/bin/python -m pip install --quiet --force-reinstall --no-deps out/wheel/*.whl
	$(PROGRAM) $(PACKAGE)/bin/python -m pytest -q tests/package

$(PACKAGE)/installed: tests/package/requirements.txt
	python3 -m venv $(PACKAGE)
	$(PACKAGE)/bin/python -m pip install --quiet numpy --requirement tests/package/requirements.txt
	@touch $@

# the extension as a file for Blender's preferences
blender: out/rrf-blender.zip

out/rrf-blender.zip: $(wildcard pipeline/blender/rrf/*.py pipeline/blender/rrf/*.toml)
	@mkdir -p out
	cd pipeline/blender/rrf && python3 -m zipfile -c $(abspath $@) *.py *.toml

python: $(VENV)/installed

$(VENV)/installed: tests/python/requirements.txt
	python3 -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --requirement tests/python/requirements.txt
	@touch $@

engines: $(ENGINES)/installed

$(ENGINES)/installed: tests/engines/requirements.txt
	python3 -m venv $(ENGINES)
	$(ENGINES)/bin/python -m pip install --quiet --requirement tests/engines/requirements.txt
	@touch $@

# the README's picture of `rrf view`, by its own test
docs/images/view.png: build python $(VENV)/installed
	test -d $(OUT)/run || $(MAKE) demo
	RRF=$(abspath $(RRF)) RRF_RUN=$(OUT)/run RRF_SCREENSHOT=$@ \
		$(VENV)/bin/python -m pytest -q tests/python/test_view.py -k screenshot

# the README's room under a moving sun
docs/images/salon-sun.webp: build python
	test -d $(OUT)/run || $(MAKE) demo
	RRF=$(abspath $(RRF)) $(VENV)/bin/python docs/images/sun.py $(OUT)/run $@

# the small run that the notebooks look at, and all of them executed
define EXECUTE
RRF=$(abspath $(RRF)) sh notebooks/demo.sh out/notebooks
RRF=$(abspath $(RRF)) RRF_DEMO=$(abspath out/notebooks) \
	$(NOTEBOOKS)/bin/python -m pytest -q --nbmake --nbmake-timeout=600 notebooks
endef

notebooks: report $(NOTEBOOKS)/installed
	$(EXECUTE)

# the programs as rust-tests built them: another choice of crates would build polars again
notebook-tests: rust-tests $(NOTEBOOKS)/installed
	$(EXECUTE)

$(NOTEBOOKS)/installed: notebooks/requirements.txt notebooks/setup.sh
	sh notebooks/setup.sh $(NOTEBOOKS)
	@touch $@

MDBOOK = out/tools/bin/mdbook

docs: build $(MDBOOK)
	python3 docs/generate.py --rrf $(RRF)
	$(MDBOOK) build docs

$(MDBOOK):
	cargo install mdbook --version 0.5.4 --locked --no-default-features --features search --root out/tools

clean:
	rm -rf out $(VENV) $(NOTEBOOKS) $(ENGINES) $(BLENDER) $(PACKAGE)
