// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/hit_scatter.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <vector>

#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

/// Hit voxels with the colour that the frame gives them, R | G << 8 | B << 16; kNoColour where it gives none.
using ColouredHits = std::map<MCode, std::uint32_t>;
constexpr std::uint32_t kNoColour = 0xFFFFFFFF;

ColouredHits hits_of(HitScatter& scatter, const FrameGeometry& frame) {
  ColouredHits hits;
  for (std::uint32_t id = 0; id < frame.block_count(); ++id) {
    const HitRecord* record = scatter.find(id);
    if (record == nullptr) continue;
    for (std::size_t place = 0; place < kBlockVoxels; ++place) {
      if ((record->flags[place] & kHitFlag) == 0) continue;
      const bool coloured = (record->flags[place] & kColourFlag) != 0;
      hits[(frame.block_key(id) << kBlockShift) | place] = coloured ? record->rgb[place] & 0xFFFFFF : kNoColour;
    }
  }
  return hits;
}

ColouredHits expected_hits(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth,
                           const std::uint8_t* rgb) {
  ColouredHits hits;
  for (const auto& [code, hit] : test::plain_hits(sensor, frame, depth)) {
    const std::uint8_t* c = rgb + 3 * std::size_t{hit.pixel};
    hits[code] = hit.has_colour ? static_cast<std::uint32_t>(c[0] | c[1] << 8 | c[2] << 16) : kNoColour;
  }
  return hits;
}

/// Voxels that a reading too near to be trusted holds.
std::set<MCode> held_by(HitScatter& scatter, const FrameGeometry& frame) {
  std::set<MCode> held;
  for (std::uint32_t id = 0; id < frame.block_count(); ++id) {
    const HitRecord* record = scatter.find(id);
    if (record == nullptr) continue;
    for (std::size_t place = 0; place < kBlockVoxels; ++place) {
      if ((record->flags[place] & kHeldFlag) != 0) held.insert((frame.block_key(id) << kBlockShift) | place);
    }
  }
  return held;
}

}  // namespace

TEST_CASE("every trusted reading marks its voxel, coloured by the lowest pixel that may, for any number of threads",
          "[threads]") {
  std::size_t held_voxels = 0;
  std::size_t held_blocks = 0;
  for (const float resolution_m : {0.02F, 0.1F}) {
    hal::CameraModel camera = test::small_camera(92);
    camera.width_px -= 1;
    const SensorGeometry sensor(camera, resolution_m, 0.8F, 3.5F);
    for (const int threads : {1, 2, 3}) {
      ThreadPool pool(threads);
      RayEnds ends(sensor, {}, 3000, true);
      HitScatter scatter(sensor);
      for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const hal::Frame image = test::random_frame(camera, seed);
        const auto frame = frame_geometry(sensor, hal::to_transform(test::random_pose(seed)));
        REQUIRE(frame);
        ends.compute(image.depth.get(), best_kernels(), pool);
        scatter.clear();
        scatter.compute(*frame, ends, image.rgb.get(), best_kernels(), pool);
        const auto expected = expected_hits(sensor, *frame, image.depth.get(), image.rgb.get());
        REQUIRE(hits_of(scatter, *frame) == expected);
        const std::set<MCode> held = test::plain_held(sensor, *frame, image.depth.get());
        REQUIRE(held_by(scatter, *frame) == held);
        held_voxels += held.size();

        std::set<std::uint32_t> listed;
        for (int s = 0; s < HitScatter::kShards; ++s) {
          for (const std::uint32_t index : scatter.shard(s)) {
            const HitRecord& record = scatter.record(index);
            CHECK(listed.insert(record.block_id).second);
            CHECK(scatter.find(record.block_id) == &record);
            CHECK(record.consumed == 0);
            const bool any_hit = std::any_of(record.flags.begin(), record.flags.end(),
                                             [](std::uint8_t flags) { return (flags & kHitFlag) != 0; });
            CHECK(record.held_only == (any_hit ? 0 : 1));
            held_blocks += record.held_only;
          }
        }
        CHECK(listed.size() == scatter.block_count());
      }
    }
  }
  CHECK(held_voxels > 1000);
  CHECK(held_blocks > 100);
}

TEST_CASE("clear forgets every record, and an image without readings makes none") {
  const hal::CameraModel camera = test::small_camera(40);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, 3000, true);
  HitScatter scatter(sensor);
  const auto frame = frame_geometry(sensor, {});
  REQUIRE(frame);
  std::vector<std::uint16_t> depth(camera.pixel_count(), 2000);
  const std::vector<std::uint8_t> rgb(3 * camera.pixel_count(), 9);
  ends.compute(depth.data(), best_kernels(), pool);
  scatter.compute(*frame, ends, rgb.data(), best_kernels(), pool);
  CHECK(scatter.block_count() > 0);
  scatter.clear();
  CHECK(scatter.block_count() == 0);
  CHECK(hits_of(scatter, *frame).empty());
  for (const std::uint16_t raw : {0, 1, 799, 3501, 65535}) {
    depth.assign(depth.size(), raw);
    ends.compute(depth.data(), best_kernels(), pool);
    scatter.compute(*frame, ends, rgb.data(), best_kernels(), pool);
    const bool too_near = raw > 0 && raw < 800;
    CHECK((scatter.block_count() > 0) == too_near);
    CHECK(hits_of(scatter, *frame).empty());
    CHECK(held_by(scatter, *frame).empty() != too_near);
    scatter.clear();
  }
}

TEST_CASE("a voxel seen only by pixels at depth edges is hit but gets no colour") {
  const hal::CameraModel camera = test::small_camera(40);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, 3000, true);
  HitScatter scatter(sensor);
  const auto frame = frame_geometry(sensor, {});
  REQUIRE(frame);
  std::vector<std::uint16_t> depth(camera.pixel_count(), 3000);
  const std::vector<std::uint8_t> rgb(3 * camera.pixel_count(), 9);
  const std::size_t pole = 20U * 40U + 11U;
  depth[pole] = 1500;  // one pixel in front of a wall: an edge on all sides
  ends.compute(depth.data(), best_kernels(), pool);
  scatter.compute(*frame, ends, rgb.data(), best_kernels(), pool);
  int without_colour = 0;
  const auto hits = hits_of(scatter, *frame);
  for (const auto& [code, colour] : hits) without_colour += colour == kNoColour ? 1 : 0;
  CHECK(without_colour >= 1);
  CHECK(without_colour <= 5);  // the pole, and wall voxels that its neighbours alone see
  CHECK(hits == expected_hits(sensor, *frame, depth.data(), rgb.data()));
}

TEST_CASE("without a colour image every voxel that is measured is hit, and none gets a colour") {
  const hal::CameraModel camera = test::small_camera(40);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, 3000, true);
  HitScatter scatter(sensor);
  const hal::Frame image = test::random_frame(camera, 3);
  const auto frame = frame_geometry(sensor, {});
  REQUIRE(frame);
  ends.compute(image.depth.get(), best_kernels(), pool);
  scatter.compute(*frame, ends, nullptr, best_kernels(), pool);
  auto expected = expected_hits(sensor, *frame, image.depth.get(), image.rgb.get());
  for (auto& [code, colour] : expected) colour = kNoColour;
  CHECK(hits_of(scatter, *frame) == expected);
}
