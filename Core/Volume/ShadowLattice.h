// How much of a light comes through a volume, at the nodes of a regular lattice over its domain: what scattered light is
// dimmed by. However fine the octree, of a fixed number of nodes, so that frames with shadows stay interactive.
#pragma once

#include "Field/Field.h"
#include "Field/TransferFunction.h"
#include "Geometry/Vec3.h"
#include "LargeArray.h"
#include "Volume/VolumeSettings.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace treeamr
{

class IntegralTable;

class ShadowLattice
{
public:
  /// Cells of the lattice along the longest edge of the domain. They are about as wide along the others.
  static constexpr int cellsAcross = 96;

  /// Mean extinctions around the nodes. integrals: of the transfer function. Where its extinction depends on the gradient,
  /// also by that.
  ShadowLattice(const Field& field, const TransferFunction& transferFunction, const IntegralTable& integrals,
    const std::optional<GradientOpacity>& gradientOpacity);

  /// In data coordinates.
  struct Source
  {
    bool isPositional;
    Vec3 place; // where it is, or the way its light travels

    bool operator==(const Source&) const = default;
  };

  /// Finds what comes through from each light, unless it is there. What lies nearer to a node than the lattice's cells are
  /// wide does not dim it: coarse cells of what is opaque would shade themselves. reach: the longest way that dims, where
  /// the domain is a cube of width 1. worldPerData: lengths that extinctions count.
  void illuminate(const std::vector<Source>& sources, double reach, double worldPerData);

  /// Lights that it was illuminated by.
  std::size_t lights() const noexcept { return sources_.size(); }
  /// Of a light, for each node, x fastest: 0 to 1. Where nothing is visible nearby, 1.
  const float* transmittance(std::size_t light) const noexcept { return transmittances_[light].data(); }
  /// Along the axes, two at least.
  const std::array<int, 3>& nodes() const noexcept { return nodes_; }
  /// Where the first node is, and the width of cells.
  const Vec3& origin() const noexcept { return origin_; }
  const Vec3& cell() const noexcept { return cell_; }
  /// What it is of, besides the field and the transfer function.
  const std::optional<GradientOpacity>& gradientOpacity() const noexcept { return gradientOpacity_; }
  /// Allocated.
  std::size_t byteSize() const noexcept;

private:
  void markVisible(const Field& field, const TransferFunction& transferFunction);
  void measure(const Field& field, const IntegralTable& integrals);
  /// Rows of nodes, all of which have the same y and z.
  template <class Use>
  void forEachRow(const Use& use) const;
  std::size_t index(int x, int y, int z) const noexcept
  {
    return (static_cast<std::size_t>(z) * nodes_[1] + y) * nodes_[0] + x;
  }
  float extinctionAt(const std::array<float, 3>& place) const noexcept;
  /// From a node towards a source.
  struct Way
  {
    std::array<float, 3> perStep{}; // in cells
    double step = 0.;               // of data coordinates
    double steps = 0.;              // from the first one's end on; 0: nothing dims
  };
  Way wayFrom(const std::array<int, 3>& node, const Source& source) const noexcept;
  float partOfLastStep(const std::array<int, 3>& node, const Way& way) const noexcept;
  float comesThrough(const std::array<int, 3>& node, const Source& source) const noexcept;
  void shineAlong(int y, int z, const Source& source, float* transmittance) const;

  std::array<int, 3> nodes_{};
  Vec3 origin_{};
  Vec3 cell_{};
  std::optional<GradientOpacity> gradientOpacity_;
  std::vector<std::uint8_t> isVisible_; // something is, within a cell of the node
  LargeVector<float> extinctions_;      // per world length
  std::vector<LargeVector<float>> transmittances_;
  std::vector<Source> sources_; // of these, with:
  double reach_ = 0.;
  double worldPerData_ = 0.;
};

} // namespace treeamr
