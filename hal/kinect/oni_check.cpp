// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/oni_check.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "hal/image/jpeg_reader.hpp"
#include "hal/kinect/depth_code.hpp"
#include "hal/kinect/oni_records.hpp"

namespace g3d::hal::kinect {
namespace {

constexpr std::uint32_t kMostNodes = 16;
constexpr std::size_t kMostName_bytes = 80;
constexpr std::size_t kMostPath_bytes = 250;  // OpenNI2 cuts longer ones off
constexpr std::uint64_t kRgb888 = 200, kDepth1Mm = 100;

constexpr std::uint32_t code_id(const char (&text)[5]) {
  return static_cast<std::uint32_t>(text[0]) | static_cast<std::uint32_t>(text[1]) << 8 |
         static_cast<std::uint32_t>(text[2]) << 16 | static_cast<std::uint32_t>(text[3]) << 24;
}
constexpr std::uint32_t kPlain = code_id("NONE"), kJpeg = code_id("JPEG"), kDepth16z = code_id("16zP"),
                        kDepth16zTable = code_id("16zT");

enum NodeType : std::uint32_t { kDevice = 1, kDepth = 2, kImage = 3 };

struct Node {
  bool is_added = false;
  bool is_ready = false;
  bool is_removed = false;
  std::uint32_t type = 0;
  std::uint32_t code = 0;
  std::uint32_t announced_frames = 0;
  std::uint64_t seek_table_at = 0;
  std::string_view name;
  std::optional<std::array<std::uint32_t, 3>> mode;  // width, height, frames per second
  std::optional<std::uint64_t> pixel_format;         // OpenNI2's number
  std::optional<std::uint64_t> farthest_mm;
  std::uint64_t required_bytes = 0;
  bool has_cropping = false;
  OniStreamInfo info;
};

class OniCheck {
 public:
  OniCheck(Bytes file, std::string_view name) : records_(file, name) {}

  Result<OniFile> run() {
    if (auto header = records_.read_header(); !header) return header.error();
    const std::uint32_t highest = records_.header().highest_node;
    if (highest >= kMostNodes) return error(20, Reason::malformed, fmt::format("{} nodes are too many", highest));
    nodes_.resize(highest + 1);
    for (;;) {
      auto record = records_.read(at_);
      if (!record) return record.error();
      at_ = records_.end_of(record.value());
      if (record.value().type == kEnd) break;
      if (auto checked = check(record.value()); !checked) return checked.error();
    }
    return finish();
  }

 private:
  [[nodiscard]] Error error(std::size_t at, Reason reason, std::string_view what) const {
    return records_.error(at, reason, what);
  }

  Result<void> check(const OniRecord& record) {
    const auto malformed = [&](std::string_view what) { return error(record.at, Reason::malformed, what); };
    if (record.node >= nodes_.size()) return malformed(fmt::format("node {} of {}", record.node, nodes_.size()));
    Node& node = nodes_[record.node];
    if (record.type == kNodeAdded || record.type == kNodeAdded1005) return add_node(record, node);
    if (!node.is_added) return malformed("of a node that was not added");
    // The player reads these alone behind what its node is.
    if (record.type != kNewData && record.type != kSeekTable && !record.payload.empty()) {
      return malformed("a record with data that should have none");
    }
    if (node.is_removed && record.type != kSeekTable) return malformed("of a node that was removed");
    switch (record.type) {
      case kIntProperty:
      case kRealProperty:
      case kStringProperty:
      case kGeneralProperty:
        return read_property(record, node);
      case kStateReady:
        return make_ready(record, node);
      case kDataBegin:
        if (node.type == kDevice || !node.is_ready || record.fields.size() < 12)
          return malformed("data cannot begin here");
        has_begun_ = true;
        return {};
      case kNewData:
        return check_image(record, node);
      case kNodeRemoved:
        node.is_removed = true;
        return {};
      case kSeekTable:
        return check_seek_table(record, node);
      default:
        return error(record.at + 4, Reason::unsupported,
                     fmt::format("records of type 0x{:02X} are not known", record.type));
    }
  }

  Result<void> add_node(const OniRecord& record, Node& node) {
    const auto malformed = [&](std::string_view what) { return error(record.at, Reason::malformed, what); };
    if (node.is_added) return malformed("a node that is there already");
    if (!record.payload.empty()) return malformed("a node with data");
    OniFields fields{record.fields};
    node.name = fields.text(kMostName_bytes - 1);
    node.type = fields.number<std::uint32_t>();
    node.code = fields.number<std::uint32_t>();
    node.announced_frames = fields.number<std::uint32_t>();
    (void)fields.number<std::uint64_t>();  // first and last stamp
    (void)fields.number<std::uint64_t>();
    if (record.type == kNodeAdded) {
      node.seek_table_at = records_.header().is_wide ? fields.number<std::uint64_t>() : fields.number<std::uint32_t>();
    }
    if (!fields.ok || node.name.empty()) return malformed("a node whose description ends too early");
    for (const Node& other : nodes_) {
      if (&other == &node || !other.is_added) continue;
      if (other.name == node.name) return malformed("two nodes of one name");
      if (other.type == node.type && node.type != kDevice) {
        return error(record.at, Reason::unsupported, "two nodes of one kind");
      }
    }
    const bool is_code_known =
        node.type == kDevice ||
        (node.type == kDepth && (node.code == kDepth16z || node.code == kDepth16zTable || node.code == kPlain)) ||
        (node.type == kImage && (node.code == kJpeg || node.code == kPlain));
    if (!is_code_known) {
      return error(
          record.at, Reason::unsupported,
          fmt::format("node {} of type {} with code 0x{:08X}: depth is read as 16z or plain, colour as JPEG or "
                      "plain",
                      record.node, node.type, node.code));
    }
    node.is_added = true;
    return {};
  }

  Result<void> read_property(const OniRecord& record, Node& node) {
    const auto malformed = [&](std::string_view what) { return error(record.at, Reason::malformed, what); };
    if (node.is_ready) return error(record.at, Reason::unsupported, "a property that changes while it is recorded");
    OniFields fields{record.fields};
    const std::string_view key = fields.text(kMostName_bytes);
    const Bytes value = fields.take(fields.number<std::uint32_t>());
    if (!fields.ok) return malformed("a property that ends too early");
    const auto is_of = [&](std::size_t bytes) { return value.size() == bytes; };
    if ((record.type == kIntProperty || record.type == kRealProperty) && !is_of(8)) {
      return malformed("a number that has not eight bytes");
    }
    if (record.type == kStringProperty &&
        (value.empty() || std::memchr(value.data(), 0, value.size()) != value.data() + value.size() - 1)) {
      return malformed("a text that does not end with a zero");
    }
    if (record.type == kIntProperty) return read_int(record, key, read_at<std::uint64_t>(value, 0), node);
    if (record.type != kGeneralProperty) return {};
    if (key == "xnMapOutputMode") {
      if (!is_of(12)) return malformed("xnMapOutputMode has not twelve bytes");
      node.mode = {read_at<std::uint32_t>(value, 0), read_at<std::uint32_t>(value, 4),
                   read_at<std::uint32_t>(value, 8)};
    } else if (key == "xnCropping") {
      if (!is_of(12)) return malformed("xnCropping has not twelve bytes");
      if (read_at<std::uint32_t>(value, 0) != 0) return error(record.at, Reason::unsupported, "the images are cropped");
      node.has_cropping = true;
    } else if (key == "xnFOV") {
      if (!is_of(16)) return malformed("xnFOV has not sixteen bytes");
      const auto fov_rad = read_at<double>(value, 0);
      if (!(fov_rad > 0.1 && fov_rad < 3.0)) return malformed("a field of view that no camera has");
      node.info.horizontal_fov_rad = fov_rad;
    } else if (key == "xnRealWorldTranslationData") {
      if (!is_of(24)) return malformed("xnRealWorldTranslationData has not 24 bytes");
    }
    return {};
  }

  Result<void> read_int(const OniRecord& record, std::string_view key, std::uint64_t value, Node& node) const {
    const auto unsupported = [&](std::string_view what) { return error(record.at, Reason::unsupported, what); };
    if (key == "xnDeviceMaxDepth") {
      if (value == 0 || value > 65535)
        return error(record.at, Reason::out_of_range, "xnDeviceMaxDepth is not 1 to 65535");
      node.farthest_mm = value;
    } else if (key == "xnMirror") {
      node.info.is_mirrored = value != 0;
    } else if (key == "oniPixelFormat") {
      if (value != (node.type == kDepth ? kDepth1Mm : kRgb888))
        return unsupported("images that are neither millimetres nor RGB");
      node.pixel_format = value;
    } else if (key == "xnPixelFormat" && node.type == kImage) {
      if (value != 1) return unsupported("colour images that are not RGB");
      node.pixel_format = kRgb888;
    } else if (key == "oniRequiredFrameSize" || key == "RequiredDataSize") {
      if (value > kPlayerBuffer_bytes)
        return error(record.at, Reason::too_large, fmt::format("images of {} bytes", value));
      node.required_bytes = value;
    }
    return {};
  }

  Result<void> make_ready(const OniRecord& record, Node& node) {
    const auto malformed = [&](std::string_view what) { return error(record.at, Reason::malformed, what); };
    if (node.is_ready) return {};
    node.is_ready = true;
    if (node.type == kDevice) return {};
    if (!node.mode) return malformed("a node whose image size is not said");
    const auto [width, height, fps] = *node.mode;
    if (width < 16 || height < 16 || width > 1600 || height > 1200 || fps == 0 || fps > 1000) {
      return error(record.at, Reason::out_of_range, fmt::format("images of {}x{} at {} Hz", width, height, fps));
    }
    node.info.width_px = static_cast<int>(width);
    node.info.height_px = static_cast<int>(height);
    if (node.type == kImage && !node.pixel_format) return malformed("colour whose format is not said");
    if (node.type == kDepth && node.code == kDepth16zTable && !node.farthest_mm)
      return malformed("xnDeviceMaxDepth is not said");
    // Without it the player gives no image, and says nothing.
    if (!node.has_cropping)
      return error(record.at, Reason::unsupported, "its driver recorded no xnCropping: OpenNI2 plays no image of it");
    if (node.required_bytes != 0 && node.required_bytes < image_bytes(node)) {
      return malformed("images larger than it says that they are");
    }
    return {};
  }

  [[nodiscard]] static std::size_t image_bytes(const Node& node) {
    return static_cast<std::size_t>(node.info.width_px) * static_cast<std::size_t>(node.info.height_px) *
           (node.type == kDepth ? 2 : 3);
  }

  Result<void> check_image(const OniRecord& record, Node& node) {
    const auto malformed = [&](std::string_view what) { return error(record.at, Reason::malformed, what); };
    if (node.type == kDevice || !node.is_ready || !has_begun_) return malformed("an image before its node is ready");
    for (const Node& other : nodes_) {
      if (other.is_added && !other.is_ready) return malformed("an image before all nodes are ready");
    }
    if (record.fields.size() < 12) return malformed("an image without stamp and number");
    const auto stamp_us = read_at<std::uint64_t>(record.fields, 0);
    const auto number = read_at<std::uint32_t>(record.fields, 8);
    if (stamp_us > records_.header().last_stamp_us || stamp_us > std::uint64_t{1} << 53)
      return malformed("an image later than the file's last");
    if (number == 0 || number > node.announced_frames) {
      return malformed(fmt::format("image {} of {}", number, node.announced_frames));
    }
    ++node.info.frames;
    const std::size_t pixels = image_bytes(node) / (node.type == kDepth ? 2 : 3);
    bool is_whole = false;
    if (node.code == kPlain) {
      is_whole = record.payload.size() == image_bytes(node);
    } else if (node.code == kJpeg) {
      const auto size = jpeg_.size(record.payload, records_.name());
      is_whole = size.ok() && size.value() == ImageSize{node.info.width_px, node.info.height_px};
    } else {
      is_whole = is_whole_depth_code(record.payload, node.code == kDepth16zTable, pixels);
    }
    if (!is_whole) {
      return malformed(fmt::format("{} image {} is damaged", node.type == kDepth ? "depth" : "colour", number));
    }
    return {};
  }

  [[nodiscard]] std::size_t seek_entry_bytes() const { return records_.header().is_wide ? 20 : 16; }

  Result<void> check_seek_table(const OniRecord& record, const Node& node) const {
    if (record.payload.size() != (std::size_t{node.announced_frames} + 1) * seek_entry_bytes()) {
      return error(record.at, Reason::malformed, "a seek table that does not fit its node");
    }
    return {};
  }

  Result<OniFile> finish() const {
    const auto malformed = [&](std::string_view what) { return error(at_, Reason::malformed, what); };
    if (!has_begun_) return malformed("no images at all");
    OniFile file;
    for (const Node& node : nodes_) {
      if (!node.is_added || node.type == kDevice) continue;
      if (!node.is_ready) return malformed(fmt::format("node {} never got ready", node.name));
      (node.type == kDepth ? file.depth : file.colour) = node.info;
      // The player follows this place before it plays.
      if (node.seek_table_at == 0 || node.announced_frames == 0) continue;
      const auto table = records_.read(node.seek_table_at);
      if (!table) return table.error();
      if (table.value().type != kSeekTable || table.value().node >= nodes_.size() ||
          &nodes_[table.value().node] != &node) {
        return error(node.seek_table_at, Reason::malformed, fmt::format("no seek table of node {}", node.name));
      }
      if (auto fits = check_seek_table(table.value(), node); !fits) return fits.error();
    }
    if (file.depth.frames == 0) return malformed("no depth images");
    if (file.has_colour() &&
        (file.colour.width_px != file.depth.width_px || file.colour.height_px != file.depth.height_px)) {
      return error(at_, Reason::unsupported, "depth and colour images of different sizes");
    }
    return file;
  }

  OniRecords records_;
  std::size_t at_ = OniRecords::kFileHeader_bytes;
  std::vector<Node> nodes_;
  bool has_begun_ = false;
  JpegReader jpeg_;
};

}  // namespace

Result<OniFile> check_oni(std::span<const std::uint8_t> file, std::string_view name) {
  return OniCheck(file, name).run();
}

Result<OniFile> check_oni_file(const std::string& path) {
  const auto refused = [&](Reason reason, std::string_view why) {
    return Error{reason, fmt::format("{}: cannot be read: {}", path, why)};
  };
  if (path.size() > kMostPath_bytes) return refused(Reason::unsupported, "its name is longer than 250 bytes");
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const Reason reason = errno == ENOENT   ? Reason::not_found
                          : errno == EACCES ? Reason::no_permission
                                            : Reason::io_error;
    return refused(reason, std::strerror(errno));
  }
  struct stat about {};
  const bool is_file = fstat(fd, &about) == 0 && S_ISREG(about.st_mode);
  const auto bytes = static_cast<std::size_t>(is_file ? about.st_size : 0);
  void* const memory = bytes > 0 ? mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
  ::close(fd);
  if (memory == MAP_FAILED) {
    if (is_file && bytes == 0) return Error{Reason::truncated, fmt::format("{}: is empty", path)};
    return refused(Reason::io_error, is_file ? std::strerror(errno) : "it is no file");
  }
  (void)madvise(memory, bytes, MADV_SEQUENTIAL);
  auto checked = check_oni({static_cast<const std::uint8_t*>(memory), bytes}, path);
  munmap(memory, bytes);
  return checked;
}

}  // namespace g3d::hal::kinect
