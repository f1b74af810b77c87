// TreeAMR: volumes of a field, emission and absorption along rays, front to back, lit or not.
//
//   treeamr::TransferFunction colors(0., 1., entries); // value range; { r, g, b, extinction } in equal steps over it
//   // (the value range less field->offset(), if the field has one)
//   treeamr::Camera camera(clipFromData, width, height); // row-major 4 x 4 matrix, as of OpenGL: NDC from -1 to 1
//   treeamr::Image image(width, height);
//   treeamr::Volume volume(field, colors);
//   volume.render(camera, {}, image);
//
// Image: width * height pixels of four floats, row by row from the lower left: linear red, green and blue times alpha,
// alpha. Extinction counts per unit of length of the field's coordinates (of the world, where the camera is given a
// matrix to it). VolumeSettings has light, gradient opacity and what else rays may make of values: their largest or
// smallest, averages, sums. RayStops, in a RayView beside the camera, leaves out what clipping planes, cropping regions
// and depths hide. The next frame, from wherever, has the vertex values of this one. Rendering is on all threads of TBB's
// arena.
#pragma once

#include "Field/TransferFunction.h"
#include "Geometry/Camera.h"
#include "Geometry/Image.h"
#include "Geometry/RayStops.h"
#include "Progress.h"
#include "Volume/Volume.h"
