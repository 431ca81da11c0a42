// SPDX-License-Identifier: Apache-2.0
// What it costs to record frames without loss: packed images against PNG, CPU time of one thread and bytes for depth
// and colour, and whether the recorder keeps up with a camera at full rate.
//   record_bench [FOLDER]...        of TUM recordings as well; without, of a simulated flight
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <thread>

#include "hal/frame_pool.hpp"
#include "hal/image/png_writer.hpp"
#include "hal/record/frame_recorder.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

struct Cost {
  double ms = 0.0;
  double bytes = 0.0;
};

template <typename Work>
Cost cost_of(const test::Workload& workload, const Work& work) {
  Cost cost;
  const double begin_ms = cpu_ms();
  for (const test::PosedImage& image : workload.frames) cost.bytes += static_cast<double>(work(image.frame));
  const auto count = static_cast<double>(workload.frames.size());
  return {(cpu_ms() - begin_ms) / count, cost.bytes / count};
}

void pack_and_compare(const test::Workload& workload) {
  const hal::ImageSize size{workload.camera.width_px, workload.camera.height_px};
  const std::size_t pixels = size.pixel_count();
  hal::ImagePacker packer(size);
  hal::ImageUnpacker unpacker;
  std::vector<std::uint16_t> depth(pixels);
  const auto say = [&](const char* what, const Cost& cost) {
    fmt::print("  {:<28} {:6.2f} ms {:9.0f} bytes\n", what, cost.ms, cost.bytes);
  };
  say("depth, packed", cost_of(workload, [&](const hal::Frame& frame) {
        return packer.pack_depth(size, {frame.depth.get(), pixels}).size();
      }));
  say("colour, packed", cost_of(workload, [&](const hal::Frame& frame) {
        return packer.pack_rgb(size, {frame.rgb.get(), 3 * pixels}).size();
      }));
  say("depth, PNG", cost_of(workload, [&](const hal::Frame& frame) {
        return hal::encode_png_depth(size, {frame.depth.get(), pixels}).value().size();
      }));
  say("colour, PNG", cost_of(workload, [&](const hal::Frame& frame) {
        return hal::encode_png_rgb(size, {frame.rgb.get(), 3 * pixels}).value().size();
      }));
  say("depth, packed and unpacked", cost_of(workload, [&](const hal::Frame& frame) {
        const auto file = packer.pack_depth(size, {frame.depth.get(), pixels});
        const bool same = unpacker.unpack_depth(file, "depth", size, depth).ok() &&
                          std::equal(depth.begin(), depth.end(), frame.depth.get());
        if (!same) {
          fmt::print(stderr, "record_bench: an image did not come back as it was\n");
          std::exit(1);
        }
        return file.size();
      }));
}

/// Ten seconds of a camera at 30 Hz.
void record_at_full_rate(const test::Workload& workload) {
  constexpr int kFrames = 300;
  constexpr auto kPeriod = std::chrono::nanoseconds(1'000'000'000 / 30);
  const test::TempFolder folder;
  auto recorder = hal::FrameRecorder::create(folder.path(), workload.camera, true);
  if (!recorder) {
    fmt::print(stderr, "record_bench: {}\n", recorder.error().text);
    std::exit(1);
  }
  hal::Frame frame = hal::make_frame(workload.camera);
  auto due = std::chrono::steady_clock::now();
  double camera_ms = 0.0;
  for (int i = 0; i < kFrames; ++i, due += kPeriod) {
    std::this_thread::sleep_until(due);
    const hal::Frame& image = workload.frames[static_cast<std::size_t>(i) % workload.frames.size()].frame;
    frame.stamp_ns = hal::TimeNs{i + 1} * kPeriod.count();
    frame.has_colour = true;
    std::copy_n(image.depth.get(), workload.camera.pixel_count(), frame.depth.get());
    std::copy_n(image.rgb.get(), 3 * workload.camera.pixel_count(), frame.rgb.get());
    const double begin_ms = cpu_ms();
    recorder.value()->put_frame(frame);
    camera_ms += cpu_ms() - begin_ms;
  }
  const auto finished = recorder.value()->finish();
  const hal::RecordCounts counts = recorder.value()->counts();
  const double run_s = kFrames / 30.0;
  fmt::print(
      "  at 30 Hz for {:.0f} s: {} of {} frames written, {} lost; writer {:.2f} cores, camera {:.2f} ms a frame, "
      "{:.1f} "
      "MB/s{}\n",
      run_s, counts.written, counts.delivered, counts.lost_behind + counts.lost_disk,
      static_cast<double>(counts.writer_cpu_ns) * 1e-9 / run_s, camera_ms / kFrames,
      static_cast<double>(counts.bytes) * 1e-6 / run_s, finished.ok() ? "" : "; " + finished.error().text);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<test::Workload> workloads;
  for (int i = 1; i < argc; ++i) workloads.push_back(test::recorded(argv[i], 60));
  if (workloads.empty()) workloads.push_back(test::simulated_drive("furnished_room", 40, 0.5));
  for (const test::Workload& workload : workloads) {
    if (workload.frames.empty()) {
      fmt::print(stderr, "record_bench: {}: no frames\n", workload.name);
      return 1;
    }
    fmt::print("{}: {} frames of {}x{}, per image, CPU time\n", workload.name, workload.frames.size(),
               workload.camera.width_px, workload.camera.height_px);
    pack_and_compare(workload);
    record_at_full_rate(workload);
  }
  return 0;
}
