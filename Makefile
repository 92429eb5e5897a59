# make demo   build, bake the Cornell box, render and compare: see README.md
# make test   everything that has to hold: Rust and Python
# make notebooks   the notebooks, executed on a small run

OUT ?= out/demo
SCENE = scenes/cornell-box/scene.pbrt
LIGHT_BOX = -0.6,1.3,-0.6,0.6,1.8,0.6
LIGHT = 0.1,1.6,0.2,4,4,4
RRF = $(or $(CARGO_TARGET_DIR),target)/release/rrf
VENV = .venv
NOTEBOOKS = .venv-notebooks

.PHONY: demo test setup build report python notebooks clean

setup:
	@sh tests/setup.sh

build: setup
	cargo build --release --locked

# what rrf inspect, chart, sweep and report start; polars takes longer to build than all the rest
report: setup
	cargo build --release --locked -p rrf-report --features inspect

demo: build
	@rm -rf $(OUT)
	@mkdir -p $(OUT)
	$(RRF) bake $(SCENE) -o $(OUT)/run --light-box $(LIGHT_BOX)
	$(RRF) render $(OUT)/run --light $(LIGHT) --size 512x512 -o $(OUT)/model.exr -o $(OUT)/model.png
	$(RRF) trace $(SCENE) --light $(LIGHT) --size 512x512 --spp 256 -o $(OUT)/traced.exr -o $(OUT)/traced.png
	$(RRF) compare $(OUT)/model.exr $(OUT)/traced.exr
	@echo "The pictures: $(OUT)/model.png (baked nets) and $(OUT)/traced.png (path traced);"
	@echo "the same as EXR with the layers direct, indirect and cell beside them."

# cargo test builds the program and the examples that the Python checks call
test: setup python
	cargo fmt --all --check
	cargo clippy --release --locked --workspace --all-targets -- -D warnings
	cargo test --release --locked --workspace
	RRF=$(abspath $(RRF)) RRF_EXAMPLES=$(abspath $(dir $(RRF))examples) \
		$(VENV)/bin/python -m pytest -q tests/python

python: $(VENV)/installed

$(VENV)/installed: tests/python/requirements.txt
	python3 -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --requirement tests/python/requirements.txt
	@touch $@

# the small run that the notebooks look at, and all of them executed
notebooks: build report $(NOTEBOOKS)/installed
	RRF=$(abspath $(RRF)) sh notebooks/demo.sh out/notebooks
	RRF=$(abspath $(RRF)) RRF_DEMO=$(abspath out/notebooks) \
		$(NOTEBOOKS)/bin/python -m pytest -q --nbmake --nbmake-timeout=400 notebooks

$(NOTEBOOKS)/installed: notebooks/requirements.txt notebooks/setup.sh
	sh notebooks/setup.sh $(NOTEBOOKS)
	@touch $@

clean:
	rm -rf out $(VENV) $(NOTEBOOKS)
