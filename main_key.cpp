// SPDX-License-Identifier: Apache-2.0
// `g3dmap key`: the key that makes robots one fleet: made, rotated, robots revoked, shown without the key itself.
#include <fmt/format.h>
#include <sys/stat.h>

#include <string>
#include <utility>

#include "main_commands.hpp"
#include "main_say.hpp"
#include "net/fleet_key.hpp"
#include "net/fleet_key_file.hpp"

namespace g3d {
namespace {

int show_key(const std::string& path, const net::FleetKey& keys) {
  fmt::print("{}  epoch {}  fingerprint {}\n", path, keys.epoch, keys.key.fingerprint());
  if (keys.previous) {
    fmt::print("epoch {} is still heard, fingerprint {}; g3dmap key --finish {} once every robot has the new key\n",
               keys.previous_epoch(), keys.previous->fingerprint(), path);
  }
  for (const std::uint64_t robot : keys.revoked) fmt::print("revoked {:016x}\n", robot);
  for (const std::uint64_t robot : keys.dropped) fmt::print("dropped {:016x}\n", robot);
  return kExitDone;
}

int make_key(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) {
    return fail(
        fmt::format("{}: is there already, and robots may need it; choose another name, or rotate it with "
                    "g3dmap key --rotate {}",
                    path, path));
  }
  const net::FleetKey keys = net::generate_fleet_key();
  if (const auto written = net::write_fleet_key(path, keys); !written) return fail(written.error().text);
  return show_key(path, keys);
}

}  // namespace

int run_key(const KeyOptions& options) {
  const int jobs = (options.out.empty() ? 0 : 1) + (options.rotate ? 1 : 0) + (options.finish ? 1 : 0) +
                   (options.revoke.empty() ? 0 : 1) + (options.drop.empty() ? 0 : 1) + (options.show ? 1 : 0);
  if (jobs != 1) {
    return bad_usage("key: give one of --out FILE, --rotate, --finish, --revoke ROBOT, --drop ROBOT, --show");
  }
  if (options.shut_out && !options.rotate) return bad_usage("--shut-out: says how to --rotate; give both");
  if (options.out.empty() == options.file.empty()) {
    return bad_usage(options.out.empty() ? "key: which file? Give the fleet's key, such as fleet.key"
                                         : "--out: makes a new file; give no other one");
  }
  if (!options.out.empty()) return make_key(options.out);

  const bool drops = !options.drop.empty();
  std::uint64_t unwanted = 0;
  if (drops || !options.revoke.empty()) {
    const std::string& text = drops ? options.drop : options.revoke;
    const auto robot = net::parse_robot_id(text);
    if (!robot) {
      return bad_usage(
          fmt::format("--{} '{}': not a robot's id, 1 to 16 hexadecimal digits", drops ? "drop" : "revoke", text));
    }
    unwanted = *robot;
  }
  auto read = net::read_fleet_key(options.file);
  if (!read) return fail(read.error().text);
  net::FleetKey keys = std::move(read).value();
  if (options.show) return show_key(options.file, keys);
  if (options.rotate && keys.previous && !options.shut_out) {
    // Robots that have only the key before the last would be cut off without anybody meaning it.
    return fail(
        fmt::format("{}: a rotation goes on already; end it with --finish once every robot has epoch {}, or "
                    "cut it short with --rotate --shut-out",
                    options.file, keys.epoch));
  }
  if (options.rotate) {
    net::rotate_fleet_key(keys, options.shut_out ? net::OldKey::shut_out : net::OldKey::kept_until_finished);
  }
  if (options.finish) net::finish_rotation(keys);
  if (drops || !options.revoke.empty()) {
    if (const auto done = drops ? net::drop_robot(keys, unwanted) : net::revoke_robot(keys, unwanted); !done) {
      return fail(fmt::format("{}: {}", options.file, done.error().text));
    }
  }
  if (const auto written = net::write_fleet_key(options.file, keys); !written) return fail(written.error().text);
  return show_key(options.file, keys);
}

}  // namespace g3d
