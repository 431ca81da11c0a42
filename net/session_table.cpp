// SPDX-License-Identifier: Apache-2.0
#include "net/session_table.hpp"

#include <algorithm>

namespace g3d::net {

SessionTable::SessionTable(const OwnIdentity& own, std::size_t most_sessions, const RateLimits& challenges)
    : own_(own), known_(std::max<std::size_t>(most_sessions, 1)), challenges_(challenges) {
  revoked_.reserve(FleetKey::kMostRevoked);
}

KnownSession* SessionTable::find(std::uint64_t session, hal::TimeNs now_ns) {
  const auto begin = known_.begin(), end = begin + static_cast<std::ptrdiff_t>(used_);
  const auto at = std::find_if(begin, end, [session](const KnownSession& known) { return known.session == session; });
  if (at == end) return nullptr;
  if (now_ns - at->proven_ns < kProvenFor_ns) return &*at;
  ++expired_;
  forget(*at);
  return nullptr;
}

std::optional<GateRefusal> SessionTable::take(KnownSession& known, std::uint64_t counter, std::uint64_t source,
                                              hal::TimeNs now_ns) {
  switch (known.window.take(counter)) {
    case Freshness::replayed:
      return GateRefusal::replayed;
    case Freshness::too_old:
      return GateRefusal::too_old;
    case Freshness::fresh:
      break;
  }
  known.source = source;
  known.heard_ns = now_ns;
  return std::nullopt;
}

std::variant<Challenge, GateRefusal> SessionTable::challenge(std::uint64_t session, std::uint64_t source,
                                                             hal::TimeNs now_ns) {
  if (session == own_.session) return GateRefusal::own_session;
  return challenges_.ask(session, source, now_ns);
}

std::optional<GateRefusal> SessionTable::prove(std::uint64_t session, std::uint64_t counter, const Response& response,
                                               std::uint64_t source, hal::TimeNs now_ns) {
  if (session == own_.session) return GateRefusal::own_session;
  KnownSession* const before = find(session, now_ns);
  if (before != nullptr) {
    if (const auto reason = take(*before, counter, source, now_ns)) return reason;
  }
  if (!challenges_.redeem(response.nonce, session, now_ns)) return GateRefusal::stale_response;
  if (is_revoked(response.robot)) return GateRefusal::revoked;
  if (response.robot == own_.robot) return GateRefusal::same_robot;
  if (before != nullptr) forget(*before);
  KnownSession& known = place_for(response.robot);
  known = {session, response.robot, response.incarnation, source, now_ns, now_ns, {}};
  known.window.begin_at(counter);
  return std::nullopt;
}

KnownSession& SessionTable::place_for(std::uint64_t robot) {
  const auto begin = known_.begin(), end = begin + static_cast<std::ptrdiff_t>(used_);
  const auto before = std::find_if(begin, end, [robot](const KnownSession& known) { return known.robot == robot; });
  if (before != end) {
    ++superseded_;
    return *before;
  }
  if (used_ < known_.size()) return known_[used_++];
  ++evicted_;
  return *std::min_element(begin, end,
                           [](const KnownSession& a, const KnownSession& b) { return a.heard_ns < b.heard_ns; });
}

bool SessionTable::is_revoked(std::uint64_t robot) const {
  return std::find(revoked_.begin(), revoked_.end(), robot) != revoked_.end();
}

void SessionTable::use_revoked(std::span<const std::uint64_t> robots) {
  revoked_.assign(robots.begin(),
                  robots.begin() + static_cast<std::ptrdiff_t>(std::min(robots.size(), FleetKey::kMostRevoked)));
  const auto begin = known_.begin(), end = begin + static_cast<std::ptrdiff_t>(used_);
  const auto kept = std::remove_if(begin, end, [this](const KnownSession& known) { return is_revoked(known.robot); });
  used_ = static_cast<std::size_t>(kept - begin);
}

}  // namespace g3d::net
