#include "Partition/BoxCuts.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace treeamr
{

namespace
{

/// Along an axis of some roots.
Coord placesAlong(int roots, int level) noexcept
{
  return level >= 0 ? Coord(roots) << level : ((roots - 1) >> -level) + 1;
}

class Cutter
{
public:
  explicit Cutter(const CellHistogram& histogram)
    : histogram_(histogram)
  {
  }

  void cut(const LatticeBox& box, int parts)
  {
    if (parts == 1)
    {
      boxes.push_back(box);
      return;
    }
    const int below = (parts + 1) / 2;
    const Plane plane = best(box, static_cast<double>(below) / parts);
    LatticeBox lower = box;
    LatticeBox upper = box;
    lower.end[plane.axis] = plane.at;
    upper.begin[plane.axis] = plane.at;
    cut(lower, below);
    cut(upper, parts - below);
  }

  std::vector<LatticeBox> boxes;

private:
  struct Plane
  {
    int axis;
    Coord at;
  };

  /// The cells of each layer across an axis.
  std::vector<double> layers(const LatticeBox& box, int axis) const
  {
    std::vector<double> sums(static_cast<std::size_t>(box.end[axis] - box.begin[axis]), 0.);
    const std::array<Coord, 3>& size = histogram_.size();
    std::array<Coord, 3> at;
    for (at[2] = box.begin[2]; at[2] < box.end[2]; ++at[2])
    {
      for (at[1] = box.begin[1]; at[1] < box.end[1]; ++at[1])
      {
        for (at[0] = box.begin[0]; at[0] < box.end[0]; ++at[0])
        {
          sums[at[axis] - box.begin[axis]] +=
            histogram_.counts()[at[0] + size[0] * (at[1] + size[1] * at[2])];
        }
      }
    }
    return sums;
  }

  /// With about `share` of the cells below and few cells beside it, of which either side needs the other's.
  Plane best(const LatticeBox& box, double share) const
  {
    Plane found{ 0, box.end[0] };
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
    {
      const std::vector<double> layer = layers(box, axis);
      double all = 0.;
      for (const double cells : layer)
      {
        all += cells;
      }
      double below = 0.;
      for (std::size_t i = 1; i < layer.size(); ++i)
      {
        below += layer[i - 1];
        // Without cells the halves are to be of one size.
        const double part =
          all > 0. ? below / all : static_cast<double>(i) / static_cast<double>(layer.size());
        const double beside = all > 0. ? (layer[i - 1] + layer[i]) / all : 0.;
        const double cost = 2. * std::abs(part - share) + beside;
        if (cost < least)
        {
          least = cost;
          found = { axis, box.begin[axis] + static_cast<Coord>(i) };
        }
      }
    }
    return found;
  }

  const CellHistogram& histogram_;
};

} // namespace

int CellHistogram::levelFor(const std::array<int, 3>& roots, int parts, int deepestLevel) noexcept
{
  // 8 places of each box along each axis, 32 in all if it is one box; a list of 16 MiB at most.
  const double wanted = std::clamp(512. * parts, 0x1p15, 0x1p21);
  double places = static_cast<double>(roots[0]) * roots[1] * roots[2];
  int level = 0;
  for (; level < deepestLevel && 8. * places <= wanted; ++level)
  {
    places *= 8.;
  }
  const auto placesAt = [&](int of) {
    double product = 1.;
    for (const int count : roots)
    {
      product *= static_cast<double>(placesAlong(count, of));
    }
    return product;
  };
  for (; placesAt(level) > 0x1p21; --level)
  {
  }
  return level;
}

CellHistogram::CellHistogram(const std::array<int, 3>& roots, int level)
  : level_(level)
  , roots_(roots)
  , size_{ placesAlong(roots[0], level), placesAlong(roots[1], level), placesAlong(roots[2], level) }
  , counts_(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]), 0.)
{
}

void CellHistogram::add(const CellId& cell, double count) noexcept
{
  const int up = std::max(0, cell.level - level_);
  const int down = std::max(0, level_ - cell.level);
  const Coord width = Coord(1) << down;
  const double part = count * std::exp2(-3. * down);
  const auto first = [&](int a) { return cell.index[a] >> up << down; };
  for (Coord z = first(2); z < first(2) + width; ++z)
  {
    for (Coord y = first(1); y < first(1) + width; ++y)
    {
      for (Coord x = first(0); x < first(0) + width; ++x)
      {
        counts_[x + size_[0] * (y + size_[1] * z)] += part;
      }
    }
  }
}

std::vector<LatticeBox> cutBoxes(const CellHistogram& histogram, int parts)
{
  Cutter cutter(histogram);
  cutter.cut({ histogram.level(), {}, histogram.size() }, parts);
  const int rootsPerPlace = std::max(0, -histogram.level());
  for (LatticeBox& box : cutter.boxes)
  {
    box.level = std::max(0, box.level);
    for (int a = 0; a < 3; ++a)
    {
      box.begin[a] <<= rootsPerPlace;
      box.end[a] = std::min(box.end[a] << rootsPerPlace, Coord(histogram.roots()[a]) << box.level);
    }
  }
  return std::move(cutter.boxes);
}

} // namespace treeamr
