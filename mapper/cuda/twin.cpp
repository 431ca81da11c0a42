// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/twin.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "mapper/cuda/mirror.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr int kKeyBits = 39;

}  // namespace

Twin::Twin(const MapperConfig& config, const cpu::SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask,
           VoxelMap& mirror)
    : builder_(config, sensor, scan_mask),
      mirror_(mirror),
      journal_(std::size_t{config.capacity.blocks} + 1),
      changed_(sensor.max_box_blocks()),
      kept_heads_(sensor.max_box_blocks()),
      kept_planes_(sensor.max_box_blocks()),
      kept_bricks_(sensor.max_box_blocks() * kBricks),
      column_keys_(sensor.max_box_blocks()),
      column_cells_(sensor.max_box_blocks() * kBlockSide_cells * kBlockSide_cells) {
  mirror_.set_journal(&journal_);
}

Twin::~Twin() { mirror_.set_journal(nullptr); }

void Twin::set_card(std::shared_ptr<Card> card) {
  card_ = std::move(card);
  card_is_empty_ = true;
  card_knows_columns_ = false;
}

bool Twin::begin(const hal::Frame& frame, const cpu::FrameGeometry& geometry, bool with_colour,
                 std::uint32_t frame_number, FrameReport& report) {
  changed_count_ = 0;
  on_card_ = 0;
  column_count_ = 0;
  frame_number_ = frame_number;
  if (!send_changes()) return false;
  FrameInput& input = card_->input();
  builder_.fill(geometry, with_colour, frame_number, input);
  const std::size_t pixels = builder_.mask().size();
  std::memcpy(card_->depth(), frame.depth.get(), pixels * sizeof(std::uint16_t));
  if (!card_->begin_frame()) return false;
  if (with_colour) std::memcpy(card_->rgb(), frame.rgb.get(), 3 * pixels);
  FrameCounters counters{};
  if (!card_->finish_frame(counters) || counters.refused_imports > 0) return false;
  if (counters.changed > changed_.size()) return false;  // no healthy card says so
  if (counters.changed <= card_->class_room() && !are_sane(card_->classes(), counters.changed)) return false;
  on_card_ = counters.changed;
  report.valid_pixels = counters.valid;
  report.too_near_pixels = counters.too_near;
  report.far_pixels = counters.far;
  report.invalid_pixels = static_cast<std::uint32_t>(pixels) - counters.valid - counters.too_near - counters.far;
  report.hit_blocks = counters.records;
  report.refused_blocks = counters.refused;
  return !column_tables_ || read_columns();
}

void Twin::follow_columns(const ColumnTables& tables) {
  column_tables_ = tables;
  card_knows_columns_ = false;
  column_bits_ = kCountedBit << 1;
  for (const auto& row : tables.bits) {
    for (const std::uint8_t bits : row) column_bits_ |= bits;
  }
}

bool Twin::read_columns() {
  if (card_->column_room() == 0) return false;
  if (!card_knows_columns_ && !card_->set_columns(*column_tables_)) return false;
  card_knows_columns_ = true;
  const std::uint32_t cells = cells_of(*column_tables_);
  for (std::uint32_t first = 0; first < on_card_; first += card_->column_room()) {
    if (!card_->read_columns(first)) return false;
    const std::uint32_t count = std::min(card_->column_room(), on_card_ - first);
    for (std::uint32_t i = 0; i < count; ++i) {
      const BlockKey key = card_->columns().keys[i];
      if (key == kForgotten) continue;
      if (column_layer(*column_tables_, key) < 0 || key >> kKeyBits != 0) return false;
      std::uint8_t* to = &column_cells_[column_count_ * cells];
      std::memcpy(to, card_->columns().cells + std::size_t{i} * cells, cells);
      std::uint8_t all = 0;
      for (std::uint32_t cell = 0; cell < cells; ++cell) all |= to[cell];
      if ((all & ~column_bits_) != 0) return false;
      column_keys_[column_count_++] = key;
    }
  }
  return true;
}

ChangedColumns Twin::changed_columns() const {
  if (card_ == nullptr || !column_tables_) return {};
  return {{column_keys_.data(), column_count_}, column_cells_.data(), cells_of(*column_tables_)};
}

bool Twin::finish(FrameReport& report) {
  if (on_card_ <= card_->room()) {
    if (on_card_ > 0 && (!card_->send_blocks(0) || !are_sane(card_->parcels(), on_card_))) return false;
    take(card_->parcels(), on_card_, report);
    return true;
  }
  kept_ = 0;
  while (kept_ < on_card_) {
    const std::uint32_t next = std::min(card_->room(), on_card_ - kept_);
    if (!card_->send_blocks(kept_) || !are_sane(card_->parcels(), next)) return false;
    keep(next);
  }
  take({kept_heads_.data(), kept_planes_.data(), kept_bricks_.data()}, kept_, report);
  return true;
}

ChangedClasses Twin::changed_classes() const {
  if (card_ == nullptr || on_card_ > card_->class_room()) return {};
  return {{card_->classes().heads, on_card_}, {card_->classes().planes, on_card_}};
}

bool Twin::are_sane(const Classes& classes, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const ClassHead& head = classes.heads[i];
    if (head.key >> kKeyBits != 0 || (head.uniform > 2 && head.uniform != kNone)) return false;
  }
  return true;
}

bool Twin::are_sane(const Parcels& parcels, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const ParcelHead& head = parcels.heads[i];
    const bool placed = (head.plane == kNone || head.plane == i) && head.first_brick == i * kBricks;
    if (!placed || head.key >> kKeyBits != 0 || head.uniform_level > kMaxLevel) return false;
  }
  return true;
}

bool Twin::are_sane(std::span<const BulkRay> rays, std::span<const BulkHit> hits) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const BulkHit& hit = hits[i];
    if (hit.end > RayEnd::left_grid) return false;
    // A range may be no number; then this is what comes back.
    const bool is_open = hit.end == RayEnd::max_range;
    const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
    if (is_open && bits(hit.distance_m) != bits(rays[i].max_range_m)) return false;
    // Through voxels and back, so the last bits may differ.
    if (!is_open && !(hit.distance_m >= 0.0F && hit.distance_m <= 1.0001F * rays[i].max_range_m + 1e-30F)) return false;
  }
  return true;
}

bool Twin::is_sane(const LookGain& gain, const Look& look, const LookModel& model) {
  const auto along = [&](std::int32_t px) {
    return static_cast<std::uint64_t>((px + model.stride_px - 1) / model.stride_px);
  };
  const std::uint64_t rays = along(model.width_px) * along(model.height_px);
  const std::uint64_t voxels =
      static_cast<std::uint64_t>(look.blocks[0] * look.blocks[1] * look.blocks[2]) * kBlockVoxels;
  return gain.unknown_voxels <= voxels && std::uint64_t{gain.blocked_rays} + gain.near_rays <= rays;
}

bool Twin::cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits) {
  if (card_ == nullptr || card_->ray_room() == 0 || !send_changes()) return false;
  const float resolution_m = mirror_.grid().resolution_m;
  while (!rays.empty()) {
    const std::size_t count = std::min<std::size_t>(rays.size(), card_->ray_room());
    std::memcpy(card_->queries().rays, rays.data(), count * sizeof(BulkRay));
    if (!card_->cast_rays(static_cast<std::uint32_t>(count), resolution_m)) return false;
    std::memcpy(hits.data(), card_->queries().ray_hits, count * sizeof(BulkHit));
    if (!are_sane(rays.first(count), hits.first(count))) return false;
    rays = rays.subspan(count);
    hits = hits.subspan(count);
  }
  return true;
}

bool Twin::count_looks(const LookModel& model, std::span<Look> looks) {
  if (card_ == nullptr || card_->look_room() == 0 || !send_changes()) return false;
  while (!looks.empty()) {
    const std::size_t count = std::min<std::size_t>(looks.size(), card_->look_room());
    std::memcpy(card_->queries().looks, looks.data(), count * sizeof(Look));
    if (!card_->count_looks(static_cast<std::uint32_t>(count), model)) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const LookGain gain = card_->queries().looks[i].gain;
      if (!is_sane(gain, looks[i], model)) return false;
      looks[i].gain = gain;
    }
    looks = looks.subspan(count);
  }
  return true;
}

void Twin::keep(std::uint32_t count) {
  const Parcels& from = card_->parcels();
  for (std::uint32_t i = 0; i < count; ++i) {
    ParcelHead& head = kept_heads_[kept_];
    head = from.heads[i];
    head.first_brick = kept_ * kBricks;
    if (head.plane != kNone) {
      head.plane = kept_;
      kept_planes_[kept_] = from.planes[i];
    }
    const auto bricks = static_cast<std::size_t>(__builtin_popcount(head.bricks));
    std::copy_n(from.bricks + std::size_t{i} * kBricks, bricks, &kept_bricks_[head.first_brick]);
    ++kept_;
  }
}

void Twin::take(const Parcels& parcels, std::uint32_t count, FrameReport& report) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const Taken taken = take_parcel(mirror_, parcels, i, frame_number_);
    if (taken.slot != kNoSlot) changed_[changed_count_++] = taken.slot;
    if (taken.complete) continue;
    ++report.refused_blocks;
    journal_.note(parcels.heads[i].key);  // the mirror has the last word
  }
}

bool Twin::send_changes() {
  if (card_is_empty_) {
    card_is_empty_ = false;
    journal_.clear();
    ReservedArray<BlockKey>& keys = journal_.keys;
    std::size_t count = 0;
    for (std::uint32_t slot = 0; slot < mirror_.slot_end(); ++slot) {
      if (mirror_.header(slot).key != VoxelMap::kNoKey) keys[count++] = mirror_.header(slot).key;
    }
    return send_keys({keys.data(), count});
  }
  if (journal_.everything) return false;  // only an empty card can start anew
  const std::span<BlockKey> keys{journal_.keys.data(), journal_.count};
  std::sort(keys.begin(), keys.end());
  const auto end = std::unique(keys.begin(), keys.end());
  const std::span<const BlockKey> changed = keys.first(static_cast<std::size_t>(end - keys.begin()));
  // Forgotten first, and only then sent: what the mirror has room for, the card has room for as well, but not for the
  // blocks before and after a change at once.
  const bool sent = forget_keys(changed) && send_keys(changed);
  journal_.clear();
  return sent;
}

bool Twin::forget_keys(std::span<const BlockKey> keys) {
  if (keys.empty()) return true;
  while (!keys.empty()) {
    const std::size_t count = std::min<std::size_t>(keys.size(), card_->room());
    for (std::size_t i = 0; i < count; ++i) {
      card_->parcels().heads[i] = {};
      card_->parcels().heads[i].key = keys[i];
      card_->parcels().heads[i].erase = 1;
    }
    if (!card_->import_blocks(static_cast<std::uint32_t>(count))) return false;
    keys = keys.subspan(count);
  }
  return card_->import_blocks(0);
}

bool Twin::send_keys(std::span<const BlockKey> keys) {
  std::uint32_t count = 0;
  for (const BlockKey key : keys) {
    if (!make_parcel(mirror_, key, card_->parcels(), count)) continue;
    if (++count < card_->room()) continue;
    if (!card_->import_blocks(count)) return false;
    count = 0;
  }
  return count == 0 || card_->import_blocks(count);
}

}  // namespace g3d::mapper::cuda
