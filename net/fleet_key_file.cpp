// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_key_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "hal/image/atomic_file.hpp"
#include "net/private_text.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::string_view kKeyFileMark = "g3dmap fleet key ";
constexpr std::string_view kKeyFileVersion = "1";
constexpr const char* kKeyFileRemedy = "copy it again from where the fleet's key was made";

/// One pass over the lines; the key so far is dropped with the parser.
class KeyFileParser {
 public:
  explicit KeyFileParser(const std::string& name) : name_(name) {}

  hal::Result<void> take_line(std::string_view line) {
    ++line_number_;
    if (line.empty() || line.front() == '#') return {};
    if (!has_mark_) return take_mark(line);
    const std::size_t space = line.find(' ');
    if (space == std::string_view::npos) return wrong(Reason::malformed, "is not WORD VALUE");
    const std::string_view word = line.substr(0, space), value = line.substr(space + 1);
    if (word == "epoch") return take_epoch(value);
    if (word == "key") return take_key(word, value, has_key_, keys_.key);
    if (word == "previous") return take_previous(value);
    if (word == "revoked") return take_revoked(value);
    if (word == "dropped") return take_dropped(value);
    return wrong(Reason::malformed, "begins with none of epoch, key, previous, revoked, dropped");
  }

  hal::Result<FleetKey> finish() {
    const char* missing = !has_mark_ ? "first line 'g3dmap fleet key 1'" : !has_epoch_ ? "epoch" : "key";
    if (has_mark_ && has_epoch_ && has_key_) return std::move(keys_);
    return Error{Reason::truncated, fmt::format("{}: has no {}; {}", name_, missing, kKeyFileRemedy)};
  }

 private:
  Error wrong(Reason reason, std::string_view what) const {
    return {reason, fmt::format("{}:{}: {}; {}", name_, line_number_, what, kKeyFileRemedy)};
  }

  hal::Result<void> take_mark(std::string_view line) {
    if (!line.starts_with(kKeyFileMark)) return wrong(Reason::malformed, "is not the first line of a fleet key");
    if (line.substr(kKeyFileMark.size()) != kKeyFileVersion) {
      return Error{Reason::unsupported, fmt::format("{}:{}: is a fleet key of another version; use the g3dmap that "
                                                    "made it, or make a new one with g3dmap key --out",
                                                    name_, line_number_)};
    }
    has_mark_ = true;
    return {};
  }

  hal::Result<void> take_epoch(std::string_view value) {
    if (has_epoch_) return wrong(Reason::malformed, "epoch stands here a second time");
    unsigned epoch = 0;
    const auto [stopped, failed] = std::from_chars(value.data(), value.data() + value.size(), epoch, 10);
    if (value.empty() || failed != std::errc{} || stopped != value.data() + value.size() || epoch > 0xFFFF) {
      return wrong(Reason::out_of_range, "epoch is not a number from 0 to 65535");
    }
    keys_.epoch = static_cast<std::uint16_t>(epoch);
    has_epoch_ = true;
    return {};
  }

  hal::Result<void> take_key(std::string_view word, std::string_view value, bool& has, SecretKey& key) {
    if (has) return wrong(Reason::malformed, fmt::format("{} stands here a second time", word));
    if (!SecretKey::from_hex(value, key)) {
      return wrong(Reason::malformed, fmt::format("{} is not 64 hexadecimal digits", word));
    }
    // A file whose disk lost its bytes must not make everybody a member.
    if (key.equals(SecretKey())) return wrong(Reason::out_of_range, fmt::format("{} is all zeros", word));
    has = true;
    return {};
  }

  hal::Result<void> take_previous(std::string_view value) {
    bool has = keys_.previous.has_value();
    SecretKey key;
    if (hal::Result<void> taken = take_key("previous", value, has, key); !taken) return taken;
    keys_.previous = std::move(key);
    return {};
  }

  hal::Result<void> take_revoked(std::string_view value) {
    const auto robot = parse_robot_id(value);
    if (!robot) return wrong(Reason::malformed, "revoked is not a robot's id, 1 to 16 hexadecimal digits");
    if (keys_.has_revoked(*robot)) return wrong(Reason::malformed, "this robot is revoked a second time");
    if (hal::Result<void> revoked = revoke_robot(keys_, *robot); !revoked) {
      return Error{revoked.error().reason, fmt::format("{}:{}: {}", name_, line_number_, revoked.error().text)};
    }
    return {};
  }

  hal::Result<void> take_dropped(std::string_view value) {
    const auto robot = parse_robot_id(value);
    if (!robot) return wrong(Reason::malformed, "dropped is not a robot's id, 1 to 16 hexadecimal digits");
    if (keys_.has_dropped(*robot)) return wrong(Reason::malformed, "this robot is dropped a second time");
    if (keys_.dropped.size() >= FleetKey::kMostRevoked) {
      return wrong(Reason::no_capacity, "more robots are dropped than a fleet can have");
    }
    keys_.dropped.push_back(*robot);
    return {};
  }

  const std::string& name_;
  std::size_t line_number_ = 0;
  bool has_mark_ = false, has_epoch_ = false, has_key_ = false;
  FleetKey keys_;
};

}  // namespace

hal::Result<FleetKey> parse_fleet_key(std::string_view text, const std::string& name) {
  KeyFileParser parser(name);
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) {
      return Error{Reason::truncated, fmt::format("{}: its last line has no end; {}", name, kKeyFileRemedy)};
    }
    if (hal::Result<void> taken = parser.take_line(text.substr(0, end)); !taken) return taken.error();
    text.remove_prefix(end + 1);
  }
  return parser.finish();
}

std::string format_fleet_key(const FleetKey& keys) {
  std::string text;
  text.reserve(kMostKeyFile_bytes);  // so that no smaller copy of the key is left behind
  text += "# Whoever can read this file can speak and listen as any robot of the fleet.\n";
  fmt::format_to(std::back_inserter(text), "{}{}\nepoch {}\n", kKeyFileMark, kKeyFileVersion, keys.epoch);
  const auto put_key = [&text](std::string_view word, const SecretKey& key) {
    std::string hex = key.to_hex();
    text.append(word).append(hex).append("\n");
    wipe_text(hex);
  };
  put_key("key ", keys.key);
  if (keys.previous) put_key("previous ", *keys.previous);
  for (const std::uint64_t robot : keys.revoked) fmt::format_to(std::back_inserter(text), "revoked {:016x}\n", robot);
  for (const std::uint64_t robot : keys.dropped) fmt::format_to(std::back_inserter(text), "dropped {:016x}\n", robot);
  return text;
}

hal::Result<FleetKey> read_fleet_key(const std::string& path) {
  PrivateText text;
  const auto read = read_private_text(path, "fleet key", "rotate it with --shut-out", text);
  if (!read) return read.error();
  return parse_fleet_key(text.view(), path);
}

hal::Result<void> write_fleet_key(const std::string& path, const FleetKey& keys) {
  hal::Result<hal::AtomicFile> file = hal::AtomicFile::create_private(path);
  if (!file) return file.error();
  std::string text = format_fleet_key(keys);
  hal::Result<void> written = file.value().write(text);
  wipe_text(text);
  return written ? file.value().commit() : written;
}

}  // namespace g3d::net
