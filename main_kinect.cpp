// SPDX-License-Identifier: Apache-2.0
#include "main_kinect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "hal/kinect/levelling.hpp"
#include "hal/kinect/openni_parts.hpp"
#include "hal/kinect/usb_control.hpp"

namespace g3d {
namespace {

using hal::kinect::Light;

/// A recording as fast as it was made, with stamps of now.
class PacedCamera final : public hal::DepthCamera {
 public:
  PacedCamera(hal::DepthCamera& recording, hal::Clock& clock) : recording_(recording), clock_(clock) {}
  [[nodiscard]] const hal::CameraModel& model() const override { return recording_.model(); }
  [[nodiscard]] hal::CameraRead read(hal::Frame& out) override {
    if (ended_.load(std::memory_order_acquire)) return {hal::CameraEvent::end, {}};
    const hal::CameraRead read = recording_.read(out);
    if (read.event != hal::CameraEvent::frame) return read;
    if (!offset_ns_) offset_ns_ = clock_.now() - out.stamp_ns;
    out.stamp_ns += *offset_ns_;
    clock_.sleep_until(out.stamp_ns);
    return read;
  }
  void end() { ended_.store(true, std::memory_order_release); }
  [[nodiscard]] std::string last_error() const override { return recording_.last_error(); }

 private:
  hal::DepthCamera& recording_;
  hal::Clock& clock_;
  std::optional<hal::TimeNs> offset_ns_;
  std::atomic<bool> ended_{false};
};

void set_intrinsics(const hal::CameraModel& model, board::Board& board) {
  board.camera_width_px = model.width_px;
  board.camera_height_px = model.height_px;
  board.camera_fx_px = static_cast<double>(model.fx_px);
  board.camera_fy_px = static_cast<double>(model.fy_px);
  board.camera_cx_px = static_cast<double>(model.cx_px);
  board.camera_cy_px = static_cast<double>(model.cy_px);
  board.camera_depth_units_per_metre = static_cast<double>(model.depth_units_per_metre);
}

Light light_for(const nav::LiveStatus& status) {
  switch (status.state) {
    case nav::MissionState::home:
      return Light::yellow;
    case nav::MissionState::needs_help:
      return Light::red;
    case nav::MissionState::exploring:
    case nav::MissionState::returning:
      return status.safety == hal::SafetyState::stand ? Light::blinking_red_yellow : Light::green;
    default:
      return Light::blinking_green;
  }
}

}  // namespace

bool is_kinect(const board::Board& board) {
  return board.camera_source == "kinect" || board.camera_source.starts_with(kOniSource);
}

hal::Result<std::unique_ptr<KinectPart>> KinectPart::open(board::Board& board, const std::string& record_path) {
  std::unique_ptr<KinectPart> part(new KinectPart);
  part->is_virtual_ = board.base_line == "sim";
  part->rate_hz_ = board.camera_rate_hz;
  part->record_path_ = record_path;
  const bool has_calibration = board.camera_calibration != "none";
  if (has_calibration) {
    auto loaded = hal::kinect::load_calibration(board.camera_calibration);
    if (!loaded) return loaded.error();
    part->calibration_ = std::move(loaded).value();
  }
  if (board.camera_source.starts_with(kOniSource)) {
    auto recording = hal::kinect::open_recording(board.camera_source.substr(kOniSource.size()),
                                                 has_calibration ? &part->calibration_ : nullptr);
    if (!recording) return recording.error();
    part->recording_ = std::move(recording).value();
    part->paced_ = std::make_unique<PacedCamera>(*part->recording_, part->clock_);
    set_intrinsics(part->recording_->model(), board);
    return part;
  }
  if (!hal::kinect::is_openni_built_in()) return hal::kinect::make_freenect_link(part->clock_, {}).error();
  // What the simulated camera takes has its own intrinsics, and needs no correction.
  if (part->is_virtual_ && !has_calibration) {
    part->calibration_.colour = {board.camera_fx_px, board.camera_fy_px, board.camera_cx_px, board.camera_cy_px};
    part->calibration_.latency_ms = 0.0;
  }
  set_intrinsics(hal::kinect::colour_model(part->calibration_), board);
  if (part->is_virtual_) return part;
  part->level(board, part->calibration_);
  auto link = hal::kinect::make_freenect_link(part->clock_, record_path);
  if (!link) return link.error();
  part->kinect_ = std::make_unique<hal::kinect::KinectCamera>(
      std::move(link).value(), part->clock_, hal::kinect::KinectOptions{.calibration = part->calibration_});
  if (const auto opened = part->kinect_->open(); !opened) {
    part->notes_.push_back(opened.error().text);
    fmt::print(stderr, "g3dmap: warning: {}; it is looked for until it is there, and the robot stands until then\n",
               opened.error().text);
  }
  return part;
}

KinectPart::~KinectPart() {
  kinect_.reset();
  if (foot_ != nullptr) (void)foot_->show(Light::off);
}

void KinectPart::level(board::Board& board, const hal::kinect::Calibration& calibration) {
  auto usb = hal::kinect::open_usb_control(hal::kinect::kMicrosoft, hal::kinect::kKinectFoot);
  if (!usb) {
    notes_.push_back(
        fmt::format("the Kinect's foot (motor, light, accelerometer) is not there: {}; the board's mounting "
                    "angles are used",
                    usb.error().text));
    return;
  }
  foot_ = std::make_unique<hal::kinect::TiltUnit>(std::move(usb).value());
  set_light(Light::blinking_green);
  hal::kinect::LevellingOptions options;
  options.target_deg = std::clamp(board.mount_pitch_deg, -hal::kinect::kMostTilt_deg, hal::kinect::kMostTilt_deg);
  const auto levelled = hal::kinect::level_camera(*foot_, clock_, calibration, options);
  if (!levelled) {
    notes_.push_back(levelled.error().text + "; the board's mounting angles are used");
    foot_.reset();
    return;
  }
  notes_.push_back(levelled.value().note);
  if (!levelled.value().attitude) return;
  board.mount_pitch_deg = levelled.value().attitude->elevation_deg;
  board.mount_roll_deg = levelled.value().attitude->roll_deg;
}

void KinectPart::show(hal::DepthCamera& shown) {
  if (!is_virtual_ || paced_ != nullptr) return;
  auto link = hal::kinect::make_virtual_link(clock_, record_path_, shown, rate_hz_);
  if (!link) return;  // open() has said so
  hal::kinect::KinectOptions options;
  options.calibration = calibration_;
  options.stall_ns = std::max(options.stall_ns, static_cast<hal::TimeNs>(5e9 / rate_hz_));
  options.colour_within_ns = static_cast<hal::TimeNs>(1e9 / rate_hz_);
  kinect_ = std::make_unique<hal::kinect::KinectCamera>(std::move(link).value(), clock_, options);
}

hal::DepthCamera& KinectPart::camera() { return paced_ != nullptr ? *paced_ : *kinect_; }

void KinectPart::end() {
  if (paced_ != nullptr) static_cast<PacedCamera&>(*paced_).end();
  if (kinect_ != nullptr) kinect_->stop();
}

void KinectPart::light_up(const nav::LiveStatus& status) { set_light(light_for(status)); }

void KinectPart::set_light(Light light) {
  if (foot_ == nullptr || (has_light_ && light == light_)) return;
  has_light_ = true;
  light_ = light;
  // One that does not answer is not asked again: each question may take a second.
  if (!foot_->show(light)) foot_.reset();
}

std::vector<std::string> KinectPart::notes() const {
  std::vector<std::string> notes = notes_;
  const hal::DepthCamera* const camera = paced_ != nullptr ? paced_.get() : kinect_.get();
  if (camera != nullptr && !camera->last_error().empty()) notes.push_back(camera->last_error());
  return notes;
}

void KinectPart::write(mapper::JsonWriter& json) const {
  json.key("kinect").begin_object();
  json.member("source", is_virtual_ ? "virtual" : paced_ != nullptr ? "recording" : "kinect");
  json.member("foot", foot_ != nullptr);
  if (kinect_ != nullptr) {
    const hal::kinect::KinectCounts counts = kinect_->counts();
    json.member("frames", counts.frames).member("opened", counts.opened).member("open_failures", counts.open_failures);
    json.member("unplugged", counts.unplugged).member("stalled", counts.stalled).member("missed", counts.missed);
    json.member("bad_depth", counts.bad_depth).member("bad_colour", counts.bad_colour);
    json.member("colourless", counts.colourless).member("doubtful_stamps", counts.doubtful_stamps);
    json.member("depth_overruns", counts.depth_overruns).member("colour_overruns", counts.colour_overruns);
  }
  json.end_object();
}

}  // namespace g3d
