// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper_starter.hpp"

#include <utility>

namespace g3d::mapper::cuda {

HelperStarter::HelperStarter(const HelperSetup& setup) : setup_(setup), thread_([this] { run(); }) {}

HelperStarter::~HelperStarter() {
  turn_.store(Turn::end, std::memory_order_release);
  turn_.notify_one();
  thread_.join();
}

void HelperStarter::run() {
  for (;;) {
    const Turn turn = turn_.load(std::memory_order_acquire);
    if (turn == Turn::end) return;
    if (turn != Turn::starter) {
      turn_.wait(turn, std::memory_order_acquire);
      continue;
    }
    problem_.clear();
    started_ = HelperProcess::start(setup_, problem_);
    Turn expected = Turn::starter;  // or the end has come meanwhile
    turn_.compare_exchange_strong(expected, Turn::mapper, std::memory_order_acq_rel);
  }
}

void HelperStarter::ask() {
  Turn expected = Turn::nobody;
  if (turn_.compare_exchange_strong(expected, Turn::starter, std::memory_order_acq_rel)) turn_.notify_one();
}

bool HelperStarter::take(std::shared_ptr<HelperProcess>& helper, std::string& problem) {
  if (turn_.load(std::memory_order_acquire) != Turn::mapper) return false;
  helper = std::move(started_);
  if (helper == nullptr) std::swap(problem, problem_);
  turn_.store(Turn::nobody, std::memory_order_release);
  return true;
}

}  // namespace g3d::mapper::cuda
