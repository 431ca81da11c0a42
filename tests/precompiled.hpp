// SPDX-License-Identifier: Apache-2.0
// What nearly every test includes; the Makefile compiles it once and puts it in front of each test file.
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>

#include "toolchain/common_headers.hpp"
