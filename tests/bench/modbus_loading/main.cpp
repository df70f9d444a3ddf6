#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <future>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/bench/command_line/command_line.hpp"
#include "tests/bench/modbus_loading/clients.hpp"

/// Loads a Modbus server from all sides at once and says, as JSON, what each kind of client got.
namespace spindle_twin::load {
namespace {

struct Options {
  int port = 502;
  double seconds = 60.0;
  int readers = 64;
  double reads_per_s = 5000.0;
  int slow = 32;
  long malformed = 1'000'000;
  std::uint64_t seed = 1;
};

double quantile_ms(std::vector<float>& sorted, double share) {
  if (sorted.empty()) return 0.0;
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

nlohmann::ordered_json told(Answers answers) {
  std::sort(answers.latency_ms.begin(), answers.latency_ms.end());
  return {{"requests", answers.requests},
          {"wrong", answers.wrong},
          {"missing", answers.missing},
          {"median_ms", quantile_ms(answers.latency_ms, 0.5)},
          {"p99_ms", quantile_ms(answers.latency_ms, 0.99)},
          {"p999_ms", quantile_ms(answers.latency_ms, 0.999)},
          {"most_ms", quantile_ms(answers.latency_ms, 1.0)}};
}

nlohmann::ordered_json load(const Options& options) {
  std::atomic<bool> stop = false;
  const std::int64_t start_ns = now_ns();
  const auto async = std::launch::async;
  auto readers =
      std::async(async, [&] { return run_readers(options.port, options.readers, options.reads_per_s, stop); });
  auto plc = std::async(async, [&] { return run_plc(options.port, stop); });
  auto slow = std::async(async, [&] { return run_slow(options.port, options.slow, stop); });
  auto malformed = std::async(async, [&] {
    return run_malformed(options.port, options.malformed, static_cast<double>(options.malformed) / options.seconds,
                         options.seed);
  });
  wait_for({}, start_ns + static_cast<std::int64_t>(1e9 * options.seconds));
  malformed.wait();
  stop = true;
  const double took_s = 1e-9 * static_cast<double>(now_ns() - start_ns);
  const SlowScore slowly = slow.get();
  const MalformedScore bad = malformed.get();
  return {{"seconds", took_s},
          {"readers", told(readers.get())},
          {"plc", told(plc.get())},
          {"slow",
           {{"bytes_dripped", slowly.bytes_dripped},
            {"ended_drips", slowly.ended_drips},
            {"unread_requests", slowly.unread_requests},
            {"ended_unread", slowly.ended_unread}}},
          {"malformed",
           {{"frames", bad.frames},
            {"refused", bad.refused},
            {"ended", bad.ended},
            {"cut", bad.cut},
            {"wrong", bad.wrong}}}};
}

int run(int argc, char** argv) {
  using bench::Allowed;
  bench::CommandLine line("Clients of all manners against a Modbus/TCP server on 127.0.0.1.");
  Options options;
  line.add("--port", options.port, "where it listens", Allowed{1, 65535});
  line.require("--port");
  line.add("--seconds", options.seconds, "at least so long", Allowed{0.1, 1e6});
  line.add("--readers", options.readers, "connections that read", Allowed{1, 200});
  line.add("--reads-per-s", options.reads_per_s, "of all readers together", Allowed{0.1, 1e6});
  line.add("--slow", options.slow, "slow connections", Allowed{1, 200});
  line.add("--malformed", options.malformed, "frames in all", Allowed{1, 1e9});
  line.add("--seed", options.seed, "of the malformed frames");
  if (const auto code = line.parse(argc, argv)) return *code;
  try {
    std::printf("%s\n", load(options).dump(2).c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "modbus_load_clients: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace spindle_twin::load

int main(int argc, char** argv) { return spindle_twin::load::run(argc, argv); }
