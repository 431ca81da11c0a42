# SPDX-License-Identifier: Apache-2.0
# Every job is one word; `make help` lists them. Objects of each flavour (release, asan, tsan) live in their own folder.
TOOLCHAIN ?= toolchain/host.mk
include $(TOOLCHAIN)
.DEFAULT_GOAL := all

BUILD ?= build/host
# -g1: lines for debuggers, a tenth of the compiler's time. In a BUILD folder of its own, as precompiled headers want the
# same options from all who use them.
DEBUG ?= -g0
OPT ?= -O2 $(DEBUG)
# Tests are not what we measure: to optimise most of them takes longer than to run them.
TEST_OPT ?= -O1 $(DEBUG)
LIGHT_TEST_OPT ?= -O0 $(DEBUG)
SANITIZE ?=
# What the fuzzers need to find their way, for the readers of outside data alone: it is slow.
COVERAGE ?=
# `lib`, `tests` or both: these are compiled by two dozen, which takes less than half the time from nothing and more after a change.
GROUPED ?=
CCACHE := $(shell command -v ccache 2>/dev/null)
# ccache refuses precompiled headers unless told that their time stamps may be trusted.
export CCACHE_SLOPPINESS ?= pch_defines,time_macros

WARN_BASE := -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror
WARN := $(WARN_BASE)
# g++ 12 sees overlapping copies in std::string that are none (GCC bug 105651), and the like in {fmt}.
# clang dislikes `|` between conditions, which keeps loops free of branches.
WARN += $(if $(findstring clang,$(CXX)),-Wno-bitwise-instead-of-logical -Wno-bitwise-conditional-parentheses,-Wno-restrict -Wno-stringop-overflow)
# -ffp-contract=off: a fused multiply-add rounds differently, and twins must agree to the last bit.
FLAGS = -std=c++20 $(TARGET) $(OPT) $(WARN) -I. -pthread -ffp-contract=off -fno-math-errno -fno-trapping-math $(SANITIZE) $(COVERED)
# Members of a group are no headers, though they are included; and g++ 12 sees more that is none (bug 105651). What one
# has in its file is no business of another's names: `make` compiles file by file and looks at that.
WARN += $(if $(GROUPED),-Wno-shadow $(if $(findstring clang,$(CXX)),,-Wno-subobject-linkage -Wno-array-bounds))
# g++ tidies up its memory again and again as it grows. The compiler of a group may have a gigabyte before it does.
FLAGS += $(if $(GROUPED),$(if $(findstring clang,$(CXX)),,--param ggc-min-heapsize=1000000))
DEPFLAGS = -MMD -MP -MF $(@:.o=.d)
# Debian has no static archive of these; scripts/setup builds them. A build without libmosquitto has no way to a broker,
# one without OpenNI2 and libusb knows no Kinect; both say so. A toolchain for another machine says in STATIC_LIBS_ENV
# what scripts/static_libs is to compile with.
STATIC_LIBS ?= $(STATIC_LIBS_ENV) scripts/static_libs
static_lib = $(shell $(STATIC_LIBS) where $(1))
MOSQUITTO := $(call static_lib,mosquitto)
LIBUSB := $(call static_lib,libusb)
OPENNI := $(call static_lib,openni2)
MOSQUITTO_LIB := $(wildcard $(MOSQUITTO)/libmosquitto.a)
OPENNI_LIB := $(if $(wildcard $(LIBUSB)/libusb-1.0.a),$(wildcard $(OPENNI)/libopenni2.a))
MQTT_PICK := hal/mqtt/pick/$(if $(MOSQUITTO_LIB),mosquitto,absent).cpp
KINECT_PICK := $(if $(OPENNI_LIB),$(wildcard hal/kinect/openni/*.cpp hal/kinect/usb/*.cpp),$(wildcard hal/kinect/pick/absent.cpp))
LIBS := $(MOSQUITTO_LIB) $(if $(OPENNI_LIB),$(OPENNI_LIB) $(LIBUSB)/libusb-1.0.a) -lgpiod -lpng -ljpeg -lzstd -lsodium -lz
TEST_LIBS := -loctomap -loctomath

KERNEL_SRC := $(wildcard mapper/cpu/kernels/*.cpp)
ROOMS := $(wildcard board hal mapper nav net)
HELPER_SRC := $(wildcard mapper/cuda/helper/*.cpp)
LIB_SRC := $(filter-out $(KERNEL_SRC) mapper/cpu/pick/% hal/mqtt/pick/% hal/kinect/openni/% hal/kinect/usb/% \
  hal/kinect/pick/% $(HELPER_SRC),$(shell find $(ROOMS) -name '*.cpp' | sort)) $(KERNEL_PICK) $(MQTT_PICK) $(KINECT_PICK)
MAIN_SRC := $(wildcard main*.cpp)
UNIT_SRC := $(filter-out $(NOT_TESTED) $(if $(OPENNI_LIB),,tests/hal/kinect/openni/%),$(filter $(or $(TESTED),%),\
  $(shell find tests -name '*_test.cpp' -not -path 'tests/system/*' -not -path 'tests/emulated/*' | sort)))
SYSTEM_SRC := $(sort $(wildcard tests/system/*_test.cpp))
# Under the thread sanitizer only what starts threads is worth its time.
THREAD_SRC := $(shell grep -l '\[threads\]' $(UNIT_SRC) /dev/null)
EMULATED_SRC := $(sort $(wildcard tests/emulated/*.cpp))
SUPPORT_SRC := $(wildcard tests/support/*.cpp)
FUZZ_SRC := $(sort $(wildcard tests/fuzz/*_fuzz.cpp))
BENCH_SRC := $(sort $(wildcard tests/bench/*_bench.cpp))

# `make V=1` shows whole commands.
Q := $(if $(V),,@)
SAY := @$(if $(V),true,echo)

comma := ,
objects = $(1:%.cpp=$(BUILD)/%.o)
# $(call grouped,KIND,NAME,SOURCES): their objects, or those of groups of two dozen. NAME-N stands for the Nth last source
# and those after it; what is in a group is in members_NAME-N.
groups = $(if $(2),$(call group,$(1)-$(words $(2)),$(wordlist 1,24,$(2))) $(call groups,$(1),$(wordlist 25,9999,$(2))))
group = $(BUILD)/groups/$(1).o$(eval members_$(1) := $(2))
grouped = $(if $(filter $(1),$(GROUPED)),$(call groups,$(2),$(3)),$(call objects,$(3)))

# Sources that have options of their own.
OWN_SRC := mapper/version.cpp mapper/cuda/carried.cpp $(MQTT_PICK) $(KINECT_PICK)
# Where the time of a frame goes, the last optimisation counts.
HOT_SRC := $(filter hal/kinect/depth_table.cpp hal/kinect/depth_registration.cpp mapper/cpu/% mapper/cuda/mirror.cpp hal/sim/% nav/astar.cpp nav/distance_field.cpp nav/inflation.cpp \
  nav/column_evidence.cpp net/block_wire.cpp net/range_coder.cpp,$(LIB_SRC))
# Readers of outside data.
READER_SRC := $(filter $(addprefix hal/boot/,init_config.cpp link_local.cpp mdns_answer.cpp robot_health.cpp) board/% hal/image/% hal/replay/% mapper/files/% \
  $(addprefix net/,block_plain.cpp block_wire.cpp broker_options.cpp datagram_batch.cpp datagram_gate.cpp \
    datagram_seal.cpp fleet_key_file.cpp gossip.cpp handshake_message.cpp journal_entry.cpp journal_frame.cpp \
    journal_restore.cpp layer_identity.cpp range_coder.cpp reconcile_message.cpp reconciler.cpp robot_status.cpp \
    set_sketch_wire.cpp signing_key.cpp site_topics.cpp sync_message.cpp update_intake.cpp update_manifest.cpp update_wire.cpp \
    wire_parts.cpp) hal/boot/slot_record.cpp \
  hal/sim/text_fields.cpp hal/sim/world_file.cpp hal/sim/map_world.cpp hal/sim/camera_path.cpp \
  $(addprefix hal/can/,candump.cpp canopen.cpp estop_node.cpp) \
  $(addprefix hal/,record/packed_image.cpp stream/frame_message.cpp stream/frame_reader.cpp) \
  $(addprefix hal/kinect/,calibration.cpp depth_code.cpp oni_check.cpp oni_records.cpp tilt_unit.cpp) \
  $(addprefix hal/kobuki/,command.cpp feedback_codec.cpp frame_scanner.cpp odometry.cpp packet_gates.cpp packet_reader.cpp),$(LIB_SRC))
READER_SRC := $(if $(COVERAGE),$(READER_SRC))
HOT_SRC := $(if $(filter -O2,$(OPT)),$(filter-out $(READER_SRC),$(HOT_SRC)))
READER_OBJ := $(call grouped,lib,reader,$(READER_SRC))
HOT_OBJ := $(call grouped,lib,hot,$(HOT_SRC))
PLAIN_OBJ := $(call grouped,lib,plain,$(filter-out $(HOT_SRC) $(READER_SRC) $(OWN_SRC),$(LIB_SRC)))
KERNEL_OBJ := $(foreach v,$(KERNEL_VARIANTS),$(KERNEL_SRC:%.cpp=$(BUILD)/%.$(v).o))
MAIN_ALONE := main.cpp
MAIN_OBJ := $(call objects,$(MAIN_ALONE)) $(call grouped,lib,main,$(filter-out $(MAIN_ALONE),$(MAIN_SRC)))
LIB_OBJ := $(PLAIN_OBJ) $(HOT_OBJ) $(READER_OBJ) $(call objects,$(OWN_SRC)) $(KERNEL_OBJ)

# Tests that compute much themselves, or have to answer in time. All others are light.
COMPUTING_TESTS := $(addprefix tests/,net/block_wire_% net/gossip_% net/set_sketch_% hal/kinect/% hal/kobuki/% hal/linux/% hal/sim/% mapper/cpu/% mapper/cuda/% mapper/files/% \
  $(addprefix mapper/,align/normal_equations_% column_bits_% mapper_% merge_% pipeline_% ray_walk_% rgbo_% rolling_window_% windowed_blocks_%) \
  $(addprefix nav/,astar_% distance_field_% explorer_% floor_steps_% follower_% frontier_% goal_pursuit_% ground_map_% \
    inflation_% navigator_% outputs_% robot_% viewpoints_%))
# A test of something that stands in headers alone is compiled with it, as the library is. Any other test finds what it
# tests in the library: under the address sanitizer its objects are those of the release build (TESTS_FROM).
TESTS_FROM ?= $(BUILD)
HEADER_TESTS := $(foreach t,$(UNIT_SRC),$(if $(wildcard $(t:tests/%_test.cpp=%.cpp)),,$(t)))
SOURCE_TESTS := $(filter-out $(HEADER_TESTS),$(UNIT_SRC))
HEADER_LIGHT_OBJ := $(call grouped,tests,light-header,$(filter-out $(COMPUTING_TESTS),$(HEADER_TESTS)))
HEADER_OTHER_OBJ := $(call grouped,tests,unit-header,$(filter $(COMPUTING_TESTS),$(HEADER_TESTS)))
SOURCE_LIGHT_OBJ := $(call grouped,tests,light,$(filter-out $(COMPUTING_TESTS),$(SOURCE_TESTS)))
SOURCE_OTHER_OBJ := $(call grouped,tests,unit,$(filter $(COMPUTING_TESTS),$(SOURCE_TESTS)))
LIGHT_UNIT_OBJ := $(HEADER_LIGHT_OBJ) $(SOURCE_LIGHT_OBJ)
OTHER_UNIT_OBJ := $(HEADER_OTHER_OBJ) $(SOURCE_OTHER_OBJ)
THREAD_OBJ := $(call grouped,tests,thread,$(THREAD_SRC))
# A malloc of one's own is no part of a group.
OWN_MALLOC_SRC := $(filter %allocation_test.cpp,$(SYSTEM_SRC))
SYSTEM_OBJ := $(call objects,$(OWN_MALLOC_SRC)) $(call grouped,tests,system,$(filter-out $(OWN_MALLOC_SRC),$(SYSTEM_SRC)))
EMULATED_OBJ := $(call objects,$(EMULATED_SRC))
SUPPORT_OBJ := $(call grouped,tests,support,$(SUPPORT_SRC))
# Catch2's own code is neither measured nor under suspicion: compiled once, for all flavours.
RUNNER_OBJ ?= build/runner/main.o
RUNNER_CXX ?= g++
SUPPORT := $(BUILD)/libsupport.a
BORROWED := $(patsubst $(BUILD)/%,$(TESTS_FROM)/%,$(SOURCE_LIGHT_OBJ) $(SOURCE_OTHER_OBJ) $(SUPPORT))
BENCH_EXE := $(BENCH_SRC:tests/bench/%.cpp=$(BUILD)/bench/%)
FUZZ_OBJ := $(call grouped,tests,fuzz,$(FUZZ_SRC))
FUZZ_EXE := $(FUZZ_SRC:tests/fuzz/%.cpp=$(BUILD)/fuzz/%)
EXE := $(BUILD)/g3dmap
LIB := $(BUILD)/libg3dmap.a
PCH := $(BUILD)/tests/precompiled.hpp
COMMON := $(BUILD)/toolchain/common_headers.hpp

# What the executable carries for NVIDIA cards (no toolkit is needed, but clang): kernels as PTX for every card since the
# TX2's, and the helper program that loads the driver. A build without clang carries no kernels and maps on the CPU.
PTX := $(BUILD)/kernels.ptx
HELPER := $(BUILD)/g3dmap-helper
PTX_CLANG ?= $(shell command -v clang++)
PTX_FLAGS := -x cuda --cuda-device-only --cuda-gpu-arch=sm_62 --cuda-path=/nonexistent -nocudainc -nocudalib -std=c++20 -O3 \
  -ffp-contract=off -fms-extensions -mllvm -inline-threshold=100000 -Xclang -target-feature -Xclang +ptx63 -I. -S
$(PTX): mapper/cuda/kernels.cu
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(if $(PTX_CLANG),$(PTX_CLANG) $(PTX_FLAGS) -MMD -MP -MT $@ -MF $@.d -o $@ $<,: >$@)
# The helper meets the C library of the robot, down to the TX2's 2.27. So it is linked against libraries that have nothing
# but these names, under the version that they have had from the start: what is newer does not link. Its start code gives
# __libc_start_main no function that runs constructors, so it must have none (a test looks).
OLD_LIBC := $(BUILD)/old_libc
LIBC_CALLS := __libc_start_main abort __cxa_finalize syscall mmap lseek getppid nanosleep sleep memcpy memset
LIBDL_CALLS := dlopen dlsym
LIBC_VERSION = $(if $(filter aarch64%,$(shell $(CXX) -dumpmachine)),GLIBC_2.17,GLIBC_2.2.5)
$(OLD_LIBC)/libc.so.6: CALLS := $(LIBC_CALLS)
$(OLD_LIBC)/libdl.so.2: CALLS := $(LIBDL_CALLS)
$(OLD_LIBC)/libc.so.6 $(OLD_LIBC)/libdl.so.2: Makefile
	@mkdir -p $(@D)
	@echo '$(LIBC_VERSION) { *; };' >$@.map
	@printf 'extern "C" void %s() {}\n' $(CALLS) | \
	  $(CXX) -x c++ - -fno-builtin -nostdlib -shared -fPIC -Wl,-soname,$(@F) -Wl,--version-script=$@.map -o $@
$(HELPER): $(OLD_LIBC)/libc.so.6 $(OLD_LIBC)/libdl.so.2
$(HELPER): $(HELPER_SRC) $(wildcard mapper/cuda/helper/*.hpp) mapper/cuda/helper_protocol.hpp \
  mapper/cuda/memory.hpp mapper/cuda/frame_params.hpp mapper/cuda/align_memory.hpp $(wildcard mapper/align/*.hpp)
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CXX) -std=c++20 $(TARGET) -O2 $(WARN) -I. -fno-exceptions -fno-rtti -s -nodefaultlibs -o $@ $(HELPER_SRC) \
	  -Wl,--no-as-needed $(OLD_LIBC)/libdl.so.2 $(OLD_LIBC)/libc.so.6
$(BUILD)/mapper/cuda/carried.o: $(PTX) $(HELPER)
$(BUILD)/mapper/cuda/carried.o: private FLAGS += -DG3D_HELPER_FILE='"$(abspath $(HELPER))"' -DG3D_KERNELS_FILE='"$(abspath $(PTX))"'

# One instrumented build serves address sanitizer, undefined-behaviour sanitizer and fuzzing; it is also the second compiler.
# What tests a source file is not instrumented itself, but for ASAN_TESTS=build/asan (the soak does so): it takes minutes.
ASAN_TESTS ?= build/host
ASAN := BUILD=build/asan TESTS_FROM=$(ASAN_TESTS) CXX=clang++ STATIC= OPT="-O1 -g1" \
  SANITIZE="-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer" COVERAGE=-fsanitize=fuzzer-no-link \
  GROUPED="lib tests"
# What g++ has to say it has said of the release build.
TSAN := BUILD=build/tsan STATIC= WARN=-w OPT="-O1 -g1" TEST_OPT="-O0 -g1" SANITIZE="-fsanitize=thread" GROUPED="lib tests"
ASAN_ENV := ASAN_OPTIONS=halt_on_error=1:detect_leaks=1:allocator_may_return_null=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
TSAN_ENV := TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$(abspath tests/support/tsan_suppressions.txt)
FUZZ_RUNS ?= 5000
TEST_ARGS ?=
BENCH_ARGS ?=

.PHONY: all help unit-tests system-tests test asan tsan fuzz bench bench-full bench-explore soak format lint tidy house clean \
  build-test build-asan build-tsan fuzz-here tsan-tests tsan-run
.DELETE_ON_ERROR:
.SECONDARY:
all: $(EXE) ## the program: build/host/g3dmap, one static executable

help: ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' Makefile

$(EXE): $(MAIN_OBJ) $(LIB)
	$(SAY) $@$(if $(MOSQUITTO_LIB),, '- without a way to a broker: no libmosquitto (see scripts/static_libs)')$(if \
	  $(OPENNI_LIB),, '- without Kinect and .oni files: no OpenNI2 (see scripts/static_libs)')
	$(Q)$(CXX) $(FLAGS) $(STATIC) -o $@ $^ $(LIBS)

$(LIB): $(LIB_OBJ)
$(SUPPORT): $(SUPPORT_OBJ)
$(LIB) $(SUPPORT):
	@rm -f $@
	@$(AR) rcs $@ $^

# A driver without a card, for tests of the helper process.
FAKE_CUDA := $(BUILD)/fake_cuda/libcuda.so.1
$(FAKE_CUDA): tests/fake_cuda/libcuda.cpp $(wildcard mapper/cuda/*.hpp mapper/cuda/kernels/*.hpp mapper/cuda/helper/*.hpp)
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CXX) -std=c++20 $(TARGET) -O2 $(WARN) -I. -ffp-contract=off -fPIC -shared -o $@ $<

$(BUILD)/unit_tests $(BUILD)/thread_tests $(BUILD)/system_tests: | $(FAKE_CUDA)
$(filter-out $(BUILD)/%,$(BORROWED)): ;
# Of an inline function that several have, the linker takes the first: the library's comes before that of borrowed tests.
$(BUILD)/unit_tests: $(RUNNER_OBJ) $(HEADER_LIGHT_OBJ) $(HEADER_OTHER_OBJ) $(LIB) $(BORROWED)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) $(TEST_LINK) -o $@ $(subst $(LIB),-Wl$(comma)--whole-archive $(LIB) -Wl$(comma)--no-whole-archive,$^) $(TEST_LIBS) $(LIBS)

$(BUILD)/thread_tests: $(RUNNER_OBJ) $(THREAD_OBJ) $(SUPPORT) $(LIB)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) $(TEST_LINK) -o $@ $^ $(TEST_LIBS) $(LIBS)

$(BUILD)/system_tests: $(RUNNER_OBJ) $(SYSTEM_OBJ) $(SUPPORT) $(LIB)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) $(TEST_LINK) -o $@ $^ $(TEST_LIBS) $(LIBS)

# A robot's computer under QEMU (scripts/setup emulated): the cross-built program, an image of it, and the tests outside.
TX2_EXE := build/tx2/g3dmap
IMAGE := build/emulated/image
.PHONY: image emulated build-emulated
ifneq ($(TX2_EXE),$(EXE))
$(TX2_EXE): force
	$(MAKE) TOOLCHAIN=toolchain/tx2.mk GROUPED="$(GROUPED)" $@
endif
image: $(TX2_EXE) ## a bootable disk image for the emulated machine; scripts/image --help for a real one
	scripts/image $(IMAGE_ARGS)
$(IMAGE)/disk.img: $(TX2_EXE) scripts/image tests/emulated/init.toml board/emulated.toml
	scripts/image --init tests/emulated/init.toml --out $(IMAGE)
$(BUILD)/emulated_tests: $(RUNNER_OBJ) $(EMULATED_OBJ) $(SUPPORT) $(LIB)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) -o $@ $^ $(TEST_LIBS) $(LIBS)
build-emulated: $(BUILD)/emulated_tests $(EXE) $(IMAGE)/disk.img
emulated: build-emulated ## the robot in an emulated machine: boot, drive, unplug, watchdog, power cuts, updates
	G3DMAP_EXE=$(abspath $(EXE)) G3DMAP_IMAGE=$(abspath $(IMAGE)) $(BUILD)/emulated_tests $(TEST_ARGS)

.PHONY: build-program build-fuzz
build-program: $(EXE) $(BUILD)/system_tests
build-test: build-program $(BUILD)/unit_tests
unit-tests: $(BUILD)/unit_tests ## unit tests alone
	$(EMULATOR) $(BUILD)/unit_tests $(TEST_ARGS)
system-tests: $(BUILD)/system_tests $(EXE) ## tests that run the built program
	G3DMAP_EXE=$(abspath $(EXE)) $(BUILD)/system_tests $(TEST_ARGS)
test: unit-tests system-tests ## unit and system tests

build-fuzz:
	$(MAKE) $(ASAN) fuzz-programs
.PHONY: tests-to-borrow
tests-to-borrow: $(SOURCE_LIGHT_OBJ) $(SOURCE_OTHER_OBJ) $(SUPPORT)
build-asan: $(RUNNER_OBJ)
	$(if $(filter $(BUILD),$(ASAN_TESTS)),$(MAKE) GROUPED="lib tests" tests-to-borrow)
	$(MAKE) $(ASAN) build/asan/unit_tests fuzz-programs
asan: build-asan ## unit tests under address and undefined-behaviour sanitizer
	$(ASAN_ENV) build/asan/unit_tests $(TEST_ARGS)

build-tsan: $(RUNNER_OBJ)
	$(MAKE) $(TSAN) build/tsan/thread_tests build/tsan/g3dmap
tsan: tsan-tests tsan-run ## threaded tests and a whole run under thread sanitizer
tsan-tests: build-tsan
	$(TSAN_ENV) build/tsan/thread_tests "[threads]" $(TEST_ARGS)
tsan-run: build-tsan
	$(TSAN_ENV) tests/system/tsan_run build/tsan/g3dmap

fuzz: ## every reader of outside data, FUZZ_RUNS inputs each (clang)
	$(MAKE) $(ASAN) FUZZ_RUNS=$(FUZZ_RUNS) fuzz-here
.PHONY: fuzz-programs
fuzz-programs: $(FUZZ_EXE)
fuzz-here: $(FUZZ_EXE)
	$(ASAN_ENV) tests/fuzz/run $(BUILD)/fuzz $(FUZZ_RUNS)
# One program with all readers in it, which does what its name says: linking it thirty times took longer than fuzzing.
FUZZ_ALL := $(BUILD)/fuzz/all
FUZZ_LIST := $(BUILD)/fuzz/targets.inc
$(FUZZ_LIST): force
	@mkdir -p $(@D)
	@printf 'FUZZ_TARGET(%s)\n' $(notdir $(FUZZ_EXE)) >$@.$$PPID
	@if cmp -s $@.$$PPID $@; then rm $@.$$PPID; else mv $@.$$PPID $@; fi
$(BUILD)/tests/fuzz/by_name.o: $(FUZZ_LIST)
$(BUILD)/tests/fuzz/by_name.o: private FLAGS += -I$(BUILD)/fuzz
$(call objects,$(FUZZ_SRC)): private FLAGS += -DLLVMFuzzerTestOneInput=$(basename $(@F))
$(FUZZ_ALL): $(BUILD)/tests/fuzz/by_name.o $(FUZZ_OBJ) $(LIB)
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) -fsanitize=fuzzer -o $@ $^ $(LIBS)
$(FUZZ_EXE): $(FUZZ_ALL)
	@ln -f $< $@

bench: all $(BENCH_EXE) ## benchmarks, in some minutes; options and figures in tests/bench/RESULTS.md
	scripts/bench
bench-full: all $(BENCH_EXE) ## the same with all frames: OctoMap takes an hour
	scripts/bench full
$(BUILD)/bench/%: $(BUILD)/tests/bench/%.o $(SUPPORT) $(LIB)
	@mkdir -p $(@D)
	$(Q)$(CXX) $(FLAGS) -o $@ $^ -lbenchmark $(TEST_LIBS) $(LIBS)

# For a machine with nothing but an NVIDIA driver: scripts/gpu-test.
$(BUILD)/gpu_bench $(BUILD)/gpu_query_bench $(BUILD)/gpu_align_bench: $(BUILD)/%: $(BUILD)/tests/bench/%.o $(SUPPORT) $(LIB)
	$(SAY) $@
	$(Q)$(CXX) $(FLAGS) $(STATIC) -o $@ $^ $(TEST_LIBS) $(LIBS)

# Starts the helper under a tool.
$(BUILD)/helper_by_shell: tests/bench/helper_by_shell.cpp
	$(SAY) $@
	$(Q)$(CXX) -std=c++20 -O2 $(WARN) -s -static -o $@ $<

bench-explore: all ## every world and building map from many starts, hours; resumable (see scripts/bench_explore)
	G3DMAP_EXE=$(abspath $(EXE)) scripts/bench_explore $(BENCH_ARGS)

soak: build-test ## the long runs, hours of them; starts again where it was stopped
	scripts/soak

SOURCES = $(wildcard main*.hpp) $(shell find $(ROOMS) tests $(MAIN_SRC) -name '*.[ch]pp')
TIDY_FLAGS := -std=c++20 -I. -isystem $(MOSQUITTO)/include -isystem $(OPENNI)/include -isystem $(LIBUSB)/include -DG3D_VERSION=0 -DG3D_KERNEL_VARIANT=baseline -DG3D_VECTOR_BYTES=16 -DG3D_HELPER_FILE=\"/dev/null\" -DG3D_KERNELS_FILE=\"/dev/null\"
format: ## clang-format in place
	clang-format -i $(SOURCES)
house: ## the rules a machine can check: formatting, SPDX lines, include order, file length, a test per source
	@echo $(SOURCES) | xargs -n 100 -P $$(nproc) clang-format --dry-run -Werror
	scripts/check-house
# A stamp per source: what was clean is looked at again only when it, a header of it or the list of checks changed.
tidy: $(patsubst %.cpp,build/tidy/%.ok,$(MAIN_SRC) $(LIB_SRC) $(KERNEL_SRC) $(HELPER_SRC)) ## clang-tidy on what changed (slow at first; -j2 -k)
build/tidy/%.ok: %.cpp .clang-tidy
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CXX) $(TIDY_FLAGS) -MM -MP -MT $@ -MF $(@:.ok=.d) $<
	$(Q)findings=$$(clang-tidy --quiet $< -- $(TIDY_FLAGS) 2>&1) || { echo "$$findings"; exit 1; }
	@touch $@
lint: house tidy ## house and tidy

.PHONY: third-party ptxas
third-party:
	@$(STATIC_LIBS_ENV) scripts/static_libs
ptxas: $(PTX) ## registers and spills of the kernels on real cards, where NVIDIA's assembler is installed
	scripts/check-ptx $<

# The version is compiled into one object, and only when it changed.
$(BUILD)/version.txt: force
	@mkdir -p $(@D)
	@version=$$(git describe --always --dirty 2>/dev/null || echo unknown); \
	  [ "$$(cat $@ 2>/dev/null)" = "$$version" ] || echo "$$version" > $@
.PHONY: force
force:
$(BUILD)/mapper/version.o: $(BUILD)/version.txt
$(BUILD)/mapper/version.o: private FLAGS += -DG3D_VERSION='"$(shell cat $(BUILD)/version.txt)"'

$(BUILD)/hal/mqtt/pick/mosquitto.o: $(MOSQUITTO_LIB)
$(BUILD)/hal/mqtt/pick/mosquitto.o: private FLAGS += -isystem $(MOSQUITTO)/include
KINECT_OBJ := $(filter-out $(BUILD)/hal/kinect/pick/%,$(call objects,$(KINECT_PICK)))
$(KINECT_OBJ): $(OPENNI_LIB)
$(KINECT_OBJ): private FLAGS += -isystem $(OPENNI)/include -isystem $(LIBUSB)/include

# Catch2 is parsed once for each set of options, not once per test file: a precompiled header wants the same options as
# its users.
LIGHT_PCH := $(if $(filter-out $(TEST_OPT),$(LIGHT_TEST_OPT)),$(BUILD)/tests/light/precompiled.hpp,$(PCH))
$(PCH).gch: private FLAGS += $(TEST_OPT)
$(BUILD)/tests/light/precompiled.hpp.gch: private FLAGS += $(LIGHT_TEST_OPT)
$(sort $(PCH).gch $(LIGHT_PCH).gch): tests/precompiled.hpp toolchain/common_headers.hpp
$(COMMON).gch: toolchain/common_headers.hpp
$(sort $(PCH).gch $(LIGHT_PCH).gch $(COMMON).gch):
	@mkdir -p $(@D)
	@cp $< $(basename $@)
	$(Q)$(CXX) $(FLAGS) -MMD -MP -MF $(basename $@).d -x c++-header -o $@ $<
precompiled = -Winvalid-pch $(if $(findstring clang,$(CXX)),,-fpch-preprocess) -include $(1)
TEST_OBJ := $(sort $(OTHER_UNIT_OBJ) $(THREAD_OBJ) $(SYSTEM_OBJ) $(EMULATED_OBJ) $(SUPPORT_OBJ))
$(TEST_OBJ): private FLAGS += $(TEST_OPT) $(call precompiled,$(PCH))
$(TEST_OBJ): $(PCH).gch
$(LIGHT_UNIT_OBJ): private FLAGS += $(LIGHT_TEST_OPT) $(call precompiled,$(LIGHT_PCH))
$(LIGHT_UNIT_OBJ): $(LIGHT_PCH).gch

$(HOT_OBJ) $(KERNEL_OBJ): private OPT := $(subst -O2,-O3,$(OPT))
$(READER_OBJ) $(FUZZ_OBJ): private COVERED := $(COVERAGE)
# Sources whose options are those of the header.
$(PLAIN_OBJ) $(MAIN_OBJ): private FLAGS += $(call precompiled,$(COMMON))
$(PLAIN_OBJ) $(MAIN_OBJ): $(COMMON).gch

$(RUNNER_OBJ): tests/main.cpp
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CCACHE) $(RUNNER_CXX) $(TARGET) -std=c++20 -O0 $(WARN_BASE) -c -o $@ $<

define kernel_rule
$(BUILD)/%.$(1).o: %.cpp
	@mkdir -p $$(@D)
	$(SAY) $$@
	$(Q)$(CCACHE) $(CXX) $$(FLAGS) $(KERNEL_FLAGS_$(1)) -DG3D_KERNEL_VARIANT=$(1) $$(DEPFLAGS) -c -o $$@ $$<
endef
$(foreach v,$(KERNEL_VARIANTS),$(eval $(call kernel_rule,$(v))))

$(BUILD)/%.o: %.cpp
	@mkdir -p $(@D)
	$(SAY) $@
	$(Q)$(CCACHE) $(CXX) $(FLAGS) $(DEPFLAGS) -c -o $@ $<

# Written anew only if something else belongs in it, and whole, as two makes may be at work in one folder.
GROUP_OBJ := $(sort $(filter $(BUILD)/groups/%,$(LIB_OBJ) $(MAIN_OBJ) $(LIGHT_UNIT_OBJ) $(TEST_OBJ) $(FUZZ_OBJ)))
$(GROUP_OBJ:.o=.cpp): $(BUILD)/groups/%.cpp: force
	@mkdir -p $(@D)
	@$(if $(filter tests/%_test.cpp tests/%_fuzz.cpp,$(members_$*)),scripts/group-tests,printf '#include "%s"\n') $(members_$*) >$@.$$PPID
	@if cmp -s $@.$$PPID $@; then rm $@.$$PPID; else mv $@.$$PPID $@; fi
$(GROUP_OBJ): %.o: %.cpp
	$(SAY) $@
	$(Q)$(CCACHE) $(CXX) $(FLAGS) $(DEPFLAGS) -c -o $@ $<

clean: ## removes build/
	rm -rf build

-include $(shell find $(BUILD) build/tidy -name '*.d' 2>/dev/null)
