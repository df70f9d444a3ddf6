#include "fem_offline/model/imposed_temperature.hpp"

#include <muParser.h>

#include <cmath>
#include <sstream>

namespace spindle_twin::fem_offline {
namespace {

constexpr std::size_t longest_formula = 1000;  // below the length at which muParser itself gives up

[[noreturn]] void fail(const ImposedTemperature& imposed, const std::string& message) {
  throw rom::InputError(imposed.where, "imposed_temperature.rise_K", "\"" + imposed.rise_K + "\" " + message);
}

/// One number from the formula: "r, z" would be two, of which muParser takes the last.
double value_of(const mu::Parser& formula, const ImposedTemperature& imposed) {
  int count = 0;
  try {
    const double* values = formula.Eval(count);
    if (count == 1) return values[0];
  } catch (const mu::Parser::exception_type& error) {
    fail(imposed, "cannot be read: " + error.GetMsg() +
                      " Allowed are r, z (m), r_mm, z_mm, numbers, + - * / ^ and functions such as sqrt, exp, ln, sin");
  }
  fail(imposed, "must be one formula");
}

}  // namespace

Eigen::VectorXd imposed_rises_K(const ImposedTemperature& imposed, const std::vector<DofPlace>& places) {
  double r_m = 0.0, z_m = 0.0, r_mm = 0.0, z_mm = 0.0;
  mu::Parser formula;
  formula.DefineVar("r", &r_m);
  formula.DefineVar("z", &z_m);
  formula.DefineVar("r_mm", &r_mm);
  formula.DefineVar("z_mm", &z_mm);
  if (imposed.rise_K.size() > longest_formula) fail(imposed, "is longer than 1000 characters");
  formula.SetExpr(imposed.rise_K);
  Eigen::VectorXd rises_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].part < 0) continue;
    r_m = places[i].r_m;
    z_m = places[i].z_m;
    r_mm = 1e3 * r_m;
    z_mm = 1e3 * z_m;
    const double rise_K = value_of(formula, imposed);
    if (!std::isfinite(rise_K)) {
      std::ostringstream place;
      place << "is not finite at (r " << r_mm << ", z " << z_mm << ") mm";
      fail(imposed, place.str());
    }
    rises_K[static_cast<Eigen::Index>(i)] = rise_K;
  }
  return rises_K;
}

}  // namespace spindle_twin::fem_offline
