// TreeAMR: implicit isosurfaces of a field, where rays meet them exactly, and local lighting.
//
//   treeamr::Isosurface surface(field, { 0.3, 0.7 });
//   treeamr::HitImage hits;
//   surface.render(camera, treeamr::SurfaceLayers::Nearest, hits); // of each pixel's ray the first hit
//   if (treeamr::SurfaceHit hit; surface.intersect(ray, 0., 1e30, hit)) // or of any ray
//   {
//     const treeamr::Vec3 place = treeamr::pointAt(ray, hit.t);
//   }
//
// HitImage: the hits of pixel p = x + width * y, lower left first, are hits[first[p]] up to hits[first[p + 1]]. t counts
// world length along a camera's rays, the ray's direction along others. Gradients are per unit of data coordinates.
// shade() gives a hit the colour that VTK's property and lights would.
#pragma once

#include "Geometry/Camera.h"
#include "Progress.h"
#include "Surface/Isosurface.h"
#include "Surface/Shading.h"
#include "Surface/SurfaceFrame.h"
