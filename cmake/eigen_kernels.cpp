#define SPINDLE_TWIN_EIGEN_KERNEL template
#include "cmake/eigen_kernels.hpp"
