// SPDX-License-Identifier: Apache-2.0
// What nearly every test includes; the Makefile compiles it once and puts it in front of each test file, and in
// sanitized builds in front of the library too.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>
