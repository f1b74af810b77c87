// What pictures are compared by, and how small ones are magnified.
#pragma once

#include "Geometry/Image.h"

namespace treeamr::report
{

/// Mean structural similarity of the luminances (Wang, Bovik, Sheikh and Simoncelli 2004): 1 for equal pictures. By
/// their weights, a Gaussian of 1.5 pixels cut to 11 x 11, over the places where it fits the picture; colours as
/// they are over black, within [0, 1]. Throws Error for sizes that differ or are below 11 x 11.
double structuralSimilarity(const Image& a, const Image& b);

/// Bilinear between the centres of pixels, beyond the outermost constant, as the window shows an image of fewer rays
/// where nothing is before or in the volume.
Image magnify(const Image& image, int width, int height);

} // namespace treeamr::report
