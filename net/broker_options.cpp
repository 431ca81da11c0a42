// SPDX-License-Identifier: Apache-2.0
#include "net/broker_options.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "hal/image/atomic_file.hpp"
#include "hal/linux/ipv4_endpoint.hpp"
#include "net/secret_key.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::size_t kMostLoginFile_bytes = 4096;

/// The whole of a small file that its owner alone may read.
hal::Result<std::string> read_login_text(int fd, const std::string& path) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return hal::system_error(path, "cannot read", errno);
  if (!S_ISREG(status.st_mode)) {
    return Error{Reason::unsupported, fmt::format("{}: is not a regular file; give the path of a login", path)};
  }
  if ((status.st_mode & 0077) != 0) {
    return Error{Reason::no_permission,
                 fmt::format("{}: others may read or change this login (mode {:04o}); chmod 600 {}", path,
                             status.st_mode & 07777, path)};
  }
  std::string text;
  text.reserve(kMostLoginFile_bytes + 1);
  std::array<char, 512> some;
  for (;;) {
    const ssize_t n = ::read(fd, some.data(), some.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return hal::system_error(path, "cannot read", errno);
    if (n == 0) return text;
    text.append(some.data(), static_cast<std::size_t>(n));
    if (text.size() > kMostLoginFile_bytes) {
      return Error{Reason::too_large,
                   fmt::format("{}: has more than {} bytes, which no login has; is it the right file?", path,
                               kMostLoginFile_bytes)};
    }
  }
}

/// What MQTT takes for a text.
bool is_plain_text(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

hal::Result<BrokerLogin> parse_broker_login(std::string_view text, const std::string& name) {
  BrokerLogin login;
  const auto wrong = [&](std::size_t line, std::string_view what) {
    return Error{Reason::malformed,
                 fmt::format("{}:{}: {}; it has the lines 'user NAME' and 'password WORD'", name, line, what)};
  };
  std::size_t line_number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, space), value = line.substr(std::min(space + 1, line.size()));
    if (word != "user" && word != "password") return wrong(line_number, "begins with neither user nor password");
    std::string& to = word == "user" ? login.user : login.password;
    if (!to.empty()) return wrong(line_number, fmt::format("{} stands here a second time", word));
    if (value.empty() || !is_plain_text(value)) {
      return wrong(line_number, fmt::format("{} is not of printable ASCII characters", word));
    }
    to = value;
  }
  if (login.user.empty() || login.password.empty()) {
    return wrong(line_number, fmt::format("has no {}", login.user.empty() ? "user" : "password"));
  }
  return login;
}

hal::Result<BrokerLogin> read_broker_login(const std::string& path) {
  // O_NONBLOCK: a named pipe in place of the file must not stop the reader.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  hal::Result<std::string> text = read_login_text(fd, path);
  ::close(fd);
  if (!text) return text.error();
  hal::Result<BrokerLogin> login = parse_broker_login(text.value(), path);
  wipe_text(text.value());
  return login;
}

hal::Result<MqttPortOptions> broker_options(const BrokerWords& words, RobotId robot) {
  const auto endpoint = hal::parse_ipv4_endpoint(words.address);
  if (!endpoint) {
    return Error{
        Reason::malformed,
        fmt::format("broker '{}' is not ADDRESS:PORT in numbers; write it like 192.0.2.7:1883", words.address)};
  }
  if (!is_topic_root(words.topic)) {
    return Error{Reason::malformed,
                 fmt::format("broker_topic '{}' is no root of topics; write names of letters, digits, "
                             "'-', '_' and '.', with '/' between them",
                             words.topic)};
  }
  MqttPortOptions options;
  const std::string text = hal::to_string(*endpoint);
  options.host = text.substr(0, text.find(':'));
  options.port = endpoint->port;
  options.root = words.topic;
  options.site = site_of(robot);
  if (words.login != "none") {
    hal::Result<BrokerLogin> login = read_broker_login(words.login);
    if (!login) return login.error();
    options.user = login.value().user;
    options.password = login.value().password;
  }
  return options;
}

}  // namespace g3d::net
