// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/hit_scatter.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

/// All records as one list of voxels.
test::PlainHits hits_of(HitScatter& scatter, const FrameGeometry& frame) {
  test::PlainHits hits;
  for (std::uint32_t id = 0; id < frame.block_count(); ++id) {
    const HitRecord* record = scatter.find(id);
    if (record == nullptr) continue;
    for (std::size_t place = 0; place < kBlockVoxels; ++place) {
      if ((record->flags[place] & kHitFlag) == 0) continue;
      const bool coloured = (record->flags[place] & kColourFlag) != 0;
      hits[(frame.block_key(id) << kBlockShift) | place] = {coloured, coloured ? record->pixel[place] : 0};
    }
  }
  return hits;
}

bool same(const test::PlainHits& a, const test::PlainHits& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) {
           return x.first == y.first && x.second.has_colour == y.second.has_colour && x.second.pixel == y.second.pixel;
         });
}

}  // namespace

TEST_CASE("every trusted reading marks its voxel, coloured by the lowest pixel that may, for any number of threads",
          "[threads]") {
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
        scatter.compute(*frame, ends, best_kernels(), pool);
        REQUIRE(same(hits_of(scatter, *frame), test::plain_hits(sensor, *frame, image.depth.get())));

        std::set<std::uint32_t> listed;
        for (int s = 0; s < HitScatter::kShards; ++s) {
          for (const std::uint32_t index : scatter.shard(s)) {
            const HitRecord& record = scatter.record(index);
            CHECK(listed.insert(record.block_id).second);
            CHECK(scatter.find(record.block_id) == &record);
            CHECK(record.consumed == 0);
          }
        }
        CHECK(listed.size() == scatter.block_count());
      }
    }
  }
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
  ends.compute(depth.data(), best_kernels(), pool);
  scatter.compute(*frame, ends, best_kernels(), pool);
  CHECK(scatter.block_count() > 0);
  scatter.clear();
  CHECK(scatter.block_count() == 0);
  CHECK(hits_of(scatter, *frame).empty());
  for (const std::uint16_t raw : {0, 799, 3501, 65535}) {
    depth.assign(depth.size(), raw);
    ends.compute(depth.data(), best_kernels(), pool);
    scatter.compute(*frame, ends, best_kernels(), pool);
    CHECK(scatter.block_count() == 0);
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
  const std::size_t pole = 20U * 40U + 11U;
  depth[pole] = 1500;  // one pixel in front of a wall: an edge on all sides
  ends.compute(depth.data(), best_kernels(), pool);
  scatter.compute(*frame, ends, best_kernels(), pool);
  int without_colour = 0;
  const auto hits = hits_of(scatter, *frame);
  for (const auto& [code, hit] : hits) without_colour += hit.has_colour ? 0 : 1;
  CHECK(without_colour >= 1);
  CHECK(without_colour <= 5);  // the pole, and wall voxels that its neighbours alone see
  CHECK(same(hits, test::plain_hits(sensor, *frame, depth.data())));
}
