// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/mdns_answer.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace g3d::hal::boot {
namespace {

constexpr std::size_t kHeader_bytes = 12;
constexpr int kMostQuestions = 16;
constexpr std::size_t kMostDnsName_bytes = 255;
constexpr std::uint16_t kTypeA = 1, kTypeAny = 255, kClassIn = 1, kClassAny = 255;
constexpr std::uint16_t kTopBit = 0x8000;   // of a question's class: answer me alone; of a record's: ours alone
constexpr std::uint32_t kLife_s = 120;      // section 10: of records with a host's address
constexpr std::uint32_t kPlainLife_s = 10;  // section 6.7

std::uint16_t get16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}

char lower(std::uint8_t c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); }

/// The name at `at`, in small letters with a dot behind each part; `at` moves behind it.
std::optional<std::string> read_name(std::span<const std::uint8_t> bytes, std::size_t& at) {
  std::string name;
  std::size_t from = at;
  bool has_jumped = false;
  for (;;) {
    if (from >= bytes.size()) return std::nullopt;
    const std::size_t length = bytes[from];
    if (length == 0) {
      if (!has_jumped) at = from + 1;
      return name;
    }
    if ((length & 0xC0U) == 0xC0U) {
      if (from + 1 >= bytes.size()) return std::nullopt;
      const std::size_t to = (length & 0x3FU) << 8U | bytes[from + 1];
      if (!has_jumped) at = from + 2;
      has_jumped = true;
      if (to >= from) return std::nullopt;  // only backwards: so it ends
      from = to;
      continue;
    }
    if (length > 63 || from + 1 + length > bytes.size() || name.size() + length + 1 > kMostDnsName_bytes)
      return std::nullopt;
    for (std::size_t i = 1; i <= length; ++i) name += lower(bytes[from + i]);
    name += '.';
    from += length + 1;
  }
}

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : out_(out) {}
  void put(std::uint32_t value, std::size_t bytes) {
    for (std::size_t i = bytes; i-- > 0;) byte(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void name(std::string_view host) {
    for (const std::string_view part : {host, std::string_view("local")}) {
      byte(static_cast<std::uint8_t>(part.size()));
      for (const char c : part) byte(static_cast<std::uint8_t>(c));
    }
    byte(0);
  }
  void address(const MdnsHost& host, bool is_plain) {
    name(host.name);
    put(kTypeA, 2);
    put(is_plain ? kClassIn : kClassIn | kTopBit, 2);
    put(is_plain ? kPlainLife_s : kLife_s, 4);
    put(4, 2);
    put(host.ipv4, 4);
  }
  [[nodiscard]] std::size_t size() const { return fits_ ? at_ : 0; }

 private:
  void byte(std::uint8_t value) {
    fits_ = fits_ && at_ < out_.size();
    if (fits_) out_[at_++] = value;
  }
  std::span<std::uint8_t> out_;
  std::size_t at_ = 0;
  bool fits_ = true;
};

}  // namespace

MdnsAnswer answer_mdns(std::span<const std::uint8_t> question, bool from_mdns_port, const MdnsHost& host,
                       std::span<std::uint8_t> out) {
  if (question.size() < kHeader_bytes || host.name.empty() || host.name.size() > 63) return {};
  if ((get16(question, 2) & 0xF800U) != 0) return {};  // a response, or no standard query
  const int questions = get16(question, 4);
  if (questions > kMostQuestions) return {};
  std::string own;
  for (const char c : host.name) own += lower(static_cast<std::uint8_t>(c));
  own += ".local.";

  bool is_asked = false, wants_it_alone = true;
  std::uint16_t type = kTypeA;
  std::size_t at = kHeader_bytes;
  for (int i = 0; i < questions; ++i) {
    const auto name = read_name(question, at);
    if (!name || at + 4 > question.size()) return {};
    const std::uint16_t wanted = get16(question, at);
    const std::uint16_t in = get16(question, at + 2);
    at += 4;
    const auto in_class = static_cast<std::uint16_t>(in & ~kTopBit);
    if (*name != own || (wanted != kTypeA && wanted != kTypeAny) || (in_class != kClassIn && in_class != kClassAny)) {
      continue;
    }
    is_asked = true;
    type = wanted;
    wants_it_alone = wants_it_alone && (in & kTopBit) != 0;
  }
  if (!is_asked) return {};
  const bool is_plain = !from_mdns_port;
  Writer writer(out);
  writer.put(is_plain ? get16(question, 0) : 0U, 2);
  writer.put(0x8400, 2);  // a response, and we are who knows
  writer.put(is_plain ? 1 : 0, 2);
  writer.put(1, 2);
  writer.put(0, 4);
  if (is_plain) {
    writer.name(host.name);
    writer.put(type, 2);
    writer.put(kClassIn, 2);
  }
  writer.address(host, is_plain);
  return {writer.size(), is_plain || wants_it_alone};
}

std::size_t announce_mdns(const MdnsHost& host, std::span<std::uint8_t> out) {
  Writer writer(out);
  writer.put(0, 2);
  writer.put(0x8400, 2);
  writer.put(0, 2);
  writer.put(1, 2);
  writer.put(0, 4);
  writer.address(host, false);
  return writer.size();
}

}  // namespace g3d::hal::boot
