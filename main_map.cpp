// SPDX-License-Identifier: Apache-2.0
// `g3dmap export` and `g3dmap info`: what can be done with a map that is a file already.
#include <fmt/format.h>

#include "main_commands.hpp"
#include "main_say.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/json_writer.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/summary.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

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

}  // namespace g3d
