// SPDX-License-Identifier: Apache-2.0
#include "net/site_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace g3d::net {
namespace {

constexpr std::string_view kEverySite = "all";

/// As we write it, and no other way.
std::optional<SiteId> read_site(std::string_view text) {
  SiteId site = 0;
  const char* const end = text.data() + text.size();
  if (text.empty() || text.front() == '0' || std::any_of(text.begin(), text.end(), [](char c) { return c < '0'; })) {
    return std::nullopt;
  }
  const auto [stopped, failed] = std::from_chars(text.data(), end, site, 16);
  if (failed != std::errc{} || stopped != end || site > kMostSiteId) return std::nullopt;
  if (std::any_of(text.begin(), text.end(), [](char c) { return c >= 'A' && c <= 'F'; })) return std::nullopt;
  return site;
}

}  // namespace

SiteId site_of(RobotId robot) {
  if (robot != 0 && robot <= kMostSiteId) return robot;
  return std::max<SiteId>(mixed(robot, 0) & kMostSiteId, 1);
}

bool is_topic_root(std::string_view text) {
  if (text.empty() || text.size() > kMostTopicRoot_bytes || text.front() == '/' || text.back() == '/') return false;
  if (text.find("//") != std::string_view::npos) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.' || c == '/';
  });
}

std::vector<std::string> SiteTopics::subscriptions() const {
  return {fmt::format("{}/{}/+", root_, kEverySite), fmt::format("{}/{:x}/+", root_, self_)};
}

std::string SiteTopics::to(Address site) const {
  return site == kEverybody ? fmt::format("{}/{}/{:x}", root_, kEverySite, self_)
                            : fmt::format("{}/{:x}/{:x}", root_, site, self_);
}

std::optional<SiteId> SiteTopics::sender(std::string_view topic) const {
  if (topic.size() <= root_.size() + 1 || topic.substr(0, root_.size()) != root_ || topic[root_.size()] != '/') {
    return std::nullopt;
  }
  const std::string_view levels = topic.substr(root_.size() + 1);
  const std::size_t slash = levels.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::string_view to = levels.substr(0, slash);
  if (to != kEverySite && read_site(to) != self_) return std::nullopt;
  const std::optional<SiteId> from = read_site(levels.substr(slash + 1));
  return from == self_ ? std::nullopt : from;
}

}  // namespace g3d::net
