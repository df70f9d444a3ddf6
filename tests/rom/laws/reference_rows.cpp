#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {

double ReferenceRow::operator[](const std::string& key) const {
  for (const auto& [name, number] : numbers) {
    if (name == key) return number;
  }
  ADD_FAILURE() << "no reference value " << key;
  return std::numeric_limits<double>::quiet_NaN();
}

std::vector<ReferenceRow> reference_rows(const std::string& law) {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/tests/rom/laws/reference_values.json");
  const nlohmann::json all = nlohmann::json::parse(file);
  std::vector<ReferenceRow> rows;
  for (const auto& entry : all.at(law)) {
    ReferenceRow row;
    for (const auto& [key, item] : entry.items()) {
      if (item.is_string()) row.oil = item.get<std::string>();
      if (item.is_number()) row.numbers.emplace_back(key, item.get<double>());
      if (item.is_null()) row.numbers.emplace_back(key, std::numeric_limits<double>::quiet_NaN());
    }
    rows.push_back(std::move(row));
  }
  EXPECT_FALSE(rows.empty()) << law;
  return rows;
}

}  // namespace spindle_twin::rom::test
