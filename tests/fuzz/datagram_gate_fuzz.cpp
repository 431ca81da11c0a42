// SPDX-License-Identifier: Apache-2.0
// The gate between network and fleet. The input is a script of datagrams: bytes as they are; authentic envelopes with
// any content, as data or as handshake, of three sessions; right answers to challenges; recordings; time. Whatever
// comes: nothing is delivered but what a session sealed that has answered, each datagram once and unchanged; every one
// is counted; a handshake decodes to what encodes to the same bytes.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "net/datagram_gate.hpp"

namespace {

using namespace g3d::net;
using Datagram = std::vector<std::uint8_t>;
using Bytes = std::span<const std::uint8_t>;

/// Longer scripts tell nothing more.
constexpr std::size_t kMaxInput_bytes = 4096;

void check(bool holds) {
  if (!holds) std::abort();
}

FleetKey fixed_key() {
  FleetKey keys;
  keys.epoch = 8;
  check(SecretKey::from_hex(std::string(64, 'a'), keys.key));
  keys.previous.emplace();
  check(SecretKey::from_hex(std::string(64, 'b'), *keys.previous));
  keys.revoked = {0x30};
  return keys;
}

void check_handshake(Bytes content) {
  const auto message = decode_handshake(content);
  if (!message) return;
  std::visit(
      [content](const auto& read) {
        const auto bytes = encode(read);
        check(std::equal(bytes.begin(), bytes.end(), content.begin(), content.end()));
      },
      *message);
}

class Script {
 public:
  explicit Script(Bytes input) : input_(input) {}

  void run() {
    while (const auto step = byte()) {
      const std::size_t who = *step / 16 % senders_.size();
      switch (*step % 8) {
        case 0:
          take(chunk(), std::nullopt);
          break;
        case 1:
        case 2:
          send(who, {.handshake = false, .holds_newer = *step % 8 == 2}, chunk());
          break;
        case 3:
          check_handshake(chunk_ahead());
          send(who, {.handshake = true}, chunk());
          break;
        case 4:
          send(who, {.handshake = true}, encode(Response{challenges_[who].nonce, byte().value_or(1), 1}));
          break;
        case 5:
          if (!recorded_.empty()) {
            const auto& [datagram, sender] = recorded_[byte().value_or(0) % recorded_.size()];
            take(Datagram(datagram), sender);
          }
          break;
        case 6:
          now_ns_ += byte().value_or(0) * 50 * g3d::hal::kMillisecond_ns;
          break;
        default:
          send(who, {.handshake = true}, encode(Challenge{byte().value_or(0), gate_.own_session()}));
      }
    }
    check(gate_.counts().taken() == taken_);
    check(gate_.sessions().size() <= 2);
  }

 private:
  std::optional<std::uint8_t> byte() {
    if (at_ >= input_.size()) return std::nullopt;
    return input_[at_++];
  }
  [[nodiscard]] Bytes chunk_ahead() const {
    if (at_ >= input_.size()) return {};
    return input_.subspan(at_ + 1, std::min<std::size_t>(input_[at_], input_.size() - at_ - 1));
  }
  Bytes chunk() {
    const Bytes taken = chunk_ahead();
    at_ += at_ < input_.size() ? taken.size() + 1 : 0;
    return taken;
  }

  void send(std::size_t who, DatagramKind kind, Bytes content) {
    std::array<std::uint8_t, kMostDatagram_bytes> out;
    const bool previous = who == 2;
    const auto sealed = senders_[who]->seal(kind, previous ? keys_.previous_epoch() : keys_.epoch,
                                            previous ? *keys_.previous : keys_.key, content, out);
    check(sealed.verdict == SealVerdict::sealed);
    Datagram datagram(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(sealed.size_bytes));
    plaintexts_.emplace_back(kind.handshake ? Datagram() : Datagram(content.begin(), content.end()));
    recorded_.emplace_back(datagram, Sent{who, plaintexts_.size() - 1, kind.handshake});
    take(datagram, recorded_.back().second);
  }

  struct Sent {
    std::size_t who;
    std::size_t plaintext;
    bool handshake;
  };
  void take(Bytes datagram, std::optional<Sent> sent) {
    ++taken_;
    const GateTaken taken = gate_.take(datagram, 5, now_ns_);
    if (taken.verdict == GateVerdict::deliver) {
      check(sent && !sent->handshake && std::ranges::equal(taken.plaintext, plaintexts_[sent->plaintext]));
      check(delivered_.insert(sent->plaintext).second);
      check(taken.robot != 0x30 && taken.robot != 0x20);
      const auto known = gate_.sessions();
      check(std::any_of(known.begin(), known.end(), [&](const KnownSession& k) {
        return k.session == senders_[sent->who]->session() && now_ns_ - k.proven_ns < SessionTable::kProvenFor_ns;
      }));
    } else {
      check(taken.plaintext.empty());
    }
    check(!taken.answer.empty() || taken.verdict != GateVerdict::answer);
    if (taken.answer.empty()) return;
    check(sent.has_value());
    std::array<std::uint8_t, kMostDatagram_bytes> out;
    const auto opened = Opener(keys_).open(taken.answer, out);
    check(opened.envelope.verdict == OpenVerdict::opened && opened.envelope.kind.handshake);
    const auto message = decode_handshake(opened.plaintext);
    check(message.has_value());
    if (const auto* const challenge = std::get_if<Challenge>(&*message)) challenges_[sent->who] = *challenge;
  }

  const Bytes input_;
  std::size_t at_ = 0;
  inline static const FleetKey keys_ = fixed_key();
  DatagramGate gate_{fixed_key(), {.robot = 0x20, .most_sessions = 2, .most_sources = 16}, {0x99, 0}};
  std::array<std::unique_ptr<Sealer>, 3> senders_{std::make_unique<Sealer>(SenderStart{0x11, 0}),
                                                  std::make_unique<Sealer>(SenderStart{0x22, 5000}),
                                                  std::make_unique<Sealer>(SenderStart{0x33, kMostCounter - 5000})};
  std::array<Challenge, 3> challenges_;
  std::vector<std::pair<Datagram, Sent>> recorded_;
  std::vector<Datagram> plaintexts_;
  std::set<std::size_t> delivered_;
  std::uint64_t taken_ = 0;
  g3d::hal::TimeNs now_ns_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes > kMaxInput_bytes) return -1;
  Script({data, size_bytes}).run();
  return 0;
}
