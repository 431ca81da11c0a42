// SPDX-License-Identifier: Apache-2.0
#include "tests/support/report_reader.hpp"

#include <stdexcept>

#include "tests/support/temp_folder.hpp"

namespace g3d::test {
namespace {

/// What follows `"name": `.
std::string after_name(const std::string& path, const std::string& name) {
  const std::string text = read_plain(path);
  const std::string wanted = '"' + name + "\": ";
  const auto place = text.find(wanted);
  if (place == std::string::npos) throw std::runtime_error(path + " has no " + name);
  return text.substr(place + wanted.size());
}

}  // namespace

std::uint64_t report_number(const std::string& path, const std::string& name) {
  return std::stoull(after_name(path, name));
}

std::string report_text(const std::string& path, const std::string& name) {
  const std::string rest = after_name(path, name);
  return rest.substr(1, rest.find('"', 1) - 1);
}

bool report_is_balanced(const std::string& path) {
  std::string rest = after_name(path, "dropped");
  rest = rest.substr(0, rest.find('}'));
  std::uint64_t dropped = 0;
  for (auto colon = rest.find(": "); colon != std::string::npos; colon = rest.find(": ", colon + 1)) {
    dropped += std::stoull(rest.substr(colon + 2));
  }
  return report_number(path, "delivered") == report_number(path, "integrated") + dropped;
}

}  // namespace g3d::test
