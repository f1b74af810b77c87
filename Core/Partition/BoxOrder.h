// What a camera sees of the boxes that a domain is cut into: their order from the eye, and which pixels' rays meet one.
#pragma once

#include "Geometry/Camera.h"
#include "Partition/LatticeBox.h"

#include <vector>

namespace treeamr
{

/// The numbers of those that are not empty, nearest first: for every ray of the camera. boxes: in the order of cutBoxes().
/// Throws Error when no planes part them.
std::vector<int> frontToBack(
  const std::vector<LatticeBox>& boxes, const RootGrid& grid, const Camera& camera);

/// Of one box.
class BoxFootprint
{
public:
  /// The camera must outlive it.
  BoxFootprint(const Bounds& box, const Camera& camera);

  ///@{
  /// Pixels, of which no others' rays meet the box.
  int left() const noexcept { return left_; }
  int right() const noexcept { return right_; } // up to, but without
  int lower() const noexcept { return lower_; }
  int upper() const noexcept { return upper_; } // as right()
  ///@}
  /// Whether there is some of the box on a pixel's ray, from the near plane on.
  bool meets(int x, int y) const noexcept { return meets(camera_->ray(x, y), false); }
  /// Of camera.ray(x, y), up to the far plane only where that ends it.
  bool meets(const Ray& ray, bool endsAtFarPlane) const noexcept;
  /// Whether any pixel's ray meets it before the far plane.
  bool isSeen() const noexcept;

private:
  Bounds box_;
  const Camera* camera_;
  int left_;
  int right_;
  int lower_;
  int upper_;
};

} // namespace treeamr
