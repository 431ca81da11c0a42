// SPDX-License-Identifier: Apache-2.0
// A Linux_for_Tegra as scripts/flash needs to find it, a copy of the scripts beside it, and tools in front of the real
// ones: nothing of NVIDIA's, and no TX2.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::test {

/// Of the checkout that this was built from.
[[nodiscard]] inline std::filesystem::path checkout() {
  return std::filesystem::weakly_canonical(std::filesystem::path(__FILE__).parent_path() / "../..");
}

class FakeL4t {
 public:
  FakeL4t() {
    namespace fs = std::filesystem;
    fs::create_directories(project() + "/scripts");
    fs::create_directories(project() + "/board");
    for (const char* script :
         {"scripts/flash", "scripts/install-service", "board/g3dmap.service", "board/60-g3dmap.rules"}) {
      fs::copy_file(checkout() / script, project() + "/" + script);
    }
    write_plain(project() + "/README.md", "read me\n");
    // Says how it was called, and leaves what the real one leaves.
    tool(project() + "/scripts/image",
         "case ${1:-} in --help) echo '  --gpu FOLDER'; exit 0 ;; esac\n"
         "echo \"image: $*\"\n"
         "while [ $# -gt 0 ]; do [ \"$1\" != --out ] || out=$2; shift; done\n"
         "mkdir -p \"$out\"; echo system >\"$out/system.img\"; echo initrd >\"$out/initrd.img\"\n"
         "for file in extlinux choose; do\n"
         "  printf 'LABEL g3dmap\\n  LINUX /Image\\n  INITRD /initrd.img\\n' >\"$out/$file.conf\"\n"
         "done\n");
    tool(folder / "bin/id", "echo 0\n");
    tool(folder / "bin/lsusb", "exit 0\n");
    tool(folder / "bin/python3", "exit 0\n");
    tool(folder / "bin/modprobe", "exit 0\n");
    if (!fs::exists("/sbin/mke2fs") && !fs::exists("/usr/sbin/mke2fs")) {
      // `mke2fs ... FILE SIZE`: a file of that size will do here.
      tool(folder / "bin/mke2fs", "while [ $# -gt 2 ]; do shift; done; truncate -s \"$2\" \"$1\"\n");
    }
    tool(l4t() + "/flash.sh", "echo \"flash.sh: $*\"; echo \"in $(pwd)\"\n");
    for (const char* file :
         {"/jetson-tx2.conf", "/kernel/Image", "/rootfs/lib/modules/4.9.253-tegra/modules.builtin"}) {
      put(file, "x\n");
    }
    put("/rootfs/lib/modules/4.9.253-tegra/modules.dep",
        "kernel/drivers/usb/serial/ftdi_sio.ko: kernel/usbserial.ko\n");
    for (const char* library :
         {"ld-linux-aarch64.so.1", "aarch64-linux-gnu/libc.so.6", "aarch64-linux-gnu/libdl.so.2"}) {
      put(std::string("/rootfs/lib/") + library, "not an ELF file\n");
    }
    put("/rootfs/etc/nv_tegra_release", "# R32 (release), REVISION: 7.1, GCID: 1, BOARD: t186ref\n");
    put("/bootloader/t186ref/cfg/flash_l4t_t186.xml",
        "<device type=\"sdmmc\">\n  <partition name=\"APP\" id=\"1\" type=\"data\">\n    <size> APPSIZE </size>\n"
        "  </partition>\n  <partition name=\"UDA\" type=\"data\">\n  </partition>\n</device>\n");
    std::string elf(64, '\0');
    elf.replace(0, 5,
                "\x7f"
                "ELF\x02");
    elf[18] = static_cast<char>(0xB7);
    write_plain(program(), elf);
    write_plain(board(), "# a board\n");
  }

  [[nodiscard]] std::string project() const { return folder / "project"; }
  [[nodiscard]] std::string l4t() const { return folder / "Linux_for_Tegra"; }
  [[nodiscard]] std::string program() const { return folder / "g3dmap-aarch64"; }
  [[nodiscard]] std::string board() const { return folder / "robot.toml"; }
  void put(const std::string& file, const std::string& text) const {
    const std::string path = l4t() + file;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    write_plain(path, text);
  }
  static void tool(const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    write_plain(path, "#!/bin/sh\n" + text);
    REQUIRE(::chmod(path.c_str(), 0755) == 0);
  }
  /// A script of the copy, with the tools in front.
  [[nodiscard]] ProgramResult run(const std::string& script, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"-u", "G3DMAP_EXE", "PATH=" + (folder / "bin") + ":/usr/sbin:/usr/bin:/sbin:/bin",
                                 project() + "/" + script};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return Program("/usr/bin/env", all).finish();
  }
  [[nodiscard]] std::vector<std::string> flash_arguments() const {
    return {l4t(), "--board", board(), "--program", program(), "--data", "16", "--out", folder / "out"};
  }

  TempFolder folder;
};

}  // namespace g3d::test
