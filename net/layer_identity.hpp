// SPDX-License-Identifier: Apache-2.0
// As whom a robot writes its layer, and which versions it may have used: a small file that is the old one or the new
// one, whenever the power fails. Versions are reserved in it before they are used, many at a time. A robot that comes
// back goes on above them; one that finds no such file begins a new incarnation.
//
//   g3dmap layer 1
//   robot 00000000deadbeef
//   incarnation 3735928559
//   reserved 4194304
//   check 89abcdef                      CRC-32 of the lines above
//
// Cold; errors name file and remedy.
#pragma once

#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "net/layer_id.hpp"

namespace g3d::net {

struct LayerIdentity {
  LayerId self;
  Version reserved = 0;  ///< no version above this was ever used
  bool operator==(const LayerIdentity&) const = default;
};

[[nodiscard]] std::string format_layer_identity(const LayerIdentity& identity);
/// `name` stands in errors. Errors: malformed, bad_checksum.
[[nodiscard]] hal::Result<LayerIdentity> parse_layer_identity(std::string_view text, const std::string& name);

/// Errors: as above, not_found, those of the file.
[[nodiscard]] hal::Result<LayerIdentity> read_layer_identity(const std::string& path);
/// Returns once it survives a power cut.
[[nodiscard]] hal::Result<void> write_layer_identity(const std::string& path, const LayerIdentity& identity);

}  // namespace g3d::net
