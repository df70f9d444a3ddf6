#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {

DeformationOutput read_deformation(const TomlTable& table, Names& names, const Names& parts) {
  DeformationOutput output;
  output.name = names.add(table);
  output.where = table.where("name");
  output.part = parts.find(table, "part");
  output.face = read_face(table, "face");
  const std::string positive_along = table.choice("positive_along", {"+z", "-z", "+r", "-r"});
  output.sign = positive_along[0] == '+' ? 1.0 : -1.0;
  output.direction = positive_along[1] == 'z' ? Direction::axial : Direction::radial;
  return output;
}

}  // namespace spindle_twin::fem_offline
