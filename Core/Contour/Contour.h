// The isosurface of a reconstructed field as triangles, watertight across refinement levels of any jump.
//
// Where Isosurface.h answers rays, this is for export, measurement and other filters.
#pragma once

#include "Field/Field.h"
#include "Partition/LatticeBox.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace treeamr
{

/// Triangles that share their points. Normals by the right-hand rule point to lower values.
///
/// Every edge has two triangles, but for edges on the domain's boundary, on faces towards missing cells and
/// on faces towards ghosts, which have one.
struct ContourMesh
{
  /// The inner node in or beside whose children the points from firstPoint up to the next block's lie.
  struct Block
  {
    std::array<Coord, 3> index{}; // on the lattice of its depth
    int depth = 0;                // from the octree's padded root
    std::int64_t firstPoint = 0;  // in the mesh's points
  };

  std::vector<std::array<double, 3>> points;          // world coordinates
  std::vector<std::array<std::int64_t, 3>> triangles; // of points
  std::vector<std::array<double, 3>> gradients;       // at the points, per world coordinate; only on request
  std::vector<Block> blocks;                          // what interpolate() starts from
  std::optional<Identity> octree;                     // whose nodes the blocks are
};

/// What contour() makes, and how it can be followed.
struct ContourOptions
{
  bool gradients = false; // whether the mesh has them
  /// The part of one of many processes, which holds what FieldSupport.h says: the parts of boxes that fill the domain make the
  /// surface, each triangle once, with the same points, bit for bit. None: all of it.
  std::optional<LatticeBox> box = {};
  /// Called now and then by the calling thread with the share that is done, 0 to 1; false: stop.
  std::function<bool(double)> progress = {};
};

/// The surface where the field passes the isovalue, rounded as values are; at the isovalue is inside. A point on an edge of an
/// octant lies where the trilinear field has the isovalue, but at least 2^-24 of the edge away from its ends:
/// nothing collapses where vertices have the isovalue. Gradients are continuous across all levels: interpolated
/// between those of the vertices (BlockGradients.h).
///
/// The same bits for any number of threads. Empty when stopped. Throws Error when the isovalue is not finite.
ContourMesh contour(const Field& field, double isovalue, const ContourOptions& options = {});

/// A field's values, less its offset, at the points of a mesh that contour() made on the same octree. Throws Error for
/// another one.
std::vector<float> interpolate(const Field& field, const ContourMesh& mesh);

} // namespace treeamr
