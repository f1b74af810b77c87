// The mean over a cell of a function that a finite element of deal.II's has values of: which of them weigh how much.
//
// FE_Q(n) and FE_DGQ(n) have their support points at those of the Gauss-Lobatto quadrature, whose weights give the exact
// mean; FE_DGQ(0) has one at the centre. FE_Q_DG0(n) is FE_Q(n) with one more value that counts everywhere; FE_Q_iso_Q1(n)
// is trilinear between n + 1 equidistant points a line; FE_DGP(n) and FE_DGQLegendre(n) have orthogonal polynomials, of
// which the constant comes first. The weights are the same whichever way lines and faces are turned.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace treeamr
{

/// Weights of the values of a scalar element, in the element's own order: each of the 8 vertices has those of `vertex`, each
/// of the 12 lines and 6 quads those of `line` and `quad`, then come those of the cell's inside. Their sum is 1 where all
/// functions are interpolated.
struct ElementMean
{
  std::vector<double> vertex;
  std::vector<double> line;
  std::vector<double> quad;
  std::vector<double> hex;
  bool isInterpolated = true; // whether each value is that of the function at a point
};

/// Up to which degree there are weights; no deal.II program has more.
constexpr int maxElementDegree = 16;

/// Nothing for a name or a degree that is not known. degree: 0 to maxElementDegree.
std::optional<ElementMean> elementMean(std::string_view name, int degree);

/// The names, for messages.
std::string elementNames();

} // namespace treeamr
