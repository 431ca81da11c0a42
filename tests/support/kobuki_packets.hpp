// SPDX-License-Identifier: Apache-2.0
// Packets as real bases sent them (public captures: K1 to K3 bus710/tortuga, K4 rust-aarhus/kobuki-interface, K5
// yujinrobot/kobuki#82), and a base that drives an arc and says so in packets like theirs.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "hal/kobuki/feedback.hpp"

namespace g3d::tests {

/// K1, K2 and K3 follow one another in 20 ms each.
inline constexpr std::string_view kPacketK1 =
    "aa554d010f90f1000000ed2b58470d0d00129f00030300000004073c1dfcff0000000506f506f9079006060201010d0e8106a1ff0800c8ff90"
    "ff0300cfff10100f00dc0fe00fe00fe00fef0f00000000a1";
inline constexpr std::string_view kPacketK2 =
    "aa554d010fa4f1000000f42b60470d0d00129f00030300000004073d1d21000000000506ec06f5079306060201010d0e830691ff0b00ddff9d"
    "ff2000f5ff10100f00d90fdf0fdb0fdf0fef0f000000008f";
inline constexpr std::string_view kPacketK3 =
    "aa554d010fb8f1000000fc2b67470d0d00129f00030300000004073e1d4f000000000506e406f4079406060201010d0e8506a5ff34001200a3"
    "ff39002b0010100f00dc0fe40fdb0fdd0ff00f00000000e7";
/// Another base, its left encoder about to wrap.
inline constexpr std::string_view kPacketK4 =
    "aa554d010fa80b000000fcffeff3000000009d00030300000004079be7000000000005068906ad074906060200000d0eee062a0092ffbcff23"
    "0098ffb9ff10100000ff0fff0fff0fff0ff00f0000000062";
/// Firmware from before 1.0: right checksum, core block of 32 bytes.
inline constexpr std::string_view kPacketK5 =
    "aa55360120a8000000fd32de3c00000016a503000000042f24feff888888056a0644077206060000104800ff0fff0fff0fff0ff20f00000000"
    "59";

[[nodiscard]] std::vector<std::uint8_t> from_hex(std::string_view hex);
[[nodiscard]] std::vector<std::uint8_t> frame_of(const hal::kobuki::Feedback& feedback);
/// Makes the last byte of a frame its right checksum again.
void repair_checksum(std::vector<std::uint8_t>& frame);

/// The packet 20 ms after `before`, wheels turning by these ticks. Gyro angle and raw samples as for a base without
/// slip. Readings vary a little from packet to packet, as real ones do.
[[nodiscard]] hal::kobuki::Feedback packet_after(const hal::kobuki::Feedback& before, int left_ticks, int right_ticks);
[[nodiscard]] hal::kobuki::Feedback first_packet();

}  // namespace g3d::tests
