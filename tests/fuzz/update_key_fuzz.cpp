// SPDX-License-Identifier: Apache-2.0
// Files of keys from hostile hands: any bytes are a key, which goes through its file unchanged, or an error that names
// the file and shows nothing of a key.
#include <cstdlib>
#include <string>
#include <string_view>

#include "net/signing_key.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::net;
  const std::string_view text(reinterpret_cast<const char*>(data), size_bytes);
  const auto half = parse_update_key(text, "f");
  if (half.ok() && parse_update_key(format_update_key(half.value()), "f").value() != half.value()) std::abort();
  if (!half.ok() && (!half.error().text.starts_with("f:") || half.error().text.size() > 300)) std::abort();
  const auto secret = parse_signing_key(text, "f");
  if (secret.ok() && half.ok()) std::abort();  // one file cannot be both
  if (!secret.ok() && (!secret.error().text.starts_with("f:") || secret.error().text.size() > 300)) std::abort();
  return 0;
}
