// SPDX-License-Identifier: Apache-2.0
// A login for a broker from hostile hands: any bytes are a user and a password of printable characters, or an error
// that names the file.
#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include "net/broker_options.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const auto read = g3d::net::parse_broker_login({reinterpret_cast<const char*>(data), size_bytes}, "f");
  if (!read.ok()) {
    if (!read.error().text.starts_with("f:") || read.error().text.size() > 200) std::abort();
    return 0;
  }
  for (const std::string& text : {read.value().user, read.value().password}) {
    if (text.empty() || std::any_of(text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; })) std::abort();
  }
  const auto again =
      g3d::net::parse_broker_login("user " + read.value().user + "\npassword " + read.value().password, "f");
  if (!again.ok() || again.value().user != read.value().user || again.value().password != read.value().password) {
    std::abort();
  }
  return 0;
}
