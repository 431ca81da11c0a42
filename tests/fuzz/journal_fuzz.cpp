// SPDX-License-Identifier: Apache-2.0
// A journal of layers from a hostile disk. The first byte picks the way in: the rest as a file, as the entries of a
// frame whose checksum is right, or as patches to an honest journal. A store takes what can be taken: its records have
// valid keys, lanes and payloads, and what was written from it is read back as the same store. The counter file gets
// the same bytes.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "net/journal_frame.hpp"
#include "net/journal_restore.hpp"
#include "net/layer_identity.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr std::size_t kMaxInput_bytes = 8192;
constexpr StoreLimits kFuzzStore{8, 400, 100'000, 64};

void check(bool holds) {
  if (!holds) std::abort();
}

/// A file in memory under a path of its own.
const std::string& journal_path(mapper::ByteSpan bytes) {
  static const int fd = ::memfd_create("journal", MFD_CLOEXEC);
  static const std::string path = "/proc/self/fd/" + std::to_string(fd);
  check(fd >= 0 && ::ftruncate(fd, 0) == 0);
  check(::pwrite(fd, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  return path;
}

mapper::Bytes honest_journal() {
  mapper::Bytes file(kJournalMark.begin(), kJournalMark.end());
  for (std::uint32_t frame = 0; frame < 4; ++frame) {
    mapper::Bytes entries;
    for (std::uint32_t i = 0; i < 5; ++i) {
      StoredRecord record;
      record.key = block_record(frame % 2, i, static_cast<Part>(frame % 3));
      record.version = 5 * frame + i + 1;
      record.lane = static_cast<Lane>(i % 3);
      add_layer_entry(entries, {1 + frame % 2, 3});
      add_record_entry(entries, record, mapper::Bytes(10 * i, 7));
    }
    LayerPosition position{{1 + frame % 2, 3}, {}};
    for (VersionRanges& had : position.had) had = VersionRanges(5 * frame + 5);
    add_claim_entry(entries, position, frame == 2);
    add_frame(file, entries);
  }
  return file;
}

mapper::Bytes journal_of(const LayerStore& store) {
  mapper::Bytes file(kJournalMark.begin(), kJournalMark.end());
  mapper::Bytes entries;
  mapper::Bytes payload;
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    store.for_each(layer, [&](const StoredRecord& record) {
      check(is_record_key(record.key) && record.version > 0 && record.bytes <= kMostPayload_bytes);
      payload.resize(record.bytes);
      store.read(record, payload);
      add_layer_entry(entries, store.id(layer));
      add_record_entry(entries, record, payload);
      add_frame(file, entries);
      entries.clear();
    });
    LayerPosition position{store.id(layer), {}};
    for (const Lane lane : kAllLanes) position.had[static_cast<std::size_t>(lane)] = store.had(layer, lane);
    add_claim_entry(entries, position, store.is_unclaimed(layer));
    add_frame(file, entries);
    entries.clear();
  }
  return file;
}

mapper::Bytes input_journal(const std::uint8_t* data, std::size_t size_bytes) {
  const mapper::ByteSpan rest{data + 1, size_bytes - 1};
  mapper::Bytes file(kJournalMark.begin(), kJournalMark.end());
  if (data[0] % 3 == 0) mapper::put_bytes(file, rest);
  if (data[0] % 3 == 1 && !rest.empty()) add_frame(file, rest);
  if (data[0] % 3 != 2) return file;
  file = honest_journal();
  for (std::size_t i = 0; i + 2 < rest.size(); i += 3) {
    file[(rest[i] * 256U + rest[i + 1]) % file.size()] ^= rest[i + 2];
  }
  return file;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes == 0 || size_bytes > kMaxInput_bytes) return 0;
  (void)parse_layer_identity({reinterpret_cast<const char*>(data), size_bytes}, "f");
  LayerStore store(kFuzzStore);
  const auto restored = restore_layers(journal_path(input_journal(data, size_bytes)), store);
  if (!restored) return 0;
  LayerStore again(kFuzzStore);
  const auto second = restore_layers(journal_path(journal_of(store)), again);
  check(second.ok() && !second.value().is_damaged() && second.value().counts.cut_bytes == 0);
  check(again.digest() == store.digest() && again.layer_count() == store.layer_count());
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    check(again.id(layer) == store.id(layer) && again.upto(layer) == store.upto(layer));
    check(again.is_unclaimed(layer) == store.is_unclaimed(layer));
  }
  return 0;
}
