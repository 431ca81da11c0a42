// SPDX-License-Identifier: Apache-2.0
// Built without libmosquitto.
#include "hal/mqtt/mqtt_client.hpp"

namespace g3d::hal {

bool MqttClient::is_built_in() { return false; }

Result<std::unique_ptr<MqttClient>> MqttClient::make(const MqttSettings&, OnMessage) {
  return Error{Reason::unsupported,
               "this g3dmap was built without libmosquitto, so it has no way to a broker; type scripts/static_libs "
               "where its sources are, and build it again"};
}

}  // namespace g3d::hal
