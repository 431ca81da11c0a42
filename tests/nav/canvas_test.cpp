// SPDX-License-Identifier: Apache-2.0
#include "nav/canvas.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string_view>

using namespace g3d;
using nav::Canvas;
using nav::Colour;

namespace {

constexpr Colour kWhite{255, 255, 255};
constexpr Colour kBlack{0, 0, 0};

int count(const Canvas& canvas, const Colour& colour) {
  int pixels = 0;
  for (int y = 0; y < canvas.size().height_px; ++y) {
    for (int x = 0; x < canvas.size().width_px; ++x) pixels += canvas.at(x, y) == colour ? 1 : 0;
  }
  return pixels;
}

}  // namespace

TEST_CASE("a canvas begins with its background and holds three bytes per pixel", "[nav][canvas]") {
  const Canvas canvas({7, 5}, kWhite);
  CHECK(canvas.rgb().size() == 3 * 7 * 5);
  CHECK(count(canvas, kWhite) == 35);
}

TEST_CASE("what lies beyond the edge is not drawn", "[nav][canvas]") {
  Canvas canvas({10, 10}, kWhite);
  canvas.set(-1, 5, kBlack);
  canvas.set(5, 10, kBlack);
  canvas.fill(20, 20, 5, 5, kBlack);
  canvas.line({-50, -5}, {50, -5}, 2, kBlack);
  canvas.line({1e9, 1e9}, {2e9, 1e9}, 2, kBlack);
  canvas.disc({-30, 4}, 10, kBlack);
  canvas.text(-40, 0, "000", kBlack, 2);
  CHECK(count(canvas, kWhite) == 100);
  canvas.fill(8, 8, 100, 100, kBlack);
  CHECK(count(canvas, kBlack) == 4);
}

TEST_CASE("lines and discs have their width and smooth edges", "[nav][canvas]") {
  Canvas canvas({40, 20}, kWhite);
  canvas.line({5, 10}, {35, 10}, 4, kBlack);
  for (int x = 6; x < 34; ++x) {
    REQUIRE(canvas.at(x, 8) == kBlack);
    REQUIRE(canvas.at(x, 11) == kBlack);
    REQUIRE(canvas.at(x, 6) == kWhite);
    REQUIRE(canvas.at(x, 13) == kWhite);
  }
  Canvas disc({21, 21}, kWhite);
  disc.disc({10.5, 10.5}, 6, kBlack);
  const int dark = count(disc, kBlack);
  CHECK(dark > 80);  // pi * 6 * 6 = 113, the edge is grey
  CHECK(dark < 114);
  CHECK(disc.at(10, 10) == kBlack);
  CHECK(disc.at(16, 16) == kWhite);
  CHECK(count(disc, kWhite) + dark < 21 * 21);
}

TEST_CASE("letters are dots, and each is another", "[nav][canvas]") {
  Canvas canvas({40, 10}, kWhite);
  canvas.text(1, 1, "1", kBlack, 1);
  CHECK(count(canvas, kBlack) == 10);
  CHECK(canvas.at(3, 1) == kBlack);  // the top of the stroke
  CHECK(Canvas::text_width_px("") == 0);
  CHECK(Canvas::text_width_px("12", 3) == 33);
  Canvas blank({40, 10}, kWhite);
  blank.text(0, 0, "\x01 ~", kBlack, 1);
  CHECK(count(blank, kBlack) == 0);
  const std::string_view letters = "0123456789abcdefghijklmnopqrstuvwxyz%.,:-/";
  for (std::size_t i = 0; i < letters.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      Canvas a({5, 7}, kWhite), b({5, 7}, kWhite);
      a.text(0, 0, letters.substr(i, 1), kBlack, 1);
      b.text(0, 0, letters.substr(k, 1), kBlack, 1);
      INFO(letters[i] << " " << letters[k]);
      REQUIRE(count(a, kBlack) > 0);
      REQUIRE_FALSE(std::equal(a.rgb().begin(), a.rgb().end(), b.rgb().begin()));
    }
  }
}

TEST_CASE("colours mix between their ends", "[nav][canvas]") {
  CHECK(mix(kBlack, kWhite, 0.0) == kBlack);
  CHECK(mix(kBlack, kWhite, 1.5) == kWhite);
  CHECK(nav::mix({0, 100, 200}, {100, 100, 100}, 0.5) == Colour{50, 100, 150});
}
