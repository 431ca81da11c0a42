# SPDX-License-Identifier: Apache-2.0
# For the Jetson TX2, built on an amd64 Debian 12: `make TOOLCHAIN=toolchain/tx2.mk` makes build/tx2/g3dmap, static as ever, so
# that neither its C library nor its kernel (L4T r32: glibc 2.27, Linux 4.9) matters. `scripts/setup cross` installs what it
# needs. Programs of the build run under EMULATOR; another SYSROOT is another folder of the same layout.
CROSS_COMPILE ?= aarch64-linux-gnu-
CC := $(CROSS_COMPILE)gcc
CXX := $(CROSS_COMPILE)g++
AR := $(CROSS_COMPILE)ar
BUILD ?= build/tx2
SYSROOT ?= $(shell scripts/sysroot where)
SYSROOT := $(SYSROOT)
STATIC_LIBS_ENV := CC=$(CC) CXX=$(CXX) AR=$(AR) SYSROOT=$(SYSROOT)
EMULATOR ?= qemu-aarch64-static

ifeq ($(and $(shell command -v $(CXX)),$(wildcard $(SYSROOT)/usr/include)),)
$(if $(filter help clean,$(MAKECMDGOALS)),,$(error no $(CXX), or no libraries for it in '$(SYSROOT)': type scripts/setup cross))
endif

# The program has to run on both of its clusters, Denver 2 and Cortex-A57: ARMv8.0, tuned for the latter. Neither has the
# atomic instructions of 8.1, so nothing has to ask at run time which to take.
# -Wno-psabi: g++ would tell of an interface that changed in its release 10.
TARGET := -mcpu=cortex-a57 -mno-outline-atomics -Wno-psabi --sysroot=$(SYSROOT)
# NEON is in every such processor: one variant of the kernels.
KERNEL_VARIANTS := baseline
KERNEL_PICK := mapper/cpu/pick/portable.cpp
KERNEL_FLAGS_baseline := -DG3D_VECTOR_BYTES=16

STATIC := -static
# Tests too: the emulator then needs no foreign C library.
TEST_LINK := -static
TEST_OPT ?= -O1
LIGHT_TEST_OPT ?= -O0
# Of the unit tests those that a machine can make differ: arithmetic and vectors, bytes in files and on wires, signs of
# characters. TESTED=tests/% would take all others as well.
TESTED ?= $(addprefix tests/,board/% hal/image/% hal/replay/% mapper/align/% mapper/cpu/% mapper/files/% \
  $(addprefix hal/,decimal_% geometry_% messages_% kobuki/command_% kobuki/feedback_% kobuki/frame_% kobuki/odometry_% kobuki/packet_% \
    sim/kinect_noise_% sim/plain_trig_% sim/text_fields_% sim/tile_kernels_% sim/world_%) \
  $(addprefix mapper/,column_bits_% json_% map_hash_% mapper_% merge_% morton_% query_% ray_walk_% rgbo_% voxel_map_%) \
  $(addprefix nav/,astar_% distance_field_% inflation_% column_evidence_%) \
  $(addprefix net/,bit_model_% block_% datagram_% handshake_% journal_entry_% journal_frame_% layer_identity_% range_coder_% \
    reconcile_% robot_status_% set_sketch_% site_topics_% sync_% wire_parts_% key_file_% fleet_key_%))
# What an emulator of single programs cannot show: the helper, which is started from memory by execveat() (the host's kernel
# refuses another machine's program), and what the host's /proc/cpuinfo says.
NOT_TESTED := $(addprefix tests/mapper/,cuda/helper/% cuda/helper_% cuda/card_keeper_% cuda/ask_grid_% cpu/pick/amd64_%)
# What it does not pass on: multicast options of sockets, ptrace(), the heap's end, and populating memory in advance.
NOT_TESTED += $(addprefix tests/,fleet/datagram_relay_% fleet/relayed_gossip_% net/udp_port_% mapper/pool_% \
  $(addprefix hal/,boot/frozen_thread_% boot/network_keeper_% linux/heap_room_% linux/multicast_group_% linux/udp_socket_% linux/watchdog_%))
RUNNER_CXX := $(CXX)
RUNNER_OBJ := $(BUILD)/runner/main.o
