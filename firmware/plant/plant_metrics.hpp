#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/show/shown_names.hpp"
#include "firmware/show/shown_values.hpp"

namespace spindle_twin::firmware {

/// Sparkplug's numbers for the types in use (Sparkplug 3.0.0, 6.4.16). Not UInt32: some libraries have it in the field
/// for 32 bits, others in that for 64.
enum class DataType : std::uint32_t { int32 = 3, int64 = 4, uint16 = 6, float32 = 9, boolean = 11, string = 12 };

/// Sparkplug's quality codes: there are only these.
enum class MetricQuality : std::uint32_t { bad = 0, good = 192, stale = 500 };

/// One number of a spindle as the plant network has it.
struct PlantMetric {
  std::string
      name;  ///< of the register, its slot and its bit: "nose", "key_point_predicted/sleeve", "fault/orders_lost"
  std::string unit;  ///< as of the register; empty: a count, a code or a bit
  DataType type = DataType::float32;
  ShownValue shown;
};

/// Numbers of one spindle at one time, and how good each is.
struct PlantValues {
  std::vector<double> numbers;           ///< NaN: not present
  std::vector<MetricQuality> qualities;  ///< as many
};

/// The numbers of one spindle that are published: those that /metrics shows, in the registers' units. For one thread.
class PlantMetrics {
 public:
  /// Of these registers, by shown_name(); none: of all.
  explicit PlantMetrics(ShownNames names, const std::vector<std::string>& registers = {});
  PlantMetrics(const PlantMetrics&) = delete;
  PlantMetrics& operator=(const PlantMetrics&) = delete;

  const std::string& spindle() const { return names_.spindle; }
  const std::vector<PlantMetric>& all() const { return all_; }
  /// In the order of all(). Bad is what has no value, a quantity while the prediction must not be used, and a reading
  /// that is not believed; stale a reading that is too old.
  PlantValues values(const RegisterImage& image) const;

 private:
  ShownNames names_;
  std::vector<PlantMetric> all_;
};

/// Whether a register that is shown has this shown_name().
bool is_published(const std::string& name);

}  // namespace spindle_twin::firmware
