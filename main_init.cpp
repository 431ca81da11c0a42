// SPDX-License-Identifier: Apache-2.0
#include "main_init.hpp"

#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/reboot.h>
#include <linux/watchdog.h>
#include <signal.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/reboot.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

#include "hal/boot/kernel_modules.hpp"
#include "hal/boot/kernel_setting.hpp"
#include "hal/boot/large_pages.hpp"
#include "hal/boot/machine_id.hpp"
#include "hal/boot/mounts.hpp"
#include "hal/boot/network_card.hpp"
#include "hal/boot/slot_image.hpp"
#include "hal/boot/wall_clock.hpp"
#include "hal/image/file_bytes.hpp"
#include "mapper/version.hpp"
#include "net/fleet_key.hpp"
#include "net/fleet_key_file.hpp"

namespace g3d {
namespace init {
namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
constexpr hal::TimeNs kDiskWait_ns = 10 * kSecond_ns;  // an eMMC or USB disk that shows up late
constexpr hal::TimeNs kLook_ns = 20'000'000;
constexpr std::size_t kMostList_bytes = 64U << 10;
constexpr int kFirstWatchdog_s = 60;  // until the configuration is read

void load_kernel_modules(Machine& machine) {
  const auto list = hal::read_text_file("/modules/list", kMostList_bytes);
  if (!list) return machine.speaker.say("no kernel modules in this image");
  const auto modules = hal::boot::parse_module_list(list.value());
  const hal::boot::ModulesLoaded loaded = hal::boot::load_modules("/modules", modules);
  machine.speaker.say(fmt::format("{} of {} kernel modules loaded", loaded.loaded, modules.size()));
  for (const std::string& failure : loaded.failures) machine.speaker.say("module " + failure);
}

void mount_data(Machine& machine, const hal::Clock& clock) {
  const hal::TimeNs until_ns = clock.now() + kDiskWait_ns;
  auto device = hal::boot::find_partition("data");
  while (!device && clock.now() < until_ns) {
    timespec look{0, kLook_ns};
    ::nanosleep(&look, nullptr);
    machine.watchdog.feed();
    device = hal::boot::find_partition("data");
  }
  if (!device) {
    machine.speaker.say("no partition is called data: nothing survives this run");
  } else if (const auto mounted = hal::boot::mount_ext4(*device, "/data", hal::boot::MountAs::writable); !mounted) {
    machine.speaker.say(mounted.error().text + "; nothing survives this run");
  } else {
    machine.has_data = true;
  }
  if (!machine.has_data) (void)::mkdir("/data", 0755);
  if (const auto opened = machine.speaker.open_log("/data/log"); !opened) machine.speaker.say(opened.error().text);
}

void set_clock(Machine& machine) {
  struct stat built {};
  (void)::stat("/init", &built);
  const std::int64_t now_s = ::time(nullptr);
  const std::int64_t time_s =
      hal::boot::believable_time_s(now_s, hal::boot::read_saved_time_s(kClockFile), built.st_mtim.tv_sec);
  if (time_s == now_s) return;
  timespec time{};
  time.tv_sec = time_s;
  const bool is_set = ::clock_settime(CLOCK_REALTIME, &time) == 0;
  machine.speaker.say(
      fmt::format("the clock was {} s behind what is known{}", time_s - now_s, is_set ? ", and was set" : ""));
}

/// Mounts the slot that the book names, or the other one; without either the program of the initramfs has to do.
void mount_system(Machine& machine, const std::string& forced) {
  machine.slot_a = hal::boot::find_partition("system-a").value_or("");
  machine.slot_b = hal::boot::find_partition("system-b").value_or("");
  hal::SlotStore store(kSlotBook);
  hal::UnusableSlots unusable;
  const auto path_of = [&](hal::Slot slot) { return slot == hal::Slot::a ? machine.slot_a : machine.slot_b; };
  const auto mount_one = [&](hal::Slot slot) -> hal::Result<void> {
    auto mounted = hal::boot::mount_ext4(path_of(slot), "/system", hal::boot::MountAs::read_only);
    if (!mounted) return mounted;
    if (::access("/system/g3dmap", X_OK) == 0) return {};
    hal::boot::leave("/system");
    return hal::Error{hal::Reason::not_found, path_of(slot) + ": has no program g3dmap"};
  };
  if (forced == "a" || forced == "b") {
    const hal::Slot slot = forced == "a" ? hal::Slot::a : hal::Slot::b;
    const auto mounted = mount_one(slot);
    if (mounted) machine.slot = slot;
    if (!mounted) machine.speaker.say(mounted.error().text);
  }
  while (!machine.slot) {
    const hal::SlotChoice choice = hal::choose_slot(store, unusable);
    if (!choice.trouble.empty()) machine.speaker.say(choice.trouble);
    if (choice.given_up) {
      machine.speaker.say(fmt::format("system {} did not come up: back to the other one", to_string(*choice.given_up)));
    }
    if (!choice.slot) break;
    const auto book = store.read();
    const hal::SlotEntry entry = book ? book.value()[*choice.slot] : hal::SlotEntry{};
    hal::Result<void> usable;
    // One that was good once is known to be what was written; looking at every byte of it takes time at every start.
    if (entry.condition != hal::SlotCondition::good) {
      usable = hal::check_slot_image(path_of(*choice.slot), entry.image, [&] { machine.watchdog.feed(); });
    }
    if (usable) usable = mount_one(*choice.slot);
    if (!usable) {
      machine.speaker.say(usable.error().text);
      (void)store.change(
          [&](hal::SlotBook b) { return hal::Result<hal::SlotBook>(hal::cannot_start(b, *choice.slot)); });
      unusable.add(*choice.slot);
      continue;
    }
    machine.slot = choice.slot;
    machine.is_on_trial = entry.condition != hal::SlotCondition::good;
  }
  if (!machine.slot) return machine.speaker.say("neither system can be used: what the boot image carries runs");
  machine.program = "/system/g3dmap";
  machine.speaker.say(fmt::format("system {}{}", to_string(*machine.slot), machine.is_on_trial ? ", on trial" : ""));
}

/// The BSP's GPU libraries lie in the system slot. The helper's interpreter and the kernel look for theirs under /lib.
void link_gpu_libraries() {
  if (::access("/system/gpu/lib", F_OK) != 0) return;
  (void)::symlink("/system/gpu/lib", "/lib");
  (void)hal::boot::set_kernel("/sys/module/firmware_class/parameters/path", "/system/gpu/firmware");
}

/// A robot that has no fleet's key yet is a fleet of its own: what it has mapped is kept for it, as for others.
void make_key(Machine& machine) {
  const std::vector<std::string>& arguments = machine.config.arguments;
  const auto found = std::find(arguments.begin(), arguments.end(), "--key");
  if (found == arguments.end() || found + 1 == arguments.end() || ::access((found + 1)->c_str(), F_OK) == 0) return;
  const net::FleetKey keys = net::generate_fleet_key();
  const auto written = net::write_fleet_key(*(found + 1), keys);
  machine.speaker.say(written ? fmt::format("{}: a new key, fingerprint {}", *(found + 1), keys.key.fingerprint())
                              : written.error().text);
}

/// The robot's own, then the system's, then the boot image's; one that is wrong is said, and the next one taken.
void read_config(Machine& machine) {
  for (const char* path : {"/data/init.toml", "/system/init.toml", "/init.toml"}) {
    if (::access(path, F_OK) != 0) continue;
    auto config = hal::boot::load_init_config(path);
    if (config) {
      machine.config = std::move(config).value();
      return machine.speaker.say(fmt::format("told by {}", path));
    }
    machine.speaker.say(config.error().text);
  }
}

}  // namespace

void Speaker::say(std::string_view line) { pass_on("init", line); }

void Speaker::pass_on(std::string_view who, std::string_view line) {
  const std::string text =
      fmt::format("[{:9.3f}] {}: {}", static_cast<double>(clock_.now()) / static_cast<double>(kSecond_ns), who, line);
  is_early_ ? early_.push_back(text) : log_.write(text);
  const std::string console = text + "\r\n";
  (void)!::write(STDOUT_FILENO, console.data(), console.size());
}

hal::Result<void> Speaker::open_log(const std::string& folder) {
  auto opened = log_.open(folder);
  is_early_ = false;
  for (const std::string& line : early_) log_.write(line);
  early_.clear();
  return opened;
}

std::string HardwareWatchdog::open(int timeout_s) {
  fd_ = ::open("/dev/watchdog", O_WRONLY | O_CLOEXEC);
  if (fd_ < 0) return "no hardware watchdog";
  int status = 0;
  has_bitten_ = ::ioctl(fd_, WDIOC_GETBOOTSTATUS, &status) == 0 && (status & WDIOF_CARDRESET) != 0;
  set_timeout(timeout_s);
  watchdog_info info{};
  (void)::ioctl(fd_, WDIOC_GETSUPPORT, &info);
  return fmt::format("hardware watchdog: {}{}", reinterpret_cast<const char*>(info.identity),
                     has_bitten_ ? "; it has caused this start" : "");
}

void HardwareWatchdog::set_timeout(int timeout_s) {
  if (fd_ >= 0) (void)::ioctl(fd_, WDIOC_SETTIMEOUT, &timeout_s);
  feed();
}

void HardwareWatchdog::feed() {
  if (fd_ >= 0) (void)::ioctl(fd_, WDIOC_KEEPALIVE, nullptr);
}

void start_machine(Machine& machine, const hal::Clock& clock) {
  (void)::setenv("PATH", "/system", 1);
  const auto mounted = hal::boot::mount_kernel_filesystems();
  machine.speaker.say(fmt::format("g3dmap {} is the first process", mapper::version()));
  if (!mounted) machine.speaker.say(mounted.error().text);
  (void)hal::boot::allow_large_pages();
  load_kernel_modules(machine);
  machine.speaker.say(machine.watchdog.open(kFirstWatchdog_s));
  mount_data(machine, clock);
  set_clock(machine);
  // Without a line of that name the answer is empty.
  const auto command_line = hal::read_text_file("/proc/cmdline", kMostList_bytes);
  mount_system(machine, command_line ? hal::boot::kernel_option(command_line.value(), "g3d.slot") : "");
  read_config(machine);
  machine.watchdog.set_timeout(machine.config.watchdog_s);
  hal::boot::link_virtio_ports();
  (void)::sethostname(machine.config.name.data(), machine.config.name.size());
  (void)hal::boot::switch_on("lo");
  if (const auto named = hal::boot::keep_machine_id("/data/machine-id", "/etc/machine-id"); !named) {
    machine.speaker.say(named.error().text);
  }
  link_gpu_libraries();
  make_key(machine);
  if (machine.config.can_virtual) {
    auto made = hal::boot::make_virtual_can("vcan0");
    if (made) made = hal::boot::switch_on("vcan0");
    if (!made) machine.speaker.say(made.error().text);
  }
}

}  // namespace init

bool is_first_process(std::string_view program) {
  return ::getpid() == 1 && program.substr(program.rfind('/') + 1) == "init";
}

int run_init() {
  hal::RealClock clock;
  init::Machine machine(clock);
  init::start_machine(machine, clock);
  init::Supervisor::End end{};
  {
    init::Supervisor supervisor(machine, clock);
    end = supervisor.run();
  }
  machine.speaker.say(end == init::Supervisor::End::reboot ? "the machine starts anew" : "the machine is switched off");
  machine.watchdog.feed();  // for the last time: it ends what hangs from here on
  ::kill(-1, SIGKILL);
  while (::waitpid(-1, nullptr, 0) > 0 || errno == EINTR) {
  }
  if (machine.has_data) {
    machine.speaker.close_log();
    if (const auto ended = hal::boot::end_writing("/data"); !ended) machine.speaker.say(ended.error().text);
  }
  ::sync();
  (void)::reboot(end == init::Supervisor::End::reboot ? LINUX_REBOOT_CMD_RESTART : LINUX_REBOOT_CMD_POWER_OFF);
  for (;;) ::pause();
}

}  // namespace g3d
