// SPDX-License-Identifier: Apache-2.0
#include "net/update_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sodium.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace g3d::net {
namespace {

constexpr hal::TimeNs kLinger_ns = 2'000 * hal::kMillisecond_ns;
constexpr int kMostWait_ms = 1000;
/// Messages that one guest may have read at once, before the others are looked at.
constexpr int kReadsAtOnce = 16;

std::array<std::uint8_t, 32> fresh_nonce() {
  std::array<std::uint8_t, 32> nonce;
  randombytes_buf(nonce.data(), nonce.size());
  return nonce;
}

bool has_disk_work(UpdateIntake::Phase phase) {
  return phase == UpdateIntake::Phase::comparing || phase == UpdateIntake::Phase::reading_back;
}

}  // namespace

struct UpdateServer::Guest {
  Guest(hal::TcpLink connection, const hal::Ipv4Endpoint& peer, const UpdateKey& key, UpdateTarget& target,
        double rate_Bps, hal::TimeNs now_ns)
      : link(std::move(connection)),
        from(peer),
        intake(key, target, fresh_nonce(), rate_Bps),
        since_ns(now_ns),
        heard_ns(now_ns) {}

  [[nodiscard]] bool is_over() const { return intake.phase() == UpdateIntake::Phase::over; }

  hal::TcpLink link;
  hal::Ipv4Endpoint from;
  UpdateIntake intake;
  hal::TimeNs since_ns;
  hal::TimeNs heard_ns;  ///< or had disk work to do
  hal::TimeNs linger_until_ns = 0;
  bool is_admitted = false;
  bool is_noted = false;
  bool is_shut = false;
};

hal::Result<std::unique_ptr<UpdateServer>> UpdateServer::open(const UpdateServerOptions& options, const UpdateKey& key,
                                                              UpdateTarget& target, Tell tell) {
  auto listener = hal::TcpListener::open(options.at);
  if (!listener) return listener.error();
  const int wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake < 0) {
    return hal::Error{hal::Reason::io_error,
                      fmt::format("update: no event: {}; raise the limit of open files", std::strerror(errno))};
  }
  return std::unique_ptr<UpdateServer>(
      new UpdateServer(options, key, target, std::move(tell), std::move(listener).value(), wake));
}

UpdateServer::UpdateServer(const UpdateServerOptions& options, const UpdateKey& key, UpdateTarget& target, Tell tell,
                           hal::TcpListener listener, int wake)
    : options_(options),
      key_(key),
      target_(target),
      tell_(std::move(tell)),
      listener_(std::move(listener)),
      wake_(wake) {}

UpdateServer::~UpdateServer() { ::close(wake_); }

void UpdateServer::stop() {
  is_stopped_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
}

bool UpdateServer::serve() {
  while (!is_stopped_.load(std::memory_order_acquire)) {
    std::array<pollfd, kMostConnections + 2> waits{};
    waits[0] = {wake_, POLLIN, 0};
    waits[1] = {listener_.fd(), POLLIN, 0};
    for (std::size_t i = 0; i < guests_.size(); ++i) {
      pollfd& wait = waits[i + 2];
      wait.fd = guests_[i] ? guests_[i]->link.fd() : -1;
      if (!guests_[i]) continue;
      const bool listens = !guests_[i]->intake.wants().empty() || guests_[i]->is_shut;
      wait.events = static_cast<short>((listens ? POLLIN : 0) | (guests_[i]->intake.says().empty() ? 0 : POLLOUT));
    }
    if (::poll(waits.data(), waits.size(), wait_ms(clock_.now())) < 0 && errno != EINTR) break;
    const hal::TimeNs now_ns = clock_.now();
    if (waits[1].revents != 0) welcome(now_ns);
    for (auto& guest : guests_) {
      if (!guest) continue;
      attend(*guest, now_ns);
      if (!guest->link.is_open()) guest.reset();
    }
    const bool somebody_lingers = std::any_of(guests_.begin(), guests_.end(), [](const auto& guest) {
      return guest && guest->intake.end() == UpdateEnd::installed;
    });
    if (is_installed_ && !somebody_lingers) return true;
  }
  for (auto& guest : guests_) {
    if (guest && guest->is_admitted && !guest->is_over()) {
      guest->intake.finish(UpdateEnd::stopping);
      exchange(*guest, clock_.now());
      note_end(*guest, clock_.now());
    }
    guest.reset();
  }
  return is_installed_;
}

int UpdateServer::wait_ms(hal::TimeNs now_ns) const {
  hal::TimeNs until_ns = now_ns + kMostWait_ms * hal::kMillisecond_ns;
  for (const auto& guest : guests_) {
    if (!guest) continue;
    if (has_disk_work(guest->intake.phase())) return 0;
    until_ns = std::min(until_ns, guest->intake.wait_until_ns());
    if (guest->is_shut) until_ns = std::min(until_ns, guest->linger_until_ns);
    if (!guest->is_admitted) until_ns = std::min(until_ns, guest->since_ns + options_.proof_patience_ns);
  }
  // Rounded up: a wait that ends too early would be one more of them.
  return static_cast<int>(
      std::max<hal::TimeNs>(0, (until_ns - now_ns + hal::kMillisecond_ns - 1) / hal::kMillisecond_ns));
}

void UpdateServer::welcome(hal::TimeNs now_ns) {
  hal::Ipv4Endpoint from;
  auto link = listener_.accept(from);
  if (!link) return;
  ++counts_.connections;
  auto place = std::find(guests_.begin(), guests_.end(), nullptr);
  if (place == guests_.end()) {
    // Whoever has waited longest without a proof goes. At most one guest is admitted, so there is one.
    for (auto guest = guests_.begin(); guest != guests_.end(); ++guest) {
      if ((*guest)->is_admitted) continue;
      if (place == guests_.end() || (*guest)->since_ns < (*place)->since_ns) place = guest;
    }
    if (place == guests_.end()) return;
    ++counts_.crowded_out;
  }
  *place = std::make_unique<Guest>(std::move(*link), from, key_, target_, options_.rate_Bps, now_ns);
}

void UpdateServer::attend(Guest& guest, hal::TimeNs now_ns) {
  exchange(guest, now_ns);
  if (!guest.link.is_open()) return;
  if (guest.intake.step(now_ns)) guest.heard_ns = now_ns;
  const hal::TimeNs silent_ns = now_ns - guest.heard_ns;
  if (!guest.is_admitted && now_ns - guest.since_ns > options_.proof_patience_ns)
    guest.intake.finish(UpdateEnd::too_slow);
  if (guest.intake.waits_for_sender() && silent_ns > options_.chunk_patience_ns)
    guest.intake.finish(UpdateEnd::too_slow);
  if (guest.is_over()) note_end(guest, now_ns);
  if (!guest.is_over()) return;
  exchange(guest, now_ns);
  if (guest.link.is_open() && !guest.is_shut && guest.intake.says().empty()) {
    // The last word is on its way; to close now, with bytes of the sender unread, would take it back.
    guest.link.say_no_more();
    guest.is_shut = true;
  }
  if (now_ns >= guest.linger_until_ns) guest.link.close();
}

void UpdateServer::exchange(Guest& guest, hal::TimeNs now_ns) {
  using Outcome = hal::TcpLink::Outcome;
  std::size_t count = 0;
  bool is_over = false;
  if (!guest.intake.says().empty()) {
    is_over = guest.link.send(guest.intake.says(), count) == Outcome::over;
    guest.intake.said(count);
  }
  std::array<std::uint8_t, 4096> unwanted;
  for (int i = 0; i < kReadsAtOnce && !is_over; ++i) {
    const auto wants = guest.is_shut ? std::span<std::uint8_t>(unwanted) : guest.intake.wants();
    if (wants.empty()) break;
    const Outcome outcome = guest.link.receive(wants, count);
    is_over = outcome == Outcome::over;
    if (outcome != Outcome::done) break;
    guest.heard_ns = now_ns;
    if (guest.is_shut) continue;
    guest.intake.took(count);
    if (guest.intake.is_proved() && !guest.is_admitted) admit(guest, now_ns);
  }
  if (is_over) dismiss(guest);
}

void UpdateServer::admit(Guest& guest, hal::TimeNs now_ns) {
  ++counts_.proved;
  for (const auto& other : guests_) {
    if (!other || !other->is_admitted || other->is_over()) continue;
    if (other->intake.waits_for_sender() && now_ns - other->heard_ns > options_.takeover_ns) {
      other->intake.finish(UpdateEnd::too_slow);
      note_end(*other, now_ns);
      continue;
    }
    return guest.intake.finish(UpdateEnd::busy);
  }
  if (is_installed_) return guest.intake.finish(UpdateEnd::stopping);
  guest.is_admitted = true;
  tell_(fmt::format("{} sends an update", hal::to_string(guest.from)));
}

void UpdateServer::dismiss(Guest& guest) {
  if (!guest.is_over()) {
    ++counts_.cut;
    if (guest.is_admitted) {
      tell_(fmt::format("{} is gone after {} chunks; what has come stays", hal::to_string(guest.from),
                        guest.intake.chunks_received()));
    }
  }
  guest.link.close();
}

void UpdateServer::note_end(Guest& guest, hal::TimeNs now_ns) {
  if (std::exchange(guest.is_noted, true)) return;
  guest.linger_until_ns = now_ns + kLinger_ns;
  const UpdateEnd end = guest.intake.end().value_or(UpdateEnd::malformed);
  ++counts_.ends[static_cast<std::size_t>(end)];
  if (end == UpdateEnd::installed) is_installed_ = true;
  const bool is_disk = end == UpdateEnd::disk_full || end == UpdateEnd::disk_error || end == UpdateEnd::too_large;
  tell_(fmt::format("{}: {}, release {}, {} chunks received{}{}", hal::to_string(guest.from), to_string(end),
                    guest.intake.image().release, guest.intake.chunks_received(), is_disk ? "; " : "",
                    is_disk ? target_.trouble() : std::string()));
}

}  // namespace g3d::net
