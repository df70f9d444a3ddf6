#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "rom/file/rom_file.hpp"
#include "tests/bench/bare_modbus_server.hpp"
#include "tests/bench/modbus_loading/connection.hpp"
#include "tests/bench/rows.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int registers = 120;
constexpr int reads = 2000, blocks = 25;

/// A process of ours, which ends with this.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {
    if (pid < 0) throw std::runtime_error("fork failed");
  }
  ~Child() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  double processor_s() const {
    clockid_t clock{};
    timespec used{};
    if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) {
      throw std::runtime_error("a server of the bench has ended");
    }
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }

 private:
  pid_t pid_;
};

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "bench-registers-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The daemon at 1 cycle per second on the network of the tests, without devices.
pid_t start_daemon(const std::string& program, const std::filesystem::path& folder, int port) {
  rom::write_network(tests::small_network(), (folder / "small.rom").string());
  const std::string config = (folder / "twin.toml").string();
  std::ofstream(config) << "network = \"small.rom\"\n[serve]\nport = " << port
                        << "\n[signals]\nspeed = { source = \"constant\", value = 6000.0 }\n"
                           "load = { source = \"constant\", value = 1.0 }\n"
                           "coolant = { source = \"constant\", value = 22.0 }\n"
                           "ambient = { source = \"constant\", value = 22.0 }\n"
                           "[start]\ntemperature_degC = 22.0\n";
  const pid_t pid = fork();
  if (pid == 0) {
    const int log = open((folder / "log").c_str(), O_WRONLY | O_CREAT, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execl(program.c_str(), program.c_str(), config.c_str(), nullptr);
    _exit(127);
  }
  return pid;
}

/// Connects as soon as somebody listens.
load::Connection connect_to(int port) {
  constexpr int patience = 500;
  for (int attempt = 1;; ++attempt) {
    try {
      load::Connection connection;
      connection.open(port);
      return connection;
    } catch (const std::runtime_error&) {
      if (attempt == patience) throw;
      usleep(20'000);
    }
  }
}

/// One read after the other, each once the answer to the one before is there.
void read_block(load::Connection& connection) {
  const load::Bytes request = load::framed(1, {4, 0, 0, 0, registers});
  const std::array<const load::Connection*, 1> waited{&connection};
  for (int n = 0; n < reads; ++n) {
    if (!connection.send(request)) throw std::runtime_error("a server of the bench takes no request");
    std::optional<load::Bytes> answer;
    while (!answer) {
      load::wait_for(waited, load::now_ns() + load::ns_per_s);
      if (!connection.receive()) throw std::runtime_error("a server of the bench has ended the connection");
      answer = connection.next_frame();
    }
    if (answer->size() != 9 + 2 * registers) throw std::runtime_error("a server of the bench answers something else");
  }
}

/// A server under measurement: seconds of one read, block by block.
struct Served {
  const Child& server;
  load::Connection connection;
  std::vector<double> wall_s = {}, processor_s = {};

  void measure_block() {
    const double used_s = server.processor_s();
    const std::int64_t start_ns = load::now_ns();
    read_block(connection);
    wall_s.push_back(1e-9 * static_cast<double>(load::now_ns() - start_ns) / reads);
    processor_s.push_back((server.processor_s() - used_s) / reads);
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string per_second(double time_s) { return with_commas(static_cast<long>(1.0 / time_s)); }

}  // namespace

void print_register_rows(const RowPrinter& printer, const std::string& daemon) {
  if (!std::filesystem::exists(daemon)) throw std::runtime_error("'" + daemon + "' of --daemon does not exist");
  const Folder folder;
  BareModbusServer bare_server;
  const Child bare_process(bare_server.start());
  const int port = free_port();
  const Child daemon_process(start_daemon(daemon, folder.path(), port));
  Served ours{daemon_process, connect_to(port)};
  Served bare{bare_process, connect_to(bare_server.port())};
  read_block(ours.connection);
  read_block(bare.connection);
  for (int block = 0; block < blocks; ++block) {
    ours.measure_block();
    bare.measure_block();
  }
  const double ours_s = median(ours.wall_s), bare_s = median(bare.wall_s);
  printer.print({.group = "Registers by Modbus/TCP",
                 .name = "a read of 120 registers, from request to answer",
                 .ours_s = ours_s,
                 .other_name = "libmodbus in a bare loop",
                 .other_s = bare_s,
                 .means = "One client on the loopback, one request after the other: " + per_second(ours_s) +
                          " against " + per_second(bare_s) + " a second; medians of 25 alternating blocks.",
                 .clock = "wall"});
  printer.print(
      {.group = "Registers by Modbus/TCP",
       .name = "what it costs the server",
       .ours_s = median(ours.processor_s),
       .other_name = "libmodbus in a bare loop",
       .other_s = median(bare.processor_s),
       .means = "What judging each frame, deadlines and many clients add to libmodbus, which answers in both."});
}

}  // namespace spindle_twin::bench
