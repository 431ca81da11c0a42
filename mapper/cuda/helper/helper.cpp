// SPDX-License-Identifier: Apache-2.0
// The helper process: waits for commands in the shared memory, obeys, answers. It ends when the program has ended.
// It is the only part that uses the system's C library, and may be carried to an older one: see OLD_LIBC in the
// Makefile.
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "mapper/cuda/helper/card_session.hpp"

using namespace g3d::mapper::cuda;

namespace {

constexpr int kSpins = 20'000;  // about a tenth of a millisecond: the next command is often close

std::uint32_t read_word(const std::uint32_t* word) { return __atomic_load_n(word, __ATOMIC_ACQUIRE); }

void set_word(std::uint32_t* word, std::uint32_t value) {
  __atomic_store_n(word, value, __ATOMIC_RELEASE);
  syscall(SYS_futex, word, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

/// Waits until `asked` is not `seen` any more. False: the program has ended.
bool wait_for_command(const HelperControl& control, std::uint32_t seen, pid_t program) {
  for (int i = 0; i < kSpins; ++i) {
    if (read_word(&control.asked) != seen) return true;
  }
  while (read_word(&control.asked) == seen) {
    if (getppid() != program) return false;
    const timespec limit{0, 200'000'000};
    syscall(SYS_futex, &control.asked, FUTEX_WAIT, seen, &limit, nullptr, 0);
  }
  return true;
}

}  // namespace

int main() {
  const pid_t program = getppid();
  const off_t bytes = lseek(kHelperFile, 0, SEEK_END);
  if (bytes < static_cast<off_t>(sizeof(HelperControl))) return 2;
  void* const place =
      mmap(nullptr, static_cast<std::size_t>(bytes), PROT_READ | PROT_WRITE, MAP_SHARED, kHelperFile, 0);
  if (place == MAP_FAILED) return 2;
  auto& control = *static_cast<HelperControl*>(place);
  static CardSession session;
  if (control.version != kProtocolVersion || !session.start(control)) {
    set_word(&control.state, static_cast<std::uint32_t>(HelperState::failed));
    return 1;
  }
  set_word(&control.state, static_cast<std::uint32_t>(HelperState::ready));
  std::uint32_t seen = 0;
  while (wait_for_command(control, seen, program)) {
    seen = read_word(&control.asked);
    if (control.command == static_cast<std::uint32_t>(HelperCommand::hang)) {
      while (getppid() == program) sleep(1);
    }
    const bool ends = control.command == static_cast<std::uint32_t>(HelperCommand::end);
    control.ok = ends || session.obey() ? 1 : 0;
    set_word(&control.answered, seen);
    if (ends) return 0;
  }
  return 0;
}
