// SPDX-License-Identifier: Apache-2.0
// By libmosquitto, which scripts/static_libs builds without threads.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <utility>

#include "hal/mqtt/mqtt_client.hpp"

// What the library calls in place of getaddrinfo, for which a static program would need the C library's shared parts:
// addresses are numbers.
extern "C" int g3d_getaddrinfo(const char* host, const char* service, const addrinfo* hints, addrinfo** found);
extern "C" void g3d_freeaddrinfo(addrinfo* found);

namespace {

struct NumericAddress {
  addrinfo info;
  sockaddr_storage address;
};

bool read_address(const char* host, NumericAddress& to) {
  to = {};
  auto* const v4 = reinterpret_cast<sockaddr_in*>(&to.address);
  auto* const v6 = reinterpret_cast<sockaddr_in6*>(&to.address);
  if (inet_pton(AF_INET, host, &v4->sin_addr) == 1) {
    to.info.ai_family = v4->sin_family = AF_INET;
    to.info.ai_addrlen = sizeof *v4;
  } else if (inet_pton(AF_INET6, host, &v6->sin6_addr) == 1) {
    to.info.ai_family = v6->sin6_family = AF_INET6;
    to.info.ai_addrlen = sizeof *v6;
  } else {
    return false;
  }
  to.info.ai_socktype = SOCK_STREAM;
  return true;
}

}  // namespace

int g3d_getaddrinfo(const char* host, const char* /*service*/, const addrinfo* /*hints*/, addrinfo** found) {
  auto* const address = static_cast<NumericAddress*>(std::malloc(sizeof(NumericAddress)));
  if (address == nullptr) return EAI_MEMORY;
  if (host == nullptr || !read_address(host, *address)) {
    std::free(address);
    return EAI_NONAME;
  }
  address->info.ai_addr = reinterpret_cast<sockaddr*>(&address->address);
  *found = &address->info;
  return 0;
}

void g3d_freeaddrinfo(addrinfo* found) { std::free(found); }

namespace g3d::hal {
namespace {

/// A property list of the library.
class MqttProperties {
 public:
  MqttProperties() = default;
  ~MqttProperties() { mosquitto_property_free_all(&list_); }
  MqttProperties(const MqttProperties&) = delete;
  MqttProperties& operator=(const MqttProperties&) = delete;
  mosquitto_property** list() { return &list_; }

 private:
  mosquitto_property* list_ = nullptr;
};

class MosquittoClient final : public MqttClient {
 public:
  MosquittoClient(const MqttSettings& settings, OnMessage on_message)
      : settings_(settings), on_message_(std::move(on_message)) {
    static std::once_flag is_started;
    std::call_once(is_started, mosquitto_lib_init);
    client_ = mosquitto_new(settings.client_id.c_str(), true, this);
    if (client_ == nullptr) return;
    is_usable_ = mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5) == MOSQ_ERR_SUCCESS;
    if (!settings.user.empty()) {
      is_usable_ = is_usable_ && mosquitto_username_pw_set(client_, settings.user.c_str(), settings.password.c_str()) ==
                                     MOSQ_ERR_SUCCESS;
    }
    mosquitto_connect_v5_callback_set(client_,
                                      [](mosquitto*, void* self, int reason, int, const mosquitto_property* p) {
                                        static_cast<MosquittoClient*>(self)->on_connected(reason, p);
                                      });
    mosquitto_subscribe_v5_callback_set(
        client_, [](mosquitto*, void* self, int, int count, const int* granted, const mosquitto_property*) {
          static_cast<MosquittoClient*>(self)->on_subscribed({granted, static_cast<std::size_t>(std::max(count, 0))});
        });
    mosquitto_message_v5_callback_set(
        client_, [](mosquitto*, void* self, const mosquitto_message* message, const mosquitto_property*) {
          static_cast<MosquittoClient*>(self)->on_message_(
              message->topic,
              {static_cast<const std::uint8_t*>(message->payload), static_cast<std::size_t>(message->payloadlen)});
        });
    mosquitto_disconnect_v5_callback_set(client_, [](mosquitto*, void* self, int reason, const mosquitto_property*) {
      static_cast<MosquittoClient*>(self)->disconnect_reason_ = reason;
    });
    // Properties of a connection can be given to the call alone that would wait for it. It is given an address that is
    // none, and keeps them.
    MqttProperties properties;
    is_usable_ = is_usable_ &&
                 mosquitto_property_add_int32(properties.list(), MQTT_PROP_MAXIMUM_PACKET_SIZE,
                                              settings.most_packet_bytes) == MOSQ_ERR_SUCCESS &&
                 mosquitto_connect_bind_v5(client_, "no address", settings.port, settings.keepalive_s, nullptr,
                                           *properties.list()) == MOSQ_ERR_EAI;
  }
  ~MosquittoClient() override { mosquitto_destroy(client_); }
  MosquittoClient(const MosquittoClient&) = delete;
  MosquittoClient& operator=(const MosquittoClient&) = delete;

  [[nodiscard]] bool is_usable() const { return is_usable_; }

  bool connect() override {
    state_ = State::connecting;
    disconnect_reason_ = 0;
    wants_to_subscribe_ = false;
    most_aliases_ = 0;
    errno = 0;
    const int status = mosquitto_connect_async(client_, settings_.host.c_str(), settings_.port, settings_.keepalive_s);
    if (status != MOSQ_ERR_SUCCESS) return lost(status);
    const int fd = mosquitto_socket(client_);
    const int bytes = static_cast<int>(settings_.send_buffer_bytes), one = 1;
    const int patience_ms = 2000 * settings_.keepalive_s;
    (void)setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    (void)setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof patience_ms);
    return true;
  }

  void disconnect() override {
    if (mosquitto_socket(client_) >= 0) (void)mosquitto_disconnect(client_);
    state_ = State::closed;
  }

  [[nodiscard]] int socket() const override { return state_ == State::closed ? -1 : mosquitto_socket(client_); }
  [[nodiscard]] bool wants_write() const override { return mosquitto_want_write(client_); }
  [[nodiscard]] bool is_ready() const override { return state_ == State::ready; }
  [[nodiscard]] std::uint16_t most_aliases() const override { return most_aliases_; }
  [[nodiscard]] const std::string& last_fault() const override { return fault_; }

  bool serve(bool is_readable, bool is_writable) override {
    if (state_ == State::closed) return false;
    errno = 0;
    int status = MOSQ_ERR_SUCCESS;
    if (is_readable) status = mosquitto_loop_read(client_, 1);
    if (status == MOSQ_ERR_SUCCESS && is_writable) status = mosquitto_loop_write(client_, 1);
    if (status == MOSQ_ERR_SUCCESS) status = mosquitto_loop_misc(client_);
    if (status == MOSQ_ERR_SUCCESS && std::exchange(wants_to_subscribe_, false)) status = subscribe();
    if (status == MOSQ_ERR_SUCCESS && refusal_ != 0) status = MOSQ_ERR_ACL_DENIED;
    if (status != MOSQ_ERR_SUCCESS || mosquitto_socket(client_) < 0) return lost(status);
    return true;
  }

  bool publish(const std::string& topic, std::uint16_t alias, std::span<const std::uint8_t> payload,
               std::uint32_t expiry_s) override {
    if (state_ != State::ready) return false;
    MqttProperties properties;
    int status = mosquitto_property_add_int32(properties.list(), MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, expiry_s);
    if (status == MOSQ_ERR_SUCCESS && alias != 0) {
      status = mosquitto_property_add_int16(properties.list(), MQTT_PROP_TOPIC_ALIAS, alias);
    }
    if (status == MOSQ_ERR_SUCCESS) {
      status = mosquitto_publish_v5(client_, nullptr, topic.empty() ? nullptr : topic.c_str(),
                                    static_cast<int>(payload.size()), payload.data(), 0, false, *properties.list());
    }
    return status == MOSQ_ERR_SUCCESS;
  }

 private:
  enum class State { closed, connecting, ready };

  void on_connected(int reason, const mosquitto_property* properties) {
    refusal_ = reason;
    // Asked for outside of this call: what is said within it would wait.
    wants_to_subscribe_ = reason == 0;
    (void)mosquitto_property_read_int16(properties, MQTT_PROP_TOPIC_ALIAS_MAXIMUM, &most_aliases_, false);
  }
  void on_subscribed(std::span<const int> granted) {
    // 0x80 and above is a refusal; so is an answer without answers.
    const bool is_granted = !granted.empty() && std::all_of(granted.begin(), granted.end(),
                                                            [](int quality) { return quality >= 0 && quality < 0x80; });
    if (!is_granted) refusal_ = MQTT_RC_NOT_AUTHORIZED;
    if (is_granted && state_ == State::connecting) state_ = State::ready;
  }
  int subscribe() {
    std::vector<char*> topics;
    for (std::string& topic : settings_.subscriptions) topics.push_back(topic.data());
    // What we publish ourselves does not come back.
    return mosquitto_subscribe_multiple(client_, nullptr, static_cast<int>(topics.size()), topics.data(), 0,
                                        MQTT_SUB_OPT_NO_LOCAL, nullptr);
  }
  bool lost(int status) {
    const int system_error = errno;
    const int refusal = std::exchange(refusal_, 0);
    const std::string place = fmt::format("broker {} port {}: ", settings_.host, settings_.port);
    if (refusal != 0) {
      fault_ = place + "refused: " + mosquitto_reason_string(refusal);
    } else if (status == MOSQ_ERR_ERRNO && system_error != 0) {
      fault_ = place + std::strerror(system_error);
    } else if (disconnect_reason_ >= 0x80) {
      fault_ = place + mosquitto_reason_string(disconnect_reason_);
    } else {
      const bool has_reason = status != MOSQ_ERR_SUCCESS && status != MOSQ_ERR_ERRNO;
      fault_ = place + mosquitto_strerror(has_reason ? status : MOSQ_ERR_CONN_LOST);
    }
    state_ = State::closed;
    return false;
  }

  MqttSettings settings_;
  OnMessage on_message_;
  mosquitto* client_ = nullptr;
  bool is_usable_ = false;
  State state_ = State::closed;
  bool wants_to_subscribe_ = false;
  std::uint16_t most_aliases_ = 0;
  int refusal_ = 0;  ///< why the broker will not have us
  int disconnect_reason_ = 0;
  std::string fault_;
};

Error mqtt_misuse(std::string text) { return {Reason::bad_usage, std::move(text)}; }

}  // namespace

bool MqttClient::is_built_in() { return true; }

Result<std::unique_ptr<MqttClient>> MqttClient::make(const MqttSettings& settings, OnMessage on_message) {
  NumericAddress address;
  if (!read_address(settings.host.c_str(), address)) {
    return mqtt_misuse(
        fmt::format("broker '{}' is no numeric IPv4 or IPv6 address; write it like 192.0.2.7, this program "
                    "does not look up names",
                    settings.host));
  }
  if (settings.port == 0) return mqtt_misuse("port 0 of a broker; write 1 to 65535, the usual one is 1883");
  for (const std::string& topic : settings.subscriptions) {
    if (mosquitto_sub_topic_check(topic.c_str()) != MOSQ_ERR_SUCCESS ||
        mosquitto_validate_utf8(topic.c_str(), static_cast<int>(topic.size())) != MOSQ_ERR_SUCCESS) {
      return mqtt_misuse(fmt::format("'{}' is no MQTT topic that can be listened to", topic));
    }
  }
  if (settings.subscriptions.empty()) return mqtt_misuse("a broker is asked for no topic");
  auto client = std::make_unique<MosquittoClient>(settings, std::move(on_message));
  if (!client->is_usable()) {
    return mqtt_misuse(fmt::format("libmosquitto does not take id '{}', user '{}' or keepalive {} s",
                                   settings.client_id, settings.user, settings.keepalive_s));
  }
  return std::unique_ptr<MqttClient>(std::move(client));
}

}  // namespace g3d::hal
