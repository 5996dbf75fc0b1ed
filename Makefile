# `make` prints every target. Nothing here needs more than cargo, python3 and a network for their packages.

.DEFAULT_GOAL := help
GEN := target/release/gen
VENV := .venv
TRAIN = $(VENV)/bin/python python/train_baseline.py
GAP = $(VENV)/bin/python python/gap.py
ABLATE = $(VENV)/bin/python python/ablate_baselines.py
DIR ?= out/wood-small
RECIPE ?= recipes/wood.yaml
INDEX ?= 0
N ?= 2
FUZZ_SECONDS ?= 600
REAL ?= real
PART ?= all
# What `make likeness` and `make transfer` hold to the photographs of REAL: the recipe, and how many of its boards.
REAL_RECIPE ?= recipes/real/board-camera.yaml
REAL_BOARDS ?= 100
# Sealed pictures are asked about once, at the end, and by name alone.
OPEN_OR_SEALED = $(if $(filter sealed,$(PART)),sealed,open)
# Of `make gap`: fresh boards and packs, and photons that the reference walks in each of their profiles.
GAP_BOARDS ?= 40
GAP_PACKS ?= 40
GAP_BOARD_PHOTONS ?= 56000
GAP_PACK_PHOTONS ?= 80000
GAP_FRESH = --seed 5 --samples-per-shard 4
# Neither speckle nor noise of the sensor, but for the least that the recipe allows.
GAP_QUIET = --set speckle.strength=0 $(patsubst %,--set exposure.%,shot_noise=0 dark_noise_dn=0.3 row_noise_dn=0 row_pattern_dn=0 column_pattern_dn=0 dsnu_dn=0 prnu=0)
# Photons per profile of the transport to take.
GAP_PATH = --set "transport={model: path, photons_per_profile: $(1)}"
ALL = --release --locked --workspace
WHEEL := .venv-wheel
SCALE := .venv-scale
MOTO := .venv-moto
FORMATS := .venv-formats
SITE := .venv-site
RELEASE := .venv-release
# The oldest glibc that released files run with, and the package of an old one to try them with.
GLIBC := 2.28
LIBC ?=
# Tests that need no Python, no browser and no machine for themselves. Those marked `#[ignore]` take long: `check-rest` runs them.
FIRST = architecture chance dataset dictionary extraction icon matter optics packaging pictures program recipe recipe_schema transport validate
FIRST_TESTS = $(ALL) --lib $(FIRST:%=--test %)

# What stands in square brackets in documentation and is no link: units, and letters of sources. Any other link that leads nowhere fails `check`.
UNITS = 1|mm|um|px|DN|rad|deg|s|Hz|bytes|characters|i|[A-Z]

.PHONY: help defect-maps build dist release wheel test-wheel test-scale test-formats test-long test-python test-installed test-alone environments quick prepare lint check check-rest check-all bench same-bytes same-values size wood wood-small blister blister-small sawtooth sawtooth-small mesh-small preview validate report bench-check check-onnx baselines gap likeness transfer real-fibres closed-loop measure-loop cover-loop unlike-rigs gallery schema kernel-table film-table bless reference fresh-draws fuzz doc site clean venv

help: ## print this help
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 14

build: ## build gen (target/release/gen)
	cargo build --release --locked --workspace --bins

dist: ## build the smaller program that is given to others (target/dist/gen); fails over 25 MB
	cargo build --profile dist --locked --workspace --bins
	@test $$(wc -c < target/dist/gen) -lt 25000000 || { wc -c target/dist/gen; exit 1; }

release: $(RELEASE)/.ready ## what is given to others, in out/release: wheel and program for old systems, sums, notes (LIBC=libc6_2.31_amd64.deb tries it)
	rm -rf out/release && mkdir -p out/release
	PATH="$(CURDIR)/$(RELEASE)/bin:$$PATH" maturin build --quiet --profile dist --zig --compatibility manylinux_$(subst .,_,$(GLIBC)) --out out/release
	PATH="$(CURDIR)/$(RELEASE)/bin:$$PATH" cargo-zigbuild zigbuild --profile dist --locked --workspace --bin gen --target x86_64-unknown-linux-gnu.$(GLIBC)
	tar -C target/x86_64-unknown-linux-gnu/dist -czf out/release/gen-linux-x86_64.tar.gz gen
	$(RELEASE)/bin/python python/check_release.py out/release $(LIBC)

venv: $(VENV)/.ready ## Python readers for the tests (.venv)

# uv finds versions that go together and unpacks them in a minute, where pip takes five.
define fill
	@python3 -c 'import sys; sys.exit("python3 is %d.%d, and the packages of python/requirements.txt need 3.11 or newer" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	python3 -m venv $(@D)
	$(@D)/bin/python -m pip install --quiet --disable-pip-version-check uv==0.13.9
	$(@D)/bin/uv pip install --quiet --python $(@D)/bin/python --override python/overrides.txt -r $<
	touch $@
endef

$(VENV)/.ready: python/requirements.txt python/overrides.txt
	$(fill)

# Packages of clusters and of the S3 server exclude each other.
$(WHEEL)/.ready $(SCALE)/.ready $(MOTO)/.ready $(FORMATS)/.ready $(SITE)/.ready $(RELEASE)/.ready: .venv-%/.ready: python/requirements-%.txt python/overrides.txt
	$(fill)

wheel: $(WHEEL)/.ready ## build the Python package (target/wheels), which `pip install` takes
	rm -f target/wheels/sheetlight-*.whl
	$(WHEEL)/bin/maturin build --quiet --release --out target/wheels

test-wheel: wheel venv ## tests of the installed wheel: SHEETLIGHT_WHEEL_FULL=1 compares 50 samples of each recipe
	$(WHEEL)/bin/python -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps target/wheels/sheetlight-*.whl
	$(WHEEL)/bin/mypy -p sheetlight
	PYTHONPATH=$$($(VENV)/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))') $(WHEEL)/bin/python -m pytest -q -p no:cacheprovider tests/wheel

test-scale: wheel $(SCALE)/.ready $(MOTO)/.ready ## tests of clusters and buckets on this machine: SCALE_FULL=1 for 200 shards, large files and Slurm itself
	$(SCALE)/bin/uv pip install --quiet --python $(SCALE)/bin/python --no-deps --reinstall target/wheels/sheetlight-*.whl
	$(SCALE)/bin/python -m pytest -q -p no:cacheprovider tests/scale

test-formats: wheel $(FORMATS)/.ready ## tests of exports and recordings by the libraries that they are for
	$(FORMATS)/bin/uv pip install --quiet --python $(FORMATS)/bin/python --no-deps --reinstall target/wheels/sheetlight-*.whl
	OMP_WAIT_POLICY=passive $(FORMATS)/bin/python -m pytest -q -p no:cacheprovider tests/formats

lint: ## format, measures of the tree, clippy with warnings as errors, documentation with its links
	cargo fmt --all --check
	python3 tests/house.py check
	cargo clippy $(ALL) --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings --force-warn rustdoc::broken-intra-doc-links" cargo doc $(ALL) --no-deps 2> target/doc.log || { grep -A 9 '^error' target/doc.log; exit 1; }
	@! grep 'unresolved link to' -A 6 target/doc.log | grep -v -E 'link to `($(UNITS))`' | grep -A 6 'unresolved link to'

quick: ## the tests that take seconds alone
	cargo test $(FIRST_TESTS)

check: lint quick ## first tier: format, lints, documentation, and the tests that need neither Python nor a browser

prepare: ## what the second tier needs: environments of Python, and its tests compiled
	$(MAKE) --no-print-directory environments & made=$$!; cargo test $(ALL) --tests --no-run || { kill $$made; exit 1; }; wait $$made

environments: $(VENV)/.ready $(WHEEL)/.ready $(SCALE)/.ready $(MOTO)/.ready $(FORMATS)/.ready ## all environments of Python that tests use

# Much of the time of readers, browsers and clusters is waiting, so these run beside each other; what is killed, fills
# disks or counts memory has the machine for itself.
check-rest: prepare ## second tier: long tests, reference models, readers, training, browser, package, clusters, kills, memory
	$(MAKE) --no-print-directory -j3 test-long test-python test-installed
	$(MAKE) --no-print-directory test-alone

# What writes files of recipes anew is asked for by name alone.
test-long:
	cargo test $(FIRST_TESTS) -- --ignored --skip write_the_
	cargo test $(ALL) --doc
	cargo test $(ALL) --test reference --test tools --test figures --test ellipses

# Threads of PyTorch that wait must not spin: two cores have other work.
test-python: venv
	OMP_WAIT_POLICY=passive cargo test $(ALL) --test python -- --include-ignored

test-installed: venv
	$(MAKE) --no-print-directory test-wheel
	$(MAKE) --no-print-directory test-scale
	$(MAKE) --no-print-directory test-formats

test-alone:
	cargo test $(ALL) --test disk --test kill --test memory

check-all: check check-rest ## both tiers: what CI runs

defect-maps: ## masks of defects against maps on 220 boards of all kinds, rendered with and without (minutes)
	DEFECT_BOARDS=11 cargo test --release --locked --test optics defect_maps -- --nocapture

bench: ## profiles and photons a second, bytes and MB/s of writing
	cargo bench --locked

size: ## lines of code in production, by crate
	@python3 tests/house.py size

same-values: venv ## whether REF=<commit> and the working tree, each with its own recipes, draw and measure the same values
	tests/same_bytes.sh values $(REF)

same-bytes: ## whether REF=<commit> and the working tree write the same bytes: datasets, exports, reports, studies
	tests/same_bytes.sh compare $(REF)

wood: build ## full-size wood dataset of N samples (N=2) in out/wood
	$(GEN) --recipe recipes/wood.yaml --n $(N) --out out/wood

wood-small: build ## small wood dataset of 16 samples in out/wood-small
	$(GEN) --recipe recipes/wood-small.yaml --n 16 --out out/wood-small

blister: build ## full-size dataset of N blister packs (N=2) in out/blister
	$(GEN) --recipe recipes/blister.yaml --n $(N) --out out/blister

blister-small: build ## small dataset of 16 blister packs in out/blister-small
	$(GEN) --recipe recipes/blister-small.yaml --n 16 --out out/blister-small

sawtooth: build ## full-size dataset of N calibration pieces (N=2) in out/sawtooth
	$(GEN) --recipe recipes/sawtooth.yaml --n $(N) --out out/sawtooth

sawtooth-small: build ## small dataset of 16 saw-teeth in out/sawtooth-small
	$(GEN) --recipe recipes/sawtooth-small.yaml --n 16 --out out/sawtooth-small

mesh-small: build ## small dataset of 16 views of a part from a file in out/mesh-small
	$(GEN) --recipe recipes/mesh-small.yaml --n 16 --out out/mesh-small

preview: build ## picture of one sample: RECIPE=recipes/wood.yaml INDEX=0
	mkdir -p out
	$(GEN) preview --recipe $(RECIPE) --index $(INDEX) --out out/preview.png

validate: build ## check a dataset: DIR=out/wood-small
	$(GEN) validate $(DIR)

report: build ## a dataset as one page for people: DIR=out/wood-small
	$(GEN) report $(DIR)

bench-check: build venv ## gen check against a bare loop of onnxruntime: ratio with 31 and with 125 windows of each of 64 boards
	$(GEN) --recipe recipes/wood-train.yaml --n 64 --out out/bench
	$(VENV)/bin/python python/bench_onnx.py out/bench --gen $(GEN) --patches 2000 --pairs 11
	$(VENV)/bin/python python/bench_onnx.py out/bench --gen $(GEN) --patches 8000 --pairs 5

check-onnx: build venv ## the trained networks of tests/models on fresh data of another seed, held to their bars
	$(GEN) --recipe recipes/wood-train.yaml --n 400 --seed 5 --out out/fresh/wood
	$(GEN) --recipe recipes/blister-train.yaml --n 350 --seed 5 --out out/fresh/packs
	$(GEN) --recipe recipes/blister-small.yaml --n 400 --seed 5 --out out/fresh/blister-small
	$(GEN) check out/fresh/wood --model tests/models/wood_patches.onnx --split all --min-accuracy 0.94
	$(GEN) check out/fresh/packs --model tests/models/blister_presence.onnx --split all --min-accuracy 0.9
	$(GEN) check out/fresh/blister-small --model tests/models/blister_presence.onnx --split all --min-accuracy 0.98
	$(GEN) check out/fresh/packs --model tests/models/blister_pockets.onnx --split all --min-accuracy 0.98

baselines: check-onnx ## train all of docs/theory/baselines.md anew, controls and ablation too, in out/baselines: an hour
	mkdir -p out/baselines
	$(GEN) --recipe recipes/wood-train.yaml --n 6000 --seed 1 --out out/train/wood
	$(GEN) --recipe recipes/blister-train.yaml --n 900 --seed 1 --out out/train/packs
	$(TRAIN) out/train/wood --task wood --patches 80000 --epochs 20 --out out/baselines/wood_patches.onnx
	$(TRAIN) out/train/packs --task presence --epochs 60 --out out/baselines/blister_presence.onnx
	$(TRAIN) out/train/packs --task blister --epochs 25 --out out/baselines/blister_pockets.onnx
	$(GEN) --recipe recipes/wood-grading-train.yaml --n 1200 --seed 1 --out out/train/grading
	$(GEN) --recipe recipes/wood-grading-train.yaml --n 300 --seed 5 --out out/fresh/grading
	$(TRAIN) out/train/grading --task grading --patches 6000 --epochs 16 --out out/baselines/grading_patches.onnx
	$(TRAIN) out/train/wood --task wood --patches 3000 --epochs 6 --shuffle-labels --out out/baselines/wood_shuffled.onnx
	$(TRAIN) out/train/packs --task presence --epochs 8 --shuffle-labels --out out/baselines/blister_shuffled.onnx
	$(ABLATE) --task wood --train out/train/wood --fresh out/fresh/wood --patches 6000 --shuffles 10
	$(ABLATE) --task presence --train out/train/packs --fresh out/fresh/packs --seeds 1 --shuffles 10
	$(ABLATE) --task grading --train out/train/grading --fresh out/fresh/grading --patches 3000 --shuffles 5

real-fibres: ## every bar of docs/real.md on the photographs of REAL=folder with a truth.json; PART=open or sealed takes half of them
	REAL=$(abspath $(REAL)) PART=$(PART) cargo test --release --locked -p wood_picture --test pictures real_boards -- --ignored --nocapture

likeness: build venv ## how like the photographs of REAL=folder boards are, and what tells them apart (out/likeness): half an hour
	$(GEN) --recipe $(REAL_RECIPE) --n $(REAL_BOARDS) --seed 1 --out out/likeness/boards
	$(GEN) --recipe recipes/wood-grading.yaml --n 10 --seed 1 --set output.bin.columns=1 --set output.bin.profiles=1 --out out/likeness/plain
	$(VENV)/bin/python python/likeness.py --real $(REAL) --simulated out/likeness/boards --control out/likeness/plain --part $(OPEN_OR_SEALED) --out out/likeness

transfer: build venv ## how well finders of knots that learned from boards of ours do on photographs of REAL=folder (out/transfer): half an hour
	$(GEN) --recipe $(REAL_RECIPE) --n $(REAL_BOARDS) --seed 2 --out out/transfer/boards
	$(VENV)/bin/python python/transfer.py --real $(REAL) --simulated out/transfer/boards --part $(OPEN_OR_SEALED) --out out/transfer

gap: build venv ## what networks lose from the kernel to the reference Monte Carlo, on boards and packs in out/gap: an hour; goes on where it was stopped
	$(GEN) --recipe recipes/gap/wood.yaml --n 2000 --seed 1 --out out/gap/wood/train
	$(GEN) --recipe recipes/gap/wood.yaml --n $(GAP_BOARDS) $(GAP_FRESH) --out out/gap/wood/kernel
	$(GEN) --recipe recipes/gap/wood.yaml --n $(GAP_BOARDS) $(GAP_FRESH) $(GAP_QUIET) --out out/gap/wood/quiet
	$(GEN) --recipe recipes/gap/wood.yaml --n $(GAP_BOARDS) $(GAP_FRESH) --set transport=thesis --out out/gap/wood/thesis
	$(GEN) --recipe recipes/gap/wood.yaml --n $(GAP_BOARDS) $(GAP_FRESH) $(call GAP_PATH,$(GAP_BOARD_PHOTONS)) --out out/gap/wood/path
	$(GEN) --recipe recipes/gap/wood.yaml --n $(GAP_BOARDS) $(GAP_FRESH) $(call GAP_PATH,$$(($(GAP_BOARD_PHOTONS) / 8))) --out out/gap/wood/fewer
	$(GEN) --recipe recipes/gap/blister.yaml --n 4000 --seed 1 --out out/gap/packs/train
	$(GEN) --recipe recipes/gap/blister.yaml --n $(GAP_PACKS) $(GAP_FRESH) --out out/gap/packs/kernel
	$(GEN) --recipe recipes/gap/blister.yaml --n $(GAP_PACKS) $(GAP_FRESH) $(GAP_QUIET) --out out/gap/packs/quiet
	$(GEN) --recipe recipes/gap/blister.yaml --n $(GAP_PACKS) $(GAP_FRESH) $(call GAP_PATH,$(GAP_PACK_PHOTONS)) --out out/gap/packs/path
	$(GEN) --recipe recipes/gap/blister.yaml --n $(GAP_PACKS) $(GAP_FRESH) $(call GAP_PATH,$$(($(GAP_PACK_PHOTONS) / 8))) --out out/gap/packs/fewer
	$(GAP) --task wood $(foreach set,train kernel path fewer quiet,--$(set) out/gap/wood/$(set)) --control out/gap/wood/thesis
	$(GAP) --task presence --epochs 25 $(foreach set,train kernel path fewer quiet,--$(set) out/gap/packs/$(set))

closed-loop: build venv ## 20 fits to scans whose keys are known: how often 90 % intervals hold the truth (out/closed-loop, 20 minutes)
	$(VENV)/bin/python python/closed_loop.py out/closed-loop --first 84 --loops 20

measure-loop: build venv ## 20 boards with hidden coefficients, measured by six scans each (out/measure-loop, 25 minutes)
	$(VENV)/bin/python python/closed_loop.py out/measure-loop --recipe recipes/fit/wood.yaml --classes plate,along,across,steep,along,across --simulations 500 --first 20

cover-loop: build venv ## 20 scans with a key outside of a recipe's spread, 20 with none: what `gen cover` says (out/cover-loop, 10 minutes)
	$(VENV)/bin/python python/cover_loop.py out/cover-loop --loops 20

unlike-rigs: build venv ## networks of first recipes on rigs unlike theirs: an hour, out/unlike
	$(VENV)/bin/python python/unlike_rigs.py out/unlike --task knots
	$(VENV)/bin/python python/unlike_rigs.py out/unlike --task packs

gallery: build venv ## 40 boards, every defect and six kinds of wood, with their labels, as docs/theory/gallery.md shows them: a minute
	$(GEN) --recipe recipes/wood-grading-train.yaml --n 51 --seed 4 --out out/gallery/grading
	for wood in pine larch beech birch oak; do $(GEN) --recipe recipes/species/$$wood.yaml --n 2 --seed 4 --out out/gallery/$$wood || exit 1; done
	$(VENV)/bin/python python/gallery.py out/gallery/grading --boards 15 --out docs/pictures/gallery-1.jpg
	$(VENV)/bin/python python/gallery.py out/gallery/grading --boards 15 --skip 15 --out docs/pictures/gallery-2.jpg
	$(VENV)/bin/python python/gallery.py $(addprefix out/gallery/,pine larch beech birch oak) --boards 10 --out docs/pictures/gallery-3.jpg

schema: build ## JSON Schemas of recipes and datasets in out/
	mkdir -p out
	$(GEN) schema recipe > out/recipe.schema.json
	$(GEN) schema dataset > out/dataset.schema.json

kernel-table: ## measure the kernel's table anew: three quarters of an hour on two cores; goes on in out/kernel_measurements.jsonl
	mkdir -p out
	cargo run --release --locked --example kernel_table -- out/kernel_measurements.jsonl crates/transport/src/kernel/table.bin

film-table: ## measure the table of films anew: some six minutes on two cores
	cargo run --release --locked --example film_table -- crates/transport/src/kernel/film_stack/film.bin

bless: build ## renew committed references (recipe schema and key reference, data dictionary, table and texts of faults, Python's commands)
	BLESS=1 cargo test $(ALL) --test recipe_schema --test dictionary
	BLESS=1 cargo test $(ALL) --test validate -- docs:: texts::
	python3 python/make_commands.py $(GEN)

reference: ## ask the reference Monte Carlo anew for what tests/data/reference keeps: half an hour on two cores
	BLESS=1 cargo test $(ALL) --test reference

fresh-draws: ## the kernel against the reference on media of a seed that nobody has seen (SEED=n for a certain one): ten minutes
	cargo test $(ALL) --test reference -- --ignored --nocapture fresh_draws

fuzz: ## feed the recipe loader random text (FUZZ_SECONDS=600); needs cargo-fuzz
	mkdir -p fuzz/corpus/recipe
	RUSTC_BOOTSTRAP=1 cargo fuzz run recipe fuzz/corpus/recipe fuzz/seeds/recipe -- -max_total_time=$(FUZZ_SECONDS) -dict=fuzz/recipe.dict

site: $(SITE)/.ready ## the pages as a searchable site in out/site; fails where a link leads nowhere
	python3 python/make_site.py
	$(SITE)/bin/zensical build --clean --strict

doc: ## Rust documentation in target/doc
	cargo doc $(ALL) --no-deps

clean: ## remove build products and out/
	cargo clean
	rm -rf out .cache $(VENV) $(WHEEL) $(SCALE) $(MOTO) $(FORMATS) $(SITE) $(RELEASE)
