// The isosurfaces of a field in full and in the detail of a draft. Private to the module.
#pragma once

#include "Surface/Isosurface.h"

#include <memory>
#include <vector>

namespace treeamr
{

/// Each is made when it is first asked for, and shared by all who ask for the same.
class SurfaceLevels
{
public:
  /// True when the field or the isovalues are not those of the last call: what was made of these is released.
  bool set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues);
  /// Without isovalues there is nothing to make.
  bool isEmpty() const noexcept { return isovalues_.empty(); }

  /// Null before it was asked for.
  const std::shared_ptr<const Isosurface>& madeInFull() const noexcept { return full_; }
  /// Throws Error as Isosurface(), as does ofDetail().
  const std::shared_ptr<const Isosurface>& inFull();
  /// With cells smaller than about so many pixels drawn together; the full one where there are none.
  const std::shared_ptr<const Isosurface>& ofDetail(const Camera& camera, double pixels);

private:
  std::shared_ptr<const Field> field_;
  std::vector<double> isovalues_; // as asked for
  std::shared_ptr<const Isosurface> full_;
  std::shared_ptr<const Isosurface> coarse_; // without cells deeper than
  int coarseCellDepth_ = 0;
};

} // namespace treeamr
