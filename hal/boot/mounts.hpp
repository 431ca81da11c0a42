// SPDX-License-Identifier: Apache-2.0
// File systems of a machine whose first process this program is: the kernel's own, and partitions found by the names
// that the partition table gives them. One thread; blocks on the disk.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal::boot {

/// /proc, /sys, /dev (with pts and shm), /run. One that is there already is left. Errors: io_error, of the first that
/// failed.
[[nodiscard]] Result<void> mount_kernel_filesystems();

/// "/dev/vda4" for the partition of that name; nothing if there is none (yet). `block_folder`: /sys/class/block.
[[nodiscard]] std::optional<std::string> find_partition(std::string_view name,
                                                        const std::string& block_folder = "/sys/class/block");
/// The value of KEY in a file of lines KEY=VALUE, as /sys has them: "uevent".
[[nodiscard]] std::string value_in(std::string_view lines, std::string_view key);

enum class MountAs { read_only, writable };
/// ext4; its journal makes good what a power cut left. The folder is made. Errors: not_found, io_error.
[[nodiscard]] Result<void> mount_ext4(const std::string& device, const std::string& folder, MountAs as);
void leave(const std::string& folder);
/// Everything that can be written is written, and nothing is writable any more. Errors: io_error; the data are synced
/// all the same.
[[nodiscard]] Result<void> end_writing(const std::string& folder);

/// /dev/virtio-ports/NAME for every port of that name, as udev makes them.
void link_virtio_ports();

/// The word behind `name=` on the kernel's command line; empty: it is not there.
[[nodiscard]] std::string kernel_option(std::string_view command_line, std::string_view name);

}  // namespace g3d::hal::boot
