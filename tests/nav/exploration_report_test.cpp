// SPDX-License-Identifier: Apache-2.0
#include "nav/exploration_report.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "hal/sim/sim_building.hpp"

using namespace g3d;

namespace {

struct Sample {
  Sample() {
    mission.note_pose({0.0, 0.0, 0.0}, 0);
    mission.note_pose({3.0, 4.0, 1.0}, 10'000'000'000);
    mission.note_coverage(0.12345678, 1'000'000'000);
    mission.note_coverage(0.96, 5'000'000'000);
    mission.note_stop(nav::StopReason::contact);
    mission.frontiers_left[nav::LeftReason::too_small] = 3;
    mission.frontiers_left.open = 1;
    mission.goals_reached = 7;
    report.mission = &mission;
    report.time_s = 10.0;
    report.home = true;
    report.state = "home";
    report.safety_stops = {{"bumper", 2}};
  }
  nav::MissionReport mission;
  nav::ExplorationReport report;
};

std::string json_of(const nav::ExplorationReport& report) {
  mapper::JsonWriter json;
  json.begin_object();
  nav::write_exploration(json, report);
  json.end_object();
  std::string text = json.take();
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n'; });
  return text;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("the report has the curve, the times, and null for what was never reached", "[nav][exploration_report]") {
  const Sample sample;
  const std::string json = json_of(sample.report);
  CHECK(contains(json, R"({"exploration":{"coverage":[[1,0.12346],[5,0.96]])"));
  CHECK(contains(json, R"("t90_s":5,"t95_s":5,"t99_s":null,"time_s":10,"path_m":5,"rotation_rad":1,)"));
  CHECK(contains(json, R"("home":true,"state":"home")"));
  CHECK(contains(json, R"("stops":{"contact":1,)"));
  CHECK(contains(json, R"("safety":{"bumper":2})"));
  CHECK(contains(json, R"("too_small":3)"));
  CHECK(contains(json, R"("open":1})"));
  CHECK(contains(json, R"("goals_reached":7)"));
  CHECK_FALSE(contains(json, "collisions"));  // nobody was there to see any
  CHECK_FALSE(contains(json, "contacts"));
}

TEST_CASE("whoever looks on from outside adds contacts, each with time, place and speed", "[nav][exploration_report]") {
  Sample sample;
  hal::RobotRecord record;
  record.contacts = 2;
  record.contacts_measurable = 1;
  record.contacts_moving = 1;
  record.contacts_ran_into = 1;
  record.fastest_contact_mps = 0.25;
  record.closest_clearance_m = 0.0;
  hal::ContactEvent event;
  event.time_ns = 3'500'000'000;
  event.at.x_m = 1.25;
  event.at.y_m = -2.0;
  event.speed_mps = 0.25;
  event.bumper = 2;
  event.solid = 17;
  event.measurable = true;
  event.ran_into = true;
  record.events = {event, {}};
  sample.report.outside = nav::outside_view(record);
  REQUIRE(sample.report.outside->contact_list.size() == 2);
  const std::string json = json_of(sample.report);
  CHECK(contains(json, R"("collisions":2,"collisions_measurable":1,"collisions_moving":1,"collisions_ran_into":1,)"));
  CHECK(contains(json, R"("fastest_collision_mps":0.25,"closest_clearance_m":0,)"));
  CHECK(contains(json, R"("contacts":[{"at_s":3.5,"x_m":1.25,"y_m":-2,"speed_mps":0.25,"bumper_flags":2,"solid":17,)"
                       R"("moving":false,"measurable":true,"ran_into":true},{)"));
}

TEST_CASE("the summary says in words how it went", "[nav][exploration_report]") {
  Sample sample;
  std::string text = nav::exploration_text(sample.report);
  CHECK(contains(text, "10 s, 5.0 m driven, 57 degrees turned, home again"));
  CHECK(contains(text, "96.00 % of what can be seen; 90 % after 5 s, 95 % 5 s, 99 % never"));
  CHECK(contains(text, "3 too_small, 1 still open"));
  CHECK_FALSE(contains(text, "contacts"));
  CHECK(text.back() == '\n');
  sample.report.home = false;
  sample.report.state = "needs_help";
  sample.report.outside = nav::OutsideView{};
  text = nav::exploration_text(sample.report);
  CHECK(contains(text, "not home: needs_help"));
  CHECK(contains(text, "contacts    0"));
  const nav::MissionReport nothing;
  sample.report.mission = &nothing;
  CHECK(contains(nav::exploration_text(sample.report), "left        nothing"));
}

TEST_CASE("the picture's title is one line of small letters", "[nav][exploration_report]") {
  Sample sample;
  CHECK(nav::exploration_title("My_House", sample.report) ==
        "my house: 96.0 % seen, 95 %: 5 s, 99 %: never, home after 10 s, 5 m");
  sample.report.home = false;
  const nav::MissionReport nothing;
  sample.report.mission = &nothing;
  CHECK(nav::exploration_title("x", sample.report) == "x: not home after 10 s, 0 m");
}
