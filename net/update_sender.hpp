// SPDX-License-Identifier: Apache-2.0
// Sends an image to a machine until it is installed there, through cuts of the network: it connects again and goes on
// where the machine is. Blocks; one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "hal/linux/ipv4_endpoint.hpp"
#include "hal/result.hpp"
#include "net/update_offer.hpp"

namespace g3d::net {

struct UpdateSenderOptions {
  hal::Ipv4Endpoint to;
  bool force = false;
  double patience_s = 60.0;  ///< without any progress; a machine that never answered is not waited for
  int silence_ms = 30'000;   ///< of one connection, before it is given up
  int pause_ms = 1000;       ///< before the next connection
};

struct UpdateProgress {
  UpdateGreeting machine;
  std::uint32_t in_place = 0;  ///< chunks, as the machine says
  std::uint32_t sent = 0;      ///< chunks
  std::uint32_t chunks = 0;    ///< of the image
  int connections = 0;
};
using ShowProgress = std::function<void(const UpdateProgress&)>;

/// Installed, or it was there already (`end`).
struct UpdateSent {
  UpdateEnd end = UpdateEnd::installed;
  UpdateProgress progress;
};

/// What went wrong and what to do about it, for a person.
[[nodiscard]] std::string explain(UpdateEnd end, const UpdateGreeting& machine, std::uint64_t release);

/// `path` holds the manifest's image, and is read chunk by chunk. Errors: not_found, no_permission (refused),
/// disk_full, io_error (cut too often), malformed (no such machine there), bad_checksum (the file has changed).
[[nodiscard]] hal::Result<UpdateSent> send_update(const std::string& path, const UpdateManifest& manifest,
                                                  const SigningKey& key, const UpdateSenderOptions& options,
                                                  const ShowProgress& show = {});

}  // namespace g3d::net
