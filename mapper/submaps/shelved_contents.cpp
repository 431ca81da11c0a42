// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/shelved_contents.hpp"

#include <utility>

namespace g3d::mapper::submaps {

ShelvedContents::ShelvedContents(SubmapContents contents, SubmapShelf* shelf)
    : grid_(contents.voxels->grid()),
      keys_(contents.voxels->sorted_keys()),
      contents_(std::move(contents)),
      shelf_(shelf),
      last_use_(shelf != nullptr ? shelf->next_use() : 0) {}

ShelvedContents::~ShelvedContents() {
  if (number_ != SubmapShelf::kNone) shelf_->drop(number_);
}

const SubmapContents& ShelvedContents::get() {
  if (shelf_ != nullptr) last_use_ = shelf_->next_use();
  if (is_in_memory()) return contents_;
  auto fetched = shelf_->fetch(number_);
  ++shelf_->counts().fetched;
  if (fetched.ok()) {
    contents_ = std::move(fetched).value();
  } else {
    ++shelf_->counts().failed_loads;
    shelf_->drop(std::exchange(number_, SubmapShelf::kNone));
    contents_.voxels = map_for_blocks(grid_, 0);
  }
  return contents_;
}

void ShelvedContents::put_away() {
  if (shelf_ == nullptr || !is_in_memory() || contents_.voxels->block_count() == 0) return;
  if (number_ == SubmapShelf::kNone) {
    const auto put = shelf_->put(contents_);
    if (!put.ok()) {
      ++shelf_->counts().failed_stores;
      return;
    }
    number_ = put.value();
  }
  ++shelf_->counts().put_away;
  contents_ = {};
}

}  // namespace g3d::mapper::submaps
