// TreeAMR: values and gradients of a field at points.
//
//   const auto sampler = treeamr::Sampler::create(treeamr::InterpolationMethod::GTI, field);
//   if (treeamr::FieldSample at; sampler->sample({ x, y, z }, at)) // false outside all cells
//   {
//     use(at.value, at.gradient); // in double precision; the gradient per unit of length
//   }
//
// Safe from several threads; points near each other cost a tenth of points apart.
#pragma once

#include "Interpolation/Sampler.h"
