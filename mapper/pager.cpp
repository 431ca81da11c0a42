// SPDX-License-Identifier: Apache-2.0
#include "mapper/pager.hpp"

#include <algorithm>
#include <cassert>

#include "mapper/block_merge.hpp"

namespace g3d::mapper {

Pager::Pager(std::unique_ptr<PageFile> file, std::uint32_t max_regions, std::uint32_t buffers)
    : store_(std::move(file), max_regions),
      buffers_(std::make_unique<PageBuffer[]>(buffers)),
      free_buffers_(std::make_unique<std::uint32_t[]>(buffers)),
      free_count_(buffers),
      jobs_(buffers),
      results_(buffers),
      merged_(kRegionBlocks) {
  for (std::uint32_t i = 0; i < buffers; ++i) free_buffers_[i] = buffers - 1 - i;
  thread_ = std::thread([this] { loop(); });
}

bool Pager::try_acquire(std::uint32_t& buffer) {
  if (free_count_ == 0) return false;
  buffer = free_buffers_[--free_count_];
  return true;
}

void Pager::submit(PageJob job, std::uint32_t buffer) {
  const bool pushed = jobs_.try_push({job, buffer});
  assert(pushed && "one place for every buffer");
  (void)pushed;
  ++under_way_;
  pager_parking_.wake();
}

bool Pager::try_result(PageResult& result) {
  if (!results_.try_pop(result)) return false;
  --under_way_;
  return true;
}

void Pager::wait_result(PageResult& result) {
  assert(under_way_ > 0);
  (void)mapper_parking_.wait([&] { return try_result(result); });
}

void Pager::stop() {
  if (!thread_.joinable()) return;
  pager_parking_.stop();
  thread_.join();
}

void Pager::loop() {
  Message message{};
  while (pager_parking_.wait([&] { return jobs_.try_pop(message); })) {
    const hal::Result<void> done = work(message.job, buffers_[message.buffer]);
    if (!done && first_error_.empty()) first_error_ = done.error().text;
    file_bytes_.store(store_.file_bytes(), std::memory_order_relaxed);
    (void)results_.try_push({message.job, done.ok(), message.buffer});  // one place for every buffer
    mapper_parking_.wake();
  }
}

hal::Result<void> Pager::work(PageJob job, PageBuffer& buffer) {
  switch (job) {
    case PageJob::store:
      return store_blocks(buffer);
    case PageJob::load:
      return load_blocks(buffer);
    case PageJob::commit:
      store_.commit(buffer.region, buffer.record);
      break;
    case PageJob::abandon:
      store_.abandon(buffer.record);
      break;
    case PageJob::drop:
      store_.drop(buffer.region);
      break;
  }
  return {};
}

hal::Result<void> Pager::store_blocks(PageBuffer& buffer) {
  std::span<const StoredBlock> blocks = buffer.filled();
  if (store_.find(buffer.region) != nullptr) {
    const auto older = store_.get(buffer.region);
    if (!older) return older.error();
    blocks = std::span(merged_).first(merge_lists(older.value(), blocks, merged_));
  }
  const auto record = store_.put(buffer.region, blocks);
  if (!record) return record.error();
  buffer.record = record.value();
  return {};
}

hal::Result<void> Pager::load_blocks(PageBuffer& buffer) {
  const auto blocks = store_.get(buffer.region);
  if (!blocks) return blocks.error();
  buffer.count = static_cast<std::uint32_t>(blocks.value().size());
  std::copy(blocks.value().begin(), blocks.value().end(), buffer.blocks.begin());
  return {};
}

}  // namespace g3d::mapper
