# Everything from a bare Debian: `make demo` and `make check` install what they need, build, and run.

# One list of the Debian packages: to build, to run, and to test. From Debian 13 on ParaView has Qt 6 and asks for Python's
# development files, after it for those of VTK, too.
PACKAGES = \
  g++ cmake ninja-build \
  $(PACKAGES_PARAVIEW_$(PARAVIEW)) libopenmpi-dev libx11-dev libglew-dev libfreetype-dev \
  libembree-dev libtbb-dev libhwy-dev \
  openmpi-bin libgl1-mesa-dri xvfb xauth \
  libgtest-dev libp4est-dev imagemagick valgrind python3-numpy python3-matplotlib
RELEASE = $(shell . /etc/os-release && echo $$VERSION_CODENAME)
PACKAGES_PARAVIEW_ON = paraview-dev python3-paraview paraview $(or $(PACKAGES_$(RELEASE)),$(PACKAGES_later))
PACKAGES_bookworm = libqt5svg5
PACKAGES_trixie = qt6-svg-plugins libpython3-dev
PACKAGES_later = $(PACKAGES_trixie) libvtk9-dev
# PARAVIEW=OFF: with plain VTK, without the plugin.
PARAVIEW = ON
PACKAGES_PARAVIEW_OFF = libvtk9-dev python3-vtk9 libpython3-dev

PREFIX = /usr/local
BUILD = build
SUDO = $(if $(filter-out 0,$(shell id -u)),sudo)
# Without -noreset the X server may reset itself between two clients.
XVFB = xvfb-run --auto-servernum --server-args="-screen 0 1600x1200x24 -noreset"
PYTHON = /usr/bin/python3 # which has Debian's packages

.PHONY: build configure setup demo docs gallery check check-debian check-sanitizers check-sanitizers-whole fuzz bench bench-vs bench-ranks bench-pieces compare-frames report report-brief package install clean

build: configure
	cmake --build $(BUILD)

configure: setup
	cmake --preset release -DTREEAMR_BUILD_PARAVIEW_PLUGIN=$(PARAVIEW)

# Does nothing, and asks for no rights, when every package is there.
setup:
	@missing=; \
	for package in $(PACKAGES); do \
	  dpkg-query --show --showformat='$${db:Status-Status}' $$package 2>/dev/null | grep -qx installed \
	    || missing="$$missing $$package"; \
	done; \
	if [ -n "$$missing" ]; then \
	  echo "Installing$$missing"; \
	  $(SUDO) apt-get update && \
	  $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $$missing; \
	fi

demo: configure
	cmake --build $(BUILD) --target demo
	mkdir -p $(BUILD)/demo
	$(BUILD)/bin/treeamr-demo-forest $(BUILD)/demo/mandelbulb.p8est
	. $(BUILD)/env.sh && $(XVFB) pvpython --force-offscreen-rendering Testing/Demo/demo.py $(BUILD)/demo/mandelbulb.p8est
	@echo "Pictures are in $(BUILD)/demo. Next, for the same in ParaView (Apply, then Tree AMR Volume instead of Surface):"
	@echo "  . $(BUILD)/env.sh && paraview $(BUILD)/demo/mandelbulb.p8est"

# API pages of the public headers in build/docs/html; what is not documented is an error.
docs: PACKAGES += doxygen
docs: configure
	cmake --build $(BUILD) --target docs

# The pictures of Documentation/gallery.md, and a page of them.
gallery: configure
	cmake --build $(BUILD) --target product
	. $(BUILD)/env.sh && $(XVFB) $(PYTHON) Testing/Plugin/TestGallery.py pvpython $(BUILD)/gallery

# CTEST_FLAGS="-R NAME" runs some of the tests, "-E NAME" all but some.
check: build
	$(XVFB) ctest --test-dir $(BUILD) --parallel 2 --output-on-failure --no-tests=error $(CTEST_FLAGS)

# All of it in a fresh root of another Debian: `make check-debian RELEASE=trixie`, bookworm or sid, for the night. ROOTS has
# them afterwards.
ROOTS = /var/tmp/treeamr-roots
check-debian:
	$(SUDO) Testing/Install/check-debian.sh $(RELEASE) $(ROOTS) PARAVIEW=$(PARAVIEW)

check-sanitizers: setup
	for sanitizer in asan tsan; do \
	  cmake --preset $$sanitizer $(if $(WHOLE),-D TREEAMR_LEFT_OUT_TESTS=) && \
	  cmake --build --preset $$sanitizer && \
	  ! ctest --preset $$sanitizer$(WHOLE) --show-only 2>&1 | grep "Error in compile" && \
	  $(XVFB) ctest --preset $$sanitizer$(WHOLE) || exit; \
	done

# Takes much longer: also what repeats others' code on more numbers, and under tsan what has one thread.
check-sanitizers-whole: WHOLE = -whole
check-sanitizers-whole: check-sanitizers

# An hour for each target, two at a time; longer or shorter by SECONDS. What is found is in build-fuzz/.
SECONDS = 3600
FUZZERS = ForestFuzz DealIIFuzz QuadrantArrayFuzz TextFuzz HexahedraFuzz
fuzz: PACKAGES += clang libclang-rt-dev
fuzz: setup
	cmake --preset fuzz && cmake --build --preset fuzz
	echo $(FUZZERS) | xargs -n 1 -P 2 sh -c 'export TMPDIR=/dev/shm && mkdir -p build-fuzz/corpus/$$0 && \
	  build-fuzz/bin/$$0 -max_total_time=$(SECONDS) -max_len=16384 -timeout=20 -rss_limit_mb=2048 -print_final_stats=1 \
	  -artifact_prefix=build-fuzz/$$0- build-fuzz/corpus/$$0 Testing/Data/Fuzz/$$0 > build-fuzz/$$0.log 2>&1 \
	  || { tail -40 build-fuzz/$$0.log; exit 255; }'
	tail -n 8 $(FUZZERS:%=build-fuzz/%.log)

# Forests and converged pictures are made once: `make clean` takes them away.
BENCH = $(BUILD)/bench
FORESTS = mandelbulb-0.3M mandelbulb-2.6M mandelbulb-20M sheet-23M
bench: build $(FORESTS:%=$(BENCH)/%.p8est)
	$(BUILD)/bin/treeamr-benchmark $(BENCH) --json $(BENCH)/bench.json
	$(BUILD)/bin/treeamr-benchmark $(BENCH) --only procedural-200M

$(BENCH)/mandelbulb-0.3M.p8est: REFINEMENT = 4 7 0.05
$(BENCH)/mandelbulb-2.6M.p8est: REFINEMENT = 4 9 0.55
$(BENCH)/mandelbulb-20M.p8est: REFINEMENT = 4 10 0.40
$(BENCH)/sheet-23M.p8est: REFINEMENT = 4 10 0.035 sheet
$(BENCH)/sphere-0.3M.p8est: REFINEMENT = 3 6 0.05 sphere 2
$(BENCH)/mandelbulb-2.6M-8.p8est: REFINEMENT = 3 8 0.55 mandelbulb 2
$(BENCH)/%.p8est: | build
	mkdir -p $(BENCH)
	$(BUILD)/bin/treeamr-demo-forest $@.part $(REFINEMENT)
	mv $@.part $@

# The same pictures and isosurfaces by ParaView's own routes, twenty minutes on two cores.
PEER_FORESTS = sphere-0.3M mandelbulb-2.6M-8
bench-vs: bench $(PEER_FORESTS:%=$(BENCH)/%.p8est)
	. $(BUILD)/env.sh && $(XVFB) python3 Testing/Benchmark/peers.py $(BENCH)

# What 1 to 8 ranks of pvbatch hold, and how far their pictures are from one's, half an hour on two cores.
bench-ranks: build $(BENCH)/mandelbulb-2.6M.p8est $(BENCH)/mandelbulb-20M.p8est
	. $(BUILD)/env.sh && $(XVFB) python3 Testing/Benchmark/ranks.py $(BENCH)

# What processes hold and read of the forests' files, for Documentation/parallel.md: a few minutes.
bench-pieces: build $(BENCH)/mandelbulb-2.6M.p8est $(BENCH)/mandelbulb-20M.p8est
	for forest in 2.6M 20M; do \
	  $(BUILD)/bin/treeamr-pieces $(BENCH)/mandelbulb-$$forest.p8est 1 2 3 4 8 16 64 256 1024 4096 || exit; \
	done

# What must not change a picture has not: the frames of this build beside those of OTHER, a build of another commit,
# equal to the bit or by TOLERANCE a channel at most. A few minutes.
TOLERANCE = 0
compare-frames: build $(FORESTS:%=$(BENCH)/%.p8est)
	$(OTHER)/bin/treeamr-frames write $(BENCH)/frames-other $(BENCH)
	$(BUILD)/bin/treeamr-frames write $(BENCH)/frames $(BENCH)
	$(BUILD)/bin/treeamr-frames compare $(BENCH)/frames $(BENCH)/frames-other $(TOLERANCE)

# Error against run time, stiff and extreme cases, ParaView's routes: all measured afresh, under an hour on two cores.
REPORT = $(BUILD)/report
CASES = StiffCasesTest ExtremeCasesTest ExtremeViewsTest ExtremeWindowsTest FaultsTest AllocationFailureTest
# Failed cases are rows of the report, not its end.
MEASURE_CASES = $(foreach test,$(CASES),$(XVFB) $(BUILD)/bin/$(test) --gtest_output=json:$(REPORT)/tests/$(test).json \
  > $(REPORT)/tests/$(test).log || cat $(REPORT)/tests/$(test).log;) \
  $(PYTHON) Testing/Report/instructions.py $(BUILD)/bin/treeamr-frame $(REPORT)/instructions.json
report: build $(FORESTS:%=$(BENCH)/%.p8est) $(PEER_FORESTS:%=$(BENCH)/%.p8est)
	rm -rf $(REPORT) && mkdir -p $(REPORT)/tests
	$(BUILD)/bin/treeamr-report $(BENCH) --json $(REPORT)/measured.json
	. $(BUILD)/env.sh && $(XVFB) sh -c '\
	  measure="python3 Testing/Benchmark/peers.py $(BENCH) --timeout 150 --json $(REPORT)/peers.json"; \
	  $$measure --part volume --datasets mandelbulb-0.3M; \
	  $$measure --part volume --datasets mandelbulb-2.6M --routes treeamr projected-tetra resample-256; \
	  $$measure --part isosurface --timeout 300; \
	  pvpython --force-offscreen-rendering Testing/Benchmark/function_peers.py $(REPORT)/peers.json'
	$(MEASURE_CASES)
	. $(BUILD)/env.sh && $(XVFB) pvpython --force-offscreen-rendering Testing/Plugin/TestSoak.py \
	  $(BENCH)/mandelbulb-0.3M.p8est 1000 > $(REPORT)/soak.log && tail -1 $(REPORT)/soak.log > $(REPORT)/soak.json
	$(PYTHON) Testing/Report/report.py $(REPORT)

# A few minutes of it, without a figure that depends on time: fails where one is missing or out of its bounds.
report-brief: build $(BENCH)/mandelbulb-0.3M.p8est
	rm -rf $(REPORT) && mkdir -p $(REPORT)/tests
	$(BUILD)/bin/treeamr-report $(BENCH) --brief --json $(REPORT)/measured.json > $(REPORT)/measured.log
	$(MEASURE_CASES)
	$(PYTHON) Testing/Report/report.py $(REPORT) --check

# Debian packages in build-package/: treeamr (plugin and Python package) and treeamr-dev (for C++ programs).
package: PACKAGES += dpkg-dev
package: setup
	cmake --preset package && cmake --build --preset package && cd build-package && cpack

install: configure
	cmake --build $(BUILD) --target product
	cmake --install $(BUILD) --prefix $(PREFIX)

clean:
	rm -rf build build-*
