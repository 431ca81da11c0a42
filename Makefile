# SPDX-License-Identifier: Apache-2.0
# Every job is one word; `make help` lists them.
TOOLCHAIN ?= toolchain/host.mk
include $(TOOLCHAIN)

BUILD ?= build/host
OPT ?= -O3 -g1
SANITIZE ?=
CCACHE := $(shell command -v ccache 2>/dev/null)

WARN := -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror
# -ffp-contract=off: a fused multiply-add rounds differently, and twins must agree to the last bit.
FLAGS := -std=c++20 $(OPT) $(WARN) -I. -pthread -ffp-contract=off -fno-math-errno -fno-trapping-math -DFMT_HEADER_ONLY $(SANITIZE)
DEPFLAGS = -MMD -MP -MF $(@:.o=.d)
LIBS := -lpng -ljpeg -lzstd -lsodium -lz

KERNEL_SRC := $(wildcard mapper/cpu/kernels/*.cpp)
LIB_SRC := $(filter-out $(KERNEL_SRC),$(shell find board hal mapper nav net -name '*.cpp' | sort))
TEST_SRC := $(shell find tests -name '*_test.cpp' | sort) tests/main.cpp
TEST_SUPPORT_SRC := $(wildcard tests/support/*.cpp)

LIB_OBJ := $(LIB_SRC:%.cpp=$(BUILD)/%.o) \
  $(foreach v,$(KERNEL_VARIANTS),$(KERNEL_SRC:%.cpp=$(BUILD)/%.$(v).o))
TEST_OBJ := $(TEST_SRC:%.cpp=$(BUILD)/%.o) $(TEST_SUPPORT_SRC:%.cpp=$(BUILD)/%.o)

.PHONY: all test clean
all: $(BUILD)/g3dmap

$(BUILD)/g3dmap: $(BUILD)/main.o $(BUILD)/libg3dmap.a
	$(CXX) $(FLAGS) $(STATIC) -o $@ $^ $(LIBS)

$(BUILD)/libg3dmap.a: $(LIB_OBJ)
	@rm -f $@
	$(AR) rcs $@ $^

$(BUILD)/unit_tests: $(TEST_OBJ) $(BUILD)/libg3dmap.a
	$(CXX) $(FLAGS) -o $@ $^ -loctomap -loctomath $(LIBS)

test: $(BUILD)/unit_tests $(BUILD)/g3dmap
	$(BUILD)/unit_tests

define kernel_rule
$(BUILD)/%.$(1).o: %.cpp
	@mkdir -p $$(@D)
	$(CCACHE) $(CXX) $(FLAGS) $(KERNEL_FLAGS_$(1)) -DG3D_KERNEL_VARIANT=$(1) -MMD -MP -MF $$(@:.o=.d) -c -o $$@ $$<
endef
$(foreach v,$(KERNEL_VARIANTS),$(eval $(call kernel_rule,$(v))))

$(BUILD)/%.o: %.cpp
	@mkdir -p $(@D)
	$(CCACHE) $(CXX) $(FLAGS) $(DEPFLAGS) -c -o $@ $<

clean:
	rm -rf build

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
