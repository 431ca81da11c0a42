// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/thread_plan.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kMaxThreadName = 15;
constexpr std::size_t kMostRules = 32;

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

/// What is wrong with the word, or nullptr.
const char* parse_rule(std::string_view word, ThreadRule& rule) {
  const std::size_t equals = word.find('=');
  if (equals == word.npos || equals == 0 || equals > kMaxThreadName) return "is not NAME=[fifoN|rrN][@CPUS]";
  rule.name = word.substr(0, equals);
  std::string_view what = word.substr(equals + 1);
  if (what.empty()) return "says neither fifoN, rrN nor @CPUS";
  if (const std::size_t at = what.find('@'); at != what.npos) {
    if (!parse_cpu_list(what.substr(at + 1), rule.cpus)) return "has no list of CPUs behind @, like 0,3-5";
    what = what.substr(0, at);
  }
  if (what.empty()) return nullptr;
  const bool is_fifo = what.starts_with("fifo");
  if (!is_fifo && !what.starts_with("rr")) return "has another policy than fifoN or rrN";
  const auto priority = whole_number(what.substr(is_fifo ? 4 : 2));
  if (!priority || *priority < 1 || *priority > 99) return "has no priority of 1 to 99";
  rule.policy = is_fifo ? ThreadRule::Policy::fifo : ThreadRule::Policy::round_robin;
  rule.priority = *priority;
  return nullptr;
}

std::string line_of_file(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

bool parse_cpu_list(std::string_view text, std::uint64_t& cpus) {
  cpus = 0;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view part = text.substr(0, comma);
    text = comma == text.npos ? std::string_view() : text.substr(comma + 1);
    if (comma != part.npos && text.empty()) return false;
    const std::size_t dash = part.find('-');
    const auto first = whole_number(part.substr(0, dash));
    const auto last = dash == part.npos ? first : whole_number(part.substr(dash + 1));
    if (!first || !last || *first > *last || *last >= kMostCpus) return false;
    for (int cpu = *first; cpu <= *last; ++cpu) cpus |= std::uint64_t{1} << cpu;
  }
  return cpus != 0;
}

Result<ThreadPlan> parse_thread_plan(std::string_view text) {
  ThreadPlan plan;
  if (text == "none") return plan;
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view word = take_word(rest);
    if (word.empty()) break;
    ThreadRule rule;
    const char* problem = parse_rule(word, rule);
    if (problem == nullptr && rule_for(plan, rule.name) != nullptr && rule_for(plan, rule.name)->name == rule.name) {
      problem = "names a thread for the second time";
    }
    if (problem == nullptr && plan.size() == kMostRules) problem = "is one too many";
    if (problem != nullptr) return Error{Reason::malformed, fmt::format("threads.plan: '{}' {}", word, problem)};
    plan.push_back(std::move(rule));
  }
  return plan;
}

const ThreadRule* rule_for(const ThreadPlan& plan, std::string_view name) {
  const ThreadRule* all = nullptr;
  for (const ThreadRule& rule : plan) {
    if (rule.name == name) return &rule;
    if (rule.name == "*") all = &rule;
  }
  return all;
}

ThreadSettler::ThreadSettler(ThreadPlan plan, std::string tasks, std::string online)
    : plan_(std::move(plan)), tasks_(std::move(tasks)), online_(std::move(online)) {}

void ThreadSettler::settle() {
  if (plan_.empty()) return;
  std::vector<Seen> now;
  std::error_code error;
  for (std::filesystem::directory_iterator at(tasks_, error), end; !error && at != end; at.increment(error)) {
    const auto thread = whole_number(at->path().filename().string());
    if (!thread) continue;
    now.push_back({*thread, line_of_file(at->path().string() + "/comm")});
  }
  for (const Seen& one : now) {
    const bool is_new = std::none_of(seen_.begin(), seen_.end(), [&](const Seen& other) {
      return other.thread == one.thread && other.name == one.name;
    });
    if (!is_new) continue;
    if (const ThreadRule* rule = rule_for(plan_, one.name)) apply(*rule, one.thread);
  }
  seen_ = std::move(now);
}

void ThreadSettler::apply(const ThreadRule& rule, int thread) {
  bool is_whole = true;
  if (rule.cpus != 0) {
    std::uint64_t online = 0;
    if (!parse_cpu_list(line_of_file(online_), online)) online = ~std::uint64_t{0};
    const std::uint64_t cpus = rule.cpus & online;
    cpu_set_t set;
    CPU_ZERO(&set);
    for (int cpu = 0; cpu < kMostCpus; ++cpu) {
      if ((cpus >> cpu & 1U) != 0) CPU_SET(static_cast<unsigned>(cpu), &set);
    }
    if (cpus == 0) {
      ++counts_.no_cpu;
      is_whole = false;
    } else if (::sched_setaffinity(thread, sizeof set, &set) != 0) {
      ++(errno == EINVAL ? counts_.no_cpu : counts_.failed);
      is_whole = false;
    }
  }
  if (rule.policy != ThreadRule::Policy::leave) {
    const sched_param parameters{rule.priority};
    const int policy = rule.policy == ThreadRule::Policy::fifo ? SCHED_FIFO : SCHED_RR;
    if (::sched_setscheduler(thread, policy, &parameters) != 0) {
      ++(errno == EPERM ? counts_.no_permission : counts_.failed);
      is_whole = false;
    }
  }
  counts_.settled += is_whole;
}

}  // namespace g3d::hal
