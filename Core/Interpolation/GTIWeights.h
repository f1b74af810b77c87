// The weights of Generalized Trilinear Interpolation: the paper's equation 9, solved, not typed in.
//
// A lattice vertex in the middle of 2^d slots takes its value from one data point per slot, at distance h/2
// along each of the d axes from an unrefined slot and h/4 from a refined one. With the d-linear basis phi
// (1, x, y, xy, ...) and V_ij = phi_j(x_i), the weights c solve V^T c = e1. The scan of the paper's Table 5 is
// damaged, and its released code misses a case of it: solving the system leaves nothing to mistype.
#pragma once

#include <array>

namespace treeamr
{

/// Weights by mask of refined slots (bit s = slot s); slot s is at the side s >> a & 1 of axis a.
template <int Dimensions>
class GTIWeights
{
public:
  static constexpr int slots = 1 << Dimensions;
  using Weights = std::array<double, slots>;

  static const GTIWeights& table();
  const Weights& operator[](unsigned refinedMask) const noexcept { return weights_[refinedMask]; }

private:
  GTIWeights();
  std::array<Weights, 1 << slots> weights_;
};

extern template class GTIWeights<1>;
extern template class GTIWeights<2>;
extern template class GTIWeights<3>;

} // namespace treeamr
