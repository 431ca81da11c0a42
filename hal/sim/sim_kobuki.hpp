// SPDX-License-Identifier: Apache-2.0
// A Kobuki as it is seen through its cable. It takes command bytes and sends feedback packets at 50 Hz by its own
// clock: wrapping encoders, gyro with bias, drift and noise, currents, battery, answers to requests. A line that is
// late, noisy, cut or silent is had by asking. With all of that at 0 the packets are exact to a tick and 0.01 degrees.
// The host's end is this ByteLine; the world's end is sense() and advance_to(). One thread; nothing is allocated after
// construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/byte_line.hpp"
#include "hal/kobuki/command.hpp"
#include "hal/kobuki/feedback_codec.hpp"
#include "hal/messages.hpp"
#include "hal/sim/base_dynamics.hpp"
#include "hal/sim/noisy_line.hpp"
#include "hal/sim/robot_body.hpp"
#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {

inline constexpr double kGyroRate_hz = 100.0;

struct SimKobukiOptions {
  std::uint64_t seed = 1;
  // The gyro
  double gyro_bias_radps = 0.0;
  double gyro_drift_radps_per_sqrt_s = 0.0;  ///< random walk of the bias
  double gyro_noise_radps = 0.0;             ///< sigma of one 100 Hz sample
  double gyro_scale = 1.0;
  double first_angle_deg = 0.0;
  // The encoders
  double left_scale = 1.0;  ///< ticks for ticks: a worn tyre
  double right_scale = 1.0;
  std::uint16_t first_left_ticks = 0;
  std::uint16_t first_right_ticks = 0;
  // Its clock
  double clock_ppm = 0.0;
  std::uint16_t first_timestamp_ms = 0;
  // Its battery: falls evenly to the dangerous 13.2 V
  double battery_V = 16.5;
  double battery_life_s = 3.0 * 3600.0;
  // Who it is, (major, minor, patch)
  std::array<std::uint8_t, 3> hardware{1, 0, 4};
  std::array<std::uint8_t, 3> firmware{1, 2, 0};
  std::array<std::uint32_t, 3> udid{98238259, 926504013, 1360618305};
  LineNoise to_host;
  LineNoise to_base;
};

/// What can go wrong while it runs.
struct KobukiFaults {
  bool unplugged = false;  ///< the host sees a lost line; the base keeps its last command
  bool silent = false;     ///< no packet comes, commands still arrive
  bool deaf = false;       ///< packets come, no command arrives
  bool left_dead = false;  ///< this encoder counts no longer
  bool right_dead = false;
  bool stuck = false;      ///< the same packet over and over
  bool scrambled = false;  ///< whole packets with encoders and gyro angle of chance
  int keep_every = 1;      ///< of the packets, only every so many-th is sent
  std::uint8_t buttons = 0;
  std::uint8_t charger = 0;
  bool operator==(const KobukiFaults&) const = default;
};

class SimKobuki final : public ByteLine {
 public:
  explicit SimKobuki(const SimKobukiOptions& options);

  // The host's end.
  [[nodiscard]] std::size_t read(std::span<std::uint8_t> into) override;
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] LineState state() const override { return faults_.unplugged ? LineState::lost : LineState::up; }

  // The world's end.
  /// What the wheels were told last. A Kobuki keeps it for ever.
  [[nodiscard]] const kobuki::BaseControl& drive() const { return drive_; }
  /// The body as it is at the time of the next advance_to.
  void sense(const RobotBody& body);
  /// Takes the commands that have arrived and sends the packets that are due. Time does not go backwards.
  void advance_to(TimeNs now_ns);
  void set_faults(const KobukiFaults& faults) { faults_ = faults; }
  void set_noise(const LineNoise& to_host, const LineNoise& to_base);

  [[nodiscard]] std::uint16_t outputs() const { return outputs_; }  ///< of the last general purpose output command
  [[nodiscard]] bool kinect_has_power() const { return (outputs_ & kobuki::kRail12V1A5) != 0; }
  [[nodiscard]] const kobuki::RejectCounts& rejects() const { return reader_.rejects(); }
  [[nodiscard]] std::uint64_t packets_sent() const { return packets_sent_; }
  [[nodiscard]] std::uint64_t packets_dropped() const { return packets_dropped_; }  ///< the host did not read
  [[nodiscard]] std::uint64_t sounds() const { return sounds_; }                    ///< played so far
  [[nodiscard]] std::uint64_t drive_commands() const { return drive_commands_; }

 private:
  struct Sensed {
    WheelPair way_m;
    WheelPair speeds_mps;
    WheelPair target_mps;
    double turned_rad = 0.0;
    double turn_radps = 0.0;
    std::uint8_t bumper = 0;
    std::uint8_t cliff = 0;
    std::uint8_t wheel_drop = 0;
    bool stalled = false;
  };

  void take_commands();
  void obey(const kobuki::Command& command);
  void send_packet(TimeNs at_ns);
  void fill_gyro(kobuki::Feedback& feedback);
  void fill_motors(kobuki::Feedback& feedback, TimeNs at_ns);

  SimKobukiOptions options_;
  KobukiFaults faults_;
  NoisyLine to_host_;
  NoisyLine to_base_;
  kobuki::CommandReader reader_;
  SeededRandom random_;
  TimeNs now_ns_ = 0;
  TimeNs next_packet_ns_ = 0;
  std::uint64_t packet_number_ = 0;
  kobuki::BaseControl drive_;
  std::uint16_t outputs_ = kobuki::kAllRails;
  kobuki::ControllerGains gains_;
  std::uint64_t sounds_ = 0;
  kobuki::Packet packet_;  ///< the answers that wait for the next packet
  Sensed sensed_;
  Sensed reported_;  ///< at the packet before
  double left_ticks_ = 0.0;
  double right_ticks_ = 0.0;
  double gyro_angle_rad_ = 0.0;
  double gyro_bias_radps_ = 0.0;
  std::uint8_t gyro_frame_ = 0;
  TimeNs stalled_since_ns_ = -1;
  std::array<std::uint8_t, kobuki::kMaxFrame_bytes> frame_{};  ///< sent last
  std::size_t frame_bytes_ = 0;
  std::uint64_t packets_sent_ = 0;
  std::uint64_t packets_dropped_ = 0;
  std::uint64_t drive_commands_ = 0;
};

}  // namespace g3d::hal
