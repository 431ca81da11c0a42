// SPDX-License-Identifier: Apache-2.0
#include "net/mqtt_port.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

namespace g3d::net {
namespace {

/// The client wants to be served once a second to keep alive.
constexpr hal::TimeNs kCourierTick_ns = 500'000'000;
/// While nobody takes what came, the thread looks so often whether there is room again.
constexpr hal::TimeNs kCourierFull_ns = 2'000'000;
/// Of one destination each; when another is needed, all leave.
constexpr std::size_t kMostOpenBatches = 16;
constexpr int kBrokerKeepalive_s = 10;

}  // namespace

const char* to_string(MqttDrop reason) {
  switch (reason) {
    case MqttDrop::bad_length:
      return "bad_length";
    case MqttDrop::not_connected:
      return "not_connected";
    case MqttDrop::outgoing_full:
      return "outgoing_full";
    case MqttDrop::connection_lost:
      return "connection_lost";
    case MqttDrop::not_published:
      return "not_published";
    case MqttDrop::foreign_topic:
      return "foreign_topic";
    case MqttDrop::malformed_batch:
      return "malformed_batch";
    case MqttDrop::incoming_full:
      return "incoming_full";
    case MqttDrop::count_:
      break;
  }
  return "unknown";
}

/// What the thread does, and all that it alone knows.
class MqttPort::Courier {
 public:
  explicit Courier(MqttPort& port)
      : port_(port), options_(port.options_), topics_(port.options_.root, port.options_.site) {}

  [[nodiscard]] hal::Result<void> make_client() {
    hal::MqttSettings settings;
    settings.host = options_.host;
    settings.port = options_.port;
    settings.user = options_.user;
    settings.password = options_.password;
    settings.client_id = fmt::format("{}-{:x}", options_.root, options_.site);
    settings.subscriptions = topics_.subscriptions();
    settings.keepalive_s = kBrokerKeepalive_s;
    auto client = hal::MqttClient::make(
        settings, [this](std::string_view topic, mapper::ByteSpan payload) { on_message(topic, payload); });
    if (!client) return client.error();
    client_ = std::move(client).value();
    return {};
  }

  void run() {
    hal::TimeNs pause_ns = options_.first_pause_ns;
    while (!is_ending()) {
      // One that held for a while was no short breath of a broker that throws us out again and again.
      const hal::TimeNs begin_ns = clock_.now();
      if (client_->connect() && serve_until_lost() && clock_.now() - begin_ns >= options_.longest_pause_ns) {
        pause_ns = options_.first_pause_ns;
      }
      port_.is_connected_.store(false, std::memory_order_release);
      client_->disconnect();
      drop_waiting();
      if (is_ending()) return;
      port_.tallies_.failed_connections.fetch_add(1, std::memory_order_relaxed);
      port_.note_fault(fault_.empty() ? client_->last_fault() : fault_);
      rest(pause_ns);
      pause_ns = std::min(2 * pause_ns, options_.longest_pause_ns);
    }
  }

 private:
  struct Batch {
    Address site = kEverybody;
    std::size_t count = 0;
    mapper::Bytes bytes;
  };

  [[nodiscard]] bool is_ending() const { return port_.is_ending_.load(std::memory_order_acquire); }

  /// Waits for the client's socket, if `events` are wanted of it, and for a call of the owner. Returns what there is of
  /// the socket.
  short wait(short events, hal::TimeNs at_most_ns) {
    std::array<pollfd, 2> waits{{{port_.wake_fd_, POLLIN, 0}, {client_->socket(), events, 0}}};
    const timespec timeout{at_most_ns / 1'000'000'000, at_most_ns % 1'000'000'000};
    if (::ppoll(waits.data(), events == 0 ? 1 : 2, &timeout, nullptr) <= 0) return 0;
    if (waits[0].revents != 0) {
      std::uint64_t calls = 0;
      (void)!::read(port_.wake_fd_, &calls, sizeof calls);
      // From here on the owner calls again; what it had put into the ring before is seen below.
      port_.is_called_.exchange(false, std::memory_order_acq_rel);
    }
    return events == 0 ? short{0} : waits[1].revents;
  }

  /// The pause before the next connection, a quarter more or less: sites that have lost the same broker do not all come
  /// back in the same moment.
  void rest(hal::TimeNs pause_ns) {
    turn_ = mixed(options_.site, turn_ + 1);
    const hal::TimeNs spread_ns = pause_ns / 2;
    const hal::TimeNs until_ns = clock_.now() + pause_ns - spread_ns / 2 +
                                 static_cast<hal::TimeNs>(turn_ % static_cast<std::uint64_t>(spread_ns + 1));
    for (hal::TimeNs now_ns = clock_.now(); now_ns < until_ns && !is_ending(); now_ns = clock_.now()) {
      (void)wait(0, until_ns - now_ns);
    }
  }

  /// Until the connection is lost or the port ends. True if the broker had accepted it.
  bool serve_until_lost() {
    const hal::TimeNs answer_by_ns = clock_.now() + options_.answer_within_ns;
    fault_.clear();
    aliased_.clear();
    bool was_ready = false;
    while (!is_ending()) {
      const bool has_room = 2 * port_.incoming_.size() < port_.incoming_.capacity();
      hal::TimeNs wait_ns = has_room ? kCourierTick_ns : kCourierFull_ns;
      if (!batches_.empty() && !client_->wants_write()) {
        wait_ns = std::clamp<hal::TimeNs>(oldest_ns_ + options_.linger_ns - clock_.now(), 0, wait_ns);
      }
      // POLLERR and POLLHUP come unasked.
      const auto events =
          static_cast<short>((has_room ? POLLIN : 0) | (client_->wants_write() ? POLLOUT : 0) | POLLPRI);
      const short there = wait(events, wait_ns);
      const bool is_broken = (there & (POLLERR | POLLHUP)) != 0;
      if (!client_->serve((there & POLLIN) != 0 || is_broken, (there & POLLOUT) != 0)) return was_ready;
      if (!client_->is_ready()) {
        if (clock_.now() < answer_by_ns) continue;
        fault_ = fmt::format("broker {} port {}: no answer for {} s", options_.host, options_.port,
                             options_.answer_within_ns / 1'000'000'000);
        return was_ready;
      }
      if (!std::exchange(was_ready, true)) {
        port_.tallies_.connections.fetch_add(1, std::memory_order_relaxed);
        port_.is_connected_.store(true, std::memory_order_release);
      }
      take_outgoing();
      if (!batches_.empty() && clock_.now() - oldest_ns_ >= options_.linger_ns) publish_all();
    }
    if (was_ready) publish_all();
    return was_ready;
  }

  void take_outgoing() {
    // One message at most waits in libmosquitto, whose memory for them has no bound.
    while (!client_->wants_write() && port_.outgoing_.try_pop(parcel_)) {
      const mapper::ByteSpan datagram(parcel_.bytes.data(), parcel_.size_bytes);
      auto batch =
          std::find_if(batches_.begin(), batches_.end(), [&](const Batch& b) { return b.site == parcel_.site; });
      const bool is_full = batch != batches_.end() &&
                           batch->bytes.size() + kBatchedLength_bytes + datagram.size() > options_.most_batch_bytes;
      if (is_full) publish(*batch);
      if (batch == batches_.end()) {
        if (batches_.size() >= kMostOpenBatches) publish_all();
        if (batches_.empty()) oldest_ns_ = clock_.now();
        batches_.push_back({parcel_.site, 0, {}});
        batch = batches_.end() - 1;
      }
      append_datagram(batch->bytes, datagram);
      ++batch->count;
    }
  }

  void publish_all() {
    for (Batch& batch : batches_) publish(batch);
    batches_.clear();
  }

  void publish(Batch& batch) {
    if (batch.count == 0) return;
    const auto aliased = std::find(aliased_.begin(), aliased_.end(), batch.site);
    const bool is_aliased = aliased != aliased_.end();
    std::uint16_t alias = 0;
    if (is_aliased || aliased_.size() < client_->most_aliases()) {
      alias = static_cast<std::uint16_t>(aliased - aliased_.begin() + 1);
    }
    Tallies& tallies = port_.tallies_;
    if (client_->publish(is_aliased ? std::string() : topics_.to(batch.site), alias, batch.bytes, options_.expiry_s)) {
      tallies.sent_datagrams.fetch_add(batch.count, std::memory_order_relaxed);
      tallies.sent_messages.fetch_add(1, std::memory_order_relaxed);
      tallies.sent_message_bytes.fetch_add(batch.bytes.size(), std::memory_order_relaxed);
      if (alias != 0 && !is_aliased) aliased_.push_back(batch.site);
    } else {
      port_.drop(MqttDrop::not_published, batch.count);
    }
    batch.count = 0;
    batch.bytes.clear();
  }

  /// Nothing that waited for a connection leaves by the next one: gossip has better news by then.
  void drop_waiting() {
    for (const Batch& batch : batches_) port_.drop(MqttDrop::connection_lost, batch.count);
    batches_.clear();
    while (port_.outgoing_.try_pop(parcel_)) port_.drop(MqttDrop::connection_lost);
  }

  /// Called by libmosquitto: nothing here throws.
  void on_message(std::string_view topic, mapper::ByteSpan payload) {
    Tallies& tallies = port_.tallies_;
    tallies.received_messages.fetch_add(1, std::memory_order_relaxed);
    const std::optional<SiteId> sender = topics_.sender(topic);
    if (!sender) return port_.drop(MqttDrop::foreign_topic);
    if (datagrams_of(payload) == 0) return port_.drop(MqttDrop::malformed_batch);
    visit_datagrams(payload, [&](mapper::ByteSpan datagram) {
      came_.site = *sender;
      came_.size_bytes = static_cast<std::uint16_t>(datagram.size());
      std::copy(datagram.begin(), datagram.end(), came_.bytes.begin());
      if (!port_.incoming_.try_push(came_)) return port_.drop(MqttDrop::incoming_full);
      tallies.received_datagrams.fetch_add(1, std::memory_order_relaxed);
    });
  }

  MqttPort& port_;
  const MqttPortOptions& options_;
  const SiteTopics topics_;
  hal::RealClock clock_;
  std::unique_ptr<hal::MqttClient> client_;
  std::vector<Batch> batches_;
  hal::TimeNs oldest_ns_ = 0;     ///< when the first of the batches was begun
  std::vector<Address> aliased_;  ///< the topic of the Nth has number N + 1 on this connection
  Parcel parcel_{};               ///< on its way out
  Parcel came_{};
  std::string fault_;  ///< what the client does not know of
  std::uint64_t turn_ = 0;
};

hal::Result<std::unique_ptr<MqttPort>> MqttPort::open(const MqttPortOptions& options) {
  const auto misuse = [](std::string text) { return hal::Error{hal::Reason::bad_usage, std::move(text)}; };
  if (!is_topic_root(options.root)) {
    return misuse(
        fmt::format("'{}' is no root of topics; write names of letters, digits, '-', '_' and '.', with '/' "
                    "between them, {} characters at most",
                    options.root, kMostTopicRoot_bytes));
  }
  if (options.site == kEverybody || options.site > kMostSiteId) {
    return misuse(fmt::format("site {:x} at a broker; take a number from 1 to {:x}", options.site, kMostSiteId));
  }
  const int wake_fd = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_fd < 0) {
    return hal::Error{hal::Reason::io_error,
                      fmt::format("no descriptor for the way to a broker: {}", std::strerror(errno))};
  }
  std::unique_ptr<MqttPort> port(new MqttPort(options, wake_fd));
  if (const auto made = port->courier_->make_client(); !made) return made.error();
  port->thread_ = std::thread([courier = port->courier_.get()] { courier->run(); });
  return port;
}

MqttPort::MqttPort(const MqttPortOptions& options, int wake_fd)
    : options_(options),
      wake_fd_(wake_fd),
      outgoing_(options.outgoing),
      incoming_(options.incoming),
      courier_(std::make_unique<Courier>(*this)) {}

MqttPort::~MqttPort() {
  is_ending_.store(true, std::memory_order_release);
  is_called_.store(false, std::memory_order_release);
  wake();
  if (thread_.joinable()) thread_.join();
  ::close(wake_fd_);
}

void MqttPort::wake() {
  if (is_called_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t call = 1;
  (void)!::write(wake_fd_, &call, sizeof call);
}

bool MqttPort::send(Address to, mapper::ByteSpan datagram) {
  const auto refuse = [this](MqttDrop reason) {
    drop(reason);
    return false;
  };
  if (datagram.empty() || datagram.size() > kMostDatagram_bytes) return refuse(MqttDrop::bad_length);
  if (!is_connected()) return refuse(MqttDrop::not_connected);
  sent_.site = to;
  sent_.size_bytes = static_cast<std::uint16_t>(datagram.size());
  std::copy(datagram.begin(), datagram.end(), sent_.bytes.begin());
  if (!outgoing_.try_push(sent_)) return refuse(MqttDrop::outgoing_full);
  wake();
  return true;
}

std::optional<DatagramPort::Received> MqttPort::receive() {
  if (!incoming_.try_pop(received_)) return std::nullopt;
  return Received{received_.site, {received_.bytes.data(), received_.size_bytes}};
}

bool MqttPort::has_room(Address /*to*/) const { return is_connected() && 2 * outgoing_.size() < outgoing_.capacity(); }

MqttPortCounts MqttPort::counts() const {
  const auto read = [](const std::atomic<std::uint64_t>& tally) { return tally.load(std::memory_order_relaxed); };
  MqttPortCounts counts;
  counts.sent_datagrams = read(tallies_.sent_datagrams);
  counts.sent_messages = read(tallies_.sent_messages);
  counts.sent_message_bytes = read(tallies_.sent_message_bytes);
  counts.received_messages = read(tallies_.received_messages);
  counts.received_datagrams = read(tallies_.received_datagrams);
  counts.connections = read(tallies_.connections);
  counts.failed_connections = read(tallies_.failed_connections);
  for (std::size_t i = 0; i < kMqttDrops; ++i) counts.drops[i] = read(tallies_.drops[i]);
  return counts;
}

std::string MqttPort::last_fault() const {
  const std::lock_guard lock(fault_mutex_);
  return fault_;
}

void MqttPort::note_fault(const std::string& fault) {
  const std::lock_guard lock(fault_mutex_);
  fault_ = fault;
}

}  // namespace g3d::net
