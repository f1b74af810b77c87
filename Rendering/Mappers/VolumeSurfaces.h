// The isosurfaces that a volume mapper draws: built, traced and lit when what they depend on has changed.
// Private to the module.
#pragma once

#include "SurfaceLevels.h"

#include "Geometry/RayStops.h"
#include "Surface/Isosurface.h"
#include "Surface/Shading.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace treeamr
{

/// Of the surface of one isovalue.
struct SurfaceMaterial
{
  Material material;
  float opacity = 1.f;
};

class VolumeSurfaces
{
public:
  /// True when the field or the isovalues are not those of the last call.
  bool set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues);
  bool isEmpty() const noexcept { return levels_.isEmpty(); }
  /// What was traced last; null before, and after release().
  const Isosurface* engine() const noexcept { return engine_.get(); }
  void release();

  /// All hits of an image of width x height pixels; the last ones when nothing has changed. Cells smaller than
  /// levelOfDetail pixels are drawn together. Throws Error as Isosurface().
  void trace(const Matrix4& clipFromData, int width, int height, double levelOfDetail);
  /// Colours of the last trace()'s hits; materials: one by isovalue of the engine; lights in view
  /// coordinates.
  void light(const std::vector<SurfaceMaterial>& materials, const std::vector<Light>& lights,
    const Matrix4& viewFromData);
  /// Valid until the next call of any other member.
  TranslucentHits hits() const noexcept { return { hits_.first, lit_ }; }

private:
  SurfaceLevels levels_;
  std::shared_ptr<const Isosurface> engine_;
  std::optional<Camera> camera_; // of the hits
  Matrix4 clipFromData_{};
  HitImage hits_;
  std::vector<TranslucentHit> lit_;
};

} // namespace treeamr
