// SPDX-License-Identifier: Apache-2.0
#include "main_buses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "hal/linux/can_link.hpp"
#include "hal/linux/memory_lock.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kMs = hal::kMillisecond_ns;
constexpr hal::TimeNs kSlowChore_ns = 1'000 * kMs;
constexpr hal::TimeNs kNews_ns = 100 * kMs;
constexpr hal::TimeNs kBaseLimit_ns = 2'000 * kMs;  // it looks each 2 ms; the guard has stopped the base long before
constexpr std::size_t kMostLateNotes = 8;

bool is_named(const std::string& field) { return field != "none"; }
double to_digits(double value, double step) { return std::round(value / step) * step; }
hal::TimeNs from_ms(double ms) { return static_cast<hal::TimeNs>(std::llround(ms * 1e6)); }

}  // namespace

hal::can::CanSafetyOptions can_options(const board::Board& board) {
  hal::can::CanSafetyOptions options;
  options.own_node = static_cast<std::uint8_t>(board.can_node);
  options.has_estop = board.can_estop_node != 0;
  options.estop.node = static_cast<std::uint8_t>(board.can_estop_node);
  options.estop.heartbeat_ns = from_ms(board.can_estop_heartbeat_ms);
  options.starts_estop = board.can_starts_estop == "yes";
  options.interface = board.can_interface.c_str();
  return options;
}

hal::GpioSafetyOptions gpio_options(const board::Board& board) {
  hal::GpioSafetyOptions options;
  options.has_estop = is_named(board.gpio_estop);
  options.estop.lines = is_named(board.gpio_estop_second) ? 2 : 1;
  options.estop.closed_level = board.gpio_estop_closed == "high";
  options.estop.glitch_ns = from_ms(board.gpio_glitch_ms);
  options.estop.settle_ns = from_ms(board.gpio_release_ms);
  options.names = {board.gpio_estop, board.gpio_estop_second};
  return options;
}

hal::GpioChipOptions gpio_chip_options(const board::Board& board) {
  hal::GpioChipOptions options;
  options.chip = board.gpio_chip;
  if (is_named(board.gpio_estop)) options.inputs[0] = board.gpio_estop;
  if (is_named(board.gpio_estop) && is_named(board.gpio_estop_second)) options.inputs[1] = board.gpio_estop_second;
  if (is_named(board.gpio_lamp)) options.output = board.gpio_lamp;
  options.bias = board.gpio_bias;
  return options;
}

/// Last of the devices: hands what the others count to other threads.
class Buses::Reporter final : public hal::SafetyDevice {
 public:
  Reporter(const hal::can::CanSafety* can, const hal::CanSocket* socket, const hal::GpioSafety* gpio)
      : can_(can), socket_(socket), gpio_(gpio) {}
  [[nodiscard]] hal::StopWord look(hal::TimeNs) override { return hal::StopWord::go; }
  void show(const hal::SafetyNews& robot, hal::TimeNs now_ns) override {
    if (now_ns < next_ns_) return;
    next_ns_ = now_ns + kNews_ns;
    tell(robot.conditions, now_ns);
  }
  void say_farewell(hal::TimeNs now_ns) override { tell(last_, now_ns); }
  [[nodiscard]] BusesNews read() const {
    BusesNews news;
    (void)news_.read(news);
    return news;
  }

 private:
  void tell(hal::Conditions conditions, hal::TimeNs now_ns) {
    last_ = conditions;
    BusesNews news;
    news.conditions = conditions;
    if (can_ != nullptr) {
      const hal::can::EstopNode& node = can_->estop();
      news.can = socket_->counts();
      news.can_words = can_->counts();
      news.estop_state = node.state();
      news.estop_alive = node.is_alive(now_ns);
      news.estop_emergency = node.has_emergency();
      news.emergency_code = node.last_emergency().code;
      news.heartbeats = node.heartbeats();
      news.emergencies = node.emergencies();
      news.losses = node.losses();
    }
    if (gpio_ != nullptr) {
      news.gpio = gpio_->lines().counts();
      news.gpio_fault = gpio_->estop().fault();
      news.presses = gpio_->estop().presses();
      news.glitches = gpio_->estop().glitches();
    }
    news_.write(news);
  }

  const hal::can::CanSafety* const can_;
  const hal::CanSocket* const socket_;
  const hal::GpioSafety* const gpio_;
  hal::TimeNs next_ns_ = 0;
  hal::Conditions last_;
  hal::Latest<BusesNews> news_;
};

Buses::Buses(const board::Board& board, hal::Clock& clock)
    : board_(board), clock_(clock), has_base_(board.base_line != "sim") {}
Buses::~Buses() = default;

hal::Result<std::unique_ptr<Buses>> Buses::open(const board::Board& board, hal::Clock& clock,
                                                const std::string& record_dir) {
  std::unique_ptr<Buses> buses(new Buses(board, clock));
  auto plan = hal::parse_thread_plan(board.threads_plan);
  if (!plan) return plan.error();
  buses->settler_ = std::make_unique<hal::ThreadSettler>(std::move(plan).value());
  if (board.threads_lock_memory == "yes") {
    // It drives as safely without, only less evenly.
    if (const auto locked = hal::lock_program_memory(); !locked) buses->first_notes_.push_back(locked.error().text);
  }
  if (is_named(board.can_interface)) {
    if (auto opened = buses->open_can(record_dir); !opened) return opened.error();
  }
  if (is_named(board.gpio_chip)) {
    if (auto opened = buses->open_gpio(record_dir); !opened) return opened.error();
  }
  buses->reporter_ = std::make_unique<Reporter>(buses->can_.get(), buses->can_socket_.get(), buses->gpio_.get());
  return buses;
}

hal::Result<void> Buses::open_can(const std::string& record_dir) {
  const hal::can::CanSafetyOptions options = can_options(board_);
  if (options.has_estop && options.estop.node == options.own_node) {
    return hal::Error{
        hal::Reason::bad_usage,
        fmt::format("can.node and can.estop_node are both {}: two nodes of one bus have two numbers", board_.can_node)};
  }
  if (!record_dir.empty()) {
    auto recorder = hal::TextRecorder::create(record_dir + "/can.log");
    if (!recorder) return recorder.error();
    can_recorder_ = std::move(recorder).value();
  }
  const auto bitrate = static_cast<std::uint32_t>(std::lround(board_.can_bitrate_kbps * 1000.0));
  hal::CanKeeperCalls calls = hal::can_keeper_calls(board_.can_interface, bitrate);
  hal::Result<void> ready;
  if (bitrate > 0) ready = hal::bring_can_up(board_.can_interface, bitrate);
  auto fd = calls.open_socket();
  if (!ready) first_notes_.push_back(ready.error().text);
  if (!fd) first_notes_.push_back(fd.error().text);
  if (options.has_estop && (!ready || !fd)) first_notes_.emplace_back("the robot stands until the CAN bus is there");
  can_socket_ = std::make_unique<hal::CanSocket>(fd ? fd.value() : -1);
  can_keeper_ = std::make_unique<hal::CanKeeper>(*can_socket_, std::move(calls));
  can_ = std::make_unique<hal::can::CanSafety>(*can_socket_, options, can_recorder_.get());
  return {};
}

hal::Result<void> Buses::open_gpio(const std::string& record_dir) {
  auto chip = hal::GpioChip::open(gpio_chip_options(board_));
  if (!chip) return chip.error();
  gpio_chip_ = std::move(chip).value();
  if (!record_dir.empty() && is_named(board_.gpio_estop)) {
    auto recorder = hal::TextRecorder::create(record_dir + "/gpio.log");
    if (!recorder) return recorder.error();
    gpio_recorder_ = std::move(recorder).value();
  }
  gpio_ = std::make_unique<hal::GpioSafety>(*gpio_chip_, gpio_options(board_), gpio_recorder_.get());
  return {};
}

void Buses::equip(nav::RobotThreadsConfig& config) {
  if (can_ != nullptr) config.base.safety_devices.push_back(can_.get());
  if (gpio_ != nullptr) config.base.safety_devices.push_back(gpio_.get());
  if (can_ != nullptr || gpio_ != nullptr) config.base.safety_devices.push_back(reporter_.get());
  const hal::TimeNs limit_ns = from_ms(board_.watchdog_thread_s * 1000.0);
  config.base.progress = &progress_.add("base", std::min(kBaseLimit_ns, limit_ns));
  config.camera_progress = &progress_.add("camera", limit_ns);
  config.mapper_progress = &progress_.add("mapper", limit_ns);
  config.navigator_progress = &progress_.add("navigator", limit_ns);
  main_progress_ = &progress_.add("main", limit_ns);
}

void Buses::start() {
  if (is_named(board_.watchdog_device) && supervised_ns_ == 0) {
    auto watchdog = hal::LinuxWatchdog::open(board_.watchdog_device, board_.watchdog_timeout_s);
    if (watchdog) {
      watchdog_ = std::move(watchdog).value();
      if (watchdog_->has_bitten()) first_notes_.emplace_back("this start follows a reset by the watchdog");
    } else {
      first_notes_.push_back(watchdog.error().text);
    }
  }
  for (const std::string& note : first_notes_) fmt::print(stderr, "g3dmap: {}\n", note);
  const bool is_needed = watchdog_ != nullptr || on_all_alive_ || can_ != nullptr || gpio_ != nullptr ||
                         board_.threads_plan != "none" || has_base_;
  if (!is_needed) return;
  hal::CaretakerOptions options;
  options.on_all_alive = on_all_alive_;
  options.on_late = [this](const std::string& name, hal::TimeNs silent_ns) {
    if (name.empty()) return;
    std::string note =
        fmt::format("thread {} made no progress for {:.1f} s", name, static_cast<double>(silent_ns) * 1e-9);
    fmt::print(stderr, "g3dmap: {}; the watchdog is not fed\n", note);
    const std::lock_guard lock(caretakers_);
    if (late_notes_.size() < kMostLateNotes) late_notes_.push_back(std::move(note));
  };
  options.chores.emplace_back([this](hal::TimeNs now_ns) { tend(now_ns); });
  if (watchdog_ != nullptr) {
    options.feed_ns = std::min(options.feed_ns, watchdog_->timeout_s() * hal::TimeNs{500'000'000});
  }
  if (supervised_ns_ > 0) options.feed_ns = std::min(options.feed_ns, supervised_ns_);
  caretaker_ = std::make_unique<hal::Caretaker>(progress_, clock_, std::move(options), watchdog_.get());
  caretaker_->start();
}

void Buses::tend(hal::TimeNs now_ns) {
  if (can_keeper_ != nullptr) can_keeper_->tend(now_ns);
  const bool is_slow_turn = now_ns >= next_slow_chore_ns_;
  std::optional<hal::ThermalPower> reading;
  if (is_slow_turn) {
    next_slow_chore_ns_ = now_ns + kSlowChore_ns;
    settler_->settle();
    reading = thermal_reader_.read();
  }
  const std::lock_guard lock(caretakers_);
  if (can_keeper_ != nullptr) {
    keeper_counts_ = can_keeper_->counts();
    keeper_error_ = can_keeper_->last_error();
  }
  if (!reading) return;
  plan_counts_ = settler_->counts();
  hottest_so_far_ = std::max(hottest_so_far_, hal::hottest_celsius(*reading));
  thermal_ = std::move(*reading);
}

void Buses::stop() {
  if (caretaker_ != nullptr) {
    caretaker_->stop();
  } else if (watchdog_ != nullptr) {
    watchdog_->disarm();
  }
}

hal::Result<void> Buses::finish_recording() {
  hal::Result<void> first;
  for (hal::TextRecorder* recorder : {can_recorder_.get(), gpio_recorder_.get()}) {
    if (recorder == nullptr) continue;
    auto finished = recorder->finish();
    if (first && !finished) first = std::move(finished);
  }
  return first;
}

void Buses::write(mapper::JsonWriter& json) const {
  const BusesNews news = reporter_->read();
  json.key("buses").begin_object();
  json.member("emergency_stop", news.conditions.has(hal::Condition::e_stop));
  if (can_ != nullptr) write_can(json, news);
  if (gpio_ != nullptr) write_gpio(json, news);
  write_machine(json);
  json.end_object();
}

void Buses::write_can(mapper::JsonWriter& json, const BusesNews& news) const {
  const hal::can::CanCounts& c = news.can;
  json.key("can").begin_object().member("interface", board_.can_interface);
  json.member("received", c.received).member("sent", c.sent).member("error_frames", c.error_frames);
  json.key("frames_dropped").begin_object().member("malformed", c.malformed).member("overflowed", c.overflowed);
  json.member("failed_reads", c.failed_reads).end_object();
  json.key("not_sent").begin_object().member("queue_full", c.send_queue_full).member("down", c.not_sent_down);
  json.member("other", c.not_sent).end_object();
  json.key("ignored").begin_object();
  for (std::size_t i = 0; i < news.can_words.ignored.size(); ++i) {
    json.member(hal::can::to_string(static_cast<hal::can::NoMessage>(i)), news.can_words.ignored[i]);
  }
  json.end_object();
  json.member("bus_offs", c.bus_offs).member("bus_restarts", c.bus_restarts).member("link_losses", c.link_losses);
  json.member("reopened", c.reopened).member("orders", news.can_words.orders);
  if (board_.can_estop_node != 0) {
    json.key("estop").begin_object().member("node", board_.can_estop_node).member("alive", news.estop_alive);
    json.member("state", static_cast<int>(news.estop_state)).member("emergency", news.estop_emergency);
    json.member("emergency_code", news.emergency_code).member("heartbeats", news.heartbeats);
    json.member("emergencies", news.emergencies).member("losses", news.losses);
    json.member("starts_sent", news.can_words.starts_sent).end_object();
  }
  const std::lock_guard lock(caretakers_);
  json.key("keeper").begin_object().member("openings", keeper_counts_.openings);
  json.member("failed_openings", keeper_counts_.failed_openings).member("ups", keeper_counts_.ups);
  json.member("failed_ups", keeper_counts_.failed_ups).member("restarts", keeper_counts_.restarts);
  json.member("failed_restarts", keeper_counts_.failed_restarts).member("last_error", keeper_error_).end_object();
  if (can_recorder_ != nullptr) json.member("unrecorded_frames", can_recorder_->lost_lines());
  json.end_object();
}

void Buses::write_gpio(mapper::JsonWriter& json, const BusesNews& news) const {
  json.key("gpio").begin_object().member("chip", board_.gpio_chip).member("fault", hal::to_string(news.gpio_fault));
  json.member("presses", news.presses).member("glitches", news.glitches).member("edges", news.gpio.edges);
  json.member("failed_reads", news.gpio.failed_reads).member("failed_writes", news.gpio.failed_writes);
  json.member("bad_stamps", news.gpio.bad_stamps);
  if (gpio_recorder_ != nullptr) json.member("unrecorded_edges", gpio_recorder_->lost_lines());
  json.end_object();
}

void Buses::write_machine(mapper::JsonWriter& json) const {
  hal::CaretakerCounts fed;
  if (caretaker_ != nullptr) (void)caretaker_->counts().read(fed);
  if (watchdog_ != nullptr) {
    json.key("watchdog").begin_object().member("device", board_.watchdog_device).member("name", watchdog_->name());
    json.member("timeout_s", watchdog_->timeout_s()).member("feeds", fed.feeds);
    json.member("refused_feeds", fed.refused_feeds).member("withheld", fed.withheld).end_object();
  }
  const std::lock_guard lock(caretakers_);
  json.key("thread_plan").begin_object().member("settled", plan_counts_.settled);
  json.member("no_permission", plan_counts_.no_permission).member("no_cpu", plan_counts_.no_cpu);
  json.member("failed", plan_counts_.failed).end_object();
  json.key("temperatures_c").begin_object();
  for (const auto& one : thermal_.temperatures) json.member(one.name, to_digits(one.celsius, 0.1));
  json.end_object().member("hottest_c", to_digits(hottest_so_far_, 0.1));
  json.key("power_w").begin_object();
  for (const auto& one : thermal_.powers) json.member(one.rail, to_digits(one.watts, 0.001));
  json.end_object();
}

std::optional<std::string> Buses::answer(std::string_view request) const {
  if (request != "buses") return std::nullopt;
  mapper::JsonWriter json;
  json.begin_object();
  write(json);
  json.end_object();
  return json.take();
}

std::vector<std::string> Buses::notes() const {
  std::vector<std::string> notes = first_notes_;
  const std::lock_guard lock(caretakers_);
  notes.insert(notes.end(), late_notes_.begin(), late_notes_.end());
  const auto note = [&](std::uint64_t count, const char* text) {
    if (count > 0) notes.push_back(fmt::format("{} {}", count, text));
  };
  note(plan_counts_.no_permission, "threads may not be as urgent as threads.plan says: give it CAP_SYS_NICE");
  note(plan_counts_.no_cpu, "threads stayed where they were: the CPUs of threads.plan are not online");
  note(plan_counts_.failed, "threads refused what threads.plan says");
  note(can_recorder_ != nullptr ? can_recorder_->lost_lines() : 0, "frames are missing in can.log: the disk was slow");
  note(gpio_recorder_ != nullptr ? gpio_recorder_->lost_lines() : 0,
       "edges are missing in gpio.log: the disk was slow");
  return notes;
}

}  // namespace g3d
