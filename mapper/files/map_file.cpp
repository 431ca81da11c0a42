// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/map_file.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>

#include "hal/image/file_bytes.hpp"

namespace g3d::mapper {
namespace {

constexpr std::size_t kMaxMapFile_bytes = std::size_t{32} << 30;

template <typename Source>
hal::Result<SaveReport> save(const Source& source, const MapFileMeta& meta, const std::string& path, int zstd_level) {
  auto file = hal::AtomicFile::create(path);
  if (!file) return file.error();
  auto report = encode_map(
      source, meta, [&](ByteSpan bytes) { return file.value().write(bytes); }, zstd_level);
  if (!report) return report.error();
  if (const auto done = file.value().commit(); !done) return done.error();
  return report;
}

}  // namespace

hal::Result<SaveReport> save_map(const VoxelMap& map, const MapFileMeta& meta, const std::string& path,
                                 int zstd_level) {
  return save(map, meta, path, zstd_level);
}

hal::Result<SaveReport> save_map(const BlockSource& source, const MapFileMeta& meta, const std::string& path,
                                 int zstd_level) {
  return save(source, meta, path, zstd_level);
}

hal::Result<LoadedMap> load_map(const std::string& path, const LoadOptions& options) {
  const auto bytes = hal::read_file(path, kMaxMapFile_bytes);
  if (!bytes) return bytes.error();
  return decode_map(bytes.value(), path, options);
}

hal::Result<MapInfo> read_map_info(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) return hal::system_error(path, "cannot be opened", errno);
  std::array<std::uint8_t, kMapHeaderBytes> bytes{};
  const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get()) != 0) return hal::system_error(path, "cannot be read", errno);
  auto info = decode_header(ByteSpan(bytes).first(got), path);
  if (!info) return info.error();
  if (std::fseek(file.get(), 0, SEEK_END) != 0) return hal::system_error(path, "cannot be measured", errno);
  info.value().file_bytes = static_cast<std::uint64_t>(std::ftell(file.get()));
  return info;
}

}  // namespace g3d::mapper
