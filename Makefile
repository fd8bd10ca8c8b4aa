# `make run` opens a dive, `make bench` installs what the makers' tools need besides, `make test` runs
# the checks of every day, `make test-house` those of a dive alone, `make nightly` all that there are,
# `make blender` opens an exported scene and passes of a film in Blender, `make train` trains a detector
# on a few pictures. Each sets up what it needs, once.
#
#   make run ARGS="--seed 3 --fullscreen"      arguments of `subsea dive`
#   make test ARGS="-k clock"                  arguments of pytest

BIN := .venv/bin
LOCKED := uv.lock pyproject.toml tools/setup.sh tools/gltf-validator/package-lock.json assets/web/package-lock.json
NO_DISPLAY = [ -z "$$DISPLAY$$WAYLAND_DISPLAY" ] && [ "$$(uname -s)" != Darwin ]

.PHONY: run bench test test-house nightly blender train format docs gallery wheel clean

run: .venv/ready-run
	@if $(NO_DISPLAY); then \
		echo "No display here: filming to dive.mp4 instead."; \
		exec $(BIN)/subsea film dive.mp4 --seconds 10 $(filter-out --fullscreen,$(ARGS)); \
	else \
		exec $(BIN)/python run_submarine.py $(ARGS); \
	fi

bench: .venv/ready-bench

# Types and format are checked beside the tests, and reported after them.
test test-house nightly: .venv/ready-test
	@{ $(BIN)/ruff format --check . && $(BIN)/ruff check . && $(BIN)/mypy; } >.venv/checks.log 2>&1 & \
	$(BIN)/pytest -n 2 --dist loadfile --max-worker-restart 0 $(TESTS) $(ARGS); tested=$$?; \
	wait $$!; checked=$$?; cat .venv/checks.log; exit $$((tested | checked))
test-house: TESTS = $(patsubst %,--ignore=tests/%,stage studio export lab docs tools)
nightly: TESTS = --nightly

# Blender is a gigabyte, and wants this version of Python.
blender: .venv/ready-test .venv/blender/ready
	$(BIN)/pytest tests/export/test_blender.py tests/media/test_blender_passes.py

.venv/blender/ready:
	$(BIN)/uv venv --quiet --clear --python 3.11 .venv/blender
	$(BIN)/uv pip install --quiet --python .venv/blender bpy==5.0.1 pillow
	@touch $@

# PyTorch is 200 MB with the processor alone, and gigabytes with the libraries of a GPU.
train: .venv/ready-test .venv/train/ready
	$(BIN)/pytest tests/docs/test_train_detector.py

.venv/train/ready:
	$(BIN)/python -m venv --clear .venv/train
	.venv/train/bin/pip install --quiet --retries 1 --extra-index-url https://download.pytorch.org/whl/cpu \
		torch pycocotools pillow
	@touch $@

format: .venv/ready-test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: .venv/ready-test
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo out/site/index.html

# Models of all species and two scenes, with an index page. An interrupted run goes on.
gallery: .venv/ready-bench
	$(BIN)/python tools/make_gallery.py $(ARGS)

# With kernels compiled for this Python and system, and the results of a first start.
wheel: .venv/ready-test
	$(BIN)/python tools/build_wheel.py -d dist

clean:
	rm -rf .venv tools/gltf-validator/node_modules

# The script makes the file, unless something is missing: then the next `make` tries again.
.venv/ready-%: $(LOCKED)
	@sh tools/setup.sh $*
