// SPDX-License-Identifier: Apache-2.0
#include "net/gate_refusals.hpp"

#include <numeric>

namespace g3d::net {

const char* to_string(GateRefusal reason) {
  switch (reason) {
    case GateRefusal::too_short:
      return "too_short";
    case GateRefusal::too_long:
      return "too_long";
    case GateRefusal::unknown_format:
      return "unknown_format";
    case GateRefusal::unknown_epoch:
      return "unknown_epoch";
    case GateRefusal::own_session:
      return "own_session";
    case GateRefusal::source_rate:
      return "source_rate";
    case GateRefusal::overall_rate:
      return "overall_rate";
    case GateRefusal::forged:
      return "forged";
    case GateRefusal::replayed:
      return "replayed";
    case GateRefusal::too_old:
      return "too_old";
    case GateRefusal::malformed_handshake:
      return "malformed_handshake";
    case GateRefusal::foreign_challenge:
      return "foreign_challenge";
    case GateRefusal::answer_rate:
      return "answer_rate";
    case GateRefusal::unproven:
      return "unproven";
    case GateRefusal::challenge_rate:
      return "challenge_rate";
    case GateRefusal::stale_response:
      return "stale_response";
    case GateRefusal::revoked:
      return "revoked";
    case GateRefusal::same_robot:
      return "same_robot";
    case GateRefusal::count_:
      break;
  }
  return "unknown";
}

std::uint64_t GateCounts::refused() const {
  return std::accumulate(by_reason.begin(), by_reason.end(), std::uint64_t{0});
}

}  // namespace g3d::net
