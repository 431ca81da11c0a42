// SPDX-License-Identifier: Apache-2.0
// What a simulated base is told, by hostile hands: whatever it understands, said again, is understood the same.
#include <array>
#include <cstdlib>

#include "hal/kobuki/command.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal::kobuki;
  if (size_bytes > 512) return -1;
  CommandReader reader;
  reader.feed({data, size_bytes}, [](const Command& command) {
    std::array<std::uint8_t, kMaxCommand_bytes> bytes;
    const std::size_t size = encode_command(command, bytes);
    Command expected = command, again;
    if (expected.outputs) expected.outputs = static_cast<std::uint16_t>(*expected.outputs | kRail12V1A5);
    CommandReader second;
    second.feed({bytes.data(), size}, [&again](const Command& read) { again = read; });
    if (!(again == expected)) std::abort();
  });
  return 0;
}
