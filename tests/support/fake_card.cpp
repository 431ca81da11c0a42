// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_card.hpp"

#include <cstdlib>
#include <filesystem>

namespace g3d::test {
namespace {

constexpr const char* kSearchPath = "LD_LIBRARY_PATH";
constexpr const char* kDriver = "libcuda.so.1";

}  // namespace

FakeCard::FakeCard(FakeDriver driver) {
  if (const char* path = std::getenv(kSearchPath)) former_path_ = path;
  const std::string link = folder_ / kDriver;
  if (driver == FakeDriver::works) {
    // The build puts it beside the test program.
    const auto built = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "fake_cuda" / kDriver;
    std::filesystem::create_symlink(built, link);
  } else if (driver == FakeDriver::lacks_functions) {
    for (const char* library : {"/lib/x86_64-linux-gnu/libm.so.6", "/lib/aarch64-linux-gnu/libm.so.6"}) {
      if (std::filesystem::exists(library)) std::filesystem::create_symlink(library, link);
    }
  } else {
    write_plain(link, std::string_view("this is no library"));
  }
  setenv(kSearchPath, folder_.path().c_str(), 1);
}

FakeCard::~FakeCard() {
  if (former_path_.empty()) {
    unsetenv(kSearchPath);
  } else {
    setenv(kSearchPath, former_path_.c_str(), 1);
  }
  unsetenv("FAKE_CUDA_BYTES");
  unsetenv("FAKE_CUDA_CANNOT_MAP");
  unsetenv("FAKE_CUDA_NO_SHARES");
}

}  // namespace g3d::test
