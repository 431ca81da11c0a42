// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/mounts.hpp"

#include <errno.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {
namespace {

struct KernelMount {
  const char* what;
  const char* folder;
  unsigned long flags;
  const char* options;
};
constexpr std::array<KernelMount, 6> kKernelMounts = {{
    {"devtmpfs", "/dev", MS_NOSUID, "mode=0755"},
    {"proc", "/proc", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr},
    {"sysfs", "/sys", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr},
    {"tmpfs", "/run", MS_NOSUID | MS_NODEV, "mode=0755,size=32m"},
    {"devpts", "/dev/pts", MS_NOSUID | MS_NOEXEC, "mode=0620"},
    {"tmpfs", "/dev/shm", MS_NOSUID | MS_NODEV, "mode=1777"},
}};

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

Result<void> mount_kernel_filesystems() {
  for (const KernelMount& one : kKernelMounts) {
    (void)::mkdir(one.folder, 0755);
    if (::mount(one.what, one.folder, one.what, one.flags, one.options) != 0 && errno != EBUSY) {
      return system_error(one.folder, "cannot be mounted", errno);
    }
  }
  return {};
}

std::string value_in(std::string_view lines, std::string_view key) {
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    const std::string_view line = lines.substr(0, end);
    if (line.size() > key.size() && line.starts_with(key) && line[key.size()] == '=') {
      return std::string(line.substr(key.size() + 1));
    }
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return {};
}

std::optional<std::string> find_partition(std::string_view name, const std::string& block_folder) {
  std::error_code code;
  std::optional<std::string> found;
  for (std::filesystem::directory_iterator entry(block_folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string lines = text_of((entry->path() / "uevent").string());
    if (value_in(lines, "PARTNAME") != name) continue;
    const std::string device = "/dev/" + value_in(lines, "DEVNAME");
    // Of two disks with such a partition the first by name, at every start the same.
    if (!found || device < *found) found = device;
  }
  return found;
}

Result<void> mount_ext4(const std::string& device, const std::string& folder, MountAs as) {
  (void)::mkdir(folder.c_str(), 0755);
  unsigned long flags = MS_NOSUID | MS_NODEV | MS_NOATIME;
  if (as == MountAs::read_only) flags |= MS_RDONLY;
  if (::mount(device.c_str(), folder.c_str(), "ext4", flags, as == MountAs::read_only ? "" : "errors=remount-ro") !=
      0) {
    return system_error(device, "cannot be mounted at " + folder, errno);
  }
  return {};
}

void leave(const std::string& folder) { (void)::umount2(folder.c_str(), MNT_DETACH); }

Result<void> end_writing(const std::string& folder) {
  ::sync();
  if (::mount(nullptr, folder.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) != 0) {
    return system_error(folder, "cannot be made read-only", errno);
  }
  return {};
}

void link_virtio_ports() {
  std::error_code code;
  const std::filesystem::path ports = "/sys/class/virtio-ports";
  for (std::filesystem::directory_iterator entry(ports, code), end; !code && entry != end; entry.increment(code)) {
    std::string name = text_of((entry->path() / "name").string());
    name.resize(std::min(name.find('\n'), name.size()));
    if (name.empty() || name.find('/') != std::string::npos) continue;
    (void)::mkdir("/dev/virtio-ports", 0755);
    (void)::symlink(("../" + entry->path().filename().string()).c_str(), ("/dev/virtio-ports/" + name).c_str());
  }
}

std::string kernel_option(std::string_view command_line, std::string_view name) {
  std::istringstream words{std::string(command_line)};
  for (std::string word; words >> word;) {
    if (word.size() > name.size() && word.starts_with(name) && word[name.size()] == '=') {
      return word.substr(name.size() + 1);
    }
  }
  return {};
}

}  // namespace g3d::hal::boot
