// SPDX-License-Identifier: Apache-2.0
#include "mapper/report.hpp"

#include <cmath>
#include <numeric>

#include "mapper/json_writer.hpp"

namespace g3d::mapper {
namespace {

double rounded_us(double us) { return std::round(us * 10.0) / 10.0; }
double rounded_um(double value) { return std::round(value * 1e6) / 1e6; }
double rounded_mm(double metres) { return std::round(metres * 1000.0) / 1000.0; }

void write_frames(JsonWriter& json, const FrameCounts& frames) {
  json.key("frames").begin_object().member("delivered", frames.delivered).member("integrated", frames.integrated);
  json.key("dropped").begin_object();
  for (std::size_t i = 0; i < hal::kDropReasonCount; ++i) {
    json.member(to_string(static_cast<hal::DropReason>(i)), frames.dropped[i]);
  }
  json.end_object().end_object();
}

void write_stages(JsonWriter& json, const std::vector<NamedStage>& stages) {
  json.key("stages_us").begin_object();
  for (const NamedStage& stage : stages) {
    json.key(stage.name).begin_object();
    json.member("p50", rounded_us(stage.times.percentile_us(0.50)));
    json.member("p99", rounded_us(stage.times.percentile_us(0.99)));
    json.member("max", rounded_us(stage.times.max_us())).end_object();
  }
  json.end_object();
}

void write_paging(JsonWriter& json, const PagingReport& paging) {
  json.key("window").begin_object();
  json.member("radius_m", rounded_mm(paging.radius_m))
      .member("smallest_radius_m", rounded_mm(paging.smallest_radius_m));
  json.member("regions_out", paging.regions_out).member("regions_in", paging.regions_in);
  json.member("blocks_out", paging.blocks_out).member("blocks_in", paging.blocks_in);
  json.member("regions_on_disk", paging.regions_on_disk).member("late_regions", paging.late_regions);
  json.member("submaps_out", paging.submaps_out).member("submaps_in", paging.submaps_in);
  json.member("submaps_on_disk", paging.submaps_on_disk);
  json.member("failed_stores", paging.failed_stores).member("failed_loads", paging.failed_loads);
  json.member("page_file_bytes", paging.page_file_bytes).end_object();
}

void write_alignment(JsonWriter& json, const AlignmentReport& alignment) {
  const align::AlignReport& counts = alignment.counts;
  json.key("alignment").begin_object();
  json.member("odometry", to_string(alignment.odometry)).member("motion", to_string(alignment.motion));
  json.key("frames").begin_object();
  for (std::size_t i = 0; i < align::kAlignOutcomeCount; ++i) {
    json.member(to_string(static_cast<align::AlignOutcome>(i)), counts.frames[i]);
  }
  json.end_object();
  json.member("held_shift_frames", counts.held_shift_frames).member("held_turn_frames", counts.held_turn_frames);
  json.member("correction_max_m", rounded_um(counts.largest_shift_m))
      .member("correction_rms_m", rounded_um(counts.shift_rms_m()));
  json.member("correction_max_rad", rounded_um(counts.largest_turn_rad))
      .member("correction_rms_rad", rounded_um(counts.turn_rms_rad()));
  json.key("learnt").begin_object().member("turn_radps", rounded_um(counts.learnt_turn_radps));
  json.member("stretch", rounded_um(counts.learnt_stretch));
  json.member("turn_noise_scale", rounded_um(counts.turn_noise_scale)).end_object();
  json.member("surface_pieces", counts.surface_pieces).member("refused_samples", counts.refused_samples);
  json.member("forgotten_pieces", counts.forgotten_pieces);
  json.end_object();
}

void write_loops(JsonWriter& json, const submaps::CloserReport& loops) {
  json.key("loops").begin_object();
  json.member("submaps", loops.submaps)
      .member("joined", loops.joined)
      .member("edges", loops.edges)
      .member("loops", loops.loops);
  json.member("alone", loops.alone).member("disbelieved", loops.disbelieved);
  json.key("candidates").begin_object();
  json.member("tried", loops.finder.tried).member("alike", loops.finder.alike).member("refused", loops.finder.refused);
  json.member("not_found_again", loops.finder.not_again).member("found", loops.finder.found).end_object();
  json.member("corrections", loops.corrections).member("correction_max_m", rounded_um(loops.largest_move_m));
  json.member("memory_bytes", loops.memory_bytes).member("refused_blocks", loops.refused_blocks);
  json.end_object();
}

}  // namespace

std::uint64_t FrameCounts::dropped_total() const {
  return std::accumulate(dropped.begin(), dropped.end(), std::uint64_t{0});
}

std::string to_json(const RunReport& report) {
  JsonWriter json;
  json.begin_object();
  write_frames(json, report.frames);
  write_stages(json, report.stages);
  json.key("map").begin_object().member("mapper", report.mapper).member("resolution_m", report.resolution_m);
  json.member("occupied", report.occupied).member("free", report.free).member("memory_bytes", report.memory_bytes);
  json.member("file_bytes", report.file_bytes).member("hash", report.hash);
  json.member("refused_blocks", report.refused_blocks);
  if (report.paging) write_paging(json, *report.paging);
  json.end_object();
  if (report.alignment) write_alignment(json, *report.alignment);
  if (report.loops) write_loops(json, *report.loops);
  if (report.write_more) report.write_more(json);
  json.key("run").begin_object().member("command", report.command).member("version", report.version);
  json.member("seed", report.seed).member("threads", report.threads).member("board", report.board);
  json.key("notes").begin_array();
  for (const std::string& note : report.notes) json.value(note);
  json.end_array().end_object();
  json.end_object();
  return json.take();
}

}  // namespace g3d::mapper
