// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/child_process.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <catch2/catch.hpp>

using namespace g3d::hal::boot;

namespace {

struct Ran {
  ProcessEnd end;
  std::vector<std::string> lines;
};

Ran run_shell(const std::string& script, const std::string& program = "/bin/sh") {
  ChildProcess child;
  REQUIRE(child.start({program, {"-c", script}, {"WORD=given"}}).ok());
  CHECK(child.is_running());
  int status = 0;
  Ran ran;
  const auto take = [&](std::string_view line) { ran.lines.emplace_back(line); };
  while (::waitpid(child.pid(), &status, WNOHANG) == 0) child.read_lines(take);
  child.on_end(take);
  CHECK_FALSE(child.is_running());
  CHECK(child.output_fd() == -1);
  ran.end = end_of(status).value();
  return ran;
}

}  // namespace

TEST_CASE("what a child says comes line by line, with its end", "[boot]") {
  const Ran ran = run_shell("echo one $WORD $HOME; echo two >&2; printf 'a\\rb\\033'; exit 3");
  CHECK(ran.lines == std::vector<std::string>{"one given", "two", "a", "b?"});
  CHECK(ran.end.exit_code == 3);
  CHECK_FALSE(ran.end.is_good());
  CHECK(to_text(ran.end) == "exit code 3");
}

TEST_CASE("a child that is killed, or that cannot be executed, is told from one that ends well", "[boot]") {
  const Ran killed = run_shell("kill -9 $$");
  CHECK(killed.end.signal == 9);
  CHECK(to_text(killed.end) == "signal 9 (Killed)");
  CHECK(run_shell("", "/no/such/program").end.exit_code == 127);
  CHECK(run_shell("exit 0").end.is_good());
}

TEST_CASE("a line without an end is handed over in pieces", "[boot]") {
  const Ran ran = run_shell("printf %02500d 0");
  REQUIRE(ran.lines.size() == 3);
  CHECK(ran.lines[0].size() == 1000);
  CHECK(ran.lines[2].size() == 500);
}

TEST_CASE("a child reads what is typed for it, and the end of it when its parent goes", "[boot]") {
  std::vector<std::string> lines;
  const auto take = [&](std::string_view line) { lines.emplace_back(line); };
  ChildProcess child;
  REQUIRE(child.start({"/bin/sh", {"-c", "read a; echo got $a; read b; echo got $b"}, {}}).ok());
  child.type("one");
  child.type("two words");
  int status = 0;
  REQUIRE(::waitpid(child.pid(), &status, 0) > 0);
  child.on_end(take);
  child.type("to nobody");
  CHECK(lines == std::vector<std::string>{"got one", "got two words"});
}
