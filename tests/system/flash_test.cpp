// SPDX-License-Identifier: Apache-2.0
// scripts/flash and scripts/install-service as a user types them, against folders that look like NVIDIA's and like a
// root file system. That flash.sh and a TX2 then do what is expected is not shown here.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/fake_l4t.hpp"

using namespace g3d::test;
using Catch::Contains;

namespace {

std::vector<std::string> with(std::vector<std::string> all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace

TEST_CASE("a TX2 is flashed from its user's own Linux_for_Tegra", "[system][flash]") {
  const FakeL4t fake;
  const std::string tegra = "/rootfs/usr/lib/aarch64-linux-gnu/tegra/";
  fake.put(tegra + "libcuda.so.1.1", "not an ELF file\n");
  fake.put("/rootfs/lib/firmware/gp10b/gpmu_ucode.bin", "firmware\n");
  fake.tool(fake.project() + "/build/host/g3dmap", "echo \"$*\" >\"$3\"\n");
  const ProgramResult result = fake.run("scripts/flash", fake.flash_arguments());
  INFO(result.err << result.out);
  REQUIRE(result.exit_code == 0);
  const std::string out = fake.folder / "out";
  CHECK_THAT(result.out, Contains("image: --program " + fake.program() + " --kernel " + fake.l4t() + "/kernel/Image"));
  CHECK_THAT(result.out, Contains("--load ftdi_sio --board"));
  CHECK_THAT(result.out, Contains("--gpu " + out + "/gpu"));
  CHECK_THAT(result.out, Contains("note: 4.9.253-tegra has no mttcan"));
  CHECK_THAT(result.out, Contains("flash.sh: -c bootloader/t186ref/cfg/flash_g3dmap_t186.xml -R " + out +
                                  "/boot -K kernel/Image -I " + out +
                                  "/initrd.img -S 512MiB jetson-tx2 mmcblk0p1\nin " + fake.l4t() + "\n"));
  const std::string config = read_plain(fake.l4t() + "/bootloader/t186ref/cfg/flash_g3dmap_t186.xml");
  std::size_t at = 0;
  for (const char* part : {"\"APP\"", "\"system-a\"", "<size> 7 </size>", "g3dmap_system.img", "\"system-b\"",
                           "\"data\"", "<size> 16777216 </size>", "g3dmap_data.img", "\"UDA\""}) {
    at = config.find(part, at);
    INFO(part << " in " << config);
    REQUIRE(at != std::string::npos);
  }
  CHECK(read_plain(fake.l4t() + "/bootloader/g3dmap_system.img") == "system\n");
  CHECK(std::filesystem::file_size(fake.l4t() + "/bootloader/g3dmap_data.img") == 16U << 20);
  for (const char* file : {"extlinux.conf", "choose.conf"}) {
    CHECK(read_plain(out + "/boot/boot/extlinux/" + file) ==
          "LABEL g3dmap\n  LINUX /boot/Image\n  INITRD /boot/initrd\n");
  }
  CHECK(read_plain(out + "/boot/boot/initrd") == "initrd\n");
  CHECK(read_plain(out + "/data/slots.state") ==
        "slots --state " + out + "/data/slots.state --first " + out + "/system.img\n");
  CHECK(read_plain(out + "/gpu/lib/libcuda.so.1") == "not an ELF file\n");
  for (const char* name : {"ld-linux-aarch64.so.1", "libc.so.6", "libdl.so.2"}) {
    CHECK(std::filesystem::exists(out + "/gpu/lib/" + name));
  }
  CHECK(read_plain(out + "/gpu/firmware/gp10b/gpmu_ucode.bin") == "firmware\n");
}

TEST_CASE("a dry run prints the same steps and does none", "[system][flash]") {
  const FakeL4t fake;
  fake.tool(fake.folder / "bin/id", "echo 1000\n");
  fake.tool(fake.folder / "bin/lsusb", "exit 1\n");
  std::filesystem::remove(fake.program());
  const ProgramResult result = fake.run("scripts/flash", with(fake.flash_arguments(), {"--dry-run"}));
  INFO(result.err << result.out);
  CHECK(result.exit_code == 0);
  for (const char* part : {"not yet: ", "use sudo", "hold REC", "builds it", "+ make_data", "+ make_boot",
                           "+ make_config", "+ run_flash -c", "no libcuda", "nothing was done"}) {
    CHECK_THAT(result.out, Contains(part));
  }
  CHECK_FALSE(std::filesystem::exists(fake.folder.path() + "/out"));
  CHECK_FALSE(std::filesystem::exists(fake.l4t() + "/bootloader/g3dmap_data.img"));
}

TEST_CASE("whatever is missing for flashing is said at once, and nothing is done", "[system][flash]") {
  const FakeL4t fake;
  fake.tool(fake.folder / "bin/id", "echo 1000\n");
  fake.tool(fake.folder / "bin/lsusb", "exit 1\n");
  fake.put("/rootfs/etc/nv_tegra_release", "# R35 (release)\n");
  fake.put("/bootloader/t186ref/cfg/flash_l4t_t186.xml", "<device/>\n");
  std::filesystem::remove(fake.l4t() + "/kernel/Image");
  write_plain(fake.program(), "#!/bin/sh\n");
  const ProgramResult result = fake.run("scripts/flash", with(fake.flash_arguments(), {"--update-key", fake.board()}));
  CHECK(result.exit_code == 1);
  CHECK(result.out.empty());
  for (const char* part : {"kernel/Image: is not there; unpack", "is not L4T r32", "has no partition APP",
                           "is no 64-bit Arm program", "not the public half", "use sudo", "hold REC"}) {
    CHECK_THAT(result.err, Contains(part));
  }
  CHECK(fake.run("scripts/flash", {"--dry-run", fake.folder / "none", "--board", fake.board()}).exit_code == 1);
  CHECK(fake.run("scripts/flash", {}).exit_code == 2);
  CHECK(fake.run("scripts/flash", {fake.l4t()}).exit_code == 2);
  CHECK(fake.run("scripts/flash", {"--nonsense"}).exit_code == 2);
  CHECK(fake.run("scripts/flash", {"--update", "10.0.0.2"}).exit_code == 2);
  CHECK(fake.run("scripts/flash", {"--help"}).exit_code == 0);
}

TEST_CASE("a robot that runs is updated by the same script", "[system][flash]") {
  const FakeL4t fake;
  const std::string key = fake.folder / "owner.key", image = fake.folder / "system.img";
  write_plain(key, "k");
  write_plain(image, "i");
  const std::vector<std::string> all{"--update",  "10.0.0.2", "--signing-key", key, "--image", image,
                                     "--release", "7",        "--dry-run"};
  ProgramResult result = fake.run("scripts/flash", all);
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, Contains("type make"));
  fake.tool(fake.project() + "/build/host/g3dmap", "echo \"g3dmap: $*\"\n");
  result = fake.run("scripts/flash", {all.begin(), all.end() - 1});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, Contains("g3dmap: update --key " + key + " --to 10.0.0.2 --release 7 " + image));
}

TEST_CASE("the service is installed into a root file system, and removed from it", "[system][service]") {
  const FakeL4t fake;
  const std::string root = fake.l4t() + "/rootfs";
  const std::vector<std::string> all{"--root", root, "--board", fake.board(), "--program", fake.program()};
  ProgramResult result = fake.run("scripts/install-service", with(all, {"--dry-run"}));
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_FALSE(std::filesystem::exists(root + "/usr/local/bin/g3dmap"));
  const std::string printed = result.out;
  result = fake.run("scripts/install-service", all);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(result.out == printed);
  CHECK(read_plain(root + "/usr/local/bin/g3dmap") == read_plain(fake.program()));
  CHECK(read_plain(root + "/etc/g3dmap/board.toml") == "# a board\n");
  CHECK(std::filesystem::read_symlink(root + "/etc/systemd/system/multi-user.target.wants/g3dmap.service") ==
        "/etc/systemd/system/g3dmap.service");
  CHECK_THAT(read_plain(root + "/etc/systemd/system/g3dmap.service"),
             Contains("Type=notify") && Contains("WatchdogSec="));
  CHECK_THAT(read_plain(root + "/etc/udev/rules.d/60-g3dmap.rules"), Contains("02ae"));

  write_plain(fake.board(), "# another board\n");
  CHECK(fake.run("scripts/install-service", all).exit_code == 0);
  CHECK(read_plain(root + "/etc/g3dmap/board.toml.old") == "# a board\n");
  CHECK(fake.run("scripts/install-service", {"--root", root, "--remove"}).exit_code == 0);
  CHECK_FALSE(std::filesystem::exists(root + "/etc/systemd/system/g3dmap.service"));
  CHECK(read_plain(root + "/etc/g3dmap/board.toml") == "# another board\n");

  CHECK_THAT(fake.run("scripts/install-service", {"--root", root, "--program", fake.program()}).err,
             Contains("which robot is this?"));
  CHECK_THAT(fake.run("scripts/install-service", {"--root", fake.folder / "none", "--board", fake.board()}).err,
             Contains("is no root file system") && Contains("type make"));
  CHECK(fake.run("scripts/install-service", {"--nonsense"}).exit_code == 2);
}

TEST_CASE("systemd finds nothing wrong with the unit", "[system][service]") {
  const std::string analyze = "/usr/bin/systemd-analyze";
  if (!std::filesystem::exists(analyze)) {
    WARN("no systemd-analyze here: the unit was not looked at");
    return;
  }
  const TempFolder folder;
  std::string unit = read_plain(checkout() / "board/g3dmap.service");
  const std::string program = "/usr/local/bin/g3dmap";
  REQUIRE(unit.find(program) != std::string::npos);
  unit.replace(unit.find(program), program.size(), "/bin/true");
  write_plain(folder / "g3dmap.service", unit);
  const ProgramResult result = Program(analyze, {"verify", "--man=no", folder / "g3dmap.service"}).finish();
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(result.err.find("g3dmap.service") == std::string::npos);
}
