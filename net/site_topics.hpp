// SPDX-License-Identifier: Apache-2.0
// Under which topics sites speak through a broker: ROOT/TO/FROM. Who writes in whose name is for the broker to control
// (its access list can hold a user to FROM); we believe what is sealed, wherever it stood.
//
//   warehouse/all/2        from site 2, to every site             each listens to  warehouse/all/+
//   warehouse/1f/2         from site 2, to site 1f                             and  warehouse/OWN/+
//
// The root is a name, not the fingerprint of the fleet's key: it stays when the key is rotated.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "net/layer_id.hpp"
#include "net/membership.hpp"

namespace g3d::net {

/// The address of a site among those at one broker; in topics as hexadecimal digits.
using SiteId = std::uint64_t;
inline constexpr SiteId kMostSiteId = (SiteId{1} << 56U) - 1;
inline constexpr std::size_t kMostTopicRoot_bytes = 64;

/// By which a robot is called there: never 0.
[[nodiscard]] SiteId site_of(RobotId robot);
/// Levels of letters, digits, '-', '_' and '.', with '/' between them, of at most kMostTopicRoot_bytes together.
[[nodiscard]] bool is_topic_root(std::string_view text);

class SiteTopics {
 public:
  /// `root`: is_topic_root().
  SiteTopics(std::string root, SiteId self) : root_(std::move(root)), self_(self) {}

  [[nodiscard]] std::vector<std::string> subscriptions() const;
  /// What we say to a site, or to kEverybody.
  [[nodiscard]] std::string to(Address site) const;
  /// Who says something under that topic to us; nothing if nobody does, or we ourselves.
  [[nodiscard]] std::optional<SiteId> sender(std::string_view topic) const;

 private:
  std::string root_;
  SiteId self_;
};

}  // namespace g3d::net
