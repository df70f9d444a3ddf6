#pragma once

namespace spindle_twin::fem_offline {

/// Error of an answer on a mesh, exact value less answer, from its change to the mesh with every element cut in four
/// and from there to the one with every element cut once more (Richardson). The order is what both changes show, within
/// 0.7 and 2 x degree: fields that are singular in corners have orders near 1, smooth ones near 2 x degree. Where the
/// second change is not smaller or turns back, the changes show no order, and 1 is taken.
double error_left(double first_change, double second_change, int degree);

/// The same of the first change alone, of order 1.
inline double error_left(double first_change) { return 2.0 * first_change; }

}  // namespace spindle_twin::fem_offline
