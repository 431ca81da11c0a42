// SPDX-License-Identifier: Apache-2.0
#include "net/site_topics.hpp"

#include <catch2/catch.hpp>

using namespace g3d::net;

TEST_CASE("topics say to whom and from whom, and are read as they were written") {
  const SiteTopics two("a/warehouse", 2), other("a/warehouse", 0x1F);
  CHECK(two.to(kEverybody) == "a/warehouse/all/2");
  CHECK(two.to(0x1F) == "a/warehouse/1f/2");
  CHECK(two.subscriptions() == std::vector<std::string>{"a/warehouse/all/+", "a/warehouse/2/+"});
  CHECK(other.sender(two.to(kEverybody)) == 2);
  CHECK(other.sender(two.to(0x1F)) == 2);
  CHECK(SiteTopics("r", 1).sender(SiteTopics("r", kMostSiteId).to(1)) == kMostSiteId);
}

TEST_CASE("a topic that is nobody's way to speak to us has no sender") {
  const SiteTopics topics("root", 0xA);
  CHECK(topics.sender("root/all/b") == 0xB);
  CHECK(topics.sender("root/a/b") == 0xB);
  for (const char* topic : {"",
                            "root",
                            "root/",
                            "root/all",
                            "root/all/",
                            "root/a",
                            "root/b/c",
                            "root/all/a",
                            "root/a/a",
                            "root/all/0",
                            "root/all/0b",
                            "root/all/B",
                            "root/all/x",
                            "root/all/b ",
                            "root/all/-1",
                            "root/all/+",
                            "root/all/b/c",
                            "root/A/b",
                            "root/all/100000000000000",
                            "root/all/11111111111111111",
                            "Root/all/b",
                            "roots/all/b",
                            "rootall/b",
                            "/root/all/b"}) {
    CAPTURE(topic);
    CHECK_FALSE(topics.sender(topic));
  }
}

TEST_CASE("a root is names with slashes between them") {
  for (const char* root : {"a", "g3dmap", "Site-1/floor_2/x.y"}) CHECK(is_topic_root(root));
  CHECK(is_topic_root(std::string(kMostTopicRoot_bytes, 'a')));
  CHECK_FALSE(is_topic_root(std::string(kMostTopicRoot_bytes + 1, 'a')));
  for (const char* root : {"", "/", "/a", "a/", "a//b", "a b", "a+", "#", "$SYS", "\xC3\xA4", "a\n"}) {
    CAPTURE(root);
    CHECK_FALSE(is_topic_root(root));
  }
  CHECK_FALSE(is_topic_root(std::string_view("a\0b", 3)));
}

TEST_CASE("a robot's number is its site's, unless it is too long for one") {
  CHECK(site_of(7) == 7);
  CHECK(site_of(kMostSiteId) == kMostSiteId);
  for (const RobotId robot : {RobotId{0}, kMostSiteId + 1, ~RobotId{0}}) {
    CHECK(site_of(robot) != 0);
    CHECK(site_of(robot) <= kMostSiteId);
  }
  CHECK(site_of(kMostSiteId + 1) != site_of(kMostSiteId + 2));
}
