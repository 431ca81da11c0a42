// SPDX-License-Identifier: Apache-2.0
// What nearly every test includes; the Makefile compiles it once and puts it in front of each test file.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>
