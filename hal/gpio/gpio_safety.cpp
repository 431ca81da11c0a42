// SPDX-License-Identifier: Apache-2.0
#include "hal/gpio/gpio_safety.hpp"

#include <algorithm>

#include "hal/gpio/status_lamp.hpp"
#include "hal/replay/gpio_log.hpp"
#include "hal/replay/text_recorder.hpp"

namespace g3d::hal {
namespace {

constexpr int kMostEdgesPerLook = 64;  // a contact bounces for a few; more than that would keep the base waiting

}  // namespace

GpioSafety::GpioSafety(GpioLines& lines, const GpioSafetyOptions& options, TextRecorder* recorder)
    : lines_(lines), options_(options), recorder_(recorder), estop_(options.estop) {}

StopWord GpioSafety::look(TimeNs now_ns) {
  if (!options_.has_estop) return StopWord::go;
  GpioEdge edge;
  for (int i = 0; i < kMostEdgesPerLook && lines_.read_edge(edge, now_ns); ++i) {
    estop_.on_edge(edge);
    record(edge.input, edge.level, edge.t_ns);
  }
  for (std::size_t i = 0; i < lines_.input_count(); ++i) {
    if (const auto level = lines_.level(i)) {
      estop_.on_level(i, *level, now_ns);
      if (recorded_[i] != level) record(i, *level, now_ns);
    } else {
      estop_.on_unreadable(i, now_ns);
    }
  }
  return estop_.word(now_ns);
}

void GpioSafety::show(const SafetyNews& news, TimeNs now_ns) {
  const bool lit = lamp_is_lit(news, now_ns);
  if (lit_ == lit) return;
  lit_ = lit;
  lines_.set_output(lit);
}

void GpioSafety::say_farewell(TimeNs) { lines_.set_output(false); }

// In the order of time, though edges of two lines and levels may come in another one.
void GpioSafety::record(std::size_t input, bool level, TimeNs t_ns) {
  if (input >= recorded_.size()) return;
  recorded_[input] = level;
  if (recorder_ == nullptr) return;
  last_recorded_ns_ = std::max(last_recorded_ns_, t_ns);
  std::array<char, kMaxGpioLogLine> line;
  recorder_->put({line.data(), format_gpio_line_to(line.data(), last_recorded_ns_, options_.names[input], level)});
}

}  // namespace g3d::hal
