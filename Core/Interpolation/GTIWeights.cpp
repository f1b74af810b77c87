#include "Interpolation/GTIWeights.h"

#include <utility>

namespace treeamr
{

namespace
{

constexpr double magnitude(double x)
{
  return x < 0. ? -x : x;
}

/// Solves the n x n system by elimination with row pivots.
template <int N>
constexpr std::array<double, N> solve(std::array<std::array<double, N>, N> a, std::array<double, N> b)
{
  for (int c = 0; c < N; ++c)
  {
    int pivot = c;
    for (int r = c + 1; r < N; ++r)
    {
      pivot = magnitude(a[r][c]) > magnitude(a[pivot][c]) ? r : pivot;
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

template <int Dimensions>
constexpr GTIWeightTable<Dimensions> makeTable()
{
  constexpr int slots = 1 << Dimensions;
  GTIWeightTable<Dimensions> table{};
  for (unsigned mask = 0; mask < table.size(); ++mask)
  {
    std::array<std::array<double, slots>, slots> transposed{};
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
    GTIWeights<Dimensions> e1{};
    e1[0] = 1.;
    table[mask] = solve<slots>(transposed, e1);
  }
  return table;
}

} // namespace

// Solved by the compiler: no initialisation at run time, no guard at each access.
constinit const GTIWeightTable<1> gtiWeights1 = makeTable<1>();
constinit const GTIWeightTable<2> gtiWeights2 = makeTable<2>();
constinit const GTIWeightTable<3> gtiWeights3 = makeTable<3>();

} // namespace treeamr
