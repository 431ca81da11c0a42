// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/init_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

// As in board_file.cpp: version 3.3 asserts what it then reports as an error.
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "hal/image/file_bytes.hpp"
#include "hal/linux/ipv4_endpoint.hpp"

namespace g3d::hal::boot {
namespace {

constexpr std::size_t kMostConfig_bytes = 64U << 10;
constexpr std::size_t kMostArguments = 64;
constexpr std::size_t kMostArgument_bytes = 256;
constexpr std::size_t kMostHostName_bytes = 32;
constexpr std::size_t kMostInterface_bytes = 15;  // IFNAMSIZ without its end

bool is_name(std::string_view text) {
  const auto is_fit = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  };
  return !text.empty() && text.size() <= kMostHostName_bytes && text.front() != '-' && text.back() != '-' &&
         std::all_of(text.begin(), text.end(), is_fit);
}

bool is_interface(std::string_view text) {
  return !text.empty() && text.size() <= kMostInterface_bytes &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 0x7F && c != '/'; });
}

std::optional<FixedAddress> parse_fixed(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto ipv4 = parse_ipv4(text.substr(0, slash));
  const std::string_view bits = text.substr(slash + 1);
  FixedAddress address;
  const auto [end, code] = std::from_chars(bits.data(), bits.data() + bits.size(), address.prefix_bits);
  if (!ipv4 || code != std::errc{} || end != bits.data() + bits.size()) return std::nullopt;
  if (address.prefix_bits < 1 || address.prefix_bits > 30) return std::nullopt;
  address.ipv4 = *ipv4;
  return address;
}

/// Reads the fields of one file, and remembers the first thing that is wrong with it.
class Reader {
 public:
  Reader(std::string_view file, InitConfig& config) : file_(file), config_(config) {}

  void read(const toml::table& root) {
    for (const auto& [key, node] : root) {
      const std::string_view name = key.str();
      if (name == "name") {
        text(
            node, "name", [&](const std::string& v) { return is_name(v) && (config_.name = v, true); },
            "letters, digits and '-', at most 32");
      } else if (const toml::table* table = node.as_table()) {
        read_table(name, *table, node);
      } else {
        fail(node,
             fmt::format("'{}' is no key of init.toml; name, [robot], [network] and [watchdog] are", shown(name)));
      }
    }
  }
  [[nodiscard]] Result<void> result() const {
    if (error_) return *error_;
    return {};
  }

 private:
  static std::string shown(std::string_view text) { return std::string(text.substr(0, 40)); }

  void fail(const toml::node& node, const std::string& what) {
    if (!error_) error_ = Error{Reason::malformed, fmt::format("{}:{}: {}", file_, node.source().begin.line, what)};
  }

  template <typename Take>
  void text(const toml::node& node, std::string_view name, const Take& take, std::string_view allowed) {
    const auto value = node.value_exact<std::string>();
    if (!value || !take(*value)) fail(node, fmt::format("{} must be {}, in quotes", name, allowed));
  }

  void whole(const toml::node& node, std::string_view name, int low, int high, int& member) {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < low || *value > high) {
      fail(node, fmt::format("{} must be a whole number from {} to {}", name, low, high));
    } else {
      member = static_cast<int>(*value);
    }
  }

  void read_arguments(const toml::node& node) {
    const toml::array* list = node.as_array();
    std::vector<std::string> arguments;
    for (std::size_t i = 0; list != nullptr && i < list->size() && i <= kMostArguments; ++i) {
      const auto one = list->get(i)->value_exact<std::string>();
      const bool is_plain = one && one->size() <= kMostArgument_bytes && one->find('\0') == std::string::npos;
      arguments.push_back(is_plain ? *one : "");
    }
    const bool has_empty = std::find(arguments.begin(), arguments.end(), "") != arguments.end();
    if (arguments.empty() || arguments.size() > kMostArguments || has_empty) {
      fail(node, "robot.arguments must be 1 to 64 texts in quotes, each of 1 to 256 bytes");
    } else {
      config_.arguments = std::move(arguments);
    }
  }

  void read_when_done(const toml::node& node) {
    constexpr std::array<std::string_view, 3> kNames = {"stay", "again", "power_off"};
    text(
        node, "robot.when_done",
        [&](const std::string& v) {
          const auto* const found = std::find(kNames.begin(), kNames.end(), v);
          if (found == kNames.end()) return false;
          config_.when_done = static_cast<WhenDone>(found - kNames.begin());
          return true;
        },
        "stay, again or power_off");
  }

  void read_network(std::string_view key, const toml::node& node) {
    if (key == "interface") {
      text(
          node, "network.interface",
          [&](const std::string& v) { return is_interface(v) && (config_.interface = v, true); },
          "auto, none, or the name of a network card");
    } else if (key == "address") {
      text(
          node, "network.address",
          [&](const std::string& v) {
            config_.address = parse_fixed(v);
            return config_.address || v == "link-local";
          },
          "link-local, or as 10.0.0.2/24");
    } else if (key == "gateway") {
      text(
          node, "network.gateway",
          [&](const std::string& v) {
            config_.gateway = parse_ipv4(v);
            return config_.gateway || v == "none";
          },
          "none, or as 10.0.0.1");
    } else if (key == "can_virtual") {
      const auto value = node.value_exact<bool>();
      if (!value) return fail(node, "network.can_virtual must be true or false");
      config_.can_virtual = *value;
    } else {
      unknown("network", key, node);
    }
  }

  void unknown(std::string_view table, std::string_view key, const toml::node& node) {
    fail(node, fmt::format("[{}] has no key '{}'", shown(table), shown(key)));
  }

  void read_table(std::string_view name, const toml::table& table, const toml::node& at) {
    if (name != "robot" && name != "network" && name != "watchdog") {
      return fail(at, fmt::format("there is no table [{}]; [robot], [network] and [watchdog] are", shown(name)));
    }
    for (const auto& [toml_key, node] : table) {
      const std::string_view key = toml_key.str();
      if (name == "network") {
        read_network(key, node);
      } else if (name == "watchdog") {
        if (key != "timeout_s") return unknown(name, key, node);
        whole(node, "watchdog.timeout_s", 2, 60, config_.watchdog_s);
      } else if (key == "arguments") {
        read_arguments(node);
      } else if (key == "when_done") {
        read_when_done(node);
      } else if (key == "silent_ms") {
        whole(node, "robot.silent_ms", 200, 30'000, config_.silent_ms);
      } else if (key == "start_s") {
        whole(node, "robot.start_s", 5, 600, config_.start_s);
      } else if (key == "prove_s") {
        whole(node, "robot.prove_s", 1, 3600, config_.prove_s);
      } else {
        unknown(name, key, node);
      }
    }
  }

  std::string_view file_;
  InitConfig& config_;
  std::optional<Error> error_;
};

}  // namespace

std::string ipv4_text(std::uint32_t ipv4) {
  return fmt::format("{}.{}.{}.{}", ipv4 >> 24U, ipv4 >> 16U & 0xFFU, ipv4 >> 8U & 0xFFU, ipv4 & 0xFFU);
}

Result<InitConfig> parse_init_config(std::string_view text, std::string_view file) {
  // toml++ 3.3 runs into undefined behaviour on some characters between words.
  const auto odd = std::find_if(text.begin(), text.end(),
                                [](char c) { return (c < 0x20 && c != '\n' && c != '\r' && c != '\t') || c == 0x7F; });
  if (odd != text.end()) {
    return Error{Reason::malformed,
                 fmt::format("{}:{}: byte 0x{:02X}; this file is plain ASCII, its comments too", file,
                             1 + std::count(text.begin(), odd, '\n'), static_cast<unsigned char>(*odd))};
  }
  const toml::parse_result parsed = toml::parse(text, file);
  if (!parsed) {
    return Error{Reason::malformed, fmt::format("{}:{}: {}", file, parsed.error().source().begin.line,
                                                std::string_view(parsed.error().description()))};
  }
  InitConfig config;
  Reader reader(file, config);
  reader.read(parsed.table());
  if (const auto read = reader.result(); !read) return read.error();
  return config;
}

Result<InitConfig> load_init_config(const std::string& path) {
  const auto text = read_text_file(path, kMostConfig_bytes);
  if (!text) return text.error();
  return parse_init_config(text.value(), path);
}

}  // namespace g3d::hal::boot
