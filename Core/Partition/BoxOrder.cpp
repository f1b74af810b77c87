#include "Partition/BoxOrder.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace treeamr
{

namespace
{

LatticeBox around(const LatticeBox& a, const LatticeBox& b) noexcept
{
  if (a.isEmpty() || b.isEmpty())
  {
    return a.isEmpty() ? b : a;
  }
  LatticeBox both = a;
  for (int axis = 0; axis < 3; ++axis)
  {
    both.begin[axis] = std::min(a.begin[axis], b.begin[axis]);
    both.end[axis] = std::max(a.end[axis], b.end[axis]);
  }
  return both;
}

/// Along the cuts, of which each parts two halves of a list.
class Sorting
{
public:
  Sorting(const std::vector<LatticeBox>& boxes, const RootGrid& grid, const Camera& camera)
    : boxes_(boxes)
    , grid_(grid)
    , camera_(camera)
    , direction_(camera.ray(camera.width() / 2, camera.height() / 2).direction)
  {
  }

  /// Appends them to `order`; the box around them.
  LatticeBox sort(int first, int count, std::vector<int>& order) const
  {
    if (count == 1)
    {
      const LatticeBox& box = boxes_[static_cast<std::size_t>(first)];
      if (!box.isEmpty())
      {
        order.push_back(first);
      }
      return box;
    }
    const int lowerCount = (count + 1) / 2;
    const auto begin = static_cast<std::ptrdiff_t>(order.size());
    const LatticeBox lower = sort(first, lowerCount, order);
    const auto middle = static_cast<std::ptrdiff_t>(order.size());
    const LatticeBox upper = sort(first + lowerCount, count - lowerCount, order);
    if (!lower.isEmpty() && !upper.isEmpty() && upperIsNearer(lower, upper))
    {
      std::rotate(order.begin() + begin, order.begin() + middle, order.end());
    }
    return around(lower, upper);
  }

private:
  bool upperIsNearer(const LatticeBox& lower, const LatticeBox& upper) const
  {
    for (int a = 0; a < 3; ++a)
    {
      if (lower.end[a] <= upper.begin[a])
      {
        const double plane = grid_.worldPlane(a, lower.end[a], lower.level);
        return camera_.nearestOctant({ plane, plane, plane }, direction_) >> a & 1;
      }
    }
    throw Error(
      "boxes of a domain: no plane parts two halves of their list, as those of a kd-tree are parted");
  }

  const std::vector<LatticeBox>& boxes_;
  const RootGrid& grid_;
  const Camera& camera_;
  Vec3 direction_;
};

} // namespace

std::vector<int> frontToBack(const std::vector<LatticeBox>& boxes, const RootGrid& grid, const Camera& camera)
{
  std::vector<int> order;
  if (!boxes.empty())
  {
    Sorting(boxes, grid, camera).sort(0, static_cast<int>(boxes.size()), order);
  }
  return order;
}

BoxFootprint::BoxFootprint(const Bounds& box, const Camera& camera)
  : box_(box)
  , camera_(&camera)
  , left_(0)
  , right_(camera.width())
  , lower_(0)
  , upper_(camera.height())
{
  const Matrix4& m = camera.clipFromData();
  double least[2] = { 1., 1. };
  double most[2] = { -1., -1. };
  for (int corner = 0; corner < 8; ++corner)
  {
    double clip[4];
    for (int row = 0; row < 4; ++row)
    {
      clip[row] = m[4 * row + 3];
      for (int a = 0; a < 3; ++a)
      {
        clip[row] += m[4 * row + a] * (corner >> a & 1 ? box.max[a] : box.min[a]);
      }
    }
    if (!(clip[2] > -clip[3]) || !(clip[3] > 0.))
    {
      return; // before the near plane: anywhere
    }
    for (int a = 0; a < 2; ++a)
    {
      least[a] = std::min(least[a], clip[a] / clip[3]);
      most[a] = std::max(most[a], clip[a] / clip[3]);
    }
  }
  // A pixel more on each side is more than rounding takes.
  const auto pixel = [](double ndc, int pixels, double aside) {
    return static_cast<int>(std::clamp(std::floor(0.5 * (ndc + 1.) * pixels + aside), 0., double(pixels)));
  };
  left_ = pixel(least[0], right_, -1.);
  right_ = pixel(most[0], right_, 2.);
  lower_ = pixel(least[1], upper_, -1.);
  upper_ = pixel(most[1], upper_, 2.);
}

bool BoxFootprint::meets(const Ray& ray, bool endsAtFarPlane) const noexcept
{
  double begin = camera_->tFromDepth(ray, 0.);
  double end = endsAtFarPlane ? camera_->tFromDepth(ray, 1.) : std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    const double low = (box_.min[a] - ray.origin[a]) / ray.direction[a];
    const double high = (box_.max[a] - ray.origin[a]) / ray.direction[a];
    if (!std::isnan(low) && !std::isnan(high)) // else it runs in a face
    {
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
  }
  return begin < end;
}

bool BoxFootprint::isSeen() const noexcept
{
  for (int y = lower_; y < upper_; ++y)
  {
    for (int x = left_; x < right_; ++x)
    {
      if (meets(camera_->ray(x, y), true))
      {
        return true;
      }
    }
  }
  return false;
}

} // namespace treeamr
