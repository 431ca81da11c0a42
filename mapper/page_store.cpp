// SPDX-License-Identifier: Apache-2.0
#include "mapper/page_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "mapper/files/map_header.hpp"

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::uint32_t kPageMagic = 0x45474150;  // "PAGE"
// Paging wants speed: a region must be on disk before the robot is far away.
constexpr int kPageZstdLevel = 1;
constexpr std::uint64_t kLeastGarbage_bytes = 1U << 16;

struct Header {
  std::uint32_t magic = kPageMagic;
  std::uint32_t blocks = 0;
  std::uint64_t region = 0;
  std::uint64_t version = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t crc = 0;  ///< of the 28 bytes before and the payload
};
static_assert(sizeof(Header) == kPageHeaderBytes && std::is_trivially_copyable_v<Header>);

std::uint32_t record_crc(std::span<const std::uint8_t> record) {
  return crc32_of(record.subspan(kPageHeaderBytes), crc32_of(record.first(kPageHeaderBytes - 4)));
}

Error damaged(Reason reason, RegionKey region, const char* what) {
  return {reason, fmt::format("page file: region {:#x} {}; check the disk", region, what)};
}

}  // namespace

struct PageStore::Work {
  // The encoder reads a map: a small one serves as its table.
  VoxelMap staged{Grid{}, {kRegionBlocks, kRegionBlocks, kRegionBlocks* kBricksPerBlock}};
  BlockEncoder encoder{kPageZstdLevel};
  BlockDecoder decoder;
  std::vector<BlockKey> keys;
  Bytes record;
  struct Placed {
    std::uint64_t offset;
    RegionKey region;
  };
  std::vector<Placed> order;
};

PageStore::PageStore(std::unique_ptr<PageFile> file, std::uint32_t max_regions)
    : file_(std::move(file)), index_(max_regions), work_(std::make_unique<Work>()) {}
PageStore::~PageStore() = default;

hal::Result<PageRecord> PageStore::put(RegionKey region, std::span<const StoredBlock> blocks) {
  assert(!blocks.empty() && blocks.size() <= kRegionBlocks);
  if (index_.find(region) == nullptr && index_.size() + uncommitted_ >= index_.capacity()) {
    return Error{Reason::no_capacity, fmt::format("page file: its index of {} regions is full", index_.capacity())};
  }
  Work& w = *work_;
  w.staged.clear();
  w.keys.clear();
  SourceSize size;
  for (const StoredBlock& block : blocks) {
    assert(region_of(block.key) == region);
    (void)w.staged.write_block(block.key, block.values);  // has room for every block of a region
    w.keys.push_back(block.key);
    size.add(block.values);
  }
  const Bytes& payload = w.encoder.encode(w.keys, w.staged);
  Header header;
  header.blocks = static_cast<std::uint32_t>(blocks.size());
  header.region = region;
  header.version = next_version_++;
  header.payload_bytes = static_cast<std::uint32_t>(payload.size());
  w.record.resize(kPageHeaderBytes);
  std::memcpy(w.record.data(), &header, sizeof header);
  put_bytes(w.record, payload);
  header.crc = record_crc(w.record);
  std::memcpy(w.record.data(), &header, sizeof header);

  PageRecord record;
  record.offset = end_;
  record.version = header.version;
  record.bytes = static_cast<std::uint32_t>(w.record.size());
  record.blocks = static_cast<std::uint16_t>(blocks.size());
  record.planes = static_cast<std::uint16_t>(size.needed.planes);
  record.colour_bricks = static_cast<std::uint16_t>(size.needed.colour_bricks);
  if (auto done = file_->write(record.offset, w.record); !done) return done.error();
  if (const auto back = read_record(region, record); !back) return back.error();
  end_ += record.bytes;
  live_bytes_ += record.bytes;
  ++uncommitted_;
  return record;
}

void PageStore::commit(RegionKey region, const PageRecord& record) {
  assert(uncommitted_ > 0);
  --uncommitted_;
  PageRecord* current = index_.find_or_insert(region);
  assert(current != nullptr && "put() kept a place");
  if (current->bytes != 0) forget(*current);
  *current = record;
  blocks_ += record.blocks;
  compact_if_worth_it();
}

void PageStore::abandon(const PageRecord& record) {
  assert(uncommitted_ > 0);
  --uncommitted_;
  live_bytes_ -= record.bytes;
  compact_if_worth_it();
}

void PageStore::forget(const PageRecord& record) {
  live_bytes_ -= record.bytes;
  blocks_ -= record.blocks;
}

bool PageStore::drop(RegionKey region) {
  const PageRecord* record = index_.find(region);
  if (record == nullptr) return false;
  forget(*record);
  index_.erase(region);
  compact_if_worth_it();
  return true;
}

// Checks everything but the payload's inside, which only get() needs.
hal::Result<std::span<const std::uint8_t>> PageStore::read_record(RegionKey region, const PageRecord& record) const {
  Bytes& bytes = work_->record;
  bytes.resize(record.bytes);
  if (auto done = file_->read(record.offset, bytes); !done) return done.error();
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.crc != record_crc(bytes)) return damaged(Reason::bad_checksum, region, "came back with a wrong checksum");
  if (header.magic != kPageMagic || header.region != region || header.version != record.version ||
      header.blocks != record.blocks || header.payload_bytes != record.bytes - kPageHeaderBytes) {
    return damaged(Reason::malformed, region, "came back as another record");
  }
  return std::span<const std::uint8_t>(bytes).subspan(kPageHeaderBytes);
}

hal::Result<std::span<const StoredBlock>> PageStore::get(RegionKey region) const {
  const PageRecord* record = index_.find(region);
  if (record == nullptr) return damaged(Reason::not_found, region, "was never written");
  const auto payload = read_record(region, *record);
  if (!payload) return payload.error();
  auto blocks = work_->decoder.decode(payload.value());
  if (!blocks) return damaged(blocks.error().reason, region, blocks.error().text.c_str());
  if (blocks.value().size() != record->blocks || region_of(blocks.value().front().key) != region ||
      region_of(blocks.value().back().key) != region) {
    return damaged(Reason::malformed, region, "came back with other blocks");
  }
  return blocks;
}

std::vector<RegionKey> PageStore::sorted_regions() const {
  std::vector<RegionKey> regions;
  regions.reserve(index_.size());
  index_.for_each([&](RegionKey region, const PageRecord&) { regions.push_back(region); });
  std::sort(regions.begin(), regions.end());
  return regions;
}

// Moves records down into the garbage before them, never onto themselves: a record that is larger than the gap before
// it stays. So the old bytes stand until the new ones were read back, and less garbage than live bytes is left.
void PageStore::compact_if_worth_it() {
  const std::uint64_t garbage_bytes = end_ - live_bytes_;
  if (uncommitted_ > 0 || garbage_bytes < kLeastGarbage_bytes || garbage_bytes <= live_bytes_) return;
  auto& order = work_->order;
  order.clear();
  index_.for_each([&](RegionKey region, const PageRecord& record) { order.push_back({record.offset, region}); });
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  std::uint64_t to = 0;
  for (const auto& [offset, region] : order) {
    PageRecord& record = *index_.find(region);
    if (to + record.bytes <= offset && read_record(region, record).ok()) {
      PageRecord moved = record;
      moved.offset = to;
      if (file_->write(to, work_->record).ok() && read_record(region, moved).ok()) record = moved;
    }
    to = record.offset + record.bytes;
  }
  end_ = to;
  (void)file_->truncate(end_);  // on failure the file is only longer than it needs to be
}

}  // namespace g3d::mapper
