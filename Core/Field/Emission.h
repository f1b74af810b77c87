// What a transfer function emits between two entries: colour times extinction, a product of two lines, which tables have
// as one line.
#pragma once

#include <cmath>

namespace treeamr
{

/// Nodes of a transfer function from which on its tables are made of as few lines as show its colours to
/// `colorsOfMany` of a channel: what thousands of lines err by is not seen as one colour, and they fill caches.
constexpr unsigned manyNodes = 1024;
constexpr double colorsOfMany = 1. / 512.;

/// What a colour is moved by, so that the line from product to product shows colours as far off to either side: the line
/// alone is off by part (1 - part) change (last - first) / extinction, at most by twice that. change: of the colour, from
/// one of both extinctions to the other.
template <class Real>
Real shiftOfProducts(Real change, Real first, Real last) noexcept
{
  const Real roots = std::sqrt(first) + std::sqrt(last);
  return roots > 0 ? Real(-0.5) * change * ((last - first) / roots) / roots : Real(0);
}

/// The shift as tables of many nodes have it: what is hardly off stays, so that its line goes on where the next one is the
/// same.
template <class Real>
Real shiftInTables(Real shift) noexcept
{
  constexpr auto least = static_cast<Real>(colorsOfMany / 16.);
  return std::abs(shift) > least ? shift : Real(0);
}

} // namespace treeamr
