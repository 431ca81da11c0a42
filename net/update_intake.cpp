// SPDX-License-Identifier: Apache-2.0
#include "net/update_intake.hpp"

#include <algorithm>
#include <limits>

namespace g3d::net {
namespace {

constexpr std::uint32_t kChunksPerSync = 32;  // 2 MiB: what a power cut costs
constexpr std::uint32_t kChunksPerWord = 16;  // so often a sender that waits hears that something goes on
constexpr hal::TimeNs kNever_ns = std::numeric_limits<hal::TimeNs>::max();

GreetingBytes greeting_of(const UpdateTarget& target, const std::array<std::uint8_t, 32>& nonce) {
  UpdateGreeting greeting = target.standing();
  greeting.nonce = nonce;
  return encode_greeting(greeting);
}

}  // namespace

UpdateIntake::UpdateIntake(const UpdateKey& key, UpdateTarget& target, const std::array<std::uint8_t, 32>& nonce,
                           double rate_Bps)
    : key_(key),
      target_(target),
      greeting_(greeting_of(target, nonce)),
      rate_{rate_Bps / static_cast<double>(kChunk_bytes), static_cast<double>(kMostWanted)},
      in_(kProof_bytes),
      out_(greeting_.begin(), greeting_.end()),
      wait_until_ns_(kNever_ns) {}

std::span<std::uint8_t> UpdateIntake::wants() {
  const bool listens =
      phase_ == Phase::proof || phase_ == Phase::manifest || (phase_ == Phase::receiving && answered_ < asked_);
  return listens ? std::span(in_).subspan(had_bytes_) : std::span<std::uint8_t>{};
}

bool UpdateIntake::waits_for_sender() const {
  return phase_ == Phase::proof || phase_ == Phase::manifest || (phase_ == Phase::receiving && answered_ < asked_);
}

void UpdateIntake::took(std::size_t count) {
  had_bytes_ += count;
  if (count == 0 || had_bytes_ < in_.size()) return;
  had_bytes_ = 0;
  if (phase_ == Phase::proof) return take_proof();
  if (phase_ == Phase::manifest) return take_manifest();
  if (phase_ == Phase::receiving) take_chunk();
}

void UpdateIntake::said(std::size_t count) {
  said_bytes_ += count;
  if (said_bytes_ < out_.size()) return;
  out_.clear();
  said_bytes_ = 0;
}

void UpdateIntake::say(const UpdateWord& word) {
  // Whoever takes no words gets no more of them than these: what a sender that waits must hear is little.
  constexpr std::size_t kMostWaiting_bytes = 1024 * kWord_bytes;
  if (word.kind == UpdateWord::Kind::working && out_.size() >= kMostWaiting_bytes) return;
  const WordBytes bytes = encode_word(word);
  out_.insert(out_.end(), bytes.begin(), bytes.end());
}

void UpdateIntake::finish(UpdateEnd end) {
  if (phase_ == Phase::over) return;
  phase_ = Phase::over;
  end_ = end;
  say({UpdateWord::Kind::end, end, in_place_});
  in_ = {};
  wait_until_ns_ = kNever_ns;
}

void UpdateIntake::end_if(std::optional<UpdateEnd> end) {
  if (end) finish(*end);
}

void UpdateIntake::take_proof() {
  ProofBytes bytes;
  std::copy(in_.begin(), in_.end(), bytes.begin());
  const ProofFault fault = decode_proof(bytes, greeting_, key_, proof_);
  if (fault != ProofFault::none) {
    return finish(fault == ProofFault::wrong_key ? UpdateEnd::wrong_key : UpdateEnd::malformed);
  }
  is_proved_ = true;
  phase_ = Phase::manifest;
  in_.resize(proof_.manifest_bytes);
}

void UpdateIntake::take_manifest() {
  if (digest_of(in_) != proof_.manifest_digest) return finish(UpdateEnd::wrong_chunk);
  if (decode_manifest(in_, manifest_) != ManifestFault::none) return finish(UpdateEnd::malformed);
  if (const auto refused = target_.begin(manifest_.image, proof_.force)) return finish(*refused);
  phase_ = Phase::comparing;
  in_.assign(kChunkHead_bytes + kChunk_bytes, 0);
}

bool UpdateIntake::step(hal::TimeNs now_ns) {
  wait_until_ns_ = kNever_ns;
  if (phase_ == Phase::comparing) {
    compare_one();
    return true;
  }
  if (phase_ == Phase::receiving) ask(now_ns);
  if (phase_ == Phase::reading_back) {
    read_back_one();
    return true;
  }
  return false;
}

void UpdateIntake::compare_one() {
  const std::uint32_t chunk = at_chunk_++;
  const std::span bytes(in_.data(), manifest_.size_of(chunk));
  if (target_.read(manifest_.offset_of(chunk), bytes) && digest_of(bytes) == manifest_.chunks[chunk]) {
    ++in_place_;
  } else {
    missing_.push_back(chunk);
  }
  if (at_chunk_ % kChunksPerWord == 0) say({UpdateWord::Kind::working, {}, in_place_});
  if (at_chunk_ < manifest_.chunks.size()) return;
  at_chunk_ = 0;
  phase_ = Phase::receiving;
}

void UpdateIntake::ask(hal::TimeNs now_ns) {
  if (answered_ == missing_.size()) {
    if (const auto failed = target_.sync()) return finish(*failed);
    crypto_generichash_init(&whole_, nullptr, 0, manifest_.image.digest.size());
    phase_ = Phase::reading_back;
    return;
  }
  while (asked_ < missing_.size() && asked_ - answered_ < kMostWanted) {
    if (!bucket_.take(rate_, now_ns)) {
      wait_until_ns_ = now_ns + std::min(rate_.token_ns(), 1000 * hal::kMillisecond_ns);
      break;
    }
    if (asked_ == answered_) in_.resize(kChunkHead_bytes + manifest_.size_of(missing_[asked_]));
    say({UpdateWord::Kind::want, {}, missing_[asked_++]});
  }
}

void UpdateIntake::take_chunk() {
  const std::uint32_t chunk = missing_[answered_];
  mapper::ByteReader in(in_);
  std::uint32_t said = 0;
  mapper::ByteSpan bytes;
  if (!in.take(said) || said != chunk || !in.take_bytes(in.left(), bytes)) return finish(UpdateEnd::malformed);
  if (digest_of(bytes) != manifest_.chunks[chunk]) return finish(UpdateEnd::wrong_chunk);
  if (const auto failed = target_.write(manifest_.offset_of(chunk), bytes)) return finish(*failed);
  ++answered_;
  ++received_;
  ++in_place_;
  if (answered_ < missing_.size()) in_.resize(kChunkHead_bytes + manifest_.size_of(missing_[answered_]));
  if (++unsynced_ < kChunksPerSync) return;
  unsynced_ = 0;
  end_if(target_.sync());
}

void UpdateIntake::read_back_one() {
  const std::uint32_t chunk = at_chunk_++;
  in_.resize(kChunkHead_bytes + kChunk_bytes);
  const std::span bytes(in_.data(), manifest_.size_of(chunk));
  if (!target_.read(manifest_.offset_of(chunk), bytes)) return finish(UpdateEnd::disk_error);
  if (digest_of(bytes) != manifest_.chunks[chunk]) return finish(UpdateEnd::read_back_differs);
  crypto_generichash_update(&whole_, bytes.data(), bytes.size());
  if (at_chunk_ % kChunksPerWord == 0) say({UpdateWord::Kind::working, {}, in_place_});
  if (at_chunk_ < manifest_.chunks.size()) return;
  hal::ImageDigest digest;
  crypto_generichash_final(&whole_, digest.data(), digest.size());
  // The chunks are right; then the manifest contradicts itself, and no start would accept what it says.
  if (digest != manifest_.image.digest) return finish(UpdateEnd::malformed);
  if (const auto failed = target_.finish(manifest_.image, proof_.force)) return finish(*failed);
  finish(UpdateEnd::installed);
}

}  // namespace g3d::net
