// Colours of isosurfaces by an array, as vtkMapper's scalar settings ask for. Private to the module.
#pragma once

#include "HyperTreeGridConverter.h"

#include "RayTracing/Isosurface.h"

#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

class vtkHyperTreeGrid;
class vtkMapper;

namespace treeamr
{

/// RGBA of hits, where there is any.
class HitColors
{
public:
  enum class Per
  {
    Hit,
    Surface // of Isosurface::isovalues()
  };
  /// None: hits have the solid colour.
  HitColors() = default;
  HitColors(vtkSmartPointer<vtkUnsignedCharArray> rgba, Per per)
    : rgba_(std::move(rgba))
    , per_(per)
  {
  }
  explicit operator bool() const noexcept { return rgba_ != nullptr; }
  /// Of hits[i].
  const unsigned char* at(std::span<const SurfaceHit> hits, std::size_t i) const
  {
    return rgba_->GetPointer(4 * static_cast<vtkIdType>(per_ == Per::Surface ? hits[i].surface : i));
  }

private:
  vtkSmartPointer<vtkUnsignedCharArray> rgba_;
  Per per_ = Per::Hit;
};

/// The array that the mapper colours by, and which of its components; without a name there is none. Throws Error for an
/// array that the grid has not.
ArraySelection selectColors(vtkMapper* mapper, vtkHyperTreeGrid* grid);

/// Of surfaces coloured by the array that they are isosurfaces of: of the isovalues themselves.
HitColors mapIsovalues(vtkMapper* mapper, const std::vector<double>& isovalues);
/// Of one value of the selected array for each hit.
HitColors mapValues(vtkMapper* mapper, std::vector<float>& values);

/// Whether the mapper's table looks values up as categories, with nothing in between.
bool hasCategories(vtkMapper* mapper);
/// The number of the category of each hit's cell; NaN where the categories have none.
std::vector<float> categoriesAtHits(
  const Categories& categories, const Isosurface& surface, std::span<const SurfaceHit> hits);
/// Of such numbers. Surfaces of an isovalue that the table lists have its colour instead; isovalues: of the hits'
/// surfaces, null when they are of another array.
HitColors mapCategories(vtkMapper* mapper, const Categories& categories, const std::vector<float>& numbers,
  std::span<const SurfaceHit> hits, const std::vector<double>* isovalues);

} // namespace treeamr
