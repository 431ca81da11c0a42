// SPDX-License-Identifier: Apache-2.0
#include "net/team_report.hpp"

#include <cmath>

namespace g3d::net {

void write_sharing(mapper::JsonWriter& json, const MapSharing& sharing, double run_s) {
  const GossipCounts& counts = sharing.gossip().counts();
  json.key("sharing").begin_object();
  json.member("layers", sharing.store().layer_count()).member("records", sharing.store().record_count());
  json.member("payload_bytes", sharing.store().payload_bytes());
  json.member("published_blocks", sharing.writer().counts().published_blocks);
  json.member("published_bytes", sharing.writer().counts().published_bytes);
  json.member("sent_bytes", counts.all_sent_bytes());
  json.member("sent_Bps", std::round(run_s > 0.0 ? static_cast<double>(counts.all_sent_bytes()) / run_s : 0.0));
  json.member("received_messages", counts.received_messages).member("stored_records", counts.stored_records);
  json.member("superseded_records", counts.superseded_records).member("refused_records", counts.refused_records);
  json.end_object();
}

void write_in_team(mapper::JsonWriter& json, const TeamTalk& talk) {
  const Cluster& cluster = talk.cluster();
  std::uint64_t words = 0;
  for (const std::uint64_t count : talk.said().words) words += count;
  std::uint64_t unread = 0;
  for (const std::uint64_t count : talk.book().counts().faults) unread += count;
  json.key("in_team").begin_object();
  json.member("cluster", cluster.members().size());
  json.member("leader", cluster.office().leader).member("term", cluster.office().term);
  json.member("begun_terms", cluster.counts().begun_terms).member("changed_leaders", cluster.counts().changed_leaders);
  json.member("assignments", talk.counts().assignments)
      .member("orders", talk.counts().orders)
      .member("beaten_claims", talk.counts().beaten_claims);
  json.member("words", words).member("words_bytes", talk.said().bytes);
  json.member("words_read", talk.book().counts().words).member("words_unread", unread);
  json.end_object();
}

}  // namespace g3d::net
