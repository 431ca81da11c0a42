// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/mqtt/mqtt_client.hpp"
#include "tests/support/broker_process.hpp"

namespace {

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::test;

bool client_tests_have_broker() {
  const std::string missing = BrokerProcess::what_is_missing();
  if (!missing.empty()) WARN("this case did not run: " << missing);
  return missing.empty();
}

struct HeardClient {
  explicit HeardClient(MqttSettings settings) {
    auto made = MqttClient::make(settings, [this](std::string_view topic, std::span<const std::uint8_t> payload) {
      heard.emplace_back(std::string(topic), std::string(payload.begin(), payload.end()));
    });
    if (!made) throw std::runtime_error(made.error().text);
    client = std::move(made).value();
  }
  /// Until `done`, or the connection is lost, or for long.
  template <class Done>
  bool serve_until(Done&& done) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!done()) {
      if (std::chrono::steady_clock::now() > end || !client->serve(true, true)) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  [[nodiscard]] bool connect() const {
    return client->connect() && serve_until([&] { return client->is_ready(); });
  }
  std::unique_ptr<MqttClient> client;
  std::vector<std::pair<std::string, std::string>> heard;
};

MqttSettings settings_for(std::uint16_t port, const char* id) {
  MqttSettings settings;
  settings.host = "127.0.0.1";
  settings.port = port;
  settings.client_id = id;
  settings.subscriptions = {"a/+", "b"};
  return settings;
}

std::span<const std::uint8_t> as_payload(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Listens, and says `words` to whoever connects, then closes.
class FalseBroker {
 public:
  explicit FalseBroker(std::string words)
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), words_(std::move(words)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(fd_, 4) == 0);
    REQUIRE(::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      const int client = ::accept(fd_, nullptr, nullptr);
      (void)!::write(client, words_.data(), words_.size());
      ::shutdown(client, SHUT_WR);
      char rest[256];
      while (::read(client, rest, sizeof rest) > 0) {
      }
      ::close(client);
    });
  }
  ~FalseBroker() {
    thread_.join();
    ::close(fd_);
  }
  std::uint16_t port = 0;

 private:
  int fd_;
  std::string words_;
  std::thread thread_;
};

TEST_CASE("settings that libmosquitto would trip over are refused with a remedy") {
  if (!MqttClient::is_built_in()) return;
  const auto refusal = [](const MqttSettings& settings) {
    const auto made = MqttClient::make(settings, {});
    return made.ok() ? std::string("none") : made.error().text;
  };
  MqttSettings settings = settings_for(1883, "a");
  CHECK(refusal(settings) == "none");
  settings.host = "::1";
  CHECK(refusal(settings) == "none");
  for (const char* host : {"", "localhost", "127.0.0.1:1883", "127.0.0", "fe80::1%eth0"}) {
    settings.host = host;
    CHECK_THAT(refusal(settings), Catch::Contains("does not look up names"));
  }
  settings = settings_for(0, "a");
  CHECK_THAT(refusal(settings), Catch::Contains("port 0"));
  settings = settings_for(1883, "a");
  settings.keepalive_s = 1;
  CHECK_THAT(refusal(settings), Catch::Contains("keepalive 1 s"));
  settings = settings_for(1883, "a");
  settings.subscriptions = {"a+"};
  CHECK_THAT(refusal(settings), Catch::Contains("'a+' is no MQTT topic"));
  settings.subscriptions.clear();
  CHECK_THAT(refusal(settings), Catch::Contains("no topic"));
}

TEST_CASE("a client hears what others say under its topics, also by number, and not itself") {
  if (!client_tests_have_broker()) return;
  BrokerProcess broker;
  broker.start();
  HeardClient a(settings_for(broker.port(), "a")), b(settings_for(broker.port(), "b"));
  REQUIRE(a.connect());
  REQUIRE(b.connect());
  REQUIRE(a.client->most_aliases() >= 2);
  const std::string large(40'000, 'x');
  CHECK(a.client->publish("b", 0, as_payload("plain"), 5));
  CHECK(a.client->publish("a/1", 2, as_payload("numbered"), 5));
  CHECK(a.client->publish("", 2, as_payload("by number"), 5));
  CHECK(a.client->publish("a/2/3", 0, as_payload("not asked for"), 5));
  CHECK(a.client->publish("a/1", 0, as_payload(large), 5));
  CHECK(a.client->publish("b", 0, {}, 5));
  CHECK_FALSE(a.client->publish("a/+", 0, as_payload("to a pattern"), 5));
  CHECK_FALSE(a.client->publish("", 0, as_payload("to nothing"), 5));
  CHECK(b.serve_until([&] {
    (void)a.client->serve(true, true);
    return b.heard.size() >= 5;
  }));
  CHECK(b.heard ==
        decltype(b.heard){{"b", "plain"}, {"a/1", "numbered"}, {"a/1", "by number"}, {"a/1", large}, {"b", ""}});
  CHECK(a.heard.empty());
  a.client->disconnect();
  CHECK(a.client->socket() == -1);
  CHECK_FALSE(a.client->publish("b", 0, as_payload("gone"), 5));
  // And again.
  CHECK(a.connect());
}

TEST_CASE("a broker that wants a name and a word, or grants no topic, refuses with its reason") {
  if (!client_tests_have_broker()) return;
  BrokerProcess broker("allow_anonymous false\n");
  broker.start();
  HeardClient stranger(settings_for(broker.port(), "a"));
  CHECK_FALSE(stranger.connect());
  CHECK_THAT(stranger.client->last_fault(), Catch::Contains("refused: Not authorized"));
  MqttSettings settings = settings_for(broker.port(), "a");
  settings.user = "somebody";
  settings.password = "guessed";
  HeardClient guesser(settings);
  CHECK_FALSE(guesser.connect());
  CHECK_THAT(guesser.client->last_fault(), Catch::Contains("refused: "));
}

TEST_CASE("what is no broker ends the connection with a reason: silence, noise, answers without content, floods") {
  if (!MqttClient::is_built_in()) return;
  const std::string connack("\x20\x03\x00\x00\x00", 5);
  for (const std::string& words :
       {std::string(), std::string("HTTP/1.1 400 Bad Request\r\n\r\n"), std::string(2000, '\xFF'),
        std::string("\x20\x7F", 2), connack + connack + std::string("\x90\x02\x00\x01", 4),  // grants nothing
        connack + std::string("\x30\xFF\xFF\xFF\x7F", 5) + std::string(200'000, 'x'),        // 256 MB are announced
        connack + std::string("\x30\x04\x00\x10xx", 6),                                      // a topic beyond the end
        std::string("\x20\x03\x00\x87\x00", 5), connack + std::string("\xE0\x02\x8E\x00", 4)}) {
    CAPTURE(words.substr(0, 20));
    FalseBroker broker(words);
    HeardClient client(settings_for(broker.port, "a"));
    CHECK_FALSE(client.connect());
    CHECK(client.client->last_fault().size() > 25);
    if (words.find("\x30\xFF") != std::string::npos)
      CHECK_THAT(client.client->last_fault(), Catch::Contains("larger than supported"));
    CHECK(client.client->socket() == -1);
    CHECK(client.heard.empty());
    client.client->disconnect();
  }
}

TEST_CASE("where nobody listens the connection is refused, not waited for") {
  if (!MqttClient::is_built_in()) return;
  HeardClient client(settings_for(1, "a"));
  CHECK_FALSE(client.connect());
  CHECK_THAT(client.client->last_fault(), Catch::Contains("broker 127.0.0.1 port 1: Connection refused"));
}

}  // namespace
