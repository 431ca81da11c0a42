// SPDX-License-Identifier: Apache-2.0
#include "net/update_sender.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "hal/clock.hpp"
#include "hal/image/atomic_file.hpp"
#include "hal/linux/tcp_link.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

constexpr int kConnectPatience_ms = 5000;

bool is_worth_another_try(UpdateEnd end) {
  return end == UpdateEnd::busy || end == UpdateEnd::too_slow || end == UpdateEnd::stopping ||
         end == UpdateEnd::wrong_chunk;
}

Reason reason_of(UpdateEnd end) {
  switch (end) {
    case UpdateEnd::disk_full:
    case UpdateEnd::too_large:
      return Reason::disk_full;
    case UpdateEnd::disk_error:
    case UpdateEnd::read_back_differs:
    case UpdateEnd::too_slow:
      return Reason::io_error;
    case UpdateEnd::malformed:
    case UpdateEnd::wrong_chunk:
      return Reason::malformed;
    default:
      return Reason::no_permission;
  }
}

class UpdateSending {
 public:
  UpdateSending(int fd, const std::string& path, const UpdateManifest& manifest, const SigningKey& key,
                const UpdateSenderOptions& options, const ShowProgress& show)
      : fd_(fd), path_(path), manifest_(manifest), key_(key), options_(options), show_(show) {
    progress_.chunks = static_cast<std::uint32_t>(manifest.chunks.size());
  }

  hal::Result<UpdateSent> run() {
    last_gain_ns_ = clock_.now();
    for (;;) {
      if (auto over = connect_once()) return *over;
      if (static_cast<double>(clock_.now() - last_gain_ns_) > options_.patience_s * 1e9) return *last_error_;
      clock_.sleep_until(clock_.now() + options_.pause_ms * hal::kMillisecond_ns);
    }
  }

 private:
  using Over = std::optional<hal::Result<UpdateSent>>;

  std::string at() const { return hal::to_string(options_.to); }
  Over try_again(Error error) {
    last_error_ = std::move(error);
    return std::nullopt;
  }
  Over was_cut() {
    return try_again(
        {Reason::io_error, fmt::format("{}: the connection was cut, and did not come back for {:.0f} s; what the "
                                       "machine has it keeps, so send the update again later",
                                       at(), options_.patience_s)});
  }
  void gain() {
    last_gain_ns_ = clock_.now();
    if (show_) show_(progress_);
  }

  /// None: another try may help.
  Over connect_once() {
    auto link = hal::TcpLink::connect(options_.to, kConnectPatience_ms);
    if (!link) {
      if (progress_.connections == 0) return link.error();
      return try_again(link.error());
    }
    ++progress_.connections;
    UpdateOffer offer(manifest_, key_, options_.force);
    GreetingBytes greeting;
    if (!link.value().receive_all(greeting, options_.silence_ms)) return was_cut();
    if (!offer.take_greeting(greeting)) {
      return Error{Reason::malformed,
                   fmt::format("{}: what answers there takes no updates; is it the right port?", at())};
    }
    progress_.machine = offer.greeting();
    if (!link.value().send_all(offer.opening(), options_.silence_ms)) return hear_end(link.value(), offer);
    for (;;) {
      WordBytes word;
      if (!link.value().receive_all(word, options_.silence_ms)) return was_cut();
      switch (offer.take_word(word)) {
        case UpdateOffer::Next::nonsense:
          return Error{
              Reason::malformed,
              fmt::format("{}: the machine says what makes no sense; is it a g3dmap of another version?", at())};
        case UpdateOffer::Next::ended:
          return ended(offer.end());
        case UpdateOffer::Next::go_on: {
          const bool is_more = offer.in_place() != progress_.in_place;
          progress_.in_place = offer.in_place();
          if (is_more) gain();
          break;
        }
        case UpdateOffer::Next::send_chunk:
          if (const auto failed = read_chunk(offer.chunk()); !failed.ok()) return failed.error();
          if (!link.value().send_all(chunk_, options_.silence_ms)) return hear_end(link.value(), offer);
          ++progress_.sent;
          gain();
          break;
      }
    }
  }

  /// The machine takes no more; its last word may be there all the same.
  Over hear_end(hal::TcpLink& link, UpdateOffer& offer) {
    WordBytes word;
    while (link.receive_all(word, 1000)) {
      if (offer.take_word(word) == UpdateOffer::Next::ended) return ended(offer.end());
    }
    return was_cut();
  }

  Over ended(UpdateEnd end) {
    if (end == UpdateEnd::installed) progress_.in_place = progress_.chunks;
    if (end == UpdateEnd::installed || end == UpdateEnd::already_there) return UpdateSent{end, progress_};
    Error error{reason_of(end), fmt::format("{}: {}", at(), explain(end, progress_.machine, manifest_.image.release))};
    if (is_worth_another_try(end)) return try_again(std::move(error));
    return error;
  }

  hal::Result<void> read_chunk(std::uint32_t chunk) {
    const std::size_t size = manifest_.size_of(chunk);
    chunk_.resize(kChunkHead_bytes + size);
    std::memcpy(chunk_.data(), &chunk, sizeof chunk);
    const std::span bytes = std::span(chunk_).subspan(kChunkHead_bytes);
    for (std::size_t had = 0; had < size;) {
      const ssize_t n =
          ::pread(fd_, bytes.data() + had, size - had, static_cast<off_t>(manifest_.offset_of(chunk) + had));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return hal::system_error(path_, "cannot read", errno);
      if (n == 0) break;
      had += static_cast<std::size_t>(n);
    }
    if (digest_of(bytes) == manifest_.chunks[chunk]) return {};
    return Error{Reason::bad_checksum,
                 fmt::format("{}: has changed while it was sent; wait until it is made, and send it again", path_)};
  }

  int fd_;
  const std::string& path_;
  const UpdateManifest& manifest_;
  const SigningKey& key_;
  const UpdateSenderOptions& options_;
  const ShowProgress& show_;
  hal::RealClock clock_;
  hal::TimeNs last_gain_ns_ = 0;
  UpdateProgress progress_;
  std::optional<Error> last_error_;
  std::vector<std::uint8_t> chunk_;
};

}  // namespace

std::string explain(UpdateEnd end, const UpdateGreeting& machine, std::uint64_t release) {
  switch (end) {
    case UpdateEnd::installed:
      return "installed; it starts with it next time";
    case UpdateEnd::already_there:
      return "has this very image already";
    case UpdateEnd::wrong_key:
      return "does not trust this signing key; give the one whose .pub file is on the machine";
    case UpdateEnd::busy:
      return "another sender updates it; wait for that one";
    case UpdateEnd::not_newer:
      return fmt::format(
          "release {} is not newer than {}, which has come up well there; --force installs it all the same", release,
          machine.newest_good_release);
    case UpdateEnd::failed_before:
      return "this very image did not come up there before; send another one, or the same with --force";
    case UpdateEnd::not_now:
      return "what runs there has not been healthy for long enough, and the other slot is all it could fall back to; "
             "wait "
             "half a minute, or see what ails it";
    case UpdateEnd::too_large:
      return "the image is larger than its slot; make a smaller one";
    case UpdateEnd::malformed:
      return "the machine did not understand; is it a g3dmap of another version?";
    case UpdateEnd::wrong_chunk:
      return "what arrived was not what was sent; the network spoils bytes, send it again";
    case UpdateEnd::disk_full:
      return "its disk is full; free some space on its data partition";
    case UpdateEnd::disk_error:
      return "its disk refuses; its log says what";
    case UpdateEnd::read_back_differs:
      return "its disk returns other bytes than were written; it wears out, replace it";
    case UpdateEnd::too_slow:
      return "it heard nothing for too long; send it again";
    case UpdateEnd::stopping:
      return "it is about to restart; send it again then";
    case UpdateEnd::count_:
      break;
  }
  return "ended for an unknown reason";
}

hal::Result<UpdateSent> send_update(const std::string& path, const UpdateManifest& manifest, const SigningKey& key,
                                    const UpdateSenderOptions& options, const ShowProgress& show) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  auto sent = UpdateSending(fd, path, manifest, key, options, show).run();
  ::close(fd);
  return sent;
}

}  // namespace g3d::net
