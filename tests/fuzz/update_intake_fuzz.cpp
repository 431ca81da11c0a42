// SPDX-License-Identifier: Apache-2.0
// Whatever a sender sends, with the right key or without: the machine never claims that something is installed which
// the key's holder has not signed, never starts what is half written, and holds no more than it may. The first byte
// says how far the input is honest: a proof and a manifest are made for it where random bytes would never find one.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "net/update_intake.hpp"
#include "net/update_offer.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;

struct Place {
  Place() {
    std::string pattern = "/tmp/g3dmap-fuzz-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    path = pattern;
  }
  ~Place() { std::filesystem::remove_all(path); }
  std::string path;
};

void feed(UpdateIntake& intake, std::span<const std::uint8_t>& bytes) {
  for (int idle = 0; idle < 2 && intake.phase() != UpdateIntake::Phase::over;) {
    if (intake.says().size() > 2 * kGreeting_bytes + 2048 * kWord_bytes) std::abort();
    const auto wants = intake.wants();
    if (wants.size() > kMostManifest_bytes) std::abort();
    const std::size_t count = std::min(wants.size(), bytes.size());
    std::copy_n(bytes.begin(), count, wants.begin());
    bytes = bytes.subspan(count);
    intake.took(count);
    const bool worked = intake.step(0);
    idle = worked || count > 0 ? 0 : idle + 1;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 2) return 0;
  static const Place place;
  static const SigningKey key = SigningKey::random();
  const std::uint8_t honesty = data[0] % 4;
  std::span<const std::uint8_t> bytes(data + 1, size_bytes - 1);
  hal::SlotStore store(place.path + "/slots");
  (void)store.change([](const hal::SlotBook&) -> hal::Result<hal::SlotBook> { return hal::first_book({5, 0, {}}); });
  UpdateTarget target({place.path + "/slots", {place.path + "/a", place.path + "/b"}, hal::Slot::a});
  UpdateIntake intake(key.update_key(), target, {1}, 1e12);
  GreetingBytes greeting;
  std::copy_n(intake.says().begin(), greeting.size(), greeting.begin());

  UpdateManifest manifest;
  mapper::Bytes opening;
  if (honesty == 1) {
    // The proof is right, and what it is for comes from the input.
    UpdateProof proof;
    proof.manifest_bytes = static_cast<std::uint32_t>(bytes.size());
    proof.manifest_digest = digest_of(bytes);
    proof.force = data[0] > 127;
    const ProofBytes signed_proof = encode_proof(proof, greeting, key);
    opening.assign(signed_proof.begin(), signed_proof.end());
  } else if (honesty >= 2) {
    // So is the manifest, and the chunks come from the input.
    const std::size_t image_bytes = std::min<std::size_t>(bytes.size(), 1000);
    manifest.image = {6, image_bytes, digest_of(bytes.first(image_bytes))};
    manifest.chunks = {digest_of(bytes.first(image_bytes))};
    UpdateOffer offer(manifest, key, false);
    if (!offer.take_greeting(greeting)) std::abort();
    opening = offer.opening();
    if (honesty == 3) opening.insert(opening.end(), 4, 0);  // the chunk's number, so that it is what was promised
  }
  std::span<const std::uint8_t> first(opening);
  if (!opening.empty()) feed(intake, first);
  feed(intake, bytes);

  const auto book = store.read();
  if (!book) std::abort();
  const bool installed = intake.end() == UpdateEnd::installed;
  if (installed != (book.value()[hal::Slot::b].condition == hal::SlotCondition::untried)) std::abort();
  if (installed && honesty != 3 && honesty != 2) std::abort();
  if (installed && !hal::check_slot_image(place.path + "/b", book.value()[hal::Slot::b].image)) std::abort();
  if (!installed && hal::plan_start(book.value())->slot != hal::Slot::a) std::abort();
  return 0;
}
