// SPDX-License-Identifier: Apache-2.0
#include "nav/outputs.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <utility>

#include "mapper/files/map_file.hpp"
#include "mapper/files/octomap_write.hpp"
#include "mapper/files/point_cloud.hpp"
#include "mapper/files/render.hpp"
#include "nav/ground_file.hpp"

namespace g3d::nav {
namespace {

struct Format {
  const char* ending;
  const char* what;
  hal::Result<void> (*write)(const mapper::VoxelMap& map, const OutputOptions& options, const std::string& path);
};

/// Forgets the value, keeps the error.
template <typename T>
hal::Result<void> outcome(const hal::Result<T>& result) {
  if (!result.ok()) return result.error();
  return {};
}

hal::Result<void> write_native(const mapper::VoxelMap& map, const OutputOptions& options, const std::string& path) {
  return outcome(save_map(map, options.meta, path));
}

hal::Result<void> write_tree(const mapper::VoxelMap& map, const OutputOptions&, const std::string& path) {
  return write_octomap(map, path);
}

hal::Result<void> write_points(const mapper::VoxelMap& map, const OutputOptions&, const std::string& path) {
  return outcome(write_point_cloud(map, path));
}

hal::Result<void> write_ground_map(const mapper::VoxelMap& map, const OutputOptions& options, const std::string& path) {
  return write_ground(project_to_ground(map, options.band), path.substr(0, path.rfind('.')));
}

hal::Result<void> write_picture(const mapper::VoxelMap& map, const OutputOptions& options, const std::string& path) {
  mapper::RenderOptions render;
  render.trajectory = options.trajectory;
  return path.ends_with("top.png") ? mapper::write_top(map, path, render)
                                   : mapper::write_perspective(map, path, render);
}

constexpr std::array kFormats{
    Format{".g3d", "the map itself", write_native},
    Format{".ot", "OctoMap with colours", write_tree},
    Format{".bt", "OctoMap, occupied and free", write_tree},
    Format{".ply", "points with colours", write_points},
    Format{".pcd", "points with colours", write_points},
    Format{".yaml", "ground map for map_server, with its .pgm", write_ground_map},
    Format{".png", "picture", write_picture},
};

}  // namespace

hal::Result<mapper::WrittenFile> write_as(const mapper::VoxelMap& map, const OutputOptions& options,
                                          const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  for (const Format& format : kFormats) {
    if (ending != format.ending) continue;
    if (const auto written = format.write(map, options, path); !written) return written.error();
    std::error_code ignored;
    const auto bytes = std::filesystem::file_size(path, ignored);
    return mapper::WrittenFile{path, format.what, ignored ? 0 : bytes};
  }
  return hal::Error{
      hal::Reason::unsupported,
      fmt::format("{}: no format is known by the ending '{}'; use .g3d, .ot, .bt, .ply, .pcd, .yaml or .png", path,
                  ending)};
}

std::vector<OutputJob> output_jobs(const mapper::VoxelMap& map, const OutputOptions& options,
                                   const std::string& folder) {
  std::vector<OutputJob> jobs;
  for (const char* name : {"map.g3d", "map.ot", "map.bt", "map.ply", "ground.yaml", "map.png", "top.png"}) {
    const std::string path = folder + "/" + name;
    jobs.push_back({path, [&map, &options, path] { return write_as(map, options, path); }});
  }
  return jobs;
}

Outputs write_outputs(const mapper::VoxelMap& map, const OutputOptions& options, const std::string& folder) {
  return write_patiently(output_jobs(map, options, folder));
}

Outputs write_native_output(const mapper::BlockSource& whole, const OutputOptions& options, const std::string& folder) {
  Outputs outputs;
  const std::string path = folder + "/map.g3d";
  const auto saved = save_map(whole, options.meta, path);
  if (!saved) {
    outputs.failures.push_back(saved.error());
    return outputs;
  }
  outputs.map_file_bytes = saved.value().file_bytes;
  outputs.files.push_back({path, kFormats[0].what, saved.value().file_bytes});
  return outputs;
}

}  // namespace g3d::nav
