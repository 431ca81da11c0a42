// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_shelf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>

#include "mapper/files/map_header.hpp"

namespace g3d::mapper::submaps {
namespace {

using hal::Error;
using hal::Reason;

struct ShelfHeader {
  std::uint64_t number = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
};
constexpr std::size_t kShelfHeader_bytes = sizeof(ShelfHeader);
static_assert(kShelfHeader_bytes == 16 && std::is_trivially_copyable_v<ShelfHeader>);

std::uint32_t shelf_crc(ByteSpan record) {
  return crc32_of(record.subspan(kShelfHeader_bytes),
                  crc32_of(record.first(kShelfHeader_bytes - sizeof(std::uint32_t))));
}

Error unusable(Reason reason, SubmapShelf::Number number, const std::string& what) {
  return {reason, fmt::format("page file: submap {} {}; check the disk", number, what)};
}

}  // namespace

hal::Result<SubmapShelf::Number> SubmapShelf::put(const SubmapContents& contents) {
  const Bytes packed = to_bytes(contents);
  if (packed.size() > std::numeric_limits<std::uint32_t>::max()) {
    return noted<Number>(Error{Reason::too_large, "page file: a submap of more than 4 GB"});
  }
  ShelfHeader header{next_number_, static_cast<std::uint32_t>(packed.size()), 0};
  Bytes bytes(kShelfHeader_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  put_bytes(bytes, packed);
  header.crc = shelf_crc(bytes);
  std::memcpy(bytes.data(), &header, sizeof header);

  Record record{0, bytes.size(), next_number_};
  auto place = records_.begin();
  for (; place != records_.end() && place->offset < end_of(record); ++place) record.offset = end_of(*place);
  if (auto written = file_->write(record.offset, bytes); !written) return noted<Number>(written.error());
  if (const auto back = read(record); !back) return noted<Number>(back.error());
  records_.insert(place, record);
  return next_number_++;
}

hal::Result<Bytes> SubmapShelf::read(const Record& record) {
  Bytes bytes(record.bytes);
  if (auto done = file_->read(record.offset, bytes); !done) return done.error();
  ShelfHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.crc != shelf_crc(bytes) || header.number != record.number ||
      header.bytes != record.bytes - kShelfHeader_bytes) {
    return unusable(Reason::bad_checksum, record.number, "came back with a wrong checksum");
  }
  return bytes;
}

hal::Result<SubmapContents> SubmapShelf::fetch(Number number) {
  const auto record =
      std::find_if(records_.begin(), records_.end(), [&](const Record& r) { return r.number == number; });
  if (record == records_.end()) return noted<SubmapContents>(unusable(Reason::not_found, number, "was never written"));
  const auto bytes = read(*record);
  if (!bytes) return noted<SubmapContents>(bytes.error());
  auto contents = from_bytes(ByteSpan(bytes.value()).subspan(kShelfHeader_bytes));
  if (!contents) {
    return noted<SubmapContents>(unusable(contents.error().reason, number, "is damaged: " + contents.error().text));
  }
  return contents;
}

void SubmapShelf::drop(Number number) {
  std::erase_if(records_, [&](const Record& record) { return record.number == number; });
  (void)file_->truncate(file_bytes());  // on failure the file is only longer than it needs to be
}

}  // namespace g3d::mapper::submaps
