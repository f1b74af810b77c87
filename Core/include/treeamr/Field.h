// TreeAMR: scalar fields on octrees.
//
// A program has cells of an adaptive grid: boxes of a lattice of root trees, each root halved along all axes as often as
// wanted (LeafCell: level 0 is a root, level l has 2^l cells along a root's edge). buildOctree() makes the topology of
// them, which all fields share, and puts their values into its order; a Field is one scalar a cell:
//
//   std::vector<treeamr::LeafCell> cells; // { { { i, j, k }, level }, value }, in any order, at most 2^56
//   auto built = treeamr::buildOctree(
//     treeamr::RootGrid::uniform({ 4, 4, 2 }, { 0., 0., 0. }, { 1., 1., 1. }), std::move(cells));
//   auto field = std::make_shared<const treeamr::Field>(built.octree, std::move(built.values));
//
// Coordinates are double precision, in whatever unit of length the RootGrid is given; values single precision, finite.
// Doubles or 64-bit integers that lie close together beside their size, of which floats would tell few apart, are given
// less an offset (which is 0 where they are not):
//
//   const double offset = treeamr::offsetFor(least, greatest); // of all values
//   ... static_cast<float>(value - offset) ...                 // as the cells' values
//   auto field = std::make_shared<const treeamr::Field>(built.octree, std::move(built.values), offset);
//
// Values at the corners of cells (finite elements Q1), by leaf of the octree, make a field that is trilinear in each:
//
//   auto field = std::make_shared<const treeamr::Field>(treeamr::Field::ofCorners(
//     built.octree, [&](std::uint64_t leaf) { return std::array<float, 8>{ ... }; })); // x fastest, then y
//
// Isovalues and the values that samplers give are the field's own again; other headers say what is less its offset.
// Regions of the lattice may be without cells. Between the cells' centres the field is reconstructed by Generalized
// Trilinear Interpolation, continuous across levels. Memory: under 6 bytes a cell for one field, under 5 for each
// further one, 13 to 20 with corners. Objects are immutable once made and may be used by several threads.
//
// Errors: what is not allowed is a treeamr::Error (a std::runtime_error, <treeamr/Error.h>) that names the object, what
// was found and what is allowed; too little memory is std::bad_alloc. So it is in all of these headers.
#pragma once

#include "Error.h"
#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"
