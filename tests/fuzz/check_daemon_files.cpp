#include "tests/fuzz/check_daemon_files.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "firmware/config/config.hpp"
#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/orders_file.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "rom/read/csv_table.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace {

/// A file without a place on a disk.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::uint8_t> bytes) : file_(memfd_create("fuzzed", 0)) {
    require(file_ >= 0 && write(file_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()), "a file");
  }
  ~MemoryFile() { close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

template <class Read>
std::string reason_of(const std::string& file, const Read& read) {
  try {
    read();
  } catch (const rom::InputError& error) {
    const std::string reason = error.what();
    require(reason.starts_with(file) && reason.size() > file.size() + 2, "a reason names its file: " + reason);
    return reason;
  }
  return {};
}

std::vector<std::uint8_t> sealed(const std::string& format, std::span<const std::uint8_t> message) {
  const std::string_view bytes(reinterpret_cast<const char*>(message.data()), message.size());
  const std::string line = "spindle-twin " + format + " " + rom::sha256_hex(bytes) + "\n";
  std::vector<std::uint8_t> file(line.begin(), line.end());
  file.insert(file.end(), message.begin(), message.end());
  return file;
}

}  // namespace

std::string checked_checkpoint(std::span<const std::uint8_t> message) {
  return reason_of("fuzzed", [&] {
    const auto once = encode_checkpoint(decode_checkpoint(sealed("checkpoint 1", message), "fuzzed"));
    require(encode_checkpoint(decode_checkpoint(once, "fuzzed")) == once, "a checkpoint survives a round trip");
  });
}

std::string checked_orders(std::span<const std::uint8_t> message) {
  return reason_of("fuzzed", [&] {
    const auto once = encode_orders(decode_orders(sealed("orders 1", message), "fuzzed"));
    require(encode_orders(decode_orders(once, "fuzzed")) == once, "orders survive a round trip");
  });
}

std::string checked_calibration(std::span<const std::uint8_t> message) {
  return reason_of("fuzzed", [&] {
    const auto read = [](const std::vector<std::uint8_t>& bytes) {
      return correction::decode_calibration(bytes, "fuzzed").calibration;
    };
    const auto once = encode_calibration(read(sealed("calibration 1", message)));
    require(encode_calibration(read(once)) == once, "calibrations survive a round trip");
  });
}

std::string checked_config(std::span<const std::uint8_t> text) {
  const MemoryFile file(text);
  return reason_of(file.path(), [&] { read_config(file.path()); });
}

std::string checked_table(std::span<const std::uint8_t> text) {
  const MemoryFile file(text);
  const auto read = [&](rom::LastLine last) {
    return reason_of(file.path(), [&] {
      const rom::CsvTable table = rom::read_csv_table(file.path(), last);
      require(table.names.size() == table.columns.size(), "a column has a name");
      for (const std::vector<double>& column : table.columns) {
        require(column.size() == table.rows(), "rows are whole");
        for (const double number : column) require(!std::isinf(number), "numbers are finite or missing");
      }
    });
  };
  read(rom::LastLine::may_be_cut);
  return read(rom::LastLine::whole);
}

std::string checked_history(std::span<const std::uint8_t> bytes) {
  // SQLite follows a link to where the file stands, so it stands somewhere; a folder for each execution took half its
  // time.
  static const spindle_twin::tests::TemporaryFolder folder;
  static const std::string file = folder.file("history.sqlite");
  for (const auto& beside : std::filesystem::directory_iterator(folder.path())) std::filesystem::remove(beside);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return reason_of(file, [&] {
    const SqliteHistoryReader reader(file);
    for (const HistoryRun& run : reader.runs()) {
      require(reader.table(run.id).rows() == static_cast<std::size_t>(run.rows), "a run has its rows");
    }
  });
}

}  // namespace spindle_twin::firmware
