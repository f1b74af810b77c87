// TreeAMR: isosurfaces of a field as triangles, watertight across levels.
//
//   const treeamr::ContourMesh mesh = treeamr::contour(*field, 0.5, { .gradients = true });
//
// points: coordinates of the field; triangles: three places in points each, whose normals by the right-hand rule point to
// lower values; gradients: one a point, per unit of length. Of another field on the same octree interpolate() gives the
// values at the points, less its offset.
#pragma once

#include "Contour/Contour.h"
