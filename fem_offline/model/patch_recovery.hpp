#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {

/// A field at every FE unknown's place from samples at the degree² Gauss points of the elements, where gradients of a
/// solution of that degree are best (superconvergent patch recovery, Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng
/// 33, 1992). Around every corner of an element a polynomial of the elements' degree is fitted to the samples of the
/// elements there by least squares, at a rim to those of one more layer; a place takes the mean of the polynomials of
/// its element's nearest corners. No patch crosses the border of a part, for parts share no point.
/// `samples[e]`: Gauss points of active cell e x components. Returns unknowns x components.
Eigen::MatrixXd recovered_at_places(const Discretisation<2>& discretisation,
                                    const std::vector<Eigen::MatrixXd>& samples);

}  // namespace spindle_twin::fem_offline
