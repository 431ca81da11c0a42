// SPDX-License-Identifier: Apache-2.0
// A fleet key's file from hostile hands: any bytes are a key, which goes through its file unchanged, or an error that
// names the file and shows nothing of a key.
#include <cstdlib>
#include <string>
#include <string_view>

#include "net/fleet_key_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::net;
  const std::string_view text(reinterpret_cast<const char*>(data), size_bytes);
  const auto read = parse_fleet_key(text, "f");
  if (!read.ok()) {
    if (!read.error().text.starts_with("f:") || read.error().text.size() > 400) std::abort();
    return 0;
  }
  const FleetKey& keys = read.value();
  if (keys.revoked.size() > FleetKey::kMostRevoked || keys.dropped.size() > FleetKey::kMostRevoked ||
      keys.key.equals(SecretKey()))
    std::abort();
  const auto again = parse_fleet_key(format_fleet_key(keys), "f");
  if (!again.ok() || !again.value().key.equals(keys.key) || again.value().epoch != keys.epoch ||
      again.value().revoked != keys.revoked || again.value().dropped != keys.dropped ||
      again.value().previous.has_value() != keys.previous.has_value()) {
    std::abort();
  }
  return 0;
}
