// What deal.II attached to each cell, told by the user as text, because its files know sizes only.
//
// The text says it block by block, in the order they were attached in, as many as there are:
//   double solution, oldSolution = FE_Q(2); skip; unsigned material
// - The vectors that one SolutionTransfer took: the type of their values (double or float), a name for each and the
//   element that they are of, as deal.II's get_name() has it, with or without <3>. Of a system each part, of one component
//   or more, is an array of its own: solution_0, solution_1 ... or what is said in brackets:
//   double solution(velocity, pressure, temperature) = FESystem<3>[FE_Q<3>(2)^3-FE_Q<3>(1)-FE_Q<3>(2)]
//   An array has the function's mean over each cell (ElementMeans.h has the elements). After the word corners at the end,
//   arrays of one component of FE_Q and FE_Q_iso_Q1 have the function's values at the cell's corners instead, as eight
//   components, x fastest:
//   double temperature = FE_Q(1) corners
// - Any other data as the members of a C struct (PayloadLayout.h), in braces where there are several: { double a; int b }.
// - skip: left out.
#pragma once

#include "Forest/PayloadLayout.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace treeamr
{

struct DealIIBlock
{
  std::string text; // what of the whole is about it
  bool skipped = false;
  std::size_t size = 0; // bytes a cell, unless it is skipped
  /// Offsets are from the block's begin.
  std::vector<PayloadField> fields;
};

/// Throws Error with the block's text, the position in it (from 1), what was found there and what is allowed.
std::vector<DealIIBlock> parseDealIIBlocks(std::string_view text);

} // namespace treeamr
