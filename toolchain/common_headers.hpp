// SPDX-License-Identifier: Apache-2.0
// The library headers that most sources include. The Makefile parses them once for each sanitizer's build; the release
// build does without, so that a source that forgets to include what it uses does not compile.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>
