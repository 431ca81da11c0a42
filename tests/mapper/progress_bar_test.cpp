// SPDX-License-Identifier: Apache-2.0
#include "mapper/progress_bar.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

using namespace g3d::mapper;

namespace {

/// What was printed to a temporary file.
class Printed {
 public:
  Printed() : file_(std::tmpfile()) { REQUIRE(file_ != nullptr); }
  ~Printed() { std::fclose(file_); }
  Printed(const Printed&) = delete;
  Printed& operator=(const Printed&) = delete;
  std::FILE* file() { return file_; }
  std::string text() {
    std::rewind(file_);
    std::string all;
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) all += static_cast<char>(c);
    return all;
  }

 private:
  std::FILE* file_;
};

}  // namespace

TEST_CASE("progress text says frames, rate and drops", "[mapper][progress]") {
  CHECK(progress_text({50, 48, 2}, 200, 61.25, ProgressStyle::plain) == "50/200 frames  61.2/s  2 dropped");
  CHECK(progress_text({50, 50, 0}, std::nullopt, 30.0, ProgressStyle::terminal) == "50 frames  30.0/s");
  const std::string bar = progress_text({100, 100, 0}, 200, 10.0, ProgressStyle::terminal);
  CHECK(std::count(bar.begin(), bar.end(), '#') == 15);
  CHECK(std::count(bar.begin(), bar.end(), '-') == 15);
  // More frames than announced: the bar stays full.
  const std::string over = progress_text({300, 300, 0}, 200, 10.0, ProgressStyle::terminal);
  CHECK(std::count(over.begin(), over.end(), '#') == 30);
}

TEST_CASE("a log gets a line every five seconds, quiet gets none", "[mapper][progress]") {
  Printed plain, quiet;
  ProgressBar bar(plain.file(), ProgressStyle::plain, 1000);
  ProgressBar silent(quiet.file(), ProgressStyle::quiet, 1000);
  for (std::uint64_t i = 0; i <= 110; ++i) {  // eleven seconds, ten calls each
    const auto now_ns = static_cast<std::int64_t>(i) * 100'000'000;
    bar.update({i * 3, i * 3, 0}, now_ns);
    silent.update({i * 3, i * 3, 0}, now_ns);
  }
  bar.finish({330, 330, 0}, 11'000'000'000);
  silent.finish({330, 330, 0}, 11'000'000'000);
  CHECK(plain.text() == "150/1000 frames  30.0/s\n300/1000 frames  30.0/s\n330/1000 frames  30.0/s\n");
  CHECK(quiet.text().empty());
}

TEST_CASE("a terminal line is drawn over itself and ends with a new line", "[mapper][progress]") {
  Printed printed;
  ProgressBar bar(printed.file(), ProgressStyle::terminal, std::nullopt);
  bar.update({1000, 1000, 7}, 0);
  bar.finish({1001, 1001, 0}, 1'000'000'000);
  const std::string text = printed.text();
  CHECK(text.front() == '\r');
  CHECK(text.back() == '\n');
  CHECK(std::count(text.begin(), text.end(), '\r') == 2);
  CHECK(text.find("1001 frames  1001.0/s        ") != std::string::npos);  // the longer line before is wiped
}
