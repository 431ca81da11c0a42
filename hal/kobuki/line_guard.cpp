// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_guard.hpp"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

#include "hal/clock.hpp"

namespace g3d::hal::kobuki {

struct LineGuard::Shared {
  std::atomic<std::uint64_t> beats{0};       // written by the main process
  std::atomic<std::uint64_t> zeros_sent{0};  // written by the guard
};

namespace {

static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "a lock would not be shared between processes");

constexpr char kNewLine = 'L';
constexpr char kGoodEnd = 'E';

Error failed(const char* call) {
  const char* const why = ::strerrordesc_np(errno);
  return {Reason::io_error, std::string("the guard of the base's line cannot be started: ") + call + ": " +
                                (why != nullptr ? why : "unknown error")};
}

bool send_word(int socket, char word, int fd) {
  iovec data{&word, 1};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  if (fd >= 0) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    ::memcpy(CMSG_DATA(header), &fd, sizeof(int));
  }
  return ::sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == 1;
}

// From here on: the child, which after fork() may only make system calls.

void close_between(int first, int last) {
  if (first > last) return;
  if (::syscall(SYS_close_range, static_cast<unsigned>(first), static_cast<unsigned>(last), 0U) == 0) return;
  // Kernels before 5.9.
  for (int fd = first; fd <= std::min(last, 65'535); ++fd) ::close(fd);
}

/// Whatever else the main process has open must not live on in the guard: other devices, files, its own sockets.
void keep_only(int a, int b) {
  const int low = std::min(a, b), high = std::max(a, b);
  close_between(3, low - 1);
  close_between(std::max(3, low + 1), high - 1);
  close_between(std::max(3, high + 1), INT32_MAX);
  const int null = ::open("/dev/null", O_RDWR);
  for (int fd = 0; fd < 3 && null >= 0; ++fd) ::dup2(null, fd);
  if (null > 2) ::close(null);
}

/// A word from the main process; 0 if it is gone, ' ' if nothing came after all. A descriptor that came along is put
/// into `fd`.
char receive_word(int socket, int& fd) {
  char word = 0;
  iovec data{&word, 1};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t count = ::recvmsg(socket, &message, MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return ' ';
  if (count <= 0) return 0;
  for (cmsghdr* h = CMSG_FIRSTHDR(&message); h != nullptr; h = CMSG_NXTHDR(&message, h)) {
    if (h->cmsg_level == SOL_SOCKET && h->cmsg_type == SCM_RIGHTS) ::memcpy(&fd, CMSG_DATA(h), sizeof(int));
  }
  return word;
}

void become_independent() {
  ::setsid();  // a Ctrl-C, or a kill of the whole group, is for the main process
  // All signals stay blocked as they were at the fork; those that would wait for ever are thrown away.
  for (const int s : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTSTP, SIGTTOU, SIGUSR1, SIGUSR2, SIGALRM}) {
    ::signal(s, SIG_IGN);
  }
  (void)::prctl(PR_SET_NAME, "g3d-line-guard");
  const sched_param urgent{10};
  (void)::sched_setscheduler(0, SCHED_FIFO, &urgent);  // granted or not: it sleeps nearly always
}

}  // namespace

void LineGuard::watch(int line_fd, int socket, pid_t parent, Shared& shared, const Times& times) {
  become_independent();
  keep_only(line_fd, socket);
  const RealClock clock;
  enum class Main { beating, missed, dead, gone_well } main = Main::beating;
  std::uint64_t beats = shared.beats.load(std::memory_order_acquire);
  TimeNs beat_ns = clock.now(), next_zero_ns = 0;
  int zeros = 0;  // since the main process went
  for (;;) {
    std::array<pollfd, 2> polled{{{socket, POLLIN, 0}, {line_fd, 0, 0}}};
    const TimeNs wait_ns = main == Main::beating ? times.period_ns / 2 : next_zero_ns - clock.now();
    (void)::poll(polled.data(), polled.size(),
                 static_cast<int>(std::clamp<TimeNs>((wait_ns + kMillisecond_ns - 1) / kMillisecond_ns, 0, 100)));

    char word = ' ';
    if (polled[0].revents != 0) {
      int fd = -1;
      word = receive_word(socket, fd);
      if (word == kNewLine && fd >= 0) {
        if (line_fd >= 0) ::close(line_fd);
        line_fd = fd;
      }
    }
    // Another child of the main process may hold the far end of the socket: then its death is silent there.
    if (socket >= 0 && word == ' ' && ::getppid() != parent) word = 0;
    if (word == 0 || word == kGoodEnd) {
      main = word == kGoodEnd ? Main::gone_well : Main::dead;
      ::close(std::exchange(socket, -1));
      // What the dead process still had under way is older than what we have to say.
      if (main == Main::dead && line_fd >= 0) (void)::tcflush(line_fd, TCOFLUSH);
      next_zero_ns = 0;
    }
    if (line_fd >= 0 && (polled[1].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0 && polled[1].fd == line_fd) {
      ::close(std::exchange(line_fd, -1));  // unplugged; kept open it would block the port's name
    }

    const TimeNs now_ns = clock.now();
    const std::uint64_t newest = shared.beats.load(std::memory_order_acquire);
    if (newest != beats) beat_ns = now_ns;
    beats = newest;
    if (main == Main::beating || main == Main::missed) {
      main = now_ns - beat_ns > times.missed_ns ? Main::missed : Main::beating;
    } else if (line_fd < 0 || zeros >= (main == Main::dead ? times.farewell_packets : times.hand_over_packets)) {
      ::_exit(0);
    }
    if (main == Main::beating || now_ns < next_zero_ns) continue;
    next_zero_ns = now_ns + times.period_ns;
    const bool over = main == Main::dead || main == Main::gone_well;
    if (over && now_ns - beat_ns > 30'000 * kMillisecond_ns) ::_exit(1);  // a line that takes nothing
    if (line_fd < 0 || ::write(line_fd, kZeroSpeedPacket.data(), kZeroSpeedPacket.size()) <= 0) continue;
    shared.zeros_sent.fetch_add(1, std::memory_order_relaxed);  // single writer; a mere count
    if (over) ++zeros;
  }
}

Result<LineGuard> LineGuard::start(int line_fd, Times times) {
  void* const page = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return failed("mmap");
  Shared* const shared = new (page) Shared;
  std::array<int, 2> sockets{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    const Error error = failed("socketpair");
    ::munmap(page, sizeof(Shared));
    return error;
  }
  // A signal between fork and the moment in which the guard ignores it would end the guard.
  sigset_t all, before;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0) watch(line_fd, sockets[1], parent, *shared, times);
  const int fork_errno = errno;
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = fork_errno;
  if (process < 0) {
    const Error error = failed("fork");
    for (const int fd : sockets) ::close(fd);
    ::munmap(page, sizeof(Shared));
    return error;
  }
  ::close(sockets[1]);
  return LineGuard(process, sockets[0], shared);
}

LineGuard::LineGuard(LineGuard&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      socket_(std::exchange(other.socket_, -1)),
      shared_(std::exchange(other.shared_, nullptr)) {}

LineGuard::~LineGuard() {
  if (shared_ == nullptr) return;
  (void)send_word(socket_, kGoodEnd, -1);
  RealClock clock;
  const TimeNs patience_ns = clock.now() + 1'000 * kMillisecond_ns;
  while (alive() && clock.now() < patience_ns) clock.sleep_until(clock.now() + 5 * kMillisecond_ns);
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(socket_);
  ::munmap(shared_, sizeof(Shared));
}

void LineGuard::beat() { shared_->beats.fetch_add(1, std::memory_order_release); }

bool LineGuard::hand_over(int line_fd) { return line_fd >= 0 && send_word(socket_, kNewLine, line_fd); }

bool LineGuard::alive() {
  if (process_ <= 0) return false;
  const pid_t ended = ::waitpid(process_, nullptr, WNOHANG);
  if (ended == process_ || (ended < 0 && errno == ECHILD)) process_ = -1;
  return process_ > 0;
}

std::uint64_t LineGuard::zeros_sent() const { return shared_->zeros_sent.load(std::memory_order_relaxed); }

}  // namespace g3d::hal::kobuki
