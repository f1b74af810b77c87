// Rays from the hits of an isosurface into its surroundings: ambient occlusion and shadows.
//
// They start on the side that the camera sees, off the surface by a small part of the cell that the hit lies in. What they
// meet is the isosurface itself, all its surfaces, but for what is cut away; other objects of a scene are not known here.
// As before Isosurface::startFrame(), no other thread queries it.
#pragma once

#include "Surface/Isosurface.h"
#include "Surface/Shading.h"

#include <cstdint>
#include <vector>

namespace treeamr
{

/// Adds to open[i] how many of the rays `first` up to `end` of hit i meet nothing within `radius` (world length).
/// Directions are distributed by their cosine with the normal, so the part of open rays is what arrives of an
/// even light from all sides. They depend on pixel and number alone: rays in portions are the same rays. Pixels
/// near each other have directions that complete each other, for filterAmbientOcclusion().
/// open: one entry for each hit, else throws Error. progress: of all hits; throws Interrupted when that is ended.
void traceAmbientOcclusion(const Isosurface& surface, const Camera& camera, const HitImage& hits,
  double radius, int first, int end, std::vector<std::uint16_t>& open, const DataCut& cut = {},
  Progress* progress = nullptr);

/// lit[l + lights.size() * i]: whether nothing stands between hit i and light l; 1 for lights that cast no shadows
/// and those behind the surface. progress: as above.
void traceShadows(const Isosurface& surface, const Camera& camera, const HitImage& hits,
  const std::vector<Light>& lights, std::vector<std::uint8_t>& lit, const DataCut& cut = {},
  Progress* progress = nullptr);

} // namespace treeamr
