// The fuzzer of a reader that takes bytes as they come: SPINDLE_TWIN_FUZZED is its check.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/check_daemon_files.hpp"
#include "tests/fuzz/check_modbus.hpp"
#include "tests/fuzz/check_plant.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spindle_twin::firmware::SPINDLE_TWIN_FUZZED({data, size});
  return 0;
}
