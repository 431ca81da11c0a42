// SPDX-License-Identifier: Apache-2.0
// What holds with and without libmosquitto.
#include <catch2/catch.hpp>

#include "hal/mqtt/mqtt_client.hpp"

using namespace g3d::hal;

TEST_CASE("a client of a broker is there only in a program that was built with one, and else says how to get it") {
  MqttSettings settings;
  settings.host = "127.0.0.1";
  settings.client_id = "a";
  settings.subscriptions = {"a/+"};
  const auto made = MqttClient::make(settings, [](std::string_view, std::span<const std::uint8_t>) {});
  CHECK(made.ok() == MqttClient::is_built_in());
  if (made.ok()) return;
  CHECK(made.error().reason == Reason::unsupported);
  CHECK_THAT(made.error().text, Catch::Contains("scripts/static_libs"));
}
