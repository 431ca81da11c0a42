// SPDX-License-Identifier: Apache-2.0
// Outcome of everything that may fail because of the outside world: a value, or a reason a program can switch on
// together with a sentence that names file, place and remedy. Cold paths only: the text allocates.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace g3d::hal {

enum class Reason {
  not_found,      ///< no such file or folder
  no_permission,  ///< exists, but may not be read or written
  io_error,       ///< the system refused a read or a write
  disk_full,      ///< no space left
  truncated,      ///< ends before what it announces
  malformed,      ///< does not follow its format
  bad_checksum,   ///< CRC or hash differs
  out_of_range,   ///< a number outside its limits
  unsupported,    ///< valid, but not handled here
  too_large,      ///< larger than what is accepted from outside
  no_capacity,    ///< a pool sized at start is full
  bad_usage,      ///< the caller asked for something impossible
};

[[nodiscard]] const char* to_string(Reason reason);

struct Error {
  Reason reason;
  std::string text;  ///< "FILE:LINE: what is wrong; what to do"
};

/// A value or an Error. `Result<void>` carries success alone.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] T& value() & {
    assert(ok() && "value() of a failed Result");
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] const T& value() const& {
    assert(ok() && "value() of a failed Result");
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] T&& value() && {
    assert(ok() && "value() of a failed Result");
    return std::move(*std::get_if<0>(&state_));
  }
  [[nodiscard]] const Error& error() const {
    assert(!ok() && "error() of a good Result");
    return *std::get_if<1>(&state_);
  }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : failed_(true), error_(std::move(error)) {}

  [[nodiscard]] bool ok() const { return !failed_; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const {
    assert(failed_ && "error() of a good Result");
    return error_;
  }

 private:
  bool failed_ = false;
  Error error_{Reason::io_error, {}};
};

}  // namespace g3d::hal
