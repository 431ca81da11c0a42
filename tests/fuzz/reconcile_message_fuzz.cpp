// SPDX-License-Identifier: Apache-2.0
// Messages by which robots find out what each lacks, from hostile hands: any bytes, through all four readers. At most
// one of them takes them, and what it takes can be: written again it reads the same.
#include <algorithm>
#include <cstdlib>

#include "net/reconcile_message.hpp"

namespace {

using namespace g3d::net;
using g3d::mapper::ByteSpan;

void check(bool holds) {
  if (!holds) std::abort();
}

WireWriter writer;

bool takes_sketch_ask(ByteSpan message) {
  SketchAsk ask, again;
  if (read_sketch_ask(message, ask) != MessageFault::none) return false;
  check(ask.count > 0 && ask.first < kMostSketchSymbols);
  write_sketch_ask(writer, ask);
  check(read_sketch_ask(writer.bytes(), again) == MessageFault::none);
  check(again.layer == ask.layer && again.salt == ask.salt && again.first == ask.first && again.count == ask.count);
  return true;
}

bool takes_sketch(ByteSpan message) {
  static SketchAnswer answer, again;
  if (read_sketch_answer(message, answer) != MessageFault::none) return false;
  for (const VersionRanges& had : answer.position.had) check(had.highest() <= kMostVersion);
  const auto symbols = answer.sketch.used();
  const std::size_t written =
      write_sketch_answer(writer, answer.position, answer.content_hash, answer.sketch.header, symbols);
  check(written <= symbols.size());
  // A message that holds no symbol is none.
  if (written == 0) return true;
  check(read_sketch_answer(writer.bytes(), again) == MessageFault::none);
  check(again.position.id == answer.position.id && again.position.had == answer.position.had);
  check(again.content_hash == answer.content_hash && again.sketch.header.first == answer.sketch.header.first);
  check(again.sketch.used().size() == written);
  check(std::equal(again.sketch.used().begin(), again.sketch.used().end(), symbols.begin()));
  return true;
}

bool takes_id_ask(ByteSpan message) {
  static IdAsk ask, again;
  if (read_id_ask(message, ask) != MessageFault::none) return false;
  check(ask.count <= kMostIdsPerMessage);
  write_id_ask(writer, ask.layer, ask.salt, ask.all());
  check(read_id_ask(writer.bytes(), again) == MessageFault::none);
  check(again.layer == ask.layer && again.salt == ask.salt && again.count <= ask.count);
  check(std::equal(again.all().begin(), again.all().end(), ask.all().begin()));
  return true;
}

bool takes_records(ByteSpan message) {
  LooseRecords records, again;
  if (records.open(message) != MessageFault::none) return false;
  check(again.open(message) == MessageFault::none && again.layer() == records.layer());
  std::size_t payload_bytes = 0;
  for (LooseRecord record, other; records.take(record);) {
    check(again.take(other) && other.key == record.key && other.version == record.version);
    check(is_record_key(record.key) && record.version > 0 && record.version <= kMostVersion);
    check(static_cast<int>(record.lane) < kLanes);
    check(record.payload.data() >= message.data());
    check(record.payload.data() + record.payload.size() <= message.data() + message.size());
    payload_bytes += record.payload.size();
  }
  LooseRecord other;
  check(!again.take(other) && payload_bytes <= message.size());
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes > kMostMessage_bytes + 100) return -1;
  const ByteSpan message(data, size_bytes);
  int taken = 0;
  for (const auto takes : {takes_sketch_ask, takes_sketch, takes_id_ask, takes_records})
    taken += takes(message) ? 1 : 0;
  check(taken <= 1);
  return 0;
}
