// SPDX-License-Identifier: Apache-2.0
// Where datagrams enter and leave, as they are on the wire: a UDP socket, a simulated radio, a test's relay. What comes
// is anybody's. One thread; never waits.
#pragma once

#include <optional>

#include "mapper/files/bytes.hpp"
#include "net/membership.hpp"

namespace g3d::net {

class DatagramPort {
 public:
  virtual ~DatagramPort() = default;
  /// `to`: an address that receive() gave, or kEverybody: all who can be reached. False: not sent, and counted.
  virtual bool send(Address to, mapper::ByteSpan datagram) = 0;

  struct Received {
    Address from = kEverybody;  ///< never kEverybody; an answer goes there
    mapper::ByteSpan datagram;  ///< valid until the next receive()
  };
  /// The next datagram that has come; nothing if none has.
  [[nodiscard]] virtual std::optional<Received> receive() = 0;
  /// False: what is sent there now would be dropped, or wait for long. What can wait should.
  [[nodiscard]] virtual bool has_room(Address /*to*/) const { return true; }
};

}  // namespace g3d::net
