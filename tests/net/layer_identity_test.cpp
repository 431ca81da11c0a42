// SPDX-License-Identifier: Apache-2.0
#include "net/layer_identity.hpp"

#include <catch2/catch.hpp>

#include "net/wire_parts.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using net::LayerIdentity;

TEST_CASE("who wrote a layer is read as it was written", "[net]") {
  const test::TempFolder folder;
  for (const LayerIdentity& identity :
       {LayerIdentity{{0xDEADBEEF, 1}, 0}, LayerIdentity{{~0ULL, 0xFFFFFFFF}, net::kMostVersion}}) {
    REQUIRE(net::write_layer_identity(folder / "identity", identity).ok());
    const auto read = net::read_layer_identity(folder / "identity");
    REQUIRE(read.ok());
    CHECK(read.value() == identity);
  }
  CHECK(net::read_layer_identity(folder / "none").error().reason == hal::Reason::not_found);
  CHECK(folder.listing() == "identity\n");
}

TEST_CASE("a counter that lost or changed a byte is none", "[net]") {
  const std::string whole = net::format_layer_identity({{0xC0FFEE, 7}, 4194304});
  REQUIRE(net::parse_layer_identity(whole, "f").ok());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CHECK_FALSE(net::parse_layer_identity(whole.substr(0, i), "f").ok());
    for (const int bit : {1, 2, 8, 32}) {
      std::string wrong = whole;
      wrong[i] = static_cast<char>(wrong[i] ^ bit);
      const auto read = net::parse_layer_identity(wrong, "f");
      // A digit of the checksum may be written large; nothing else may differ.
      if (read.ok()) CHECK(read.value() == LayerIdentity{{0xC0FFEE, 7}, 4194304});
      if (!read.ok()) CHECK(read.error().text.starts_with("f: "));
    }
  }
  CHECK_FALSE(net::parse_layer_identity(whole + "\n", "f").ok());
  const std::string far = net::format_layer_identity({{1, 1}, net::kMostVersion + 1});
  CHECK(net::parse_layer_identity(far, "f").error().reason == hal::Reason::malformed);
}
