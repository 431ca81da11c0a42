// SPDX-License-Identifier: Apache-2.0
// Writes JSON (RFC 8259), two spaces deep, in the order in which it is told. Cold paths only: it allocates.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace g3d::mapper {

/// Text in double quotes; control characters, quotes and backslashes escaped, bytes that are not UTF-8 replaced by
/// U+FFFD.
[[nodiscard]] std::string json_quoted(std::string_view text);

class JsonWriter {
 public:
  JsonWriter& begin_object() { return open('{'); }
  JsonWriter& end_object() { return close('}'); }
  JsonWriter& begin_array() { return open('['); }
  JsonWriter& end_array() { return close(']'); }
  JsonWriter& key(std::string_view name);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(double number);  ///< shortest digits that read back the same; null where JSON has no such number
  template <std::integral T>
  JsonWriter& value(T number) {
    if constexpr (std::same_as<T, bool>) {
      return raw(number ? "true" : "false");
    } else {
      return raw(std::to_string(number));
    }
  }
  template <typename T>
  JsonWriter& member(std::string_view name, const T& content) {
    return key(name).value(content);
  }

  /// The finished text with a final newline. Precondition: everything that was opened is closed.
  [[nodiscard]] std::string take();

 private:
  JsonWriter& open(char bracket);
  JsonWriter& close(char bracket);
  JsonWriter& raw(std::string_view text);
  void separate();

  std::string text_;
  std::vector<bool> has_content_;  ///< one per open bracket
  bool after_key_ = false;
};

}  // namespace g3d::mapper
