#pragma once

#include <Eigen/Core>

#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/exact_field.hpp"

namespace spindle_twin::fem_offline {

/// L2 errors of a nodal field over all parts, by a Gauss rule finer than the elements' own.
FieldError field_error(const Discretisation<2>& discretisation, const Eigen::VectorXd& nodal, const ExactField& exact);

}  // namespace spindle_twin::fem_offline
