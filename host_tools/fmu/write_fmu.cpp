#include "host_tools/fmu/write_fmu.hpp"

#include <zip.h>

#include <memory>
#include <vector>

#include "host_tools/fmu/variables.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

/// The runtime, fmu/embedded_library.S.
extern "C" const unsigned char spindle_twin_fmu_library[];
extern "C" const unsigned char spindle_twin_fmu_library_end[];

namespace spindle_twin::host_tools {
namespace {

/// A zip archive in memory.
class Archive {
 public:
  explicit Archive(const std::string& path) : path_(path) {
    memory_ = zip_source_buffer_create(nullptr, 0, 0, nullptr);
    if (memory_ == nullptr) refuse("no memory");
    zip_source_keep(memory_);  // the archive's own reference goes with zip_close
    zip_ = zip_open_from_source(memory_, ZIP_TRUNCATE, nullptr);
    if (zip_ == nullptr) refuse("no archive can be opened in memory");
  }
  ~Archive() {
    if (zip_ != nullptr) zip_discard(zip_);
    if (memory_ != nullptr) zip_source_free(memory_);
  }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  /// `bytes` must live until finish().
  void add(const char* name, std::span<const std::uint8_t> bytes) {
    zip_source_t* source = zip_source_buffer(zip_, bytes.data(), bytes.size(), 0);
    const zip_int64_t index = source != nullptr ? zip_file_add(zip_, name, source, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) {
      zip_source_free(source);
      refuse(zip_strerror(zip_));
    }
    // A fixed date (1980-01-01, the format's first), so that the same network gives the same bytes.
    if (zip_file_set_dostime(zip_, static_cast<zip_uint64_t>(index), 0, 0x21, 0) != 0) refuse(zip_strerror(zip_));
  }

  std::vector<std::uint8_t> finish() {
    if (zip_close(zip_) != 0) refuse(zip_strerror(zip_));
    zip_ = nullptr;
    zip_stat_t stat;
    if (zip_source_stat(memory_, &stat) != 0 || zip_source_open(memory_) != 0) refuse("cannot be read back");
    std::vector<std::uint8_t> bytes(stat.size);
    const zip_int64_t count = zip_source_read(memory_, bytes.data(), bytes.size());
    zip_source_close(memory_);
    if (count != static_cast<zip_int64_t>(bytes.size())) refuse("cannot be read back");
    return bytes;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { throw rom::InputError({path_, 0}, "--fmu", what); }

  std::string path_;
  zip_source_t* memory_ = nullptr;
  zip_t* zip_ = nullptr;
};

}  // namespace

const char* fmu_platform() { return SPINDLE_TWIN_FMU_PLATFORM; }

void write_fmu(const rom::Network& network, std::span<const std::uint8_t> rom_file, const std::string& path) {
  const std::string description = fmu_model_description(network, fmu_guid(rom_file));
  const std::string library = std::string("binaries/") + fmu_platform() + "/spindle_twin.so";
  Archive archive(path);
  archive.add("modelDescription.xml", {reinterpret_cast<const std::uint8_t*>(description.data()), description.size()});
  archive.add(library.c_str(), {spindle_twin_fmu_library, spindle_twin_fmu_library_end});
  archive.add("resources/network.rom", rom_file);
  rom::write_whole_file(path, archive.finish());
}

}  // namespace spindle_twin::host_tools
