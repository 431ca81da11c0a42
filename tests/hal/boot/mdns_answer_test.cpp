// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/mdns_answer.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace g3d::hal::boot;

namespace {

constexpr MdnsHost kHost{"Robot1", 0x0A000007};
using Bytes = std::vector<std::uint8_t>;

void put_name(Bytes& bytes, const std::string& name) {
  for (std::size_t begin = 0; begin < name.size();) {
    const std::size_t end = std::min(name.find('.', begin), name.size());
    bytes.push_back(static_cast<std::uint8_t>(end - begin));
    bytes.insert(bytes.end(), name.begin() + static_cast<std::ptrdiff_t>(begin),
                 name.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end + 1;
  }
  bytes.push_back(0);
}

Bytes question(const std::vector<std::string>& names, std::uint8_t type = 1, std::uint8_t class_high = 0) {
  Bytes bytes = {0x12, 0x34, 0, 0, 0, static_cast<std::uint8_t>(names.size()), 0, 0, 0, 0, 0, 0};
  for (const std::string& name : names) {
    put_name(bytes, name);
    for (const int byte : {0, static_cast<int>(type), static_cast<int>(class_high), 1})
      bytes.push_back(static_cast<std::uint8_t>(byte));
  }
  return bytes;
}

struct Said {
  Bytes bytes;
  bool goes_to_asker = false;
};
Said answer(const Bytes& asked, bool from_mdns_port = true) {
  std::array<std::uint8_t, 256> out{};
  const MdnsAnswer said = answer_mdns(asked, from_mdns_port, kHost, out);
  return {Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(said.size_bytes)), said.goes_to_asker};
}

}  // namespace

TEST_CASE("a question for NAME.local is answered with the address, in capitals or not", "[boot]") {
  const Said said = answer(question({"rObot1.LOCAL"}));
  Bytes expected = {0, 0, 0x84, 0, 0, 0, 0, 1, 0, 0, 0, 0};
  put_name(expected, "Robot1.local");
  for (const int byte : {0, 1, 0x80, 1, 0, 0, 0, 120, 0, 4, 10, 0, 0, 7})
    expected.push_back(static_cast<std::uint8_t>(byte));
  CHECK(said.bytes == expected);
  CHECK_FALSE(said.goes_to_asker);
  CHECK(answer(question({"robot1.local"}, 255)).bytes == expected);            // any
  CHECK(answer(question({"x.local", "robot1.local"})).bytes == expected);      // among others
  CHECK(answer(question({"robot1.local"}, 1, 0x80)).goes_to_asker);            // who wants to be answered alone
  CHECK_FALSE(answer(question({"robot1.local"}, 1, 0x7F)).bytes == expected);  // another class
  std::array<std::uint8_t, 256> out{};
  const std::size_t size = announce_mdns(kHost, out);
  CHECK(Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)) == expected);
}

TEST_CASE("who asks as plain DNS does is answered so, with its number and question", "[boot]") {
  const Said said = answer(question({"robot1.local"}), false);
  CHECK(said.goes_to_asker);
  REQUIRE(said.bytes.size() > 12);
  CHECK(said.bytes[0] == 0x12);
  CHECK(said.bytes[1] == 0x34);
  CHECK(said.bytes[5] == 1);
  CHECK(said.bytes[7] == 1);
  const Bytes tail(said.bytes.end() - 10, said.bytes.end());
  CHECK(tail == Bytes{0, 0, 0, 10, 0, 4, 10, 0, 0, 7});
}

TEST_CASE("nothing is said to what does not concern us, or is broken", "[boot]") {
  CHECK(answer(question({"robot2.local"})).bytes.empty());
  CHECK(answer(question({"robot1.local.x"})).bytes.empty());
  CHECK(answer(question({"robot1.local"}, 28)).bytes.empty());  // IPv6
  CHECK(answer(question({})).bytes.empty());
  CHECK(answer(question(std::vector<std::string>(17, "robot1.local"))).bytes.empty());
  Bytes response = question({"robot1.local"});
  response[2] = 0x84;
  CHECK(answer(response).bytes.empty());
  const Bytes whole = question({"robot1.local"});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CHECK(answer(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))).bytes.empty());
  }
}

TEST_CASE("names that point back into the datagram are followed, but never in a circle", "[boot]") {
  Bytes asked = question({"robot1.local", "robot1.local"});
  // The second name as a pointer to the first.
  const std::size_t second = 12 + 14 + 4;
  asked.resize(second);
  for (const int byte : {0xC0, 12, 0, 1, 0, 1}) asked.push_back(static_cast<std::uint8_t>(byte));
  CHECK_FALSE(answer(asked).bytes.empty());
  asked[second + 1] = static_cast<std::uint8_t>(second);  // to itself
  CHECK(answer(asked).bytes.empty());
}

TEST_CASE("an answer that does not fit is none", "[boot]") {
  std::array<std::uint8_t, 30> small{};
  CHECK(answer_mdns(question({"robot1.local"}), true, kHost, small).size_bytes == 0);
  CHECK(announce_mdns(kHost, small) == 0);
}
