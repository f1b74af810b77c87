#include "TransferFunction2DConversion.h"

#include "TransferFunctionConversion.h"

#include "Error.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkPointData.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

namespace
{

using Pixel = std::array<double, 4>; // red, green, blue, opacity

class Pixels
{
public:
  explicit Pixels(vtkImageData* image)
    : scalars_(image->GetPointData()->GetScalars())
  {
    std::copy_n(image->GetDimensions(), 2, size_.begin());
    const int components = scalars_ ? scalars_->GetNumberOfComponents() : 0;
    if (components != 4 || size_[0] < 1 || size_[1] < 1 || image->GetDimensions()[2] != 1)
    {
      throw Error("volume property: a TransferFunction2D of " + std::to_string(size_[0]) + " x " +
        std::to_string(size_[1]) + " x " + std::to_string(image->GetDimensions()[2]) + " pixels of " +
        std::to_string(components) + " components, allowed are images in the plane x, y of 4 components");
    }
  }

  int size(int axis) const noexcept { return size_[axis]; }
  Pixel at(int x, int y) const
  {
    Pixel pixel;
    const auto row = static_cast<vtkIdType>(size_[0]) * std::min(y, size_[1] - 1);
    scalars_->GetTuple(row + std::min(x, size_[0] - 1), pixel.data());
    for (double& channel : pixel)
    {
      channel = std::clamp(std::isnan(channel) ? 0. : channel, 0., 1.);
    }
    return pixel;
  }

private:
  vtkDataArray* scalars_;
  std::array<int, 2> size_;
};

Pixel between(const Pixel& a, const Pixel& b, double part)
{
  Pixel pixel;
  std::transform(a.begin(), a.end(), b.begin(), pixel.begin(),
    [part](double of, double to) { return std::lerp(of, to, part); });
  return pixel;
}

/// How many steps there are from pixel to pixel: opacities between few pixels are not the extinctions'.
int stepsBetween(int pixels)
{
  constexpr int fewest = 256;
  return pixels < 2 ? 1 : (fewest - 2) / (pixels - 1) + 1;
}

TransferFunction2D::Axis axisOf(int pixels, double min, double max)
{
  const double half = 0.5 * (max - min) / pixels;
  return { min + half, max - half,
    pixels < 2 ? 2 : static_cast<std::size_t>(pixels - 1) * stepsBetween(pixels) + 1 };
}

} // namespace

TransferFunction2D convertTransferFunction2D(vtkVolumeProperty* property, const TransferRange2D& range)
{
  checkUnitDistance(property, 0);
  const Pixels pixels(property->GetTransferFunction2D(0));
  const double unitDistance = property->GetScalarOpacityUnitDistance(0);
  const TransferFunction2D::Axis first = axisOf(pixels.size(0), range[0], range[1]);
  const TransferFunction2D::Axis second = axisOf(pixels.size(1), range[2], range[3]);
  const int columnSteps = stepsBetween(pixels.size(0));
  const int rowSteps = stepsBetween(pixels.size(1));
  std::vector<TransferFunction2D::Entry> entries;
  if (first.size <= TransferFunction2D::mostEntries / second.size) // else it is refused
  {
    entries.reserve(first.size * second.size);
  }
  for (int row = 0; row < static_cast<int>(second.size) && entries.capacity() > 0; ++row)
  {
    const int y = row / rowSteps;
    const double rowPart = static_cast<double>(row % rowSteps) / rowSteps;
    for (int column = 0; column < static_cast<int>(first.size); ++column)
    {
      const int x = column / columnSteps;
      const double part = static_cast<double>(column % columnSteps) / columnSteps;
      const Pixel pixel = between(between(pixels.at(x, y), pixels.at(x + 1, y), part),
        between(pixels.at(x, y + 1), pixels.at(x + 1, y + 1), part), rowPart);
      entries.push_back({ static_cast<float>(pixel[0]), static_cast<float>(pixel[1]),
        static_cast<float>(pixel[2]), TransferFunction::extinctionFromOpacity(pixel[3], unitDistance) });
    }
  }
  return TransferFunction2D(first, second, std::move(entries));
}

} // namespace treeamr
