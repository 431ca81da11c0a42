// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_search.hpp"

#include <cassert>
#include <utility>

namespace g3d::mapper::submaps {

LoopSearch::LoopSearch(const CloserOptions& options, const JoinRule& join)
    : closer_(options), join_(join), thread_([this] { work(); }) {}

LoopSearch::~LoopSearch() {
  questions_.stop();
  thread_.join();
}

void LoopSearch::ask(SubmapChain& chain) {
  assert(!is_busy());
  chain_ = &chain;
  state_.store(State::asked, std::memory_order_release);
  questions_.wake();
}

void LoopSearch::wait() {
  (void)answers_.wait([this] { return state_.load(std::memory_order_acquire) != State::asked; });
}

MovedSubmaps LoopSearch::take() {
  assert(has_answer());
  MovedSubmaps moved = std::exchange(moved_, {});
  state_.store(State::idle, std::memory_order_release);
  return moved;
}

void LoopSearch::work() {
  while (questions_.wait([this] { return state_.load(std::memory_order_acquire) == State::asked; })) {
    answer();
    state_.store(State::answered, std::memory_order_release);
    answers_.wake();
  }
}

void LoopSearch::answer() {
  join_old(*chain_, closer_, join_);
  if (!closer_.add_submap(*chain_)) return;
  moved_.placed = std::make_unique<PlacedSubmaps>(chain_->view().grid());
  const auto submaps = chain_->submaps();
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    moved_.placed->add(*submaps[i].voxels, closer_.T_world_stored()[i]);
  }
  moved_.whole = moved_.placed->whole();
}

}  // namespace g3d::mapper::submaps
