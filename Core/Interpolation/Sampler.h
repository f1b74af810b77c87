// Values and gradients of the reconstructed field at points: the paper's five methods behind one interface.
//
// nearest  the cell's value
// current  trilinear on the dual grid of the cell's own level (Wald et al. 2017)
// finest   trilinear on the dual grid of the finest level around the point (Wald et al. 2017)
// octant   continuous and adaptive, equal weights at level boundaries (Wang et al. 2019)
// GTI      the paper's generalized trilinear interpolation
// A corner of a dual cell without a cell takes no part: the others' weights are renormalised.
// Of a field that is given at corners GTI stands for what it is, trilinear in each cell; the others know cells' means alone.
#pragma once

#include "Field/Field.h"

#include <array>
#include <memory>
#include <utility>

namespace treeamr
{

/// Between cells' centres, as described above.
enum class InterpolationMethod
{
  Nearest, // discontinuous
  Current, // discontinuous where levels meet, as Finest
  Finest,
  Octant, // continuous
  GTI     // continuous, and exact for trilinear fields
};

/// Of the field at a point.
struct FieldSample
{
  double value = 0.;                // in the field's unit
  std::array<double, 3> gradient{}; // d value / d world coordinate
};

/// One of the methods for one field, which it keeps.
class Sampler
{
public:
  virtual ~Sampler() = default;
  /// False, and `sample` untouched, where there is no cell (cells are closed boxes) or pWorld is not finite.
  /// Safe from several threads.
  bool sample(const std::array<double, 3>& pWorld, FieldSample& sample) const
  {
    if (!this->sampleRelative(pWorld, sample))
    {
      return false;
    }
    sample.value += field_->offset();
    return true;
  }
  /// The same with the value less the field's offset.
  virtual bool sampleRelative(const std::array<double, 3>& pWorld, FieldSample& sample) const = 0;

  /// Throws Error without a field.
  static std::unique_ptr<Sampler> create(InterpolationMethod method, std::shared_ptr<const Field> field);

protected:
  explicit Sampler(std::shared_ptr<const Field> field)
    : field_(std::move(field))
  {
  }
  const Field& field() const noexcept { return *field_; }

private:
  std::shared_ptr<const Field> field_;
};

/// The cell that holds a point, as a sampler finds it. False, and `cell` untouched, where there is none.
bool findCell(const Octree& octree, const std::array<double, 3>& pWorld, CellId& cell);

} // namespace treeamr
