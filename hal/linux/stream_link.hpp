// SPDX-License-Identifier: Apache-2.0
// A byte stream to one other program, made anew whenever it breaks: dialled again and again with growing pauses, or
// accepted from whoever comes last. One thread; no call ever waits.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/linux/ipv4_endpoint.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// Where the two meet.
struct StreamPlace {
  bool is_tcp = false;
  std::string path;  ///< of a unix socket; to dial also a character device or a pipe
  Ipv4Endpoint endpoint;
};

/// "tcp:10.0.0.2:7000", "unix:/run/camera.sock", or a path with a slash in it. Errors: bad_usage, with what is allowed.
[[nodiscard]] Result<StreamPlace> parse_stream_place(std::string_view text);
[[nodiscard]] std::string to_string(const StreamPlace& place);

class StreamLink {
 public:
  struct Pauses {
    TimeNs first_ns = 100'000'000;
    TimeNs most_ns = 2'000'000'000;  ///< each try in vain doubles the pause up to this
  };

  /// Goes to `place`, from the first call of connection() on.
  [[nodiscard]] static StreamLink dial(StreamPlace place, Pauses pauses);
  [[nodiscard]] static StreamLink dial(StreamPlace place) { return dial(std::move(place), Pauses{}); }
  /// Others come to `place`; what a killed program left there is replaced. Port 0: a free one. Errors: no_capacity
  /// (somebody listens there), no_permission, too_large (the path), io_error.
  [[nodiscard]] static Result<StreamLink> listen(StreamPlace place);
  StreamLink(StreamLink&& other) noexcept;
  StreamLink& operator=(StreamLink&&) = delete;
  ~StreamLink();

  /// The open stream, or -1: it is tried again when its pause is over. Who comes while there is one takes its place.
  [[nodiscard]] int connection(TimeNs now_ns);
  /// The stream of the last connection(), without a try.
  [[nodiscard]] int fd() const { return fd_; }
  /// Readable when somebody comes; -1 for one that dials.
  [[nodiscard]] int listener() const { return listener_; }
  /// It has broken.
  void hang_up(TimeNs now_ns);
  /// How often there was a new stream.
  [[nodiscard]] std::uint64_t connections() const { return connections_; }
  /// As it is now: with the port that was free.
  [[nodiscard]] const StreamPlace& place() const { return place_; }
  /// Why the last try failed, as errno; 0: it did not.
  [[nodiscard]] int last_errno() const { return last_errno_; }

 private:
  StreamLink(StreamPlace place, Pauses pauses, int listener)
      : place_(std::move(place)), pauses_(pauses), listener_(listener), pause_ns_(pauses.first_ns) {}
  void accept_newest();

  StreamPlace place_;
  Pauses pauses_;
  int listener_;
  int fd_ = -1;
  TimeNs pause_ns_;
  TimeNs next_try_ns_ = 0;
  std::uint64_t connections_ = 0;
  int last_errno_ = 0;
};

}  // namespace g3d::hal
