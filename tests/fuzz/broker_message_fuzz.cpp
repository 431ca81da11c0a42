// SPDX-License-Identifier: Apache-2.0
// Messages of a broker from hostile hands: a topic up to the first zero byte, then a batch. A topic that has a sender
// is one that this sender writes; a batch that is taken holds what makes the same batch again.
#include <algorithm>
#include <cstdlib>
#include <string>

#include "net/datagram_batch.hpp"
#include "net/site_topics.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;

void check(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const mapper::ByteSpan input(data, size_bytes);
  const auto end = std::find(input.begin(), input.end(), 0);
  const std::string topic(input.begin(), end);
  const SiteTopics ours("g3dmap", 0xA);
  if (const auto sender = ours.sender(topic)) {
    const SiteTopics theirs("g3dmap", *sender);
    check(*sender != 0 && *sender <= kMostSiteId && *sender != 0xA);
    check(topic == theirs.to(kEverybody) || topic == theirs.to(0xA));
  }
  if (is_topic_root(topic)) {
    const SiteTopics rooted(topic, 1);
    check(rooted.sender(SiteTopics(topic, 2).to(1)) == 2);
  }
  if (end == input.end()) return 0;
  const mapper::ByteSpan batch(end + 1, input.end());
  std::size_t count = 0;
  mapper::Bytes again;
  if (datagrams_of(batch) == 0) return 0;
  visit_datagrams(batch, [&](mapper::ByteSpan datagram) {
    check(!datagram.empty() && datagram.size() <= kMostDatagram_bytes);
    append_datagram(again, datagram);
    ++count;
  });
  check(count == datagrams_of(batch) && std::equal(again.begin(), again.end(), batch.begin(), batch.end()));
  return 0;
}
