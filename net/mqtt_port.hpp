// SPDX-License-Identifier: Apache-2.0
// The way to other sites through an MQTT broker: the same sealed datagrams as on the radio, as messages of QoS 0 under
// the topics of site_topics.hpp. What is lost there gossip sends again, so nothing is kept for later: while the broker
// is away, nothing leaves. The broker can read nothing and forge nothing.
//
//   owner ──send()──▶ ring ──▶ thread: batches by destination ──▶ libmosquitto ──▶ broker
//   owner ◀─receive()── ring ◀── thread: whole batches ◀────────── libmosquitto ◀──┘
//
// All that may take long happens in a thread of the port: connecting, again after longer and longer pauses, and waiting
// for a slow broker. Rings are bounded; what does not fit is dropped and counted. Addresses are numbers of sites.
// The thread allocates while it runs, the owner's calls do not.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "hal/clock.hpp"
#include "hal/mqtt/mqtt_client.hpp"
#include "hal/result.hpp"
#include "hal/ring.hpp"
#include "net/datagram_batch.hpp"
#include "net/datagram_port.hpp"
#include "net/site_topics.hpp"

namespace g3d::net {

struct MqttPortOptions {
  std::string host;  ///< of the broker; numeric
  std::uint16_t port = 1883;
  std::string user, password;
  std::string root = "g3dmap";  ///< of the topics; the same at all sites
  SiteId site = 0;              ///< of this one: 1 to kMostSiteId, another at each site
  std::size_t outgoing = 256;   ///< datagrams
  std::size_t incoming = 512;
  std::size_t most_batch_bytes = 16 * 1024;
  hal::TimeNs linger_ns = 2'000'000;  ///< a datagram waits so long for others to travel with
  hal::TimeNs answer_within_ns = 5'000'000'000;
  hal::TimeNs first_pause_ns = 250'000'000;  ///< before it connects again; doubled each time
  hal::TimeNs longest_pause_ns = 2'000'000'000;
  std::uint32_t expiry_s = 5;  ///< what a broker could not pass on by then is worth nothing
};

/// Why a datagram was dropped, or a message with all that is in it.
enum class MqttDrop : std::uint8_t {
  bad_length,       ///< send() was given nothing, or more than kMostDatagram_bytes
  not_connected,    ///< send(), while there is no broker
  outgoing_full,    ///< send(), faster than the broker takes it
  connection_lost,  ///< it was waiting to leave when the connection broke
  not_published,    ///< libmosquitto refused it
  foreign_topic,    ///< a message under a topic that is nobody's way to speak to us
  malformed_batch,  ///< a message that is no whole batch
  incoming_full,    ///< received, faster than the owner takes it
  count_,
};
inline constexpr std::size_t kMqttDrops = static_cast<std::size_t>(MqttDrop::count_);
[[nodiscard]] const char* to_string(MqttDrop reason);

/// Any thread may look.
struct MqttPortCounts {
  std::uint64_t sent_datagrams = 0;
  std::uint64_t sent_messages = 0;
  std::uint64_t sent_message_bytes = 0;  ///< of their payloads
  std::uint64_t received_messages = 0;
  std::uint64_t received_datagrams = 0;
  std::uint64_t connections = 0;         ///< that the broker accepted
  std::uint64_t failed_connections = 0;  ///< refused, unanswered or lost
  std::array<std::uint64_t, kMqttDrops> drops{};
  [[nodiscard]] std::uint64_t operator[](MqttDrop reason) const { return drops[static_cast<std::size_t>(reason)]; }
};

class MqttPort final : public DatagramPort {
 public:
  /// Starts to connect. That there is no broker is no error. Errors: unsupported (built without libmosquitto),
  /// bad_usage (an option), io_error (no thread or no descriptor is left).
  [[nodiscard]] static hal::Result<std::unique_ptr<MqttPort>> open(const MqttPortOptions& options);
  ~MqttPort() override;
  MqttPort(const MqttPort&) = delete;
  MqttPort& operator=(const MqttPort&) = delete;

  bool send(Address to, mapper::ByteSpan datagram) override;
  [[nodiscard]] std::optional<Received> receive() override;
  /// Connected, and the broker keeps up.
  [[nodiscard]] bool has_room(Address to) const override;

  // Any thread:
  [[nodiscard]] bool is_connected() const { return is_connected_.load(std::memory_order_acquire); }
  [[nodiscard]] MqttPortCounts counts() const;
  /// Why the last connection failed; empty if none did. For people: locks and allocates.
  [[nodiscard]] std::string last_fault() const;

 private:
  class Courier;
  /// A datagram on its way between the threads.
  struct Parcel {
    Address site;
    std::uint16_t size_bytes;
    std::array<std::uint8_t, kMostDatagram_bytes> bytes;
  };
  struct Tallies {
    std::atomic<std::uint64_t> sent_datagrams{0}, sent_messages{0}, sent_message_bytes{0};
    std::atomic<std::uint64_t> received_messages{0}, received_datagrams{0};
    std::atomic<std::uint64_t> connections{0}, failed_connections{0};
    std::array<std::atomic<std::uint64_t>, kMqttDrops> drops{};
  };

  MqttPort(const MqttPortOptions& options, int wake_fd);
  void wake();
  void drop(MqttDrop reason, std::uint64_t count = 1) {
    tallies_.drops[static_cast<std::size_t>(reason)].fetch_add(count, std::memory_order_relaxed);
  }
  void note_fault(const std::string& fault);

  const MqttPortOptions options_;
  const int wake_fd_;  ///< an eventfd: readable while the thread is called
  hal::Ring<Parcel> outgoing_;
  hal::Ring<Parcel> incoming_;
  Parcel sent_{};      ///< the owner's
  Parcel received_{};  ///< the owner's: what receive() shows
  std::atomic<bool> is_called_{false};
  std::atomic<bool> is_connected_{false};
  std::atomic<bool> is_ending_{false};
  Tallies tallies_;
  mutable std::mutex fault_mutex_;  ///< cold: a broken connection, and people who ask
  std::string fault_;
  std::unique_ptr<Courier> courier_;
  std::thread thread_;
};

}  // namespace g3d::net
