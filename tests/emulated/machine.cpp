// SPDX-License-Identifier: Apache-2.0
#include "tests/emulated/machine.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <array>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>

namespace g3d::test {
namespace {

constexpr const char* kQemu = "/usr/bin/qemu-system-aarch64";
constexpr const char* kUBoot = "/usr/lib/u-boot/qemu_arm64/u-boot.bin";

int dial(const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::strncpy(name.sun_path, path.c_str(), sizeof name.sun_path - 1);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0) return fd;
    ::close(fd);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  throw std::runtime_error("QEMU does not answer at " + path);
}

/// Up to the first line with one of these words; what came otherwise is in front of it.
std::string read_answer(int fd, const std::vector<std::string>& ends) {
  std::string text;
  char buffer[512];
  timeval limit{20, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  for (;;) {
    for (const std::string& end : ends) {
      const std::size_t at = text.find(end);
      if (at != std::string::npos && text.find('\n', at) != std::string::npos) return text;
    }
    const ssize_t size = ::read(fd, buffer, sizeof buffer);
    if (size <= 0) return text;
    text.append(buffer, static_cast<std::size_t>(size));
  }
}

}  // namespace

std::string Machine::what_is_missing() {
  for (const char* file : {kQemu, kUBoot}) {
    if (!std::filesystem::exists(file)) return std::string(file) + " is not there; scripts/setup emulated installs it";
  }
  return {};
}

Machine::Machine(MachineOptions options) : options_(std::move(options)) {}

Machine::~Machine() { cut_power(); }

void Machine::power_on() {
  const std::string console = folder_ / "console", qmp = folder_ / "qmp";
  for (const std::string& socket : {console, qmp}) std::filesystem::remove(socket);
  std::vector<std::string> arguments = {
      "-M",
      "virt,acpi=off",
      "-cpu",
      "cortex-a57",
      "-smp",
      "2",
      "-m",
      "512",
      "-display",
      "none",
      "-bios",
      kUBoot,
      "-action",
      "watchdog=reset",
      "-drive",
      "if=none,id=disk,format=raw,file=" + options_.disk,
      "-device",
      "virtio-blk-pci,drive=disk",
      "-chardev",
      fmt::format("socket,id=console,path={},server=on,wait=off,logfile={},logappend=on", console, folder_ / "log"),
      "-serial",
      "chardev:console",
      "-qmp",
      "unix:" + qmp + ",server=on,wait=off",
      "-device",
      "i6300esb",
      "-device",
      "qemu-xhci"};
  const auto add = [&](std::initializer_list<std::string> more) { arguments.insert(arguments.end(), more); };
  if (!options_.base_socket.empty()) {
    std::filesystem::remove(options_.base_socket);
    add({"-chardev", "socket,id=base,server=on,wait=off,path=" + options_.base_socket, "-device",
         "usb-serial,chardev=base,id=kobuki,serial=kobuki_emulated"});
  }
  if (!options_.camera_socket.empty()) {
    add({"-chardev", "socket,id=camera,reconnect=1,path=" + options_.camera_socket, "-device", "virtio-serial-pci",
         "-device", "virtserialport,chardev=camera,name=g3d.camera"});
  }
  if (options_.netdev.empty()) {
    add({"-nic", "none"});
  } else {
    arguments.insert(arguments.end(), options_.netdev.begin(), options_.netdev.end());
    add({"-device", fmt::format("virtio-net-pci,netdev=net,romfile=,mac=52:54:00:67:33:{:02x}", options_.number)});
  }
  qemu_ = std::make_unique<Program>(kQemu, arguments);
  console_fd_ = dial(console);
  // What the log has already: but who is connected and does not read stops the machine after some hundred characters.
  reader_ = std::thread([fd = console_fd_] {
    std::array<char, 4096> shown;
    while (::recv(fd, shown.data(), shown.size(), 0) > 0) {
    }
  });
}

void Machine::cut_power() {
  qemu_.reset();  // kills it
  if (console_fd_ < 0) return;
  ::shutdown(console_fd_, SHUT_RDWR);
  reader_.join();
  ::close(console_fd_);
  console_fd_ = -1;
}

bool Machine::is_on() { return qemu_ != nullptr && qemu_->is_running(); }

std::string Machine::console(std::size_t from) const {
  std::error_code code;
  if (!std::filesystem::exists(folder_.path() + "/log", code)) return {};
  const std::string text = read_plain(folder_.path() + "/log");
  return text.substr(std::min(from, text.size()));
}

std::optional<std::string> Machine::await(const std::string& text, std::chrono::seconds limit, std::size_t from) const {
  const auto end = std::chrono::steady_clock::now() + limit;
  for (;;) {
    const std::string shown = console(from);
    const std::size_t at = shown.find(text);
    if (at != std::string::npos) {
      const std::size_t line_end = shown.find_first_of("\r\n", at);
      if (line_end != std::string::npos) {
        const std::size_t begin = shown.find_last_of("\r\n", at);
        return shown.substr(begin == std::string::npos ? 0 : begin + 1,
                            line_end - (begin == std::string::npos ? 0 : begin + 1));
      }
    }
    if (std::chrono::steady_clock::now() >= end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

void Machine::type(const std::string& line) {
  const std::string text = line + "\n";
  if (::send(console_fd_, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("the console does not take '" + line + "'");
  }
}

std::string Machine::ask_qemu(const std::string& command) {
  const int fd = dial(folder_ / "qmp");
  (void)read_answer(fd, {"\"QMP\""});
  const auto say = [&](const std::string& text) {
    (void)!::write(fd, text.data(), text.size());
    return read_answer(fd, {"\"return\"", "\"error\""});
  };
  (void)say("{\"execute\": \"qmp_capabilities\"}\n");
  const std::string answer = say(command + "\n");
  ::close(fd);
  return answer;
}

bool Machine::unplug_base() {
  return ask_qemu(R"({"execute": "device_del", "arguments": {"id": "kobuki"}})").find("\"return\"") !=
         std::string::npos;
}

bool Machine::plug_base() {
  return ask_qemu(
             R"({"execute": "device_add", "arguments": {"driver": "usb-serial", "chardev": "base", "id": "kobuki", )"
             R"("serial": "kobuki_emulated"}})")
             .find("\"return\"") != std::string::npos;
}

bool Machine::pulse_gpio() {
  return ask_qemu(R"({"execute": "system_powerdown"})").find("\"return\"") != std::string::npos;
}

double guest_time_s(const std::string& line) {
  const std::size_t bracket = line.find('[');
  return bracket == std::string::npos ? -1.0 : std::strtod(line.c_str() + bracket + 1, nullptr);
}

}  // namespace g3d::test
