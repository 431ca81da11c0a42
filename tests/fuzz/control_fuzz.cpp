// SPDX-License-Identifier: Apache-2.0
// What comes in by the control socket: any bytes are one of the words or refused and counted, and the answer is one
// JSON object that fits into a message. The texts of --at and --fail are read as well.
#include <cstdlib>
#include <string>
#include <string_view>

#include "hal/linux/control_socket.hpp"
#include "hal/sim/fault_plan.hpp"
#include "nav/hotline.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size_bytes);
  const auto word = nav::parse_word(bytes);
  if (word && bytes != nav::to_string(*word) && bytes != std::string(nav::to_string(*word)) + "\n") std::abort();
  nav::Hotline hotline;
  if (!word || *word == nav::PersonWord::status) {  // others wait for a robot to hear them
    const std::string answer = hotline.answer(bytes);
    if (answer.empty() || answer.size() > hal::ControlSocket::kMostAnswer_bytes || answer.front() != '{') std::abort();
    if (hotline.unknown_words() != (word ? 0U : 1U)) std::abort();
  }
  if (hotline.take()) std::abort();
  if (const auto timed = nav::parse_timed_word(bytes); timed.ok() && timed.value().at_ns < 0) std::abort();
  const auto fault = hal::parse_fault(bytes);
  if (fault.ok() && (fault.value().from_ns < 0 || fault.value().to_ns <= fault.value().from_ns ||
                     fault.value().kind == hal::FaultKind::none)) {
    std::abort();
  }
  return 0;
}
