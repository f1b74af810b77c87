// A field along rays in extended precision, octant by octant, from the brute force's vertex values or others: surfaces and colours that renderers are tested against.
#pragma once

#include "Field/TransferFunction.h"
#include "Geometry/Camera.h"
#include "Support/BruteForceGTI.h"

#include <array>
#include <functional>
#include <map>
#include <vector>

namespace treeamr::test
{

/// Rays are in units of roots, of which the first has its lower corner in the origin; t is theirs.
class ExactRay
{
public:
  ExactRay(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells);
  /// Of a field that has other values at the octants' vertices than the reconstruction's.
  ExactRay(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells,
    std::function<double(const BruteForceGTI::Vertex&)> vertices);

  /// All t in [tMin, tMax] where the field crosses the isovalue.
  std::vector<double> crossings(const Ray& ray, double tMin, double tMax, double isovalue);
  /// Emission and absorption along [tMin, tMax], with so many midpoint samples in each octant: colour, premultiplied,
  /// and opacity.
  std::array<double, 4> light(
    const Ray& ray, double tMin, double tMax, const TransferFunction& transferFunction, int samples = 32);

private:
  struct Octant
  {
    long double t0; // the part of the ray in it
    long double t1;
    std::array<long double, 3> from; // places at t0 and t1, 0 to 1 in the octant
    std::array<long double, 3> to;
    std::array<long double, 8> values;

    /// The field at a part of the way, 0 to 1.
    long double at(long double part) const;
  };
  /// In the order of the ray.
  void forEachOctant(
    const Ray& ray, double tMin, double tMax, const std::function<void(const Octant&)>& visit);
  double vertex(const BruteForceGTI::Vertex& v);

  BruteForceGTI truth_;
  std::function<double(const BruteForceGTI::Vertex&)> vertices_; // none: the truth's
  int levels_ = 0;                                               // deepest level
  std::array<std::vector<Coord>, 3> planes_; // of octants, in half widths of the deepest level
  std::map<BruteForceGTI::Vertex, double> values_;
};

} // namespace treeamr::test
