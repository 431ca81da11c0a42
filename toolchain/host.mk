# SPDX-License-Identifier: Apache-2.0
# The machine that builds is the machine that runs: amd64 or arm64 Debian 12.
CXX ?= g++
AR ?= ar
ARCH := $(shell uname -m)

# Kernels are compiled once per instruction set, for vectors of its width; the program picks one at start.
ifeq ($(ARCH),x86_64)
KERNEL_VARIANTS := baseline avx2 avx512
KERNEL_PICK := mapper/cpu/pick/amd64.cpp
KERNEL_FLAGS_baseline := -DG3D_VECTOR_BYTES=16
AVX2 := -mavx2 -mbmi -mbmi2 -mpopcnt -mf16c
KERNEL_FLAGS_avx2 := $(AVX2) -DG3D_VECTOR_BYTES=32
KERNEL_FLAGS_avx512 := $(AVX2) -DG3D_VECTOR_BYTES=64 -mavx512f -mavx512bw -mavx512dq -mavx512vl -mprefer-vector-width=512
else
KERNEL_VARIANTS := baseline
KERNEL_PICK := mapper/cpu/pick/portable.cpp
KERNEL_FLAGS_baseline := -DG3D_VECTOR_BYTES=16
endif

STATIC := -static
