// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/picture.hpp"

#include <catch2/catch.hpp>

using namespace g3d::mapper;

namespace {

constexpr Rgb kBlack{0, 0, 0};
constexpr Rgb kRed{1, 0, 0};
constexpr Rgb kGreen{0, 1, 0};

std::array<ScreenPoint, 4> rectangle(float x0, float y0, float x1, float y1, float depth_m) {
  return {ScreenPoint{x0, y0, depth_m}, {x1, y0, depth_m}, {x1, y1, depth_m}, {x0, y1, depth_m}};
}

int drawn_pixels(const Picture& picture) {
  int drawn = 0;
  for (int y = 0; y < picture.size().height_px; ++y) {
    for (int x = 0; x < picture.size().width_px; ++x) drawn += picture.is_drawn(x, y) ? 1 : 0;
  }
  return drawn;
}

}  // namespace

TEST_CASE("A quad fills exactly the pixels whose centres it holds") {
  Picture picture({20, 20}, kBlack, kBlack);
  picture.draw_quad(rectangle(2, 3, 6, 8, 1), kRed);
  CHECK(drawn_pixels(picture) == 4 * 5);
  CHECK(picture.is_drawn(2, 3));
  CHECK(picture.is_drawn(5, 7));
  CHECK_FALSE(picture.is_drawn(6, 7));
  CHECK_FALSE(picture.is_drawn(1, 3));
}

TEST_CASE("Quads of either winding and partly outside are drawn, those outside are not") {
  Picture picture({20, 20}, kBlack, kBlack);
  auto quad = rectangle(-5, -5, 3, 2, 1);
  std::swap(quad[1], quad[3]);
  picture.draw_quad(quad, kRed);
  CHECK(drawn_pixels(picture) == 6);
  picture.draw_quad(rectangle(30, 30, 40, 40, 1), kRed);
  picture.draw_quad(rectangle(1e9F, 0, 2e9F, 5, 1), kRed);
  picture.draw_quad(rectangle(0.0F / 0.0F, 0, 3, 5, 1), kRed);
  CHECK(drawn_pixels(picture) == 6);
}

TEST_CASE("Adjacent quads leave no gap") {
  Picture picture({40, 40}, kBlack, kBlack);
  for (int i = 0; i < 10; ++i) {
    const float x = 3.0F + 1.37F * static_cast<float>(i);
    picture.draw_quad(rectangle(x, 5, x + 1.37F, 15, 1), kRed);
  }
  CHECK(drawn_pixels(picture) == 10 * 14);  // centres 3.5 .. 16.5
}

TEST_CASE("The nearer quad wins in any order") {
  for (const bool near_first : {false, true}) {
    Picture picture({4, 4}, kBlack, kBlack);
    picture.draw_quad(rectangle(0, 0, 4, 4, near_first ? 1.0F : 2.0F), near_first ? kRed : kGreen);
    picture.draw_quad(rectangle(0, 0, 4, 4, near_first ? 2.0F : 1.0F), near_first ? kGreen : kRed);
    CHECK(picture.halved() == std::vector<std::uint8_t>{255, 0, 0, 255, 0, 0, 255, 0, 0, 255, 0, 0});
  }
}

TEST_CASE("Halving averages four pixels") {
  Picture picture({2, 2}, kBlack, kBlack);
  picture.draw_quad(rectangle(0, 0, 1, 1, 1), kRed);
  CHECK(picture.halved() == std::vector<std::uint8_t>{64, 0, 0});
}

TEST_CASE("Lighting darkens what lies behind an edge, not what lies before it") {
  Picture picture({20, 4}, kBlack, kBlack);
  picture.draw_quad(rectangle(0, 0, 10, 4, 1), kRed);
  picture.draw_quad(rectangle(10, 0, 20, 4, 2), kRed);
  picture.shade_by_depth(2, 60.0F);
  const auto rgb = picture.halved();
  const auto red_at = [&](std::size_t x) { return static_cast<int>(rgb[3 * x]); };
  CHECK(red_at(0) == 255);
  CHECK(red_at(4) == 255);  // the near side of the edge
  CHECK(red_at(5) < 150);   // the far side
  CHECK(red_at(9) == 255);
}

TEST_CASE("A line shows where it is near and only faintly where it is hidden") {
  Picture picture({40, 20}, kBlack, kBlack);
  picture.draw_quad(rectangle(20, 0, 40, 20, 1), kBlack);
  picture.draw_line({2, 10, 5}, {38, 10, 5}, 2, kGreen);
  const auto rgb = picture.halved();
  const auto green_at = [&](std::size_t x) { return static_cast<int>(rgb[3 * (5 * 20 + x) + 1]); };
  CHECK(green_at(5) > 200);
  CHECK(green_at(15) < 120);
  CHECK(green_at(15) > 0);
}
