// SPDX-License-Identifier: Apache-2.0
#include "tests/support/octomap_twin.hpp"

#include <fmt/format.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace g3d::test {

using namespace mapper;

namespace {

/// Log-odds are our levels less 16: whole numbers, so that nothing rounds.
class LevelTree : public octomap::OcTree {
 public:
  explicit LevelTree(double resolution_m) : octomap::OcTree(resolution_m) {
    prob_hit_log = 4.0F;
    prob_miss_log = -2.0F;
    clamping_thres_min = -16.0F;
    clamping_thres_max = 16.0F;
    occ_prob_thres_log = 0.0F;
  }
};

octomap::point3d to_point(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

struct Segment {
  std::array<double, 3> from_cells;
  std::array<double, 3> to_cells;
};

/// How near a ray passes to the boundary of a voxel: what it covers inside of it, by how much it misses it, or how near
/// to a face it ends.
double boundary_distance_cells(const Segment& ray, const std::array<double, 3>& low) {
  double in = 0;
  double out = 1;
  double squared = 0;
  double end = 1e9;
  bool ends_beside = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const double span = ray.to_cells[a] - ray.from_cells[a];
    squared += span * span;
    const double beyond_low = ray.to_cells[a] - low[a];
    end = std::min({end, std::abs(beyond_low), std::abs(beyond_low - 1)});
    ends_beside &= beyond_low > -kGraze_cells && beyond_low < 1 + kGraze_cells;
    if (span == 0) continue;
    const double t0 = (low[a] - ray.from_cells[a]) / span;
    const double t1 = (low[a] + 1 - ray.from_cells[a]) / span;
    in = std::max(in, std::min(t0, t1));
    out = std::min(out, std::max(t0, t1));
  }
  const double inside = std::abs(out - in) * std::sqrt(squared);
  return ends_beside ? std::min(end, inside) : inside;
}

}  // namespace

std::string describe(const Agreement& a) {
  return fmt::format(
      "{:.4f} % of {} known voxels agree, {} ties; {} known to us alone, {} to OctoMap alone, {} in the other state; "
      "{} of them grazed by a ray, {} not",
      100.0 * a.share(), a.known, a.ties, a.only_ours, a.only_theirs, a.other_state, a.grazed, a.deep);
}

struct OctomapTwin::Parts {
  explicit Parts(float resolution) : resolution_m(resolution), tree(static_cast<double>(resolution)) {}

  void add_ray(const octomap::point3d& origin, const octomap::point3d& end, octomap::KeySet& free) {
    if (tree.computeRayKeys(origin, end, key_ray)) free.insert(key_ray.begin(), key_ray.end());
    const double r = static_cast<double>(resolution_m);
    segments.push_back({{origin.x() / r, origin.y() / r, origin.z() / r}, {end.x() / r, end.y() / r, end.z() / r}});
  }

  [[nodiscard]] bool is_grazed(const VoxelIndex& v) const {
    const std::array<double, 3> low{v.x - 32768.0, v.y - 32768.0, v.z - 32768.0};
    return std::any_of(segments.begin(), segments.end(),
                       [&](const Segment& ray) { return boundary_distance_cells(ray, low) <= kGraze_cells; });
  }

  void judge(const VoxelIndex& v, State ours, State theirs, Agreement& a) const {
    ++a.known;
    if (ours == theirs) {
      ++a.same;
      return;
    }
    ++(theirs == State::unknown ? a.only_ours : ours == State::unknown ? a.only_theirs : a.other_state);
    ++(is_grazed(v) ? a.grazed : a.deep);
  }

  float resolution_m;
  LevelTree tree;
  octomap::KeyRay key_ray;
  std::vector<Segment> segments;
};

OctomapTwin::OctomapTwin(float resolution_m) : parts_(std::make_unique<Parts>(resolution_m)) {}
OctomapTwin::~OctomapTwin() = default;

// OccupancyOcTreeBase::computeUpdate and insertPointCloud, but for the rays that end at the far bound.
void OctomapTwin::integrate(const RayList& rays) {
  octomap::KeySet free;
  octomap::KeySet occupied;
  const octomap::point3d origin = to_point(rays.origin_m);
  for (const auto& p : rays.hits_m) {
    parts_->add_ray(origin, to_point(p), free);
    octomap::OcTreeKey key;
    if (parts_->tree.coordToKeyChecked(to_point(p), key)) occupied.insert(key);
  }
  for (const auto& p : rays.far_m) parts_->add_ray(origin, to_point(p), free);
  constexpr bool kLazy = true;  // no inner node is ever asked
  for (const octomap::OcTreeKey& key : free) {
    if (occupied.find(key) == occupied.end()) parts_->tree.updateNode(key, false, kLazy);
  }
  for (const octomap::OcTreeKey& key : occupied) parts_->tree.updateNode(key, true, kLazy);
}

Agreement OctomapTwin::compare(const VoxelMap& map) const {
  Agreement a;
  std::uint64_t matched = 0;  // voxels of ours that OctoMap knows, too
  const auto& tree = parts_->tree;
  for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
    const octomap::OcTreeKey key = leaf.getKey();
    const VoxelIndex v{key[0], key[1], key[2]};
    const State ours = state_of(map.at(v));
    matched += ours != State::unknown ? 1 : 0;
    const float level = leaf->getLogOdds();
    if (level == 0.0F) {
      ++a.ties;
    } else {
      parts_->judge(v, ours, level > 0 ? State::occupied : State::free, a);
    }
  }
  if (map.counts().known() == matched) return a;
  BlockValues values;
  for (const BlockKey block : map.sorted_keys()) {
    map.read_block(block, values);
    for (MCode place = 0; place < kBlockVoxels; ++place) {
      const State ours = state_of(values[place]);
      if (ours == State::unknown) continue;
      const VoxelIndex v = decode((block << kBlockShift) | place);
      const octomap::OcTreeKey key(static_cast<octomap::key_type>(v.x), static_cast<octomap::key_type>(v.y),
                                   static_cast<octomap::key_type>(v.z));
      if (tree.search(key) == nullptr) parts_->judge(v, ours, State::unknown, a);
    }
  }
  return a;
}

}  // namespace g3d::test
