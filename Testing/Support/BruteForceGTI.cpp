#include "Support/BruteForceGTI.h"

#include <algorithm>
#include <cmath>

namespace treeamr::test
{

namespace
{

/// Solves V^T c = e1 for points at +-1/2 or +-1/4 per axis (Cramer-free: Gauss-Jordan on the augmented
/// matrix).
std::vector<double> weights(const std::vector<std::vector<double>>& points)
{
  const std::size_t n = points.size();
  std::vector<std::vector<double>> m(n, std::vector<double>(n + 1, 0.));
  for (std::size_t basis = 0; basis < n; ++basis)
  {
    for (std::size_t p = 0; p < n; ++p)
    {
      m[basis][p] = 1.;
      for (std::size_t a = 0; a < points[p].size(); ++a)
      {
        m[basis][p] *= basis >> a & 1 ? points[p][a] : 1.;
      }
    }
    m[basis][n] = basis == 0 ? 1. : 0.;
  }
  for (std::size_t c = 0; c < n; ++c)
  {
    std::size_t best = c;
    for (std::size_t r = c; r < n; ++r)
    {
      best = std::abs(m[r][c]) > std::abs(m[best][c]) ? r : best;
    }
    std::swap(m[c], m[best]);
    for (std::size_t r = 0; r < n; ++r)
    {
      const double factor = r == c ? 0. : m[r][c] / m[c][c];
      for (std::size_t k = 0; k <= n; ++k)
      {
        m[r][k] -= factor * m[c][k];
      }
    }
  }
  std::vector<double> solution(n);
  for (std::size_t r = 0; r < n; ++r)
  {
    solution[r] = m[r][n] / m[r][r];
  }
  return solution;
}

Coord floorDiv(Coord a, Coord b)
{
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/// A vertex off a lattice, between two that are off it along fewer axes.
struct Hanging
{
  BruteForceGTI::Vertex low;
  BruteForceGTI::Vertex high;
  double fraction; // of the way
};

std::optional<Hanging> hangingOn(Coord spacing, const BruteForceGTI::Vertex& v)
{
  for (int a = 0; a < 3; ++a)
  {
    Hanging h{ v, v, 0. };
    h.low[a] = floorDiv(v[a], spacing) * spacing;
    if (h.low[a] != v[a])
    {
      h.high[a] = h.low[a] + spacing;
      h.fraction = static_cast<double>(v[a] - h.low[a]) / static_cast<double>(spacing);
      return h;
    }
  }
  return std::nullopt;
}

} // namespace

BruteForceGTI::BruteForceGTI(std::array<int, 3> roots, const std::vector<LeafCell>& cells, bool octantRule)
  : roots_(roots)
  , octantRule_(octantRule)
  , cells_(cells)
{
  for (const LeafCell& c : cells_)
  {
    finest_ = std::max(finest_, c.cell.level);
  }
  for (const LeafCell& c : cells_)
  {
    for (int level = c.cell.level; level >= 0; --level)
    {
      const int up = c.cell.level - level;
      Node& node = nodes_[Key{ level, c.cell.index[0] >> up, c.cell.index[1] >> up, c.cell.index[2] >> up }];
      const double volume = std::ldexp(1., -3 * c.cell.level);
      node.sum += static_cast<double>(c.value) * volume;
      node.volume += volume;
      node.leaf = up == 0 ? &c : node.leaf;
    }
  }
}

const BruteForceGTI::Node* BruteForceGTI::find(int level, const std::array<Coord, 3>& i) const
{
  const auto found = nodes_.find(Key{ level, i[0], i[1], i[2] });
  return found == nodes_.end() ? nullptr : &found->second;
}

std::optional<double> BruteForceGTI::cellValue(int level, const std::array<Coord, 3>& i) const
{
  if (const Node* node = find(level, i))
  {
    return node->leaf ? node->leaf->value : node->sum / node->volume;
  }
  for (int up = 1; up <= level; ++up)
  {
    const Node* node = find(level - up, { i[0] >> up, i[1] >> up, i[2] >> up });
    if (node && node->leaf)
    {
      return node->leaf->value;
    }
  }
  return std::nullopt;
}

bool BruteForceGTI::isRefined(int level, const std::array<Coord, 3>& index) const
{
  const Node* node = find(level, index);
  return node && !node->leaf;
}

int BruteForceGTI::coarsestAround(const Vertex& v) const
{
  int coarsest = finest_ + 1;
  for (int level = finest_; level >= 0; --level)
  {
    for (int side = 0; side < 8; ++side)
    {
      std::array<Coord, 3> index;
      for (int a = 0; a < 3; ++a)
      {
        index[a] = floorDiv(side >> a & 1 ? v[a] : v[a] - 1, width(level));
      }
      const Node* node = find(level, index);
      coarsest = node && node->leaf ? level : coarsest;
    }
  }
  return coarsest;
}

BruteForceGTI::Datum BruteForceGTI::datumOf(
  int level, const std::array<Coord, 3>& index, const Vertex& v) const
{
  const Node* node = find(level, index);
  if (!node)
  {
    return { std::nullopt, 0.5, false };
  }
  if (node->leaf)
  {
    return { node->leaf->value, 0.5, true };
  }
  double sum = 0.;
  int count = 0;
  bool isWhole = true;
  for (int o = 0; o < 8; ++o)
  {
    std::array<Coord, 3> child;
    bool touches = true;
    for (int a = 0; a < 3; ++a)
    {
      child[a] = 2 * index[a] + (o >> a & 1);
      touches = touches && child[a] * width(level + 1) <= v[a] && v[a] <= (child[a] + 1) * width(level + 1);
    }
    const Node* c = touches ? find(level + 1, child) : nullptr;
    isWhole = isWhole && (!touches || (c && c->volume == std::ldexp(1., -3 * (level + 1))));
    sum += c ? c->sum / c->volume : 0.;
    count += c != nullptr;
  }
  if (count == 0)
  {
    return { std::nullopt, 0.5, false };
  }
  return { sum / count, octantRule_ ? 0.5 : 0.25, isWhole };
}

std::optional<double> BruteForceGTI::vertex(const Vertex& v, bool* gap) const
{
  // Step 1: the coarsest leaf that touches v, looked for on all eight sides of it.
  const int coarsest = coarsestAround(v);
  if (coarsest > finest_)
  {
    return std::nullopt;
  }
  const Coord w = width(coarsest);
  const Coord half = w / 2;

  // Step 2: a vertex off that level's octant lattice is interpolated along one or two axes. Those that it is between may
  // hang along another one: their own step 2, at this same level.
  if (const auto between = hangingOn(half, v))
  {
    return (1. - between->fraction) * vertex(between->low, gap).value() +
      between->fraction * vertex(between->high, gap).value();
  }

  // Step 3: the cells of that level around v, along the axes in which v is not at their middle.
  std::vector<int> axes;
  for (int a = 0; a < 3; ++a)
  {
    if (floorDiv(v[a], w) * w == v[a])
    {
      axes.push_back(a);
    }
  }
  std::vector<std::vector<double>> points;
  std::vector<std::optional<double>> data;
  bool incomplete = false;
  for (std::size_t s = 0; s < std::size_t(1) << axes.size(); ++s)
  {
    std::array<Coord, 3> index;
    for (int a = 0; a < 3; ++a)
    {
      index[a] = floorDiv(v[a], w);
    }
    std::vector<double> sign;
    for (std::size_t d = 0; d < axes.size(); ++d)
    {
      const bool upper = s >> d & 1;
      index[axes[d]] -= upper ? 0 : 1;
      sign.push_back(upper ? 1. : -1.);
    }
    const Datum datum = datumOf(coarsest, index, v);
    incomplete = incomplete || !datum.isWhole;
    for (double& x : sign)
    {
      x *= datum.distance;
    }
    points.push_back(sign);
    data.push_back(datum.value);
  }
  if (gap && incomplete)
  {
    *gap = true;
  }
  const std::vector<double> c = weights(points);
  double sum = 0.;
  double total = 0.;
  for (std::size_t s = 0; s < data.size(); ++s)
  {
    sum += data[s] ? c[s] * *data[s] : 0.;
    total += data[s] ? c[s] : 0.;
  }
  return sum / total;
}

bool BruteForceGTI::isEven(const Vertex& v, int axis) const
{
  const int coarsest = coarsestAround(v);
  if (coarsest > finest_)
  {
    return false;
  }
  if (const auto between = hangingOn(width(coarsest) / 2, v))
  {
    return isEven(between->low, axis) && isEven(between->high, axis);
  }
  // A little to all sides of v lie the cells that touch it.
  const auto touched = [&](int level, int side) {
    std::array<Coord, 3> index;
    for (int a = 0; a < 3; ++a)
    {
      index[a] = floorDiv(2 * v[a] + (side >> a & 1 ? 1 : -1), 2 * width(level));
    }
    return find(level, index);
  };
  std::array<bool, 8> has;
  for (int side = 0; side < 8; ++side)
  {
    const Node* cell = touched(coarsest, side);
    has[side] = cell && (cell->leaf || touched(coarsest + 1, side));
  }
  for (int side = 0; side < 8; ++side)
  {
    if (has[side] != has[side ^ 1 << axis])
    {
      return false;
    }
  }
  return true;
}

std::array<double, 3> BruteForceGTI::gradient(const Vertex& v, const RootGrid& grid) const
{
  const Coord half = width(coarsestAround(v)) / 2;
  if (const auto between = hangingOn(half, v))
  {
    std::array<double, 3> mean = gradient(between->low, grid);
    const std::array<double, 3> high = gradient(between->high, grid);
    for (int a = 0; a < 3; ++a)
    {
      mean[a] += between->fraction * (high[a] - mean[a]);
    }
    return mean;
  }
  std::array<double, 3> slopes;
  for (int a = 0; a < 3; ++a)
  {
    std::vector<Vertex> exist;
    std::vector<Vertex> even;
    for (Coord k = -2; k <= 2; ++k)
    {
      Vertex along = v;
      along[a] += k * half;
      if (vertex(along))
      {
        exist.push_back(along);
      }
      if (isEven(along, a))
      {
        even.push_back(along);
      }
    }
    const std::vector<Vertex>& used = even.size() > 1 ? even : exist;
    const auto world = [&](const Vertex& w) { return grid.worldPlane(a, w[a], finest_ + 1); };
    slopes[a] = (*vertex(used.back()) - *vertex(used.front())) / (world(used.back()) - world(used.front()));
  }
  return slopes;
}

const CellId* BruteForceGTI::leafAt(const std::array<double, 3>& p) const
{
  for (int level = 0; level <= finest_; ++level)
  {
    std::array<Coord, 3> index;
    for (int a = 0; a < 3; ++a)
    {
      index[a] = static_cast<Coord>(std::floor(std::ldexp(p[a], level)));
      index[a] -= p[a] == roots_[a] ? 1 : 0;
    }
    const Node* node = find(level, index);
    if (node && node->leaf)
    {
      return &node->leaf->cell;
    }
  }
  return nullptr;
}

std::optional<double> BruteForceGTI::value(const std::array<double, 3>& p) const
{
  const CellId* leaf = leafAt(p);
  return leaf ? std::optional<double>(valueInside(*leaf, p)) : std::nullopt;
}

double BruteForceGTI::valueInside(const CellId& leaf, const std::array<double, 3>& p, bool* gap) const
{
  const Coord half = width(leaf.level) / 2;
  Vertex base;
  std::array<double, 3> f;
  for (int a = 0; a < 3; ++a)
  {
    const double local = 2. * (std::ldexp(p[a], leaf.level) - static_cast<double>(leaf.index[a]));
    const int octant = local >= 1. ? 1 : 0;
    base[a] = (2 * leaf.index[a] + octant) * half;
    f[a] = local - octant;
  }
  double sum = 0.;
  for (int c = 0; c < 8; ++c)
  {
    Vertex v = base;
    double weight = 1.;
    for (int a = 0; a < 3; ++a)
    {
      v[a] += c >> a & 1 ? half : 0;
      weight *= c >> a & 1 ? f[a] : 1. - f[a];
    }
    sum += weight * vertex(v, gap).value();
  }
  return sum;
}

} // namespace treeamr::test
