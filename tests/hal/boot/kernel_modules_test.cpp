// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/kernel_modules.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("a list of modules is read in its order, and nothing leads out of its folder", "[boot]") {
  const auto modules =
      parse_module_list("# first\nusb-common.ko\n\nftdi_sio.ko debug=1 x=2 \n../evil.ko\nnot_a_module\nlast.ko");
  REQUIRE(modules.size() == 3);
  CHECK(modules[0] == ModuleLine{"usb-common.ko", ""});
  CHECK(modules[1] == ModuleLine{"ftdi_sio.ko", "debug=1 x=2"});
  CHECK(modules[2] == ModuleLine{"last.ko", ""});
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "m.ko\n";
  CHECK(parse_module_list(many).size() == 256);
}

TEST_CASE("modules that cannot be loaded are told, one by one", "[boot]") {
  const test::TempFolder folder;
  test::write_plain(folder / "broken.ko", "no module");
  const ModulesLoaded loaded = load_modules(folder.path(), {{"missing.ko", ""}, {"broken.ko", ""}});
  CHECK(loaded.loaded == 0);
  REQUIRE(loaded.failures.size() == 2);
  CHECK(loaded.failures[0].find("missing.ko: ") == 0);
  CHECK(loaded.failures[1].find("broken.ko: ") == 0);
}
