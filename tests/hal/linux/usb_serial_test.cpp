// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/usb_serial.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::find_usb_serial;
using hal::Reason;

namespace {

// A sysfs tree as the kernel builds it: the port is a folder below the interface below the device, and the bus has
// links.
struct SysTree {
  test::TempFolder root;

  void add(const std::string& port, const std::string& where, const std::string& product, const std::string& serial,
           const std::string& latency = "1\n") {
    const std::string device = "devices/pci0000:00/usb1/" + where;
    test::write_plain(root / (device + "/idVendor"), "0403\n");
    if (!product.empty()) test::write_plain(root / (device + "/product"), product + "\n");
    if (!serial.empty()) test::write_plain(root / (device + "/serial"), serial + "\n");
    const std::string folder = device + "/" + where + ":1.0/" + port;
    test::write_plain(root / (folder + "/latency_timer"), latency);
    const std::string link = root / ("bus/usb-serial/devices/" + port);
    std::filesystem::create_directories(std::filesystem::path(link).parent_path());
    std::filesystem::create_symlink(root.path() + "/" + folder, link);
  }
};

}  // namespace

TEST_CASE("The base is found by its product string") {
  SysTree sys;
  sys.add("ttyUSB0", "1-1", "FT232R USB UART", "A1B2C3");
  sys.add("ttyUSB1", "1-2", "iClebo Kobuki", "");
  const auto found = find_usb_serial({}, sys.root.path(), "/dev");
  REQUIRE(found.ok());
  CHECK(found.value().path == "/dev/ttyUSB1");
  CHECK(found.value().product == "iClebo Kobuki");
  CHECK(found.value().latency_timer_ms == 1);
}

TEST_CASE("The base is found by how its serial string begins") {
  SysTree sys;
  sys.add("ttyUSB3", "1-1", "FT232R USB UART", "kobuki_AH02F6OQ", "16\n");
  sys.add("ttyUSB4", "1-2", "FT232R USB UART", "my_kobuki");
  const auto found = find_usb_serial({}, sys.root.path(), "/somewhere");
  REQUIRE(found.ok());
  CHECK(found.value().path == "/somewhere/ttyUSB3");
  CHECK(found.value().serial == "kobuki_AH02F6OQ");
  CHECK(found.value().latency_timer_ms == 16);
}

TEST_CASE("None there, or none that fits, says what is there") {
  SysTree sys;
  const auto empty = find_usb_serial({}, sys.root.path());
  REQUIRE_FALSE(empty.ok());
  CHECK(empty.error().reason == Reason::not_found);
  CHECK(empty.error().text.find("there are: none") != std::string::npos);
  sys.add("ttyUSB0", "1-1", "GPS receiver", "7");
  const auto other = find_usb_serial({}, sys.root.path());
  REQUIRE_FALSE(other.ok());
  CHECK(other.error().reason == Reason::not_found);
  CHECK(other.error().text.find("GPS receiver") != std::string::npos);
}

TEST_CASE("Two bases are told apart by the whole serial string") {
  SysTree sys;
  sys.add("ttyUSB0", "1-1", "iClebo Kobuki", "kobuki_1");
  sys.add("ttyUSB1", "1-2", "iClebo Kobuki", "kobuki_2");
  const auto both = find_usb_serial({}, sys.root.path());
  REQUIRE_FALSE(both.ok());
  CHECK(both.error().reason == Reason::bad_usage);
  CHECK(both.error().text.find("kobuki_2") != std::string::npos);
  const auto second = find_usb_serial({"", "kobuki_2"}, sys.root.path());
  REQUIRE(second.ok());
  CHECK(second.value().path == "/dev/ttyUSB1");
}

TEST_CASE("Strings of strange devices are kept harmless") {
  SysTree sys;
  sys.add("ttyUSB0", "1-1", std::string(5000, 'x') + "iClebo Kobuki", "\x1b[31mred", "soon\n");
  const auto none = find_usb_serial({}, sys.root.path());
  REQUIRE_FALSE(none.ok());
  CHECK(none.error().text.find('\x1b') == std::string::npos);
  CHECK(none.error().text.size() < 1000);
  const auto red = find_usb_serial({"", "?[31mred"}, sys.root.path());
  REQUIRE(red.ok());
  CHECK(red.value().latency_timer_ms == -1);
}

TEST_CASE("An empty match fits nothing, and a dangling link is passed over") {
  SysTree sys;
  sys.add("ttyUSB0", "1-1", "", "");
  std::filesystem::create_symlink("/nonexistent/port", sys.root / "bus/usb-serial/devices/ttyUSB9");
  CHECK_FALSE(find_usb_serial({"", ""}, sys.root.path()).ok());
}
