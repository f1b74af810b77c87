#include "Interpolation/GTIWeights.h"

#include <cmath>
#include <utility>

namespace treeamr
{

namespace
{

/// Solves the n x n system by elimination with row pivots.
template <int N>
std::array<double, N> solve(std::array<std::array<double, N>, N> a, std::array<double, N> b)
{
  for (int c = 0; c < N; ++c)
  {
    int pivot = c;
    for (int r = c + 1; r < N; ++r)
    {
      pivot = std::abs(a[r][c]) > std::abs(a[pivot][c]) ? r : pivot;
    }
    std::swap(a[c], a[pivot]);
    std::swap(b[c], b[pivot]);
    for (int r = c + 1; r < N; ++r)
    {
      const double factor = a[r][c] / a[c][c];
      for (int k = c; k < N; ++k)
      {
        a[r][k] -= factor * a[c][k];
      }
      b[r] -= factor * b[c];
    }
  }
  for (int r = N; r-- > 0;)
  {
    for (int k = r + 1; k < N; ++k)
    {
      b[r] -= a[r][k] * b[k];
    }
    b[r] /= a[r][r];
  }
  return b;
}

} // namespace

template <int Dimensions>
GTIWeights<Dimensions>::GTIWeights()
{
  for (unsigned mask = 0; mask < weights_.size(); ++mask)
  {
    std::array<std::array<double, slots>, slots> transposed;
    for (int s = 0; s < slots; ++s)
    {
      const double distance = mask >> s & 1 ? 1. : 2.; // in quarters of h: a common factor cancels
      for (int basis = 0; basis < slots; ++basis)
      {
        double phi = 1.;
        for (int a = 0; a < Dimensions; ++a)
        {
          phi *= basis >> a & 1 ? (s >> a & 1 ? distance : -distance) : 1.;
        }
        transposed[basis][s] = phi;
      }
    }
    Weights e1{};
    e1[0] = 1.;
    weights_[mask] = solve<slots>(transposed, e1);
  }
}

template <int Dimensions>
const GTIWeights<Dimensions>& GTIWeights<Dimensions>::table()
{
  static const GTIWeights instance;
  return instance;
}

template class GTIWeights<1>;
template class GTIWeights<2>;
template class GTIWeights<3>;

} // namespace treeamr
