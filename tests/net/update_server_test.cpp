// SPDX-License-Identifier: Apache-2.0
#include "net/update_server.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>

#include "net/update_offer.hpp"
#include "tests/support/update_host.hpp"

using namespace g3d;
using namespace g3d::net;
using test::SlotMachine;
using test::UpdateHost;

namespace {

constexpr int kPatience_ms = 20'000;
constexpr std::size_t kImage_bytes = 3 * kChunk_bytes + 99;

/// A sender step by step, as hostile or slow as a test wants.
class RawSender {
 public:
  RawSender(const UpdateHost& host, const UpdateManifest& manifest, const SigningKey& key,
            const std::vector<std::uint8_t>& image)
      : manifest_(manifest), image_(image), offer_(manifest, key, false) {
    auto link = hal::TcpLink::connect(host.at(), kPatience_ms);
    REQUIRE(link.ok());
    link_ = std::move(link).value();
    GreetingBytes greeting;
    REQUIRE(link_.receive_all(greeting, kPatience_ms));
    REQUIRE(offer_.take_greeting(greeting));
  }
  void open_up() { REQUIRE(link_.send_all(offer_.opening(), kPatience_ms)); }
  /// Answers until a word is neither `want` nor `working`, or until `most_chunks` were sent. None: cut.
  std::optional<UpdateEnd> answer(std::uint32_t most_chunks = ~0U) {
    while (most_chunks > 0) {
      WordBytes word;
      if (!link_.receive_all(word, kPatience_ms)) return std::nullopt;
      const auto next = offer_.take_word(word);
      if (next == UpdateOffer::Next::ended) return offer_.end();
      if (next != UpdateOffer::Next::send_chunk) continue;
      send_chunk(offer_.chunk());
      --most_chunks;
    }
    return std::nullopt;
  }
  hal::TcpLink& link() { return link_; }

 private:
  void send_chunk(std::uint32_t chunk) {
    std::vector<std::uint8_t> bytes(kChunkHead_bytes);
    std::memcpy(bytes.data(), &chunk, sizeof chunk);
    const auto at = image_.begin() + static_cast<std::ptrdiff_t>(manifest_.offset_of(chunk));
    bytes.insert(bytes.end(), at, at + static_cast<std::ptrdiff_t>(manifest_.size_of(chunk)));
    (void)link_.send_all(bytes, kPatience_ms);
  }
  const UpdateManifest& manifest_;
  const std::vector<std::uint8_t>& image_;
  UpdateOffer offer_;
  hal::TcpLink link_;
};

struct Bench {
  SlotMachine machine;
  UpdateManifest manifest = machine.make_image(kImage_bytes, 6);
  std::vector<std::uint8_t> image = test::system_image(kImage_bytes, 6);
};

}  // namespace

TEST_CASE("an update over a connection is installed, its sender is told, and the server is done", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  RawSender sender(host, bench.manifest, bench.machine.key, bench.image);
  sender.open_up();
  REQUIRE(sender.answer() == UpdateEnd::installed);
  sender.link().close();
  CHECK(host.join());
  bench.machine.check_installed(bench.manifest);
  CHECK(host.counts().proved == 1);
  CHECK(host.counts().of(UpdateEnd::installed) == 1);
  CHECK_THAT(host.told(),
             Catch::Contains("sends an update") && Catch::Contains("installed, release 6, 4 chunks received"));
}

TEST_CASE("two senders at once: one is served, the other is told", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  const UpdateManifest other_manifest = bench.machine.make_image(kImage_bytes, 7);
  const auto other_image = test::system_image(kImage_bytes, 7);
  RawSender first(host, bench.manifest, bench.machine.key, bench.image);
  RawSender second(host, other_manifest, bench.machine.key, other_image);
  first.open_up();
  CHECK_FALSE(first.answer(1));
  second.open_up();
  CHECK(second.answer() == UpdateEnd::busy);
  REQUIRE(first.answer() == UpdateEnd::installed);
  first.link().close();
  second.link().close();
  CHECK(host.join());
  bench.machine.check_installed(bench.manifest);
  CHECK(host.counts().of(UpdateEnd::busy) == 1);
}

TEST_CASE("a sender that has fallen silent gives way to one that has not", "[update][threads]") {
  Bench bench;
  UpdateServerOptions options = test::patient_server();
  options.takeover_ns = 0;  // at once
  UpdateHost host(bench.machine, options);
  RawSender silent(host, bench.manifest, bench.machine.key, bench.image);
  silent.open_up();
  CHECK_FALSE(silent.answer(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  RawSender lively(host, bench.manifest, bench.machine.key, bench.image);
  lively.open_up();
  REQUIRE(lively.answer() == UpdateEnd::installed);
  CHECK(silent.answer() == UpdateEnd::too_slow);
  silent.link().close();
  lively.link().close();
  CHECK(host.join());
  bench.machine.check_installed(bench.manifest);
}

TEST_CASE("whoever proves nothing keeps nobody out", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  std::vector<hal::TcpLink> crowd;
  for (std::size_t i = 0; i < 3 * UpdateServer::kMostConnections; ++i) {
    auto link = hal::TcpLink::connect(host.at(), kPatience_ms);
    REQUIRE(link.ok());
    (void)link.value().send_all(std::vector<std::uint8_t>(i * 3, 0xFF), kPatience_ms);
    crowd.push_back(std::move(link).value());
  }
  RawSender sender(host, bench.manifest, bench.machine.key, bench.image);
  sender.open_up();
  REQUIRE(sender.answer() == UpdateEnd::installed);
  sender.link().close();
  CHECK(host.join());
  bench.machine.check_installed(bench.manifest);
  CHECK(host.counts().crowded_out > 0);
}

TEST_CASE("a wrong key is told, and leaves no trace", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  const SigningKey stranger = SigningKey::random();
  RawSender wrong(host, bench.manifest, stranger, bench.image);
  wrong.open_up();
  CHECK(wrong.answer() == UpdateEnd::wrong_key);
  CHECK_FALSE(host.stop());
  CHECK(host.counts().proved == 0);
  bench.machine.check_runs_on();
  CHECK(bench.machine.folder.listing().find("b.img") == std::string::npos);
}

TEST_CASE("one who takes too long for a proof, or for a chunk, is told and let go", "[update][threads]") {
  Bench bench;
  UpdateServerOptions options = test::patient_server();
  options.proof_patience_ns = 100 * hal::kMillisecond_ns;
  {
    UpdateHost host(bench.machine, options);
    RawSender slow(host, bench.manifest, bench.machine.key, bench.image);
    CHECK(slow.answer() == UpdateEnd::too_slow);
  }
  options = test::patient_server();
  options.chunk_patience_ns = 300 * hal::kMillisecond_ns;
  UpdateHost host(bench.machine, options);
  RawSender stuck(host, bench.manifest, bench.machine.key, bench.image);
  stuck.open_up();
  WordBytes word;
  UpdateWord said;
  do {
    REQUIRE(stuck.link().receive_all(word, kPatience_ms));
    REQUIRE(decode_word(word, said));
  } while (said.kind != UpdateWord::Kind::end);
  CHECK(said.end == UpdateEnd::too_slow);
  CHECK_FALSE(host.stop());
  bench.machine.check_runs_on();
}

TEST_CASE("a sender that is gone in the middle leaves what has come for the next one", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  {
    RawSender cut(host, bench.manifest, bench.machine.key, bench.image);
    cut.open_up();
    CHECK_FALSE(cut.answer(2));
  }
  // The server may still take the one that was cut for alive.
  std::optional<UpdateEnd> end;
  for (int i = 0; i < 200 && end != UpdateEnd::installed; ++i) {
    RawSender again(host, bench.manifest, bench.machine.key, bench.image);
    again.open_up();
    end = again.answer();
    if (end == UpdateEnd::busy) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  REQUIRE(end == UpdateEnd::installed);
  CHECK(host.join());
  CHECK(host.counts().cut >= 1);
  bench.machine.check_installed(bench.manifest);
}

TEST_CASE("a server that is stopped tells its sender", "[update][threads]") {
  Bench bench;
  UpdateHost host(bench.machine);
  RawSender sender(host, bench.manifest, bench.machine.key, bench.image);
  sender.open_up();
  CHECK_FALSE(sender.answer(1));
  CHECK_FALSE(host.stop());
  std::optional<UpdateEnd> end;
  end = sender.answer();
  CHECK((end == UpdateEnd::stopping || !end));  // its last word may be lost with the bytes that nobody has read
  bench.machine.check_runs_on();
}
