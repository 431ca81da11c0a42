// SPDX-License-Identifier: Apache-2.0
// `g3dmap update`: makes the key, sends a system to a robot, or takes one. `g3dmap slots`: what a machine holds.
#include "main_update.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <charconv>
#include <map>
#include <utility>

#include "hal/boot/slot_store.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"
#include "net/update_sender.hpp"
#include "net/update_server.hpp"

namespace g3d {
namespace {

/// "ADDRESS:PORT", or the half of it that has no default.
std::optional<hal::Ipv4Endpoint> endpoint_of(const std::string& text, std::uint32_t default_ipv4) {
  if (const auto whole = hal::parse_ipv4_endpoint(text)) return whole;
  if (const auto address = hal::parse_ipv4(text)) return hal::Ipv4Endpoint{*address, net::kUpdatePort};
  // 0 is a port here: any that is free.
  const std::size_t colon = text.find(':');
  const auto address = colon == std::string::npos ? default_ipv4 : hal::parse_ipv4(text.substr(0, colon));
  const std::string port_text = text.substr(colon == std::string::npos ? 0 : colon + 1);
  std::uint16_t port = 0;
  const auto [end, failed] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (!address || failed != std::errc{} || port_text.empty() || end != port_text.data() + port_text.size())
    return std::nullopt;
  return hal::Ipv4Endpoint{*address, port};
}

/// When the file was made: a later one is newer.
hal::Result<std::uint64_t> release_of(const std::string& path, const std::optional<std::uint64_t>& said) {
  if (said) return *said;
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    return hal::Error{hal::Reason::not_found,
                      fmt::format("{}: is not there; give the system's image, such as make image leaves it", path)};
  }
  return static_cast<std::uint64_t>(std::max<std::int64_t>(1, status.st_mtim.tv_sec));
}

int make_signing_key(const std::string& path) {
  const net::SigningKey key = net::SigningKey::random();
  if (const auto written = net::write_new_signing_key(path, key); !written) return fail(written.error().text);
  fmt::print(
      "{}  keep it; whoever has it can put any system on your machines\n{}.pub  goes on their image\nfingerprint {}\n",
      path, path, key.update_key().fingerprint());
  return kExitDone;
}

void show_progress(const net::UpdateProgress& progress) {
  static const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  static int last_percent = -1;
  const int percent = static_cast<int>(std::uint64_t{100} * progress.in_place / std::max(1U, progress.chunks));
  const bool is_told = is_terminal ? percent == last_percent : percent / 10 == last_percent / 10;
  if (is_told && last_percent >= 0) return;
  last_percent = percent;
  fmt::print(stderr, "{}{} % there, {} KiB sent{}", is_terminal ? "\r" : "", percent,
             std::uint64_t{progress.sent} * net::kChunk_bytes / 1024, is_terminal ? "  " : "\n");
  std::fflush(stderr);
}

int send_one(const UpdateOptions& options) {
  const auto to = endpoint_of(options.to, 0);
  if (!to || to->ipv4 == 0 || to->port == 0) {
    return bad_usage(
        fmt::format("--to '{}': not an address such as 10.0.0.2 or 10.0.0.2:{}", options.to, net::kUpdatePort));
  }
  const auto key = net::read_signing_key(options.key);
  if (!key) return fail(key.error().text);
  const auto release = release_of(options.image, options.release);
  if (!release) return fail(release.error().text);
  const auto manifest = net::manifest_of(options.image, release.value());
  if (!manifest) return fail(manifest.error().text);
  net::UpdateSenderOptions how;
  how.to = *to;
  how.force = options.force;
  how.patience_s = options.patience_s;
  const auto sent = net::send_update(options.image, manifest.value(), key.value(), how,
                                     options.quiet ? net::ShowProgress{} : net::ShowProgress(show_progress));
  if (!options.quiet && ::isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\n");
  if (!sent) return fail(sent.error().text);
  const net::UpdateProgress& progress = sent.value().progress;
  fmt::print("{}: release {}: {}; sent {} of {} chunks in {} connection{}\n", hal::to_string(*to), release.value(),
             net::explain(sent.value().end, progress.machine, release.value()), progress.sent, progress.chunks,
             progress.connections, progress.connections == 1 ? "" : "s");
  return kExitDone;
}

std::atomic<net::UpdateServer*> serving{nullptr};

void stop_serving(int) {
  if (net::UpdateServer* const server = serving.load(std::memory_order_acquire)) server->stop();
}

int take_updates(const UpdateOptions& options) {
  const auto at = endpoint_of(options.listen, 0);
  if (!at)
    return bad_usage(
        fmt::format("--listen '{}': not a port such as {}, or ADDRESS:PORT", options.listen, net::kUpdatePort));
  for (const auto& [name, value] : {std::pair{"--trust", &options.trust}, std::pair{"--state", &options.state},
                                    std::pair{"--slot-a", &options.slot_a}, std::pair{"--slot-b", &options.slot_b}}) {
    if (value->empty()) return bad_usage(fmt::format("--listen: needs {} as well", name));
  }
  const auto key = net::read_update_key(options.trust);
  if (!key) return fail(key.error().text);
  net::UpdateTargetPaths paths;
  paths.book = options.state;
  paths.slots = {options.slot_a, options.slot_b};
  if (options.running != "none") paths.running = options.running == "a" ? hal::Slot::a : hal::Slot::b;
  net::UpdateTarget target(std::move(paths));
  net::UpdateServerOptions how;
  how.at = *at;
  how.rate_Bps = 1000.0 * options.rate_kBps;
  const auto tell = [](const std::string& line) { fmt::print(stderr, "update: {}\n", line); };
  auto server = net::UpdateServer::open(how, key.value(), target, tell);
  if (!server) return fail(server.error().text);
  serving.store(server.value().get(), std::memory_order_release);
  struct sigaction action {};
  action.sa_handler = stop_serving;
  (void)::sigaction(SIGTERM, &action, nullptr);
  (void)::sigaction(SIGINT, &action, nullptr);
  tell(fmt::format("listening at {} for the holder of key {}",
                   hal::to_string(hal::Ipv4Endpoint{at->ipv4, server.value()->port()}), key.value().fingerprint()));
  const bool is_installed = server.value()->serve();
  serving.store(nullptr, std::memory_order_release);
  if (is_installed) tell("installed; restart to run it");
  return is_installed ? kExitDone : kExitFailed;
}

void show_slots(const hal::SlotBook& book, bool json) {
  if (json)
    fmt::print("{{\"next\": \"{}\", \"newest_good_release\": {}", hal::to_string(book.preferred),
               book.newest_good_release);
  for (const hal::Slot slot : {hal::Slot::a, hal::Slot::b}) {
    const hal::SlotEntry& entry = book[slot];
    const char* const form = json
                                 ? ", \"{}\": {{\"condition\": \"{}\", \"release\": {}, \"bytes\": {}, \"starts\": {}}}"
                                 : "slot {}: {}, release {}, {} bytes, {} starts without health\n";
    fmt::print(fmt::runtime(form), hal::to_string(slot), hal::to_string(entry.condition), entry.image.release,
               entry.image.size_bytes, entry.starts);
  }
  if (json) fmt::print("}}\n");
  if (!json)
    fmt::print("next: {}; newest release that came up well: {}\n", hal::to_string(book.preferred),
               book.newest_good_release);
}

}  // namespace

void add_update_options(CLI::App& command, UpdateOptions& options) {
  command.add_option("IMAGE", options.image, "The system to send");
  command.add_option("--new-key", options.new_key, "Make a signing key in this file, and FILE.pub for the machines");
  command.add_option("--key", options.key, "The signing key");
  command.add_option("--to", options.to, "The robot: ADDRESS or ADDRESS:PORT");
  command.add_option("--release", options.release,
                     "The image's number; later ones have larger ones. Default: when it was made");
  command.add_flag("--force", options.force, "Also an older release, or one that failed there before");
  command
      .add_option("--patience", options.patience_s, "Try so many seconds without progress once the robot has answered")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command.add_flag("--quiet", options.quiet, "No progress");
  command.add_option("--listen", options.listen, "Take updates at this PORT or ADDRESS:PORT, instead of sending one");
  command.add_option("--trust", options.trust, "With --listen: the .pub file of the key whose updates are taken");
  command.add_option("--state", options.state, "With --listen: what is known of the slots");
  command.add_option("--slot-a", options.slot_a, "With --listen: file or partition");
  command.add_option("--slot-b", options.slot_b, "With --listen: file or partition");
  command.add_option("--running", options.running, "With --listen: the slot that runs")
      ->check(CLI::IsMember({"a", "b", "none"}))
      ->capture_default_str();
  command.add_option("--rate-kBps", options.rate_kBps, "With --listen: how fast an update is asked for")
      ->check(CLI::Range(64.0, 1e6))
      ->capture_default_str();
}

void add_slots_options(CLI::App& command, SlotsOptions& options) {
  command.add_option("--state", options.state, "File or partition")->required();
  command.add_option("--first", options.first, "Make a new state: this image is in slot A, and B is empty");
  command.add_option("--release", options.release, "With --first: the image's number. Default: when it was made");
  command.add_flag("--json", options.json, "For scripts");
}

int run_update(const UpdateOptions& options) {
  const int jobs = (options.new_key.empty() ? 0 : 1) + (options.to.empty() ? 0 : 1) + (options.listen.empty() ? 0 : 1);
  if (jobs != 1) return bad_usage("update: give one of --to ADDRESS, --new-key FILE, --listen PORT");
  if (!options.new_key.empty()) return make_signing_key(options.new_key);
  if (!options.listen.empty()) return take_updates(options);
  if (options.image.empty() || options.key.empty()) return bad_usage("--to: needs --key SIGNING_KEY and an IMAGE");
  return send_one(options);
}

int run_slots(const SlotsOptions& options) {
  hal::SlotStore store(options.state);
  if (!options.first.empty()) {
    const auto release = release_of(options.first, options.release);
    if (!release) return fail(release.error().text);
    const auto manifest = net::manifest_of(options.first, release.value());
    if (!manifest) return fail(manifest.error().text);
    const auto made = store.change(
        [&](const hal::SlotBook&) -> hal::Result<hal::SlotBook> { return hal::first_book(manifest.value().image); });
    if (!made) return fail(made.error().text);
  }
  const auto book = store.read();
  if (!book) return fail(book.error().text);
  show_slots(book.value(), options.json);
  return kExitDone;
}

}  // namespace g3d
