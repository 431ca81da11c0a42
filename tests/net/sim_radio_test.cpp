// SPDX-License-Identifier: Apache-2.0
#include "net/sim_radio.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <tuple>
#include <vector>

using namespace g3d;
using hal::TimeNs;
using net::RadioModel;
using net::SimRadio;

namespace {

constexpr TimeNs kRadioMs = 1'000'000;
constexpr TimeNs kRadioLong = 1'000'000 * kRadioMs;

struct RadioArrival {
  TimeNs at_ns = 0;
  std::uint32_t from = 0, to = 0;
  mapper::Bytes datagram;
  bool operator==(const RadioArrival&) const = default;
};

mapper::Bytes numbered_datagram(std::uint32_t number) {
  mapper::Bytes bytes;
  mapper::put(bytes, number);
  return bytes;
}
std::uint32_t number_in(const RadioArrival& arrival) {
  std::uint32_t number = 0;
  REQUIRE(mapper::ByteReader(arrival.datagram).take(number));
  return number;
}

/// Delivers millisecond by millisecond.
std::vector<RadioArrival> arrivals_until(SimRadio& radio, TimeNs from_ns, TimeNs to_ns) {
  std::vector<RadioArrival> arrivals;
  for (TimeNs now = from_ns; now <= to_ns; now += kRadioMs) {
    radio.deliver(now, [&](std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram) {
      arrivals.push_back({now, from, to, {datagram.begin(), datagram.end()}});
    });
  }
  return arrivals;
}

/// 4000 datagrams from 0 to 1, one in a millisecond.
std::vector<RadioArrival> arrivals_of_many(SimRadio& radio) {
  for (std::uint32_t i = 0; i < 4000; ++i) radio.send(0, 1, numbered_datagram(i), i * kRadioMs);
  return arrivals_until(radio, 0, 4200 * kRadioMs);
}

constexpr RadioModel kBadRadio{0.3, 0.2, 0.2, 2 * kRadioMs, 5 * kRadioMs, 60 * kRadioMs, 11};

}  // namespace

TEST_CASE("a radio that mistreats nothing delivers all in order, once, unchanged, after its delay", "[net]") {
  SimRadio radio(2, {0.0, 0.0, 0.0, 3 * kRadioMs, 0, 0, 1});
  const std::vector<RadioArrival> arrivals = arrivals_of_many(radio);
  REQUIRE(arrivals.size() == 4000);
  for (std::uint32_t i = 0; i < 4000; ++i) {
    REQUIRE(arrivals[i] == RadioArrival{(i + 3) * kRadioMs, 0, 1, numbered_datagram(i)});
  }
  CHECK(radio.delivered() == 4000);
  CHECK(radio.lost() == 0);
  CHECK(radio.under_way() == 0);
}

TEST_CASE("the same seed gives the same deliveries, another one others", "[net]") {
  SimRadio radio(2, kBadRadio), same(2, kBadRadio);
  RadioModel other_model = kBadRadio;
  other_model.seed = 12;
  SimRadio other(2, other_model);
  const std::vector<RadioArrival> arrivals = arrivals_of_many(radio);
  CHECK(arrivals == arrivals_of_many(same));
  CHECK_FALSE(arrivals == arrivals_of_many(other));
}

TEST_CASE("of many datagrams the share is lost, doubled and late that was asked for", "[net]") {
  SimRadio radio(2, kBadRadio);
  const std::vector<RadioArrival> arrivals = arrivals_of_many(radio);
  std::map<std::uint32_t, int> copies;
  std::size_t late = 0;
  for (const RadioArrival& arrival : arrivals) {
    const std::uint32_t number = number_in(arrival);
    ++copies[number];
    const TimeNs delay = arrival.at_ns - number * kRadioMs;
    // Deliveries are looked for every millisecond.
    REQUIRE(delay >= 2 * kRadioMs);
    REQUIRE(delay <= 68 * kRadioMs);
    REQUIRE((delay <= 8 * kRadioMs || delay >= 62 * kRadioMs));
    if (delay >= 62 * kRadioMs) ++late;
  }
  const auto arrived = static_cast<double>(copies.size());
  CHECK(radio.lost() == 4000 - copies.size());
  CHECK(radio.delivered() == arrivals.size());
  CHECK(arrived / 4000 == Approx(0.7).margin(0.03));
  CHECK((static_cast<double>(arrivals.size()) - arrived) / arrived == Approx(0.2).margin(0.03));
  CHECK(static_cast<double>(late) / static_cast<double>(arrivals.size()) == Approx(0.2).margin(0.03));
  for (const auto& [number, count] : copies) REQUIRE(count <= 2);
}

TEST_CASE("late datagrams are overtaken, and what arrives at one time comes in the order it was sent", "[net]") {
  SimRadio radio(2, {0.0, 0.0, 0.1, 2 * kRadioMs, 0, 60 * kRadioMs, 5});
  const std::vector<RadioArrival> arrivals = arrivals_of_many(radio);
  REQUIRE(arrivals.size() == 4000);
  int overtaken = 0;
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    REQUIRE(arrivals[i].at_ns >= arrivals[i - 1].at_ns);
    if (number_in(arrivals[i]) < number_in(arrivals[i - 1])) ++overtaken;
  }
  CHECK(overtaken > 200);

  SimRadio at_once(2, {0.0, 0.0, 0.0, 2 * kRadioMs, 0, 0, 5});
  for (std::uint32_t i = 0; i < 100; ++i) at_once.send(0, 1, numbered_datagram(i), 0);
  const std::vector<RadioArrival> in_order = arrivals_until(at_once, 0, 2 * kRadioMs);
  REQUIRE(in_order.size() == 100);
  for (std::uint32_t i = 0; i < 100; ++i) REQUIRE(number_in(in_order[i]) == i);
}

TEST_CASE("what is sent to everybody reaches all but the sender, each with its own luck", "[net]") {
  SimRadio radio(5, {0.5, 0.0, 0.0, 0, 0, 0, 3});
  std::map<std::uint32_t, int> heard;
  std::map<std::uint32_t, int> ears;
  for (std::uint32_t i = 0; i < 1000; ++i) radio.send(2, SimRadio::kEveryStation, numbered_datagram(i), 0);
  for (const RadioArrival& arrival : arrivals_until(radio, 0, 0)) {
    CHECK(arrival.from == 2);
    ++heard[arrival.to];
    ++ears[number_in(arrival)];
  }
  REQUIRE(heard.size() == 4);
  CHECK(heard.count(2) == 0);
  for (const auto& [station, count] : heard) CHECK(count == Approx(500).margin(70));
  std::map<int, int> numbers_by_ears;
  for (const auto& [number, count] : ears) ++numbers_by_ears[count];
  for (int count = 1; count <= 4; ++count) CHECK(numbers_by_ears[count] > 30);
}

TEST_CASE("a link that is cut loses all that is sent over it meanwhile, and only in its direction", "[net]") {
  SimRadio radio(3, {0.0, 0.0, 0.0, 0, 0, 0, 1}, [](std::uint32_t from, std::uint32_t to, TimeNs now_ns) {
    return !(from == 0 && to == 1 && now_ns >= 10 * kRadioMs && now_ns < 20 * kRadioMs);
  });
  for (std::uint32_t i = 0; i < 30; ++i) {
    radio.send(0, SimRadio::kEveryStation, numbered_datagram(i), i * kRadioMs);
    radio.send(1, 0, numbered_datagram(i), i * kRadioMs);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> heard;
  for (const RadioArrival& arrival : arrivals_until(radio, 0, kRadioMs * 40)) {
    heard[{arrival.from, arrival.to}].push_back(number_in(arrival));
  }
  CHECK((heard[{0, 2}].size()) == 30);
  CHECK((heard[{1, 0}].size()) == 30);
  const std::vector<std::uint32_t> over_cut = heard[{0, 1}];
  REQUIRE(over_cut.size() == 20);
  CHECK(over_cut[9] == 9);
  CHECK(over_cut[10] == 20);
  CHECK(radio.lost() == 10);
}

TEST_CASE("a station that is switched off loses what is under way to it, and others nothing", "[net]") {
  const RadioModel model{0.0, 0.0, 0.3, 2 * kRadioMs, 9 * kRadioMs, 60 * kRadioMs, 8};
  SimRadio radio(4, model), untouched(4, model);
  for (std::uint32_t i = 0; i < 200; ++i) {
    for (SimRadio* each : {&radio, &untouched}) {
      each->send(0, SimRadio::kEveryStation, numbered_datagram(i), i * kRadioMs);
    }
  }
  CHECK(radio.under_way() == 600);
  radio.forget(2);
  CHECK(radio.under_way() == 400);
  CHECK(radio.lost() == 200);
  std::vector<RadioArrival> expected = arrivals_until(untouched, 0, 400 * kRadioMs);
  std::erase_if(expected, [](const RadioArrival& arrival) { return arrival.to == 2; });
  CHECK(expected.size() == 400);
  CHECK(arrivals_until(radio, 0, 400 * kRadioMs) == expected);
  radio.send(0, 2, numbered_datagram(1), 0);  // on again
  CHECK(arrivals_until(radio, kRadioLong, kRadioLong).size() == 1);
}

TEST_CASE("what is sent while others are delivered is delivered with them if its time has come", "[net]") {
  SimRadio radio(2, {0.0, 0.0, 0.0, 1 * kRadioMs, 0, 0, 1});
  radio.send(0, 1, numbered_datagram(0), 0);
  std::vector<std::uint32_t> heard;
  radio.deliver(10 * kRadioMs, [&](std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram) {
    std::uint32_t number = 0;
    REQUIRE(mapper::ByteReader(datagram).take(number));
    heard.push_back(number);
    radio.send(to, from, numbered_datagram(number + 1), static_cast<TimeNs>(number + 1) * 3 * kRadioMs);
  });
  CHECK(heard == std::vector<std::uint32_t>{0, 1, 2, 3});  // the fourth answer arrives at 13 ms
  CHECK(radio.under_way() == 1);
}

TEST_CASE("a model that is changed on the way counts from then on", "[net]") {
  RadioModel model{0.0, 0.0, 0.0, 0, 0, 0, 1};
  SimRadio radio(2, model);
  radio.send(0, 1, numbered_datagram(0), 0);
  model.loss = 1.0;
  radio.set_model(model);
  radio.send(0, 1, numbered_datagram(1), 0);
  model.loss = 0.0;
  model.doubled = 1.0;
  radio.set_model(model);
  radio.send(0, 1, numbered_datagram(2), 0);
  std::vector<std::uint32_t> heard;
  for (const RadioArrival& arrival : arrivals_until(radio, 0, 0)) heard.push_back(number_in(arrival));
  CHECK(heard == std::vector<std::uint32_t>{0, 2, 2});
}
