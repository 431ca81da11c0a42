// SPDX-License-Identifier: Apache-2.0
// `g3dmap export`, `g3dmap info` and `g3dmap merge`: what can be done with maps that are files already.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "hal/geometry.hpp"
#include "main_commands.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/json_writer.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "mapper/summary.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

int fail(const std::string& text, int exit_code = kExitFailed) {
  fmt::print(stderr, "g3dmap: {}\n", text);
  return exit_code;
}

void print_info(const std::string& file, const mapper::AnyMap& any) {
  const mapper::MapCounts counts = any.map->counts();
  const mapper::MapMemory memory = any.map->memory();
  const auto& t = any.meta.T_world_map.translation_m;
  const auto& q = any.meta.T_world_map.rotation_xyzw;
  fmt::print("file        {}, {}, {}\n", file, any.format, mapper::readable_bytes(any.file_bytes));
  fmt::print("resolution  {:g} cm\n", any.map->grid().resolution_m * 100.0F);
  fmt::print("voxels      {} occupied, {} free, {} with a colour\n", mapper::readable_count(counts.occupied),
             mapper::readable_count(counts.free), mapper::readable_count(counts.coloured));
  fmt::print("blocks      {}, of them {} uniform\n", mapper::readable_count(counts.blocks),
             mapper::readable_count(counts.uniform_blocks));
  fmt::print("memory      {}\n", mapper::readable_bytes(memory.used_bytes));
  fmt::print("pose        {:g} {:g} {:g} m, quaternion {:g} {:g} {:g} {:g}\n", t[0], t[1], t[2], q[0], q[1], q[2],
             q[3]);
  fmt::print("hash        {}\n", map_hash(*any.map));
}

void print_info_json(const std::string& file, const mapper::AnyMap& any) {
  const mapper::MapCounts counts = any.map->counts();
  mapper::JsonWriter json;
  json.begin_object().member("file", file).member("format", any.format).member("file_bytes", any.file_bytes);
  // The shortest decimal that names the stored float: 0.05, not 0.0500000007.
  json.member("resolution_m", std::stod(fmt::format("{}", any.map->grid().resolution_m)));
  json.member("occupied", counts.occupied).member("free", counts.free).member("coloured", counts.coloured);
  json.member("blocks", counts.blocks).member("uniform_blocks", counts.uniform_blocks);
  json.member("memory_bytes", static_cast<std::uint64_t>(any.map->memory().used_bytes));
  json.key("translation_m").begin_array();
  for (const double value : any.meta.T_world_map.translation_m) json.value(value);
  json.end_array().key("rotation_xyzw").begin_array();
  for (const double value : any.meta.T_world_map.rotation_xyzw) json.value(value);
  json.end_array().member("hash", map_hash(*any.map)).end_object();
  fmt::print("{}", json.take());
}

/// "x,y,z,roll,pitch,yaw"; six finite numbers, positions within 1000 km.
std::optional<hal::Pose> parse_pose(std::string_view text) {
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto end = i + 1 < numbers.size() ? text.find(',') : text.size();
    if (end == std::string_view::npos) return std::nullopt;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + end, numbers[i]);
    if (error != std::errc{} || stop != text.data() + end || !std::isfinite(numbers[i]) || std::abs(numbers[i]) > 1e6) {
      return std::nullopt;
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return hal::from_xyz_rpy(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]);
}

}  // namespace

int run_export(const ExportOptions& options) {
  const auto any = mapper::read_any_map(options.from);
  if (!any) return fail(any.error().text);
  nav::OutputOptions output;
  output.meta = any.value().meta;
  for (const std::string& path : options.to) {
    const auto written = nav::write_as(*any.value().map, output, path);
    if (!written) {
      return fail(written.error().text,
                  written.error().reason == hal::Reason::unsupported ? kExitBadUsage : kExitFailed);
    }
    fmt::print("{}  {}  {}\n", written.value().path, mapper::readable_bytes(written.value().bytes),
               written.value().what);
  }
  return kExitDone;
}

int run_info(const InfoOptions& options) {
  const auto any = mapper::read_any_map(options.file);
  if (!any) return fail(any.error().text);
  options.json ? print_info_json(options.file, any.value()) : print_info(options.file, any.value());
  return kExitDone;
}

int run_merge(const MergeOptions& options) {
  if (!options.poses.empty() && options.poses.size() != options.maps.size()) {
    return fail(fmt::format("{} maps but {} poses; give one --pose per map, or none", options.maps.size(),
                            options.poses.size()),
                kExitBadUsage);
  }
  std::vector<mapper::AnyMap> maps;
  std::vector<mapper::MergeSource> sources;
  for (std::size_t i = 0; i < options.maps.size(); ++i) {
    auto any = mapper::read_any_map(options.maps[i]);
    if (!any) return fail(any.error().text);
    hal::Pose pose = any.value().meta.T_world_map;
    if (!options.poses.empty()) {
      const auto given = parse_pose(options.poses[i]);
      if (!given) {
        return fail(
            fmt::format("--pose '{}': not x,y,z,roll,pitch,yaw with six numbers (metres, radians)", options.poses[i]),
            kExitBadUsage);
      }
      pose = *given;
    }
    maps.push_back(std::move(any).value());
    sources.push_back({maps.back().map.get(), pose, maps.back().meta.layer_id});
  }
  const auto merged = mapper::merge_maps(sources);
  if (!merged) return fail(merged.error().text);
  const auto written = nav::write_as(*merged.value(), {}, options.out);
  if (!written) return fail(written.error().text);
  const mapper::MapCounts counts = merged.value()->counts();
  fmt::print("{}  {}  {} occupied and {} free voxels out of {} maps\nhash {}\n", written.value().path,
             mapper::readable_bytes(written.value().bytes), mapper::readable_count(counts.occupied),
             mapper::readable_count(counts.free), options.maps.size(), map_hash(*merged.value()));
  return kExitDone;
}

}  // namespace g3d
