// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/packet_reader.hpp"

#include "hal/kobuki/packet_gates.hpp"

namespace g3d::hal::kobuki {
namespace {

void take_answers(const DeviceInfo& from, DeviceInfo& to) {
  if (from.has_hardware) {
    to.has_hardware = true;
    to.hardware = from.hardware;
  }
  if (from.has_firmware) {
    to.has_firmware = true;
    to.firmware = from.firmware;
  }
  if (from.has_udid) {
    to.has_udid = true;
    to.udid = from.udid;
  }
}

}  // namespace

PacketReader::PacketReader() : scanner_(feedback_size_is_right) {}

bool PacketReader::next(TimeNs received_ns, Feedback& feedback) {
  for (auto payload = scanner_.next(rejects_); !payload.empty(); payload = scanner_.next(rejects_)) {
    Packet packet;
    std::optional<Reject> reason = decode_feedback(payload, packet);
    if (!reason) reason = impossible_value(packet.feedback);
    if (reason) {
      rejects_.count(*reason);
      continue;
    }
    packet.feedback.received_ns = received_ns;
    if (!believe(packet.feedback)) continue;
    take_answers(packet.info, info_);
    if (packet.gains) gains_ = packet.gains;
    feedback = packet.feedback;
    hold_flags(feedback);
    last_ = packet.feedback;
    candidate_.reset();
    return true;
  }
  return false;
}

bool PacketReader::believe(const Feedback& feedback) {
  if (!last_) return true;
  const std::optional<Reject> reason = impossible_step(*last_, feedback);
  if (!reason) return true;
  if (candidate_ && !impossible_step(*candidate_, feedback)) {
    ++restarts_;
    return true;
  }
  rejects_.count(*reason);
  candidate_ = feedback;
  return false;
}

void PacketReader::hold_flags(Feedback& feedback) {
  if (!last_) return;
  feedback.bumper |= last_->bumper;
  feedback.wheel_drop |= last_->wheel_drop;
  feedback.cliff |= last_->cliff;
  feedback.over_current |= last_->over_current;
}

void PacketReader::line_was_lost() {
  scanner_.clear();
  candidate_.reset();
  info_ = {};
  gains_.reset();
}

}  // namespace g3d::hal::kobuki
