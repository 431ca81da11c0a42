// SPDX-License-Identifier: Apache-2.0
// The bytes of messages, one by one.
#include <algorithm>
#include <catch2/catch.hpp>

#include "net/sync_message.hpp"

using namespace g3d;
using mapper::Bytes;
using net::Lane;
using net::MessageWriter;
using net::RecordKey;
using net::Version;
using net::WantedLayer;

namespace {

Bytes golden_bytes_of(const MessageWriter& message) { return {message.bytes().begin(), message.bytes().end()}; }

}  // namespace

TEST_CASE("messages are these bytes, on every machine and in every version of the program", "[net]") {
  const net::LayerId id{0x0102030405060708ULL, 0x0A0B0C0DU};
  const Bytes id_bytes{8, 7, 6, 5, 4, 3, 2, 1, 0x0D, 0x0C, 0x0B, 0x0A};
  const auto joined = [&](std::initializer_list<Bytes> parts) {
    Bytes all;
    for (const Bytes& part : parts) mapper::put_bytes(all, part);
    return all;
  };
  MessageWriter message;
  message.begin_beacon(0x1122334455667788ULL);
  REQUIRE(message.add_layer({id, {300, 299, 0}, 300, 99}));
  CHECK(golden_bytes_of(message) ==
        joined({{1, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11}, id_bytes, {0xAC, 2, 0, 1, 0xAC, 2}}));
  message.begin_vector(true);
  REQUIRE(message.add_layer({id, {5, 3, 0}, 5, 0x1122334455667788ULL}));
  CHECK(golden_bytes_of(message) ==
        joined({{2, 1}, id_bytes, {5, 0, 2, 5, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11}}));

  constexpr net::LayerAlias kAlias = 0x0A0B0C0DU;
  const Bytes alias_bytes{0x0D, 0x0C, 0x0B, 0x0A};
  WantedLayer wanted{kAlias, {net::VersionRanges(200), net::VersionRanges(0), net::VersionRanges(7)}};
  REQUIRE((wanted.had[0].add({203, 204}) && wanted.had[0].add({334, 336})));
  const Bytes wanted_bytes = joined({alias_bytes, {1, 0xC8, 1, 0x8F, 3, 14, 2, 3, 1, 0x82, 1, 2}});
  message.begin_want({0xA1B2, 0xC3D4});
  REQUIRE(message.add_wanted(wanted));
  CHECK(golden_bytes_of(message) == joined({{3, 0xB2, 0xA1, 0xD4, 0xC3}, wanted_bytes}));
  message.begin_wants();
  REQUIRE(message.begin_part(0x01020304U, {1, 2}));
  REQUIRE(message.begin_part(0x05060708U, {3, 4}));
  REQUIRE(message.add_wanted(wanted));
  CHECK(golden_bytes_of(message) == joined({{7, 4, 3, 2, 1, 1, 0, 2, 0, 0, 8, 7, 6, 5, 3, 0, 4, 0, 1}, wanted_bytes}));

  const auto add = [&](RecordKey key, Version version, const Bytes& payload) {
    const auto place = message.add_record(key, version, payload.size());
    REQUIRE(place);
    std::copy(payload.begin(), payload.end(), place->begin());
  };
  message.begin_data(7);
  REQUIRE(message.begin_segment(kAlias, Lane::ground, 5, 3));
  add(net::block_record(0, 5, net::Part::low_half), 6, {0xAA, 0xBB, 0xCC});  // key 21
  add(net::block_record(0, 4, net::Part::whole), 9, {});                     // key 16
  message.end_segment(12);
  REQUIRE(message.begin_segment(kAlias, Lane::rest, 0, 1));
  add(net::block_record(0, 5, net::Part::whole), 1, {0xDD});  // key 20
  message.end_segment(1);
  REQUIRE(message.begin_segment(1, Lane::frontier, 300, 0));
  message.end_segment(301);
  CHECK(golden_bytes_of(message) == joined({{4, 7, 0},
                                            {0},
                                            alias_bytes,
                                            {5},
                                            {5, 42, 0xAA, 0xBB, 0xCC},
                                            {1, 2, 2, 9},
                                            {0, 3},
                                            {6, 0},
                                            {3, 8, 0xDD},
                                            {0, 0},
                                            {1, 1, 0, 0, 0},
                                            {0xAC, 2},
                                            {0, 1}}));
  message.begin_news(0x0102);
  CHECK(golden_bytes_of(message) == Bytes{6, 2, 1});
  // Names of layers and robots on the wire.
  CHECK(net::alias_of(id) == static_cast<net::LayerAlias>(net::mixed(id.robot, id.incarnation)));
  CHECK(net::alias_of(net::LayerId{1, 1}) == 0xCCA4E16EU);
  CHECK(net::alias_of(net::RobotId{1}) == 0xE15C2D26U);
}
