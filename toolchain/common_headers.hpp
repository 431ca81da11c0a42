// SPDX-License-Identifier: Apache-2.0
// The library headers that most sources include, parsed once for each build. Sources include what they use all the same:
// `make tidy` looks at each of them without this.
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
