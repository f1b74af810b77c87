// The weights of Generalized Trilinear Interpolation: the paper's equation 9, solved, not typed in.
//
// A lattice vertex in the middle of 2^d slots takes its value from one data point per slot, at distance h/2
// along each of the d axes from an unrefined slot and h/4 from a refined one. With the d-linear basis phi
// (1, x, y, xy, ...) and V_ij = phi_j(x_i), the weights c solve V^T c = e1. The scan of the paper's Table 5
// is damaged, and its released code misses a case of it: solving the system leaves nothing to mistype.
#pragma once

#include <array>

namespace treeamr
{

/// Weights of one mask of refined slots; slot s is at the side s >> a & 1 of axis a.
template <int Dimensions>
using GTIWeights = std::array<double, 1 << Dimensions>;

/// All weights by mask (bit s = slot s is refined).
template <int Dimensions>
using GTIWeightTable = std::array<GTIWeights<Dimensions>, 1 << (1 << Dimensions)>;

extern const GTIWeightTable<1> gtiWeights1;
extern const GTIWeightTable<2> gtiWeights2;
extern const GTIWeightTable<3> gtiWeights3;

/// Those of a mask, one by one; 1 in no dimension.
template <int Dimensions>
const double* gtiWeightsOf(unsigned refined) noexcept
{
  static constexpr double one = 1.;
  if constexpr (Dimensions == 0)
  {
    return &one;
  }
  else if constexpr (Dimensions == 1)
  {
    return gtiWeights1[refined].data();
  }
  else if constexpr (Dimensions == 2)
  {
    return gtiWeights2[refined].data();
  }
  else
  {
    return gtiWeights3[refined].data();
  }
}

} // namespace treeamr
