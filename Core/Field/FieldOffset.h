// What a field's values are stored less, where floats would not hold their digits.
#pragma once

namespace treeamr
{

/// The offset of a field whose values are from base + least to base + greatest, by the floats least and greatest that
/// are stored with the offset `base`: `base` itself where it will do.
///
/// Without one (0) floats lose half a step of the largest value. That will do up to 2^-16 of the range, so that what
/// floats can tell apart is stored as it is; one value that lies far out makes the range, and so do all others lose
/// their digits. Otherwise the offset is the middle of the range, rounded to a multiple of a power of two about as
/// large as the range (whole for a range of whole numbers, and mostly the same for all parts of a data set): floats
/// relative to it lose at most 2^-24 of the range. Of one value alone it is that value.
double offsetFor(double least, double greatest, double base = 0.) noexcept;

} // namespace treeamr
