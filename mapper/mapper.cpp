// SPDX-License-Identifier: Apache-2.0
#include "mapper/mapper.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapper/cpu/block_updater.hpp"
#include "mapper/cpu/bulk_rays.hpp"
#include "mapper/cpu/depth_pyramid.hpp"
#include "mapper/cpu/exact_rays.hpp"
#include "mapper/cpu/free_space.hpp"
#include "mapper/cpu/hit_scatter.hpp"
#include "mapper/cpu/projective.hpp"
#include "mapper/cpu/ray_ends.hpp"
#include "mapper/cpu/ray_grid.hpp"
#include "mapper/cuda/card_keeper.hpp"

namespace g3d::mapper {
namespace {

constexpr std::array<const char*, 3> kIntegratorNames{"dda", "bresenham", "projective"};
constexpr std::array<const char*, 2> kModeNames{"static", "dynamic"};

std::uint16_t mask_raw(const MapperConfig& config, const hal::CameraModel& camera) {
  const float raw = std::nearbyint(config.mask_depth_m * camera.depth_units_per_metre);
  return static_cast<std::uint16_t>(std::clamp(raw, 0.0F, 65535.0F));
}

std::unique_ptr<cpu::FreeSpace> make_free_space(const MapperConfig& config, const cpu::SensorGeometry& sensor) {
  if (config.mode == MapMode::static_mode) return nullptr;
  if (config.integrator == IntegratorKind::projective) return std::make_unique<cpu::Projective>(sensor);
  if (config.integrator == IntegratorKind::dda && cpu::ExactRays::pays(sensor)) {
    return std::make_unique<cpu::ExactRays>(sensor);
  }
  return std::make_unique<cpu::RayGrid>(sensor, config.integrator);
}

}  // namespace

const char* to_string(IntegratorKind kind) { return kIntegratorNames[static_cast<std::size_t>(kind)]; }
const char* to_string(MapMode mode) { return kModeNames[static_cast<std::size_t>(mode)]; }

std::optional<IntegratorKind> integrator_from_string(std::string_view name) {
  for (std::size_t i = 0; i < kIntegratorNames.size(); ++i) {
    if (name == kIntegratorNames[i]) return static_cast<IntegratorKind>(i);
  }
  return std::nullopt;
}

std::optional<MapMode> mode_from_string(std::string_view name) {
  for (std::size_t i = 0; i < kModeNames.size(); ++i) {
    if (name == kModeNames[i]) return static_cast<MapMode>(i);
  }
  return std::nullopt;
}

std::optional<std::string> config_problem(const MapperConfig& config, const hal::CameraModel& camera) {
  // About 1.7 GB of scratch address space for hits and updates; a Kinect at 2 mm needs a quarter of it.
  constexpr double kMostBoxBlocks = 1 << 27;
  const double side = cpu::longest_side_blocks(camera, config.resolution_m, config.far_m);
  const double blocks = side * side * side;
  if (!(blocks <= kMostBoxBlocks)) {
    return "the camera sees too large a space for this resolution: check fx and fy in camera.txt, or choose a coarser "
           "--resolution";
  }
  // Rays count the cells of their grid in 32 bits.
  const bool walks_rays = config.mode == MapMode::dynamic_mode && config.integrator != IntegratorKind::projective;
  if (walks_rays && blocks * kBlockVoxels >= 2147483647.0) {
    return std::string("the integrator ") + to_string(config.integrator) +
           " cannot work at this resolution; choose a coarser --resolution or --integrator projective";
  }
  return std::nullopt;
}

struct Mapper::Parts {
  Parts(const MapperConfig& settings, const hal::CameraModel& camera, std::span<const std::uint16_t> scan_mask)
      : config(settings),
        sensor(camera, settings.resolution_m, settings.near_m, settings.far_m),
        map(Grid{settings.resolution_m}, settings.capacity),
        pool(settings.threads),
        kernels(cpu::best_kernels()),
        ends(sensor, scan_mask, mask_raw(settings, camera), settings.carve_invalid),
        pyramid(camera.width_px, camera.height_px),
        hits(sensor),
        updater(map, sensor, settings.steps),
        free_space(make_free_space(settings, sensor)),
        look_counter(sensor) {
    map.touch();
    if (settings.backend != Backend::cpu) card = std::make_unique<cuda::CardKeeper>(config, sensor, scan_mask, map);
  }

  void integrate_here(const hal::Frame& frame, const cpu::FrameGeometry& geometry, const std::uint8_t* rgb,
                      FrameReport& report);

  /// Hits that no free block took along: all of them in static mode.
  void offer_remaining_hits(const cpu::FrameGeometry& frame, std::uint32_t chunk) {
    for (int s = 0; s < cpu::HitScatter::kShards; ++s) {
      for (const std::uint32_t index : hits.shard(s)) {
        cpu::HitRecord& record = hits.record(index);
        if (record.consumed == 0) updater.offer_hits(chunk, frame.block_key(record.block_id), record);
      }
    }
  }

  MapperConfig config;
  cpu::SensorGeometry sensor;
  VoxelMap map;
  cpu::ThreadPool pool;
  const cpu::Kernels& kernels;
  cpu::RayEnds ends;
  cpu::DepthPyramid pyramid;
  cpu::HitScatter hits;
  cpu::BlockUpdater updater;
  std::unique_ptr<cpu::FreeSpace> free_space;
  cpu::LookCounter look_counter;
  std::unique_ptr<cuda::CardKeeper> card;
  bool last_on_card = false;
  std::uint32_t frame_number = 0;
  const hal::Frame* begun_frame = nullptr;  ///< until it is finished
  std::optional<cpu::FrameGeometry> begun_geometry;
};

Mapper::Mapper(const MapperConfig& config, const hal::CameraModel& camera, std::span<const std::uint16_t> scan_mask)
    : parts_(std::make_unique<Parts>(config, camera, scan_mask)) {}
Mapper::~Mapper() = default;

std::int64_t Mapper::workers_cpu_ns() const { return parts_->pool.workers_cpu_ns(); }

bool Mapper::begin_frame(const hal::Frame& frame, const hal::Pose& T_world_camera) {
  Parts& p = *parts_;
  p.begun_frame = nullptr;
  p.last_on_card = false;
  p.begun_geometry = cpu::frame_geometry(p.sensor, hal::to_transform(T_world_camera));
  if (!p.begun_geometry) return false;
  ++p.frame_number;
  p.begun_frame = &frame;
  const bool with_colour = p.config.with_colour && frame.has_colour;
  p.last_on_card = p.card != nullptr && p.card->begin(frame, *p.begun_geometry, with_colour, p.frame_number);
  return p.last_on_card;
}

FrameReport Mapper::finish_frame() {
  Parts& p = *parts_;
  FrameReport report;
  if (p.begun_frame == nullptr) {
    report.status = FrameStatus::out_of_range;
    return report;
  }
  if (p.last_on_card) p.last_on_card = p.card->finish(report);
  if (!p.last_on_card) {
    const bool with_colour = p.config.with_colour && p.begun_frame->has_colour;
    p.integrate_here(*p.begun_frame, *p.begun_geometry, with_colour ? p.begun_frame->rgb.get() : nullptr, report);
  }
  p.begun_frame = nullptr;
  if (report.refused_blocks > 0) report.status = FrameStatus::pool_full;
  return report;
}

cuda::ChangedClasses Mapper::card_classes() const {
  return parts_->last_on_card ? parts_->card->changed_classes() : cuda::ChangedClasses{};
}

void Mapper::follow_columns(const ColumnTables& tables) {
  if (parts_->card != nullptr) parts_->card->follow_columns(tables);
}
ChangedColumns Mapper::card_columns() const {
  return parts_->last_on_card ? parts_->card->changed_columns() : ChangedColumns{};
}

void Mapper::Parts::integrate_here(const hal::Frame& frame, const cpu::FrameGeometry& geometry, const std::uint8_t* rgb,
                                   FrameReport& report) {
  ends.compute(frame.depth.get(), kernels, pool);
  hits.clear();
  hits.compute(geometry, ends, rgb, kernels, pool);
  std::uint32_t last_chunk = 0;
  if (free_space != nullptr) {
    pyramid.compute(ends, kernels, pool);
    free_space->offer({sensor, geometry, ends, pyramid, hits, updater, kernels, pool, rgb != nullptr, frame_number});
    last_chunk = updater.chunks() - 1;
  } else {
    updater.begin(geometry, rgb != nullptr, kernels, frame_number, 1, geometry.block_count(), pool.threads() == 1);
  }
  offer_remaining_hits(geometry, last_chunk);
  report.refused_blocks = updater.finish(pool);
  report.valid_pixels = ends.counts().valid;
  report.too_near_pixels = ends.counts().too_near;
  report.far_pixels = ends.counts().far;
  report.invalid_pixels = ends.counts().invalid;
  report.hit_blocks = hits.block_count();
}

void Mapper::free_footprint(const std::array<double, 3>& base_m, double radius_m, double height_m) {
  VoxelMap& map = parts_->map;
  const double r = static_cast<double>(map.grid().resolution_m);
  const auto low = [&](double x) { return map.grid().to_index(static_cast<float>(x)); };
  BlockValues values;
  const VoxelIndex lowest{low(base_m[0] - radius_m), low(base_m[1] - radius_m), low(base_m[2])};
  const VoxelIndex highest{low(base_m[0] + radius_m), low(base_m[1] + radius_m), low(base_m[2] + height_m)};
  if (!is_inside_grid(lowest) || !is_inside_grid(highest)) return;
  for (std::int32_t bz = lowest.z & ~7; bz <= highest.z; bz += 8) {
    for (std::int32_t by = lowest.y & ~7; by <= highest.y; by += 8) {
      for (std::int32_t bx = lowest.x & ~7; bx <= highest.x; bx += 8) {
        const BlockKey key = block_of({bx, by, bz});
        map.read_stored_block(key, values);
        bool touched = false;
        for (std::size_t place = 0; place < values.size(); ++place) {
          const VoxelIndex in_block = decode(place);
          const VoxelIndex v{bx + in_block.x, by + in_block.y, bz + in_block.z};
          const auto c = map.grid().centre_m(v);
          const double dx = c[0] - base_m[0];
          const double dy = c[1] - base_m[1];
          const bool inside =
              dx * dx + dy * dy <= (radius_m + 0.5 * r) * (radius_m + 0.5 * r) && v.z >= lowest.z && v.z <= highest.z;
          if (!inside || level_of(values[place]) != kUnknownLevel) continue;
          values[place] = after_miss(kUnknownLevel, parts_->config.steps);
          touched = true;
        }
        if (touched) (void)map.write_block(key, values);
      }
    }
  }
}

// While a frame is in the card and not yet in the mirror, the mirror is what map() says.
void Mapper::cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits) {
  Parts& p = *parts_;
  if (p.card != nullptr && p.begun_frame == nullptr && p.card->cast_rays(rays, hits)) return;
  cpu::cast_bulk_rays(p.map, rays, hits, p.pool);
}

Look Mapper::look_from(const hal::Pose& T_world_camera) const {
  return cpu::look_from(parts_->sensor, hal::to_transform(T_world_camera));
}

void Mapper::count_looks(std::span<Look> looks, int stride_px) {
  Parts& p = *parts_;
  const LookModel model = cpu::look_model(p.sensor, stride_px);
  if (p.card != nullptr && p.begun_frame == nullptr && p.card->count_looks(model, looks)) return;
  for (Look& look : looks) look.gain = {};  // what a card that was lost has left there
  p.look_counter.count(p.map, model, looks, p.pool);
}

std::size_t Mapper::rays_from(const hal::Pose& T_world_camera, int stride_px, std::span<BulkRay> rays) const {
  return cpu::rays_from(parts_->sensor, hal::to_transform(T_world_camera), stride_px, rays);
}

std::span<const std::uint32_t> Mapper::changed_slots() const {
  return parts_->last_on_card ? parts_->card->changed_slots() : parts_->updater.changed_slots();
}

align::FitCard* Mapper::fit_card() {
  return parts_->config.surface_slots != 0 && parts_->card != nullptr && parts_->card->is_ready() ? parts_->card.get()
                                                                                                  : nullptr;
}

const char* Mapper::backend_name() const {
  const bool on_card =
      parts_->frame_number == 0 ? parts_->card != nullptr && parts_->card->is_ready() : parts_->last_on_card;
  return on_card ? "cuda" : "cpu";
}
CardReport Mapper::card() const {
  if (parts_->card == nullptr) return {};
  CardReport report = parts_->card->report();
  report.in_use = parts_->last_on_card;
  return report;
}
int Mapper::card_process() const { return parts_->card != nullptr ? parts_->card->process() : -1; }
VoxelMap& Mapper::map() { return parts_->map; }
const VoxelMap& Mapper::map() const { return parts_->map; }
const MapperConfig& Mapper::config() const { return parts_->config; }

}  // namespace g3d::mapper
