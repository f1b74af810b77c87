// Implicit isosurface ray tracing (the paper's section 6.2): active octants in an Embree user geometry.
#pragma once

#include "Octree/Field.h"
#include "RayTracing/Camera.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace treeamr
{

/// The first hit of each pixel's ray; width * height entries, lower left first.
struct HitImage
{
  std::vector<float> depth;                    // window depth; 1 without a hit
  std::vector<std::uint8_t> hit;               // 0 or 1
  std::vector<std::array<double, 3>> point;    // data coordinates
  std::vector<std::array<double, 3>> gradient; // of the field, d value / d data coordinate
};

struct Hit
{
  double t;
  std::array<double, 3> gradient; // d value / d data coordinate
};

class Isosurface
{
public:
  /// Extracts the active octants and builds the acceleration structure. The field needs its node ranges.
  /// Throws Error for a non-finite isovalue or when Embree fails.
  Isosurface(std::shared_ptr<const Field> field, float isovalue);
  ~Isosurface();
  Isosurface(const Isosurface&) = delete;
  Isosurface& operator=(const Isosurface&) = delete;

  float isovalue() const noexcept;
  std::size_t primitiveCount() const noexcept;
  /// First hit along the ray with t in [tMin, tMax]; false: none. Safe from several threads.
  bool intersect(const Ray& ray, double tMin, double tMax, Hit& hit) const;
  /// First hits between the camera's near and far planes.
  void render(const Camera& camera, HitImage& hits) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace treeamr
