// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/noisy_line.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

using namespace g3d::hal;

namespace {

std::vector<std::uint8_t> through(NoisyLine& line, std::size_t count) {
  std::vector<std::uint8_t> out;
  std::array<std::uint8_t, 100> sent;
  std::iota(sent.begin(), sent.end(), std::uint8_t{0});
  std::array<std::uint8_t, 64> got;
  for (std::size_t i = 0; i < count; i += sent.size()) {
    REQUIRE(line.push(sent, 0));
    for (std::size_t n = line.pop(got, 0); n > 0; n = line.pop(got, 0))
      out.insert(out.end(), got.begin(), got.begin() + n);
  }
  return out;
}

}  // namespace

TEST_CASE("a quiet line hands on every byte in order") {
  NoisyLine line(1);
  const auto got = through(line, 20000);
  REQUIRE(got.size() == 20000);
  for (std::size_t i = 0; i < got.size(); ++i) REQUIRE(got[i] == i % 100);
}

TEST_CASE("bytes wait for their time") {
  NoisyLine line(1);
  line.set_noise({.latency_ns = 5000});
  const std::array<std::uint8_t, 2> sent = {7, 8};
  std::array<std::uint8_t, 8> got{};
  REQUIRE(line.push(sent, 1000));
  CHECK(line.pop(got, 5999) == 0);
  CHECK(line.pop(std::span(got).first(1), 6000) == 1);
  CHECK(line.pop(got, 6000) == 1);
  CHECK(got[0] == 8);
}

TEST_CASE("noise comes at its rate and repeats by its seed") {
  NoisyLine lossy(1);
  lossy.set_noise({.lose = 0.1});
  CHECK(through(lossy, 100000).size() / 100000.0 == Approx(0.9).margin(0.01));
  NoisyLine chatty(1);
  chatty.set_noise({.insert = 0.1});
  CHECK(through(chatty, 100000).size() / 100000.0 == Approx(1.1).margin(0.01));
  NoisyLine noisy(1);
  noisy.set_noise({.corrupt = 0.1});
  const auto got = through(noisy, 100000);
  REQUIRE(got.size() == 100000);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < got.size(); ++i) wrong += got[i] != i % 100 ? 1U : 0U;
  CHECK(wrong / 100000.0 == Approx(0.1).margin(0.01));
  NoisyLine again(1);
  again.set_noise({.corrupt = 0.1});
  CHECK(through(again, 100000) == got);
  NoisyLine other(2);
  other.set_noise({.corrupt = 0.1});
  CHECK(through(other, 100000) != got);
}

TEST_CASE("a full line takes nothing instead of a part") {
  NoisyLine line(1);
  const std::vector<std::uint8_t> much(NoisyLine::kCapacity_bytes / 2);
  CHECK(line.push(much, 0));
  CHECK_FALSE(line.push(much, 0));
  std::vector<std::uint8_t> got(NoisyLine::kCapacity_bytes);
  CHECK(line.pop(got, 0) == much.size());
  CHECK(line.push(much, 0));
}
