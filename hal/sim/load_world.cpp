// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/load_world.hpp"

#include <fmt/format.h>

#include <string_view>

#include "hal/image/file_bytes.hpp"
#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/map_world.hpp"
#include "hal/sim/text_fields.hpp"
#include "hal/sim/world_file.hpp"

namespace g3d::hal {
namespace {

/// What else a name that is no file could have meant.
Error with_names(Error error) {
  if (error.reason != Reason::not_found) return error;
  error.text += "; built in are";
  for (const std::string_view name : builtin_names()) error.text += fmt::format(" {}", name);
  return error;
}

}  // namespace

Result<World> load_world(const std::string& name_or_file, const std::optional<FloorRectangle>& crop) {
  if (name_or_file.ends_with(".yaml") || name_or_file.ends_with(".yml")) return load_map_world(name_or_file, {}, crop);
  if (crop) {
    return Error{Reason::bad_usage,
                 fmt::format("{}: only map_server maps (.yaml) can be cropped; take the whole world", name_or_file)};
  }
  if (const std::string_view text = builtin_world(name_or_file); !text.empty()) return parse_world(text, name_or_file);
  const auto text = read_text_file(name_or_file, kMaxTextBytes);
  if (!text) return with_names(text.error());
  return parse_world(text.value(), name_or_file);
}

Result<CameraPath> load_camera_path(const std::string& name_or_file) {
  if (const std::string_view text = builtin_path(name_or_file); !text.empty()) {
    return parse_camera_path(text, name_or_file);
  }
  const auto text = read_text_file(name_or_file, kMaxTextBytes);
  if (!text) return with_names(text.error());
  return parse_camera_path(text.value(), name_or_file);
}

}  // namespace g3d::hal
