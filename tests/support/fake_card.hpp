// SPDX-License-Identifier: Apache-2.0
// Which driver a helper process finds while an object of this lives: one without a card behind it (tests/fake_cuda), a
// library that is none, one that lacks its functions.
#pragma once

#include <string>

#include "tests/support/temp_folder.hpp"

namespace g3d::test {

enum class FakeDriver { works, not_there, lacks_functions };

class FakeCard {
 public:
  explicit FakeCard(FakeDriver driver);
  ~FakeCard();
  FakeCard(const FakeCard&) = delete;
  FakeCard& operator=(const FakeCard&) = delete;

 private:
  TempFolder folder_;
  std::string former_path_;
};

}  // namespace g3d::test
