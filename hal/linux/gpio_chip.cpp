// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/gpio_chip.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gpiod.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace g3d::hal {
namespace {

constexpr const char* kConsumer = "g3dmap";
constexpr unsigned kEdgesAtOnce = 16;  // as many as the kernel keeps of a line

Error gpio_error(const std::string& chip, const std::string& what, int error) {
  const auto say = [&](Reason reason, const char* remedy) {
    return Error{reason, fmt::format("{}: {}: {}; {}", chip, what, std::strerror(error), remedy)};
  };
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
    case EINVAL:
      return say(Reason::not_found, "see gpioinfo for what there is, and [gpio] in the board file");
    case EACCES:
    case EPERM:
      return say(Reason::no_permission, "add the user to group gpio, or run it as root");
    case EBUSY:
      return say(Reason::no_capacity, "another program or driver holds that line; see gpioinfo");
    default:
      return say(Reason::io_error, "see dmesg for what its driver says");
  }
}

TimeNs timespec_ns(const timespec& t) { return TimeNs{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }
TimeNs real_now_ns() {
  timespec now{};
  (void)::clock_gettime(CLOCK_REALTIME, &now);
  return timespec_ns(now);
}

gpiod_line* find_line(gpiod_chip* chip, const std::string& name) {
  unsigned offset = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), offset);
  if (error == std::errc{} && end == name.data() + name.size()) return gpiod_chip_get_line(chip, offset);
  return gpiod_chip_find_line(chip, name.c_str());
}

std::optional<int> bias_flags(const std::string& bias) {
  if (bias == "as_is") return 0;
  if (bias == "pull_up") return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (bias == "pull_down") return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (bias == "disable") return GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  return std::nullopt;
}

}  // namespace

std::optional<TimeNs> monotonic_edge_ns(TimeNs stamp_ns, TimeNs monotonic_now_ns, TimeNs real_now_ns) {
  // An edge waits for its reader for a moment; a line that nobody reads keeps the first ones for long.
  constexpr TimeNs kLongest_ns = 60'000'000'000, kAhead_ns = 10'000'000;
  const auto is_near = [&](TimeNs now_ns) {
    return stamp_ns >= now_ns - kLongest_ns && stamp_ns <= now_ns + kAhead_ns;
  };
  if (is_near(monotonic_now_ns)) return stamp_ns;
  if (is_near(real_now_ns)) return stamp_ns - real_now_ns + monotonic_now_ns;
  return std::nullopt;
}

struct GpioChip::Lines {
  ~Lines() {
    // Releases its lines as well.
    if (chip != nullptr) gpiod_chip_close(chip);
  }
  struct Input {
    gpiod_line* line = nullptr;
    int fd = -1;  ///< the line's own
    std::array<gpiod_line_event, kEdgesAtOnce> edges{};
    std::size_t count = 0, next = 0;
  };
  gpiod_chip* chip = nullptr;
  std::array<Input, kMaxGpioInputs> inputs{};
  std::size_t input_count = 0;
  gpiod_line* output = nullptr;
};

GpioChip::GpioChip(std::unique_ptr<Lines> lines) : lines_(std::move(lines)) {}
GpioChip::~GpioChip() = default;

Result<std::unique_ptr<GpioChip>> GpioChip::open(const GpioChipOptions& options) {
  const auto flags = bias_flags(options.bias);
  if (!flags) return Error{Reason::bad_usage, fmt::format("{}: no such bias of a line", options.bias)};
  auto lines = std::make_unique<Lines>();
  lines->chip = gpiod_chip_open_lookup(options.chip.c_str());
  if (lines->chip == nullptr) return gpio_error(options.chip, "no such GPIO chip", errno);
  for (const std::string& name : options.inputs) {
    if (name.empty()) break;
    Lines::Input& input = lines->inputs[lines->input_count];
    errno = ENOENT;
    input.line = find_line(lines->chip, name);
    if (input.line == nullptr) return gpio_error(options.chip, fmt::format("no line '{}'", name), errno);
    if (gpiod_line_request_both_edges_events_flags(input.line, kConsumer, *flags) != 0) {
      if (errno == EINVAL && *flags != 0) {
        return Error{Reason::unsupported, fmt::format("{}: line '{}' has no bias {}: older than Linux 5.5, or the chip "
                                                      "cannot; set gpio.bias = \"as_is\" and use a resistor",
                                                      options.chip, name, options.bias)};
      }
      return gpio_error(options.chip, fmt::format("line '{}' as an input", name), errno);
    }
    input.fd = gpiod_line_event_get_fd(input.line);
    const int now = ::fcntl(input.fd, F_GETFL);
    if (input.fd < 0 || now < 0 || ::fcntl(input.fd, F_SETFL, now | O_NONBLOCK) != 0) {
      return gpio_error(options.chip, fmt::format("edges of line '{}'", name), errno);
    }
    ++lines->input_count;
  }
  if (!options.output.empty()) {
    errno = ENOENT;
    lines->output = find_line(lines->chip, options.output);
    if (lines->output == nullptr) return gpio_error(options.chip, fmt::format("no line '{}'", options.output), errno);
    if (gpiod_line_request_output(lines->output, kConsumer, 0) != 0) {
      return gpio_error(options.chip, fmt::format("line '{}' as an output", options.output), errno);
    }
  }
  return std::unique_ptr<GpioChip>(new GpioChip(std::move(lines)));
}

std::size_t GpioChip::input_count() const { return lines_->input_count; }

bool GpioChip::fill(std::size_t at) {
  Lines::Input& input = lines_->inputs[at];
  if (input.next < input.count) return true;
  input.next = input.count = 0;
  const int count = gpiod_line_event_read_fd_multiple(input.fd, input.edges.data(), kEdgesAtOnce);
  if (count > 0) {
    input.count = static_cast<std::size_t>(count);
    return true;
  }
  if (count < 0 && errno != EAGAIN && errno != EINTR) ++counts_.failed_reads;
  return false;
}

// Of two lines the earlier edge comes first.
bool GpioChip::read_edge(GpioEdge& edge, TimeNs now_ns) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < lines_->input_count; ++i) {
    if (!fill(i)) continue;
    const auto stamp = [&](std::size_t k) { return timespec_ns(lines_->inputs[k].edges[lines_->inputs[k].next].ts); };
    if (!first || stamp(i) < stamp(*first)) first = i;
  }
  if (!first) return false;
  Lines::Input& input = lines_->inputs[*first];
  const gpiod_line_event& event = input.edges[input.next++];
  const auto t_ns = monotonic_edge_ns(timespec_ns(event.ts), now_ns, real_now_ns());
  counts_.bad_stamps += !t_ns;
  ++counts_.edges;
  edge = {t_ns.value_or(now_ns), static_cast<std::uint8_t>(*first), event.event_type == GPIOD_LINE_EVENT_RISING_EDGE};
  return true;
}

std::optional<bool> GpioChip::level(std::size_t input) {
  const int value = input < lines_->input_count ? gpiod_line_get_value(lines_->inputs[input].line) : -1;
  if (value < 0) {
    ++counts_.failed_reads;
    return std::nullopt;
  }
  return value != 0;
}

void GpioChip::set_output(bool level) {
  if (lines_->output == nullptr) return;
  counts_.failed_writes += gpiod_line_set_value(lines_->output, level ? 1 : 0) != 0;
}

}  // namespace g3d::hal
