// SPDX-License-Identifier: Apache-2.0
#include "net/update_sender.hpp"

#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "tests/support/update_host.hpp"

using namespace g3d;
using namespace g3d::net;
using hal::Reason;
using test::SlotMachine;
using test::UpdateHost;

namespace {

constexpr std::uint32_t kLoopback = 0x7F000001;

/// A wire that is cut after so many bytes of the sender, again and again, until no more cuts are due.
class CutWire {
 public:
  CutWire(const hal::Ipv4Endpoint& to, std::vector<std::uint64_t> cuts_bytes)
      : to_(to), cuts_bytes_(std::move(cuts_bytes)), listener_(opened()), thread_([this] { carry(); }) {}
  ~CutWire() {
    is_over_ = true;
    thread_.join();
  }
  CutWire(const CutWire&) = delete;
  CutWire& operator=(const CutWire&) = delete;
  [[nodiscard]] hal::Ipv4Endpoint at() const { return listener_.endpoint(); }
  [[nodiscard]] std::size_t cuts() const { return cuts_; }

 private:
  static hal::TcpListener opened() {
    auto listener = hal::TcpListener::open({kLoopback, 0});
    REQUIRE(listener.ok());
    return std::move(listener).value();
  }
  void carry() {
    while (!is_over_) {
      pollfd wait{listener_.fd(), POLLIN, 0};
      if (::poll(&wait, 1, 20) != 1) continue;
      hal::Ipv4Endpoint from;
      auto sender = listener_.accept(from);
      auto machine = hal::TcpLink::connect(to_, 5000);
      if (!sender || !machine) continue;
      carry_one(*sender, machine.value());
    }
  }
  void carry_one(hal::TcpLink& sender, hal::TcpLink& machine) {
    std::uint64_t left = cuts_ < cuts_bytes_.size() ? cuts_bytes_[cuts_] : ~std::uint64_t{0};
    std::vector<std::uint8_t> buffer(30'000);
    while (!is_over_) {
      std::array<pollfd, 2> waits{pollfd{sender.fd(), POLLIN, 0}, pollfd{machine.fd(), POLLIN, 0}};
      if (::poll(waits.data(), waits.size(), 20) < 0) return;
      std::size_t count = 0;
      if (waits[0].revents != 0) {
        const std::size_t room = std::min<std::uint64_t>(buffer.size(), left);
        if (sender.receive(std::span(buffer).first(room), count) == hal::TcpLink::Outcome::over) return;
        if (!machine.send_all(std::span(buffer).first(count), 5000)) return;
        left -= count;
        if (left == 0) {
          ++cuts_;
          return;
        }
      }
      if (waits[1].revents != 0) {
        if (machine.receive(buffer, count) == hal::TcpLink::Outcome::over) return;
        if (!sender.send_all(std::span(buffer).first(count), 5000)) return;
      }
    }
  }

  const hal::Ipv4Endpoint to_;
  const std::vector<std::uint64_t> cuts_bytes_;
  std::atomic<std::size_t> cuts_{0};
  std::atomic<bool> is_over_{false};
  hal::TcpListener listener_;
  std::thread thread_;
};

UpdateSenderOptions quick(const hal::Ipv4Endpoint& to) {
  UpdateSenderOptions options;
  options.to = to;
  options.pause_ms = 20;
  options.patience_s = 30.0;
  return options;
}

}  // namespace

TEST_CASE("an update is sent, and how far it is is told", "[update][threads]") {
  SlotMachine machine;
  const auto manifest = machine.make_image(40 * kChunk_bytes + 1, 6);
  UpdateHost host(machine);
  std::uint32_t told = 0;
  const auto sent = send_update(machine.image_path(6), manifest, machine.key, quick(host.at()),
                                [&told](const UpdateProgress& progress) { told = std::max(told, progress.sent); });
  REQUIRE(sent.ok());
  CHECK(sent.value().end == UpdateEnd::installed);
  CHECK(sent.value().progress.sent == 41);
  CHECK(sent.value().progress.connections == 1);
  CHECK(sent.value().progress.machine.running_release == SlotMachine::kRunningRelease);
  CHECK(told == 41);
  CHECK(host.join());
  machine.check_installed(manifest);
}

TEST_CASE("a wire that is cut at random costs what was on its way, and no more", "[update][threads]") {
  std::mt19937 chance(11);
  constexpr std::size_t kImage_bytes = 30 * kChunk_bytes;
  SlotMachine machine;
  const auto manifest = machine.make_image(kImage_bytes, 6);
  UpdateServerOptions server = test::patient_server();
  server.takeover_ns = 100 * hal::kMillisecond_ns;
  UpdateHost host(machine, server);
  std::vector<std::uint64_t> cuts{1, kProof_bytes, kProof_bytes + 7};
  for (int i = 0; i < 5; ++i) cuts.push_back(1 + chance() % (5 * kChunk_bytes));
  CutWire wire(host.at(), cuts);
  const auto sent = send_update(machine.image_path(6), manifest, machine.key, quick(wire.at()));
  if (!sent) FAIL(sent.error().text);
  CHECK(sent.value().end == UpdateEnd::installed);
  CHECK(wire.cuts() == cuts.size());
  // Some of what was handed to the system had not left yet.
  CHECK(sent.value().progress.sent <= 30 + 8 * kMostWanted);
  CHECK(host.join());
  machine.check_installed(manifest);
}

TEST_CASE("every refusal says what to do", "[update][threads]") {
  SlotMachine machine;
  UpdateHost host(machine);
  const auto older = machine.make_image(1000, 4);
  const auto refused = send_update(machine.image_path(4), older, machine.key, quick(host.at()));
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().reason == Reason::no_permission);
  CHECK_THAT(refused.error().text, Catch::Contains("release 4 is not newer than 5") && Catch::Contains("--force"));
  const auto newer = machine.make_image(1000, 6);
  const auto stranger = send_update(machine.image_path(6), newer, SigningKey::random(), quick(host.at()));
  REQUIRE_FALSE(stranger.ok());
  CHECK_THAT(stranger.error().text, Catch::Contains("does not trust this signing key"));
  machine.check_runs_on();
  auto forced = quick(host.at());
  forced.force = true;
  REQUIRE(send_update(machine.image_path(4), older, machine.key, forced).ok());
  CHECK(host.join());
  for (int i = 0; i < static_cast<int>(UpdateEnd::count_); ++i) {
    CHECK(explain(static_cast<UpdateEnd>(i), {}, 1) != explain(UpdateEnd::count_, {}, 1));
  }
}

TEST_CASE("a file that changes under the sender, or a wrong address, is told at once", "[update][threads]") {
  SlotMachine machine;
  UpdateHost host(machine);
  const auto manifest = machine.make_image(10'000, 6);
  test::write_plain(machine.image_path(6), test::system_image(10'000, 99));
  const auto changed = send_update(machine.image_path(6), manifest, machine.key, quick(host.at()));
  REQUIRE_FALSE(changed.ok());
  CHECK(changed.error().reason == Reason::bad_checksum);
  const hal::Ipv4Endpoint gone = host.at();
  CHECK_FALSE(host.stop());
  machine.check_runs_on();
  CHECK(send_update(machine.image_path(6), manifest, machine.key, quick({kLoopback, 1})).error().reason ==
        Reason::not_found);
  CHECK(send_update(machine.folder / "none", manifest, machine.key, quick(gone)).error().reason == Reason::not_found);
}

TEST_CASE("whatever else answers is no machine that takes updates", "[update][threads]") {
  SlotMachine machine;
  const auto manifest = machine.make_image(10'000, 6);
  auto listener = hal::TcpListener::open({kLoopback, 0});
  REQUIRE(listener.ok());
  std::thread other([&] {
    pollfd wait{listener.value().fd(), POLLIN, 0};
    (void)::poll(&wait, 1, 20'000);
    hal::Ipv4Endpoint from;
    auto link = listener.value().accept(from);
    std::array<std::uint8_t, 1> byte{};
    if (!link) return;
    (void)link->send_all(std::vector<std::uint8_t>(100, 'H'), 5000);
    (void)link->receive_all(byte, 20'000);
  });
  const auto sent = send_update(machine.image_path(6), manifest, machine.key, quick(listener.value().endpoint()));
  other.join();
  REQUIRE_FALSE(sent.ok());
  CHECK_THAT(sent.error().text, Catch::Contains("takes no updates"));
}
