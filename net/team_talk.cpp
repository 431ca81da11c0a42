// SPDX-License-Identifier: Apache-2.0
#include "net/team_talk.hpp"

#include <algorithm>

namespace g3d::net {
namespace {

MotionWord motion_of(const nav::TeamWord& own) {
  MotionWord word;
  word.T_world_base = own.T_world_base;
  word.is_moving = own.is_moving;
  word.has_goal = own.has_goal;
  word.goal = own.goal;
  word.way = own.way;
  word.way_count = std::min(own.way_count, own.way.size());
  return word;
}

OffersWord offers_of(const nav::TeamWord& own) { return {own.offers, std::min(own.offer_count, own.offers.size())}; }

nav::Teammate mate_of(const RobotWords& words, bool claim_stands) {
  const MotionWord& motion = words.motion;
  nav::Teammate mate;
  mate.robot = words.layer.robot;
  mate.T_world_base = motion.T_world_base;
  mate.told_ns = words.moved_ns;
  if (words.has(StatusKind::state)) mate.radius_m = words.state.radius_m;
  mate.is_moving = motion.is_moving;
  mate.way = motion.way;
  mate.way_count = motion.way_count;
  mate.has_goal = motion.has_goal && claim_stands;
  mate.goal = motion.goal;
  return mate;
}

}  // namespace

TeamTalk::TeamTalk(const TeamTalkOptions& options, Gossip& gossip, const LayerStore& store, hal::TimeNs now_ns)
    : options_(options),
      self_(gossip.options().self.robot),
      gossip_(gossip),
      store_(store),
      writer_(options.pace, gossip),
      book_(self_, gossip.options().most_peers + store.most_layers()),
      cluster_(self_, gossip.options().most_peers + store.most_layers(), options.cluster, now_ns),
      assignment_(options.assignment),
      looked_ns_(now_ns - options.look_every_ns),
      assigned_ns_(now_ns) {
  heard_.reserve(gossip.options().most_peers);
  contacts_.reserve(gossip.options().most_peers + store.most_layers());
  mates_.reserve(gossip.options().most_peers + store.most_layers());
  sight_.self = self_;
}

bool TeamTalk::on_time(const nav::TeamWord& own, const StateWord& state, hal::TimeNs now_ns) {
  // At once, as the time at which a word comes says how old it is.
  book_.update(store_, now_ns);
  if (now_ns - looked_ns_ < options_.look_every_ns) return false;
  looked_ns_ = now_ns;
  look(now_ns);
  if (cluster_.is_leader() && now_ns - assigned_ns_ >= options_.assign_every_ns) {
    assigned_ns_ = now_ns;
    lead(own);
  }
  settle_claims(own);
  show(own, now_ns);
  writer_.say(cluster_.word(), now_ns);
  if (cluster_.is_leader()) writer_.say(orders_, now_ns);
  writer_.say(motion_of(own), cluster_.members().size(), now_ns);
  writer_.say(offers_of(own), now_ns);
  writer_.say(state, now_ns);
  return true;
}

void TeamTalk::look(hal::TimeNs now_ns) {
  heard_.clear();
  for (const Peer& peer : gossip_.members().all()) {
    if (peer.state != PeerState::gone) heard_.push_back(peer.robot);
  }
  std::sort(heard_.begin(), heard_.end());
  contacts_.clear();
  for (const RobotWords& words : book_.all()) {
    if (words.has(StatusKind::contact)) contacts_.push_back({words.layer.robot, words.contact});
  }
  cluster_.update(heard_, contacts_, now_ns);
}

void TeamTalk::lead(const nav::TeamWord& own) {
  const OffersWord own_offers = offers_of(own);
  std::array<Bidder, kMostOrders> bidders;
  std::size_t count = 0;
  for (const RobotId robot : cluster_.members()) {
    const RobotWords* const words = robot == self_ ? nullptr : book_.find(robot);
    if ((words == nullptr && robot != self_) || count == bidders.size()) continue;
    const OffersWord& offers = robot == self_ ? own_offers : words->offers;
    if (offers.count > 0) bidders[count++] = {robot, {offers.offers.data(), offers.count}, order_for(robot)};
  }
  orders_.term = cluster_.office().term;
  orders_.count = 0;
  // Who is alone knows best where to go.
  if (count < 2) return;
  ++counts_.assignments;
  const std::span<const int> offers = assignment_.assign({bidders.data(), count});
  for (std::size_t i = 0; i < count; ++i) {
    // Who gets what it would take by itself needs no order, and may think better of it as it sees more.
    if (offers[i] <= 0) continue;
    ++counts_.orders;
    orders_.orders[orders_.count++] = {bidders[i].robot, bidders[i].offers[static_cast<std::size_t>(offers[i])].goal};
  }
}

const OrdersWord* TeamTalk::standing_orders() const {
  const Office& office = cluster_.office();
  if (office.leader == 0) return nullptr;
  if (office.leader == self_) return orders_.term == office.term ? &orders_ : nullptr;
  const RobotWords* words = book_.find(office.leader);
  return words != nullptr && words->orders.term == office.term ? &words->orders : nullptr;
}

std::optional<hal::PlanarPose> TeamTalk::order_for(RobotId robot) const {
  const OrdersWord* const orders = standing_orders();
  if (orders == nullptr) return std::nullopt;
  for (std::size_t i = 0; i < orders->count; ++i) {
    if (orders->orders[i].robot == robot) return orders->orders[i].goal;
  }
  return std::nullopt;
}

std::optional<hal::PlanarPose> TeamTalk::assigned_to(const nav::TeamWord& own) const {
  const auto order = order_for(self_);
  if (!order) return std::nullopt;
  const double same_m = options_.assignment.same_m;
  if (own.has_goal && apart_m(own.goal, *order) < same_m) return own.goal;
  std::optional<hal::PlanarPose> nearest;
  for (std::size_t i = 0; i < std::min(own.offer_count, own.offers.size()); ++i) {
    const hal::PlanarPose& goal = own.offers[i].goal;
    const double distance_m = apart_m(goal, *order);
    if (distance_m < (nearest ? apart_m(*nearest, *order) : same_m)) nearest = goal;
  }
  return nearest;
}

void TeamTalk::settle_claims(const nav::TeamWord& own) {
  claims_.clear();
  for (const RobotId robot : cluster_.members()) {
    const RobotWords* const words = robot == self_ ? nullptr : book_.find(robot);
    if (words == nullptr && robot != self_) continue;
    const bool claims = robot == self_ ? own.has_goal : words->motion.has_goal;
    const hal::PlanarPose& place = robot == self_ ? own.goal : words->motion.goal;
    if (claims) claims_.note({robot, place});
  }
  claims_.settle(options_.same_claim_m);
  if (own.has_goal && !claims_.stands(self_)) ++counts_.beaten_claims;
}

void TeamTalk::show(const nav::TeamWord& own, hal::TimeNs now_ns) {
  // Of who is not heard of any more the body may still stand there.
  mates_.clear();
  for (const RobotWords& words : book_.all()) {
    if (words.has(StatusKind::motion)) mates_.push_back(&words);
  }
  if (mates_.size() > sight_.mates.size()) {
    // The nearest ones are in the way.
    std::sort(mates_.begin(), mates_.end(), [&](const RobotWords* a, const RobotWords* b) {
      const double a_m = apart_m(a->motion.T_world_base, own.T_world_base);
      const double b_m = apart_m(b->motion.T_world_base, own.T_world_base);
      return a_m != b_m ? a_m < b_m : a->layer.robot < b->layer.robot;
    });
    counts_.left_out_mates += mates_.size() - sight_.mates.size();
    mates_.resize(sight_.mates.size());
  }
  sight_.count = 0;
  for (const RobotWords* words : mates_) {
    nav::Teammate& mate = sight_.mates[sight_.count++];
    mate = mate_of(*words, claims_.stands(words->layer.robot));
    // Who lives and has not said otherwise still stands there.
    if (!mate.is_moving && cluster_.has(mate.robot)) mate.told_ns = now_ns;
  }
  sight_.assigned = assigned_to(own);
}

}  // namespace g3d::net
