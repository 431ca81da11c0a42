// SPDX-License-Identifier: Apache-2.0
// `g3dmap key` as a user types it: make, show, rotate, finish, shut out, revoke; and what it refuses.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string key_line(const std::string& file) {
  const std::string text = read_plain(file);
  const std::size_t at = text.find("\nkey ");
  REQUIRE(at != std::string::npos);
  return text.substr(at + 5, 64);
}

TEST_CASE("a fleet's key is made, shown, rotated and finished, and never printed", "[system][key]") {
  const TempFolder folder;
  const std::string file = folder / "fleet.key";
  std::string all_output;
  const auto key = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"key"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramResult result = run_g3dmap(all);
    INFO(result.err);
    CHECK(result.exit_code == 0);
    all_output += result.out + result.err;
    return result.out;
  };
  const std::string made = key({"--out", file});
  CHECK(contains(made, "epoch 1 "));
  struct stat info {};
  REQUIRE(::stat(file.c_str(), &info) == 0);
  CHECK((info.st_mode & 07777) == 0600);
  CHECK(key({"--show", file}) == made);
  const std::string first = key_line(file);

  const std::string rotated = key({"--rotate", file});
  CHECK(contains(rotated, "epoch 2 "));
  CHECK(contains(rotated, "epoch 1 is still heard"));
  CHECK(contains(read_plain(file), "previous " + first));
  const std::string second = key_line(file);
  CHECK_FALSE(contains(key({"--finish", file}), "still heard"));
  CHECK(key_line(file) == second);

  CHECK(contains(key({"--revoke", "c0ffee", file}), "revoked 0000000000c0ffee"));
  const std::string dropped = key({"--drop", "bad", file});
  CHECK(contains(dropped, "revoked 0000000000000bad"));
  CHECK(contains(dropped, "dropped 0000000000000bad"));
  const std::string shut = key({"--rotate", "--shut-out", file});
  CHECK(contains(shut, "epoch 3 "));
  CHECK(contains(shut, "revoked 0000000000c0ffee"));
  CHECK_FALSE(contains(shut, "still heard"));
  const std::string text = read_plain(file);
  CHECK_FALSE(contains(text, first));
  CHECK_FALSE(contains(text, second));
  for (const std::string& secret : {first, second, key_line(file)})
    CHECK_FALSE(contains(all_output, secret.substr(0, 8)));
  CHECK(folder.listing() == "fleet.key\n");
}

TEST_CASE("what would lose or betray a fleet's key is refused", "[system][key]") {
  const TempFolder folder;
  const std::string file = folder / "fleet.key";
  REQUIRE(run_g3dmap({"key", "--out", file}).exit_code == 0);
  const std::string before = read_plain(file);
  const ProgramResult again = run_g3dmap({"key", "--out", file});
  CHECK(again.exit_code == 1);
  CHECK(contains(again.err, "is there already"));
  REQUIRE(::chmod(file.c_str(), 0644) == 0);
  const ProgramResult open = run_g3dmap({"key", "--show", file});
  CHECK(open.exit_code == 1);
  CHECK(contains(open.err, "chmod 600"));
  CHECK(run_g3dmap({"key", "--rotate", file}).exit_code == 1);
  REQUIRE(::chmod(file.c_str(), 0600) == 0);
  CHECK(read_plain(file) == before);
  REQUIRE(run_g3dmap({"key", "--rotate", file}).exit_code == 0);
  const ProgramResult twice = run_g3dmap({"key", "--rotate", file});
  CHECK(twice.exit_code == 1);
  CHECK(contains(twice.err, "--finish"));
  CHECK(run_g3dmap({"key", "--show", folder / "none"}).exit_code == 1);
}

TEST_CASE("bad usage of the key is exit code 2", "[system][key][usage]") {
  const std::vector<std::vector<std::string>> cases{{},
                                                    {"f"},
                                                    {"--rotate"},
                                                    {"--show", "--rotate", "f"},
                                                    {"--shut-out", "f"},
                                                    {"--out", "a", "b"},
                                                    {"--revoke", "xyz", "f"},
                                                    {"--drop", "xyz", "f"},
                                                    {"--drop", "1", "--revoke", "1", "f"},
                                                    {"--revoke", "12345678901234567", "f"}};
  for (const auto& arguments : cases) {
    std::vector<std::string> all{"key"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramResult result = run_g3dmap(all);
    INFO((arguments.empty() ? "no arguments" : arguments.back()));
    CHECK(result.exit_code == 2);
    CHECK_FALSE(result.err.empty());
  }
}

}  // namespace
