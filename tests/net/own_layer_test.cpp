// SPDX-License-Identifier: Apache-2.0
#include "net/own_layer.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using net::Lane;
using net::OwnLayer;
using net::Version;
using net::VersionRange;

TEST_CASE("an own layer that begins now is ours alone and complete from the first version", "[net]") {
  net::LayerStore store;
  OwnLayer own(store, {3, 1}, 0);
  CHECK(own.is_ours_alone(own.index()));
  CHECK_FALSE(own.is_ours_alone(own.index() + 1));
  CHECK_FALSE(own.may_take(own.index(), 1));
  CHECK(own.may_take(own.index() + 1, 1));
  CHECK_FALSE(own.may_compare(own.index(), 0));
  own.set_limit(2);
  REQUIRE(own.may_publish());
  own.advance();
  own.advance();
  CHECK_FALSE(own.may_publish());
  own.commit();
  for (const Lane lane : net::kAllLanes) CHECK(store.had(own.index(), lane).upto() == 2);
}

TEST_CASE("an own layer that comes back goes on above, and takes back only what its disk may have lost", "[net]") {
  net::LayerStore store;
  const net::LayerIndex layer = store.find_or_add({3, 1});
  for (const Lane lane : net::kAllLanes) REQUIRE(store.add_had(layer, lane, {0, 40}));
  OwnLayer own(store, {3, 1}, 100);
  REQUIRE(own.has_gap());
  CHECK_FALSE(own.is_ours_alone(layer));
  CHECK(own.may_take(layer, 100));
  CHECK_FALSE(own.may_take(layer, 101));
  own.advance();
  CHECK(own.version() == 101);
  own.commit();
  CHECK(store.had(layer, Lane::rest).upto() == 40);
  CHECK(store.had(layer, Lane::rest).covers({100, 101}));
  CHECK(own.may_compare(layer, 101));
  CHECK_FALSE(own.may_compare(layer, 102));
  own.close_gap();
  CHECK(store.had(layer, Lane::rest).upto() == 101);
  CHECK_FALSE(own.may_take(layer, 50));

  // Once more, without anybody having been met: only the last gap stays open.
  net::LayerStore again;
  const net::LayerIndex same = again.find_or_add({3, 1});
  for (const Lane lane : net::kAllLanes) {
    REQUIRE(again.add_had(same, lane, {0, 40}));
    REQUIRE(again.add_had(same, lane, {100, 150}));
  }
  OwnLayer third(again, {3, 1}, 200);
  third.advance();
  third.commit();
  CHECK(again.had(same, Lane::ground).upto() == 150);
  REQUIRE(again.had(same, Lane::ground).beyond().size() == 1);
  CHECK(again.had(same, Lane::ground).beyond()[0] == VersionRange{200, 201});
}

TEST_CASE("an own layer of which nothing can be lost has no gap", "[net]") {
  net::LayerStore store;
  const net::LayerIndex layer = store.find_or_add({3, 1});
  for (const Lane lane : net::kAllLanes) REQUIRE(store.add_had(layer, lane, {0, 100}));
  const OwnLayer own(store, {3, 1}, 100);
  CHECK_FALSE(own.has_gap());
  CHECK(own.is_ours_alone(layer));
}
