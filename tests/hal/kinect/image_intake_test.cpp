// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "hal/kinect/image_intake.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

namespace {

constexpr int kIntakeWidth = 8, kIntakeHeight = 4;

struct TestImage {
  explicit TestImage(ImageKind kind, std::uint16_t value, int stride_pixels = kIntakeWidth) {
    const int pixel_bytes = kind == ImageKind::depth ? 2 : 3;
    bytes.resize(static_cast<std::size_t>(stride_pixels * pixel_bytes * kIntakeHeight));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<std::uint8_t>(kind == ImageKind::depth && i % 2 == 1 ? value >> 8 : value);
    }
    image.kind = kind;
    image.width_px = kIntakeWidth;
    image.height_px = kIntakeHeight;
    image.stride_bytes = stride_pixels * pixel_bytes;
    image.bytes = bytes;
    image.index = value;
    image.device_ticks = 1000U * value;
    image.arrived_ns = value;
  }
  std::vector<std::uint8_t> bytes;
  SensorImage image;
};

}  // namespace

TEST_CASE("images cross from the driver to the camera whole and in order, without the bytes between their rows") {
  ImageIntake intake(kIntakeWidth, kIntakeHeight);
  const TestImage first(ImageKind::depth, 700), second(ImageKind::depth, 701, kIntakeWidth + 3),
      colour(ImageKind::colour, 9, kIntakeWidth + 1);
  for (const TestImage* sent : {&first, &second, &colour}) intake.take(sent->image);
  ImageIntake::Taken taken;
  for (const std::uint16_t value : {700, 701}) {
    REQUIRE(intake.try_take(ImageKind::depth, taken));
    CHECK(taken.fault == ImageFault::none);
    CHECK(taken.index == value);
    CHECK(taken.device_ticks == 1000U * value);
    for (int i = 0; i < kIntakeWidth * kIntakeHeight; ++i) CHECK(intake.depth(taken)[i] == value);
    intake.release(ImageKind::depth, taken);
  }
  CHECK_FALSE(intake.try_take(ImageKind::depth, taken));
  REQUIRE(intake.try_take(ImageKind::colour, taken));
  for (int i = 0; i < 3 * kIntakeWidth * kIntakeHeight; ++i) CHECK(intake.rgb(taken)[i] == 9);
}

TEST_CASE("an image that lacks bytes, or is of another size or format, is counted by reason; bad depth is passed on") {
  ImageIntake intake(kIntakeWidth, kIntakeHeight);
  TestImage half(ImageKind::depth, 1), size(ImageKind::depth, 2), format(ImageKind::depth, 3),
      thin(ImageKind::depth, 4);
  half.image.bytes = half.image.bytes.first(half.bytes.size() - 1);
  size.image.height_px -= 1;
  format.image.is_known_format = false;
  thin.image.stride_bytes -= 1;
  TestImage colour(ImageKind::colour, 5);
  colour.image.bytes = {};
  for (const TestImage* sent : {&half, &size, &format, &thin, &colour}) intake.take(sent->image);
  CHECK(intake.faults(ImageKind::depth, ImageFault::half) == 1);
  CHECK(intake.faults(ImageKind::depth, ImageFault::wrong_size) == 2);
  CHECK(intake.faults(ImageKind::depth, ImageFault::wrong_format) == 1);
  CHECK(intake.faults(ImageKind::colour, ImageFault::half) == 1);
  ImageIntake::Taken taken;
  REQUIRE(intake.try_take(ImageKind::depth, taken));
  CHECK(taken.fault != ImageFault::none);
  CHECK_FALSE(intake.try_take(ImageKind::colour, taken));
}

TEST_CASE("a camera thread that is behind loses the oldest images, and finds the newest") {
  ImageIntake intake(kIntakeWidth, kIntakeHeight);
  for (std::uint16_t i = 1; i <= 20; ++i) intake.take(TestImage(ImageKind::depth, i).image);
  ImageIntake::Taken taken;
  std::vector<std::uint32_t> got;
  while (intake.try_take(ImageKind::depth, taken)) {
    got.push_back(taken.index);
    CHECK(intake.depth(taken)[0] == taken.index);
    intake.release(ImageKind::depth, taken);
  }
  CHECK(got == std::vector<std::uint32_t>{15, 16, 17, 18, 19, 20});
  CHECK(intake.overruns(ImageKind::depth) == 14);
  intake.take(TestImage(ImageKind::depth, 21).image);
  intake.drain();
  CHECK_FALSE(intake.try_take(ImageKind::depth, taken));
}

TEST_CASE("every image that a driver's threads hand over is taken or counted, and none is torn", "[threads]") {
  ImageIntake intake(kIntakeWidth, kIntakeHeight);
  constexpr int kImages = 3000;
  std::atomic<bool> done{false};
  std::thread depth([&] {
    for (int i = 1; i <= kImages; ++i) {
      intake.take(TestImage(ImageKind::depth, static_cast<std::uint16_t>(i)).image);
      if (i % 8 == 0) std::this_thread::yield();
    }
    done = true;
  });
  std::thread colour([&] {
    for (int i = 1; i <= kImages; ++i) intake.take(TestImage(ImageKind::colour, static_cast<std::uint8_t>(i)).image);
  });
  std::uint64_t taken_count = 0;
  std::uint32_t last = 0;
  bool is_torn = false, falls = false;
  for (bool was_done = false;;) {
    ImageIntake::Taken taken;
    if (intake.try_take(ImageKind::depth, taken)) {
      ++taken_count;
      falls = falls || taken.index <= last;
      last = taken.index;
      for (int i = 0; i < kIntakeWidth * kIntakeHeight; ++i) is_torn = is_torn || intake.depth(taken)[i] != taken.index;
      intake.release(ImageKind::depth, taken);
    } else if (was_done) {
      break;
    }
    if (intake.try_take(ImageKind::colour, taken)) intake.release(ImageKind::colour, taken);
    was_done = done.load();
  }
  depth.join();
  colour.join();
  CHECK_FALSE(is_torn);
  CHECK_FALSE(falls);
  CHECK(last == kImages);
  CHECK(taken_count + intake.overruns(ImageKind::depth) == kImages);
}
