// Colours of isosurfaces by an array, as vtkMapper's scalar settings ask for. Private to the module.
#pragma once

#include "HyperTreeGridConverter.h"

#include "Surface/Isosurface.h"

#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

class vtkDataArray;
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
    , values_(rgba_->GetPointer(0))
    , per_(per)
  {
  }
  explicit operator bool() const noexcept { return rgba_ != nullptr; }
  /// Of hits[i].
  const unsigned char* at(std::span<const SurfaceHit> hits, std::size_t i) const
  {
    return values_ + 4 * (per_ == Per::Surface ? hits[i].surface : i);
  }

private:
  vtkSmartPointer<vtkUnsignedCharArray> rgba_;
  const unsigned char* values_ = nullptr; // its
  Per per_ = Per::Hit;
};

/// What a mapper colours by.
struct ColorSource
{
  vtkDataArray* array = nullptr; // null: nothing, the solid colour
  // The values that the lookup table gets for each point: one each.
  std::vector<ArraySelection> components;
  /// Whether the values are colours themselves.
  bool direct = false;
};

/// Gives the mapper the array's own lookup table when it has one, as vtkMapper does. Throws Error for an
/// array that the grid has not.
ColorSource selectColors(vtkMapper* mapper, vtkHyperTreeGrid* grid);

/// Whether some of an array's colours are translucent, as far as vtkMapper goes into it, or that of NaN,
/// which VTK's transfer functions leave out of account. Null: of any array of values.
bool isTranslucent(vtkMapper* mapper, vtkDataArray* array);

/// Of surfaces coloured by the array that they are isosurfaces of: of the isovalues themselves.
HitColors mapIsovalues(vtkMapper* mapper, const ColorSource& source, const std::vector<double>& isovalues);
/// values: of each hit its components, less their offsets.
HitColors mapValues(vtkMapper* mapper, const ColorSource& source, std::vector<float>& values,
  const std::vector<double>& offsets);

/// Whether the mapper's table looks values up as categories, with nothing in between; of colours it looks
/// none up.
bool hasCategories(vtkMapper* mapper, const ColorSource& source);
/// The number of the category of each hit's cell; NaN where the categories have none.
std::vector<float> categoriesAtHits(
  const Categories& categories, const Isosurface& surface, std::span<const SurfaceHit> hits);
/// Of such numbers. Surfaces of an isovalue that the table lists have its colour instead; isovalues: of the
/// hits' surfaces, null when they are of another array.
HitColors mapCategories(vtkMapper* mapper, const Categories& categories, const std::vector<float>& numbers,
  std::span<const SurfaceHit> hits, const std::vector<double>* isovalues);

} // namespace treeamr
