// SPDX-License-Identifier: Apache-2.0
// `g3dmap update` and `g3dmap slots`: what may be said, and the functions that do it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace g3d {

struct UpdateOptions {
  std::string image;
  std::string new_key;                   ///< file to make
  std::string key;                       ///< secret half
  std::string to;                        ///< "10.0.0.2" or "10.0.0.2:7178"
  std::optional<std::uint64_t> release;  ///< none: when the image was made, in seconds since 1970
  bool force = false;
  double patience_s = 60.0;
  bool quiet = false;

  std::string listen;  ///< "7178" or "10.0.0.2:7178": takes updates instead of sending one
  std::string trust;   ///< public half
  std::string state;
  std::string slot_a;
  std::string slot_b;
  std::string running = "none";
  double rate_kBps = 4000.0;
};

struct SlotsOptions {
  std::string state;
  std::string first;  ///< image in slot A: makes a new state
  std::optional<std::uint64_t> release;
  bool json = false;
};

void add_update_options(CLI::App& command, UpdateOptions& options);
void add_slots_options(CLI::App& command, SlotsOptions& options);
int run_update(const UpdateOptions& options);
int run_slots(const SlotsOptions& options);

inline constexpr const char* kUpdateExamples = R"(
Examples:
  g3dmap update --new-key owner.key                        once; owner.key.pub goes on every machine's image
  g3dmap update --key owner.key --to 10.0.0.2 system.img   puts it into the slot that does not run, and restarts
  g3dmap update --key owner.key --to 10.0.0.2 --release 41 --force old.img      goes back on purpose

A cut connection is taken up again where it was; so is an update that is sent a second time. An image that does not come up
in three starts is left for the one before it.

What a machine itself runs to take updates; it ends with 0 once one is installed:
  g3dmap update --listen 7178 --trust owner.key.pub --state slots.state --slot-a a.img --slot-b b.img --running a)";

inline constexpr const char* kSlotsExamples = R"(
Examples:
  g3dmap slots --state /data/slots.state                   what is in slots A and B, and which one starts next
  g3dmap slots --state slots.state --first system.img      a new state for an image that is in slot A)";

}  // namespace g3d
