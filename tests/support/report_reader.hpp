// SPDX-License-Identifier: Apache-2.0
// Looks single members up in a report.json. Not a JSON reader: names must be unique in the report.
#pragma once

#include <cstdint>
#include <string>

namespace g3d::test {

/// Throws if there is no such number.
[[nodiscard]] std::uint64_t report_number(const std::string& path, const std::string& name);
[[nodiscard]] std::string report_text(const std::string& path, const std::string& name);
/// delivered = integrated + the sum of all that stands under "dropped".
[[nodiscard]] bool report_is_balanced(const std::string& path);

}  // namespace g3d::test
