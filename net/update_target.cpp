// SPDX-License-Identifier: Apache-2.0
#include "net/update_target.hpp"

namespace g3d::net {

using hal::Slot;
using hal::SlotBook;
using hal::SlotCondition;

std::optional<UpdateEnd> judge_update(const SlotBook& book, std::optional<Slot> running, const hal::SlotImageId& image,
                                      bool force) {
  const Slot target = hal::slot_for_update(book, running);
  const auto holds = [&](Slot slot) { return book[slot].image.size_bytes != 0 && book[slot].image == image; };
  const bool waits = book[target].condition == SlotCondition::untried && book.preferred == target && holds(target);
  if ((running && holds(*running) && !force) || waits) return UpdateEnd::already_there;
  if (!force && book[target].condition == SlotCondition::bad && book[target].image.size_bytes == image.size_bytes &&
      book[target].image.digest == image.digest) {
    return UpdateEnd::failed_before;
  }
  if (!force && image.release <= book.newest_good_release) return UpdateEnd::not_newer;
  if (!hal::begin_writing(book, running, target)) return UpdateEnd::not_now;
  return std::nullopt;
}

UpdateGreeting UpdateTarget::standing() const {
  UpdateGreeting greeting;
  const auto book = store_.read();
  if (!book) return greeting;
  greeting.newest_good_release = book.value().newest_good_release;
  if (paths_.running) greeting.running_release = book.value()[*paths_.running].image.release;
  return greeting;
}

UpdateEnd UpdateTarget::failed(const hal::Error& error) {
  trouble_ = error.text;
  if (error.reason == hal::Reason::disk_full) return UpdateEnd::disk_full;
  return error.reason == hal::Reason::too_large ? UpdateEnd::too_large : UpdateEnd::disk_error;
}

std::optional<UpdateEnd> UpdateTarget::begin(const hal::SlotImageId& image, bool force) {
  image_.reset();
  std::optional<UpdateEnd> refused;
  const auto begun = store_.change([&](SlotBook book) -> hal::Result<SlotBook> {
    refused = judge_update(book, paths_.running, image, force);
    target_ = hal::slot_for_update(book, paths_.running);
    return refused ? book : hal::begin_writing(book, paths_.running, *target_);
  });
  if (refused) return refused;
  if (!begun) return failed(begun.error());
  auto opened = hal::SlotImage::open_for_writing(paths_.slots[static_cast<std::size_t>(*target_)]);
  if (!opened) return failed(opened.error());
  image_.emplace(std::move(opened).value());
  if (const auto room = image_->make_room(image.size_bytes); !room) return failed(room.error());
  return std::nullopt;
}

bool UpdateTarget::read(std::uint64_t offset, std::span<std::uint8_t> bytes) {
  const auto read = image_->read(offset, bytes);
  if (!read) trouble_ = read.error().text;
  return read.ok();
}

std::optional<UpdateEnd> UpdateTarget::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (const auto written = image_->write(offset, bytes); !written) return failed(written.error());
  return std::nullopt;
}

std::optional<UpdateEnd> UpdateTarget::sync() {
  if (const auto synced = image_->sync(); !synced) return failed(synced.error());
  return std::nullopt;
}

std::optional<UpdateEnd> UpdateTarget::finish(const hal::SlotImageId& image, bool force) {
  image_.reset();
  bool is_ours = false;
  const auto finished = store_.change([&](SlotBook book) -> hal::Result<SlotBook> {
    // The book must still say what begin() made it say.
    is_ours = book[*target_].condition == SlotCondition::empty;
    return is_ours ? hal::finish_writing(book, *target_, image, force) : book;
  });
  if (!finished) return failed(finished.error());
  if (!is_ours) {
    trouble_ = paths_.book + ": another one has written this slot in the meantime; end it, and send the update again";
    return UpdateEnd::disk_error;
  }
  return std::nullopt;
}

}  // namespace g3d::net
