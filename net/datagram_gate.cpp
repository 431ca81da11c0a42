// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_gate.hpp"

#include <utility>
#include <variant>

namespace g3d::net {
namespace {

constexpr std::size_t kAnsweredSources = 128;

GateRefusal refusal_of(OpenVerdict verdict) {
  switch (verdict) {
    case OpenVerdict::too_short:
      return GateRefusal::too_short;
    case OpenVerdict::too_long:
      return GateRefusal::too_long;
    case OpenVerdict::unknown_format:
      return GateRefusal::unknown_format;
    case OpenVerdict::unknown_epoch:
      return GateRefusal::unknown_epoch;
    case OpenVerdict::forged:
    case OpenVerdict::opened:
      break;
  }
  return GateRefusal::forged;
}

}  // namespace

DatagramGate::DatagramGate(FleetKey keys, const GateSettings& settings, SenderStart start)
    : keys_(std::move(keys)),
      sealer_(start),
      opener_(keys_),
      sessions_({start.session, settings.robot, settings.incarnation}, settings.most_sessions, settings.challenges),
      datagram_limit_(settings.datagrams, settings.most_sources),
      answer_limit_(settings.answers, kAnsweredSources) {
  sessions_.use_revoked(keys_.revoked);
}

void DatagramGate::use_keys(FleetKey keys) {
  keys_ = std::move(keys);
  sessions_.use_revoked(keys_.revoked);
  stragglers_.forget();
}

GateTaken DatagramGate::refuse(GateRefusal reason) {
  counts_.count(reason);
  return {.verdict = GateVerdict::refused, .reason = reason};
}

// A known session that speaks from where it last did pays for itself, apart from all else that seems to come from
// there: who forges a robot's address does not silence it, nor does who copies its session. Who does both can only by
// as many datagrams as a robot may send: its forgeries are not charged, or twenty a second would do.
std::uint64_t DatagramGate::payer(const Envelope& envelope, std::uint64_t source, hal::TimeNs now_ns,
                                  RateClass& rate_class) {
  const KnownSession* const known = sessions_.find(envelope.session, now_ns);
  const bool at_home = known != nullptr && known->source == source;
  rate_class = at_home ? RateClass::known : RateClass::stranger;
  return at_home ? envelope.session : source;
}

GateTaken DatagramGate::take(std::span<const std::uint8_t> datagram, std::uint64_t source, hal::TimeNs now_ns) {
  const Envelope envelope = opener_.look(datagram);
  if (envelope.verdict != OpenVerdict::opened) return refuse(refusal_of(envelope.verdict));
  if (envelope.session == sealer_.session()) return refuse(GateRefusal::own_session);
  RateClass rate_class = RateClass::stranger;
  const std::uint64_t payer_of = payer(envelope, source, now_ns, rate_class);
  switch (datagram_limit_.admit(payer_of, rate_class, now_ns)) {
    case RateVerdict::source_rate:
      return refuse(GateRefusal::source_rate);
    case RateVerdict::overall_rate:
      return refuse(GateRefusal::overall_rate);
    case RateVerdict::admitted:
      break;
  }
  const Opener::Opened opened = opener_.open(datagram, opened_);
  if (opened.envelope.verdict != OpenVerdict::opened) {
    if (rate_class == RateClass::stranger) datagram_limit_.charge_forged(payer_of, now_ns);
    return refuse(refusal_of(opened.envelope.verdict));
  }
  return envelope.kind.handshake ? take_handshake(opened, source, now_ns) : take_data(opened, source, now_ns);
}

GateTaken DatagramGate::take_data(const Opener::Opened& opened, std::uint64_t source, hal::TimeNs now_ns) {
  const Envelope& envelope = opened.envelope;
  KnownSession* const known = sessions_.find(envelope.session, now_ns);
  if (known == nullptr) {
    const auto asked = sessions_.challenge(envelope.session, source, now_ns);
    if (const auto* const reason = std::get_if<GateRefusal>(&asked)) return refuse(*reason);
    ++counts_.challenged;
    return answer(encode(std::get<Challenge>(asked)), envelope);
  }
  if (const auto reason = sessions_.take(*known, envelope.counter, source, now_ns)) return refuse(*reason);
  stragglers_.note(envelope, now_ns);
  ++counts_.delivered;
  GateTaken taken;
  if (SessionTable::should_prove_again(*known, now_ns)) {
    const auto asked = sessions_.challenge(envelope.session, source, now_ns);
    if (const auto* const challenge = std::get_if<Challenge>(&asked)) taken = answer(encode(*challenge), envelope);
  }
  taken.verdict = GateVerdict::deliver;
  taken.robot = known->robot;
  taken.incarnation = known->incarnation;
  taken.session = known->session;
  taken.plaintext = opened.plaintext;
  return taken;
}

GateTaken DatagramGate::take_handshake(const Opener::Opened& opened, std::uint64_t source, hal::TimeNs now_ns) {
  const auto message = decode_handshake(opened.plaintext);
  if (!message) return refuse(GateRefusal::malformed_handshake);
  if (const auto* const challenge = std::get_if<Challenge>(&*message)) {
    return take_challenge(*challenge, opened.envelope, source, now_ns);
  }
  return take_response(std::get<Response>(*message), opened.envelope, source, now_ns);
}

// An unknown session is answered as well, or two that do not know each other would wait for ever. A recorded challenge
// can make us answer, a few times a second, but opens nothing to whoever sent it: its nonce is used up.
GateTaken DatagramGate::take_challenge(const Challenge& challenge, const Envelope& envelope, std::uint64_t source,
                                       hal::TimeNs now_ns) {
  if (KnownSession* const known = sessions_.find(envelope.session, now_ns)) {
    if (const auto reason = sessions_.take(*known, envelope.counter, source, now_ns)) return refuse(*reason);
  }
  if (challenge.session != sealer_.session()) return refuse(GateRefusal::foreign_challenge);
  if (answer_limit_.admit(source, RateClass::stranger, now_ns) != RateVerdict::admitted) {
    return refuse(GateRefusal::answer_rate);
  }
  const OwnIdentity& own = sessions_.own();
  ++counts_.answered;
  return answer(encode(Response{challenge.nonce, own.robot, own.incarnation}), envelope);
}

GateTaken DatagramGate::take_response(const Response& response, const Envelope& envelope, std::uint64_t source,
                                      hal::TimeNs now_ns) {
  const bool again = sessions_.find(envelope.session, now_ns) != nullptr;
  if (const auto reason = sessions_.prove(envelope.session, envelope.counter, response, source, now_ns)) {
    return refuse(*reason);
  }
  stragglers_.note(envelope, now_ns);
  ++(again ? counts_.proven_again : counts_.proven);
  return {.verdict = GateVerdict::handled, .robot = response.robot, .incarnation = response.incarnation};
}

GateTaken DatagramGate::answer(std::span<const std::uint8_t> message, const Envelope& to) {
  const Sealed sealed = seal_as(true, to.previous_epoch, message);
  if (sealed.verdict != SealVerdict::sealed) return {.verdict = GateVerdict::handled};
  return {.verdict = GateVerdict::answer, .answer = sealed.datagram};
}

DatagramGate::Sealed DatagramGate::seal(std::span<const std::uint8_t> plaintext, hal::TimeNs now_ns) {
  return seal_as(false, hears_stragglers(now_ns), plaintext);
}

DatagramGate::Sealed DatagramGate::seal_as(bool handshake, bool previous_epoch,
                                           std::span<const std::uint8_t> plaintext) {
  const std::uint16_t epoch = previous_epoch ? keys_.previous_epoch() : keys_.epoch;
  const SecretKey& key = previous_epoch ? *keys_.previous : keys_.key;
  const auto [verdict, size_bytes] = sealer_.seal({handshake, previous_epoch}, epoch, key, plaintext, sealed_);
  ++(verdict != SealVerdict::sealed ? counts_.not_sealed : counts_.sealed);
  if (verdict == SealVerdict::sealed && previous_epoch) ++counts_.sealed_previous;
  return {verdict, std::span<const std::uint8_t>(sealed_).first(size_bytes)};
}

GateCounts DatagramGate::counts() const {
  GateCounts counts = counts_;
  counts.evicted = sessions_.evicted();
  counts.expired = sessions_.expired();
  counts.superseded = sessions_.superseded();
  return counts;
}

}  // namespace g3d::net
