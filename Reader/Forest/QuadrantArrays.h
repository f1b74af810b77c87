// Arrays in files beside a forest, one value, or several, for each quadrant in the forest's order: what programs write
// that save their forests without data.
//
// The text lists them:
//   density.npy; u = velocity.npy; double pressure = p.raw; float b[3] = {}_field.raw
// Files of numpy (numpy.lib.format: little-endian or single bytes, one axis or two of C order) say their type; the array's
// name is the file's, unless another one is given. Raw files hold nothing but values in this machine's byte order, of a
// type and components as PayloadLayout.h has them. Paths are from the forest's folder; {} in them is the forest's file
// name without its extension, for series.
#pragma once

#include "Forest/PayloadLayout.h"
#include "Forest/QuadrantRecords.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace treeamr
{

/// As the text has it.
struct QuadrantArray
{
  PayloadField field; // of numpy's files the name alone
  bool isNumpy;
  std::string path;
};

/// Throws Error naming the part that is none, what was found and what is allowed; for names that are there twice, too.
std::vector<QuadrantArray> parseQuadrantArrays(std::string_view text);

/// Of one.
class QuadrantArrayFile
{
public:
  /// Throws Error naming the file, what was found and what is allowed: where it cannot be read, is none of numpy's, or
  /// has not one record for each quadrant.
  QuadrantArrayFile(const QuadrantArray& array, const std::string& forestPath, std::uint64_t quadrants);

  /// With an offset of 0.
  const PayloadField& field() const noexcept { return field_; }
  /// All values, quadrant by quadrant.
  const QuadrantRecords& records() const noexcept { return *records_; }

private:
  PayloadField field_;
  std::optional<QuadrantRecords> records_;
};

} // namespace treeamr
