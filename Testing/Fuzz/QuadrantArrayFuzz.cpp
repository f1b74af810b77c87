// A file of numpy beside a forest: a byte of how many quadrants this has, then the file.
#include "FuzzInput.h"

#include "Error.h"
#include "Forest/QuadrantArrays.h"

using namespace treeamr;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const fuzz::HeapWatch watch(size);
  fuzz::Bytes bytes{ data, size };
  const std::uint64_t quadrants = bytes.takeByte();
  const std::string folder = fuzz::writeFiles({ { "values.npy", bytes } });
  try
  {
    const QuadrantArrayFile file(parseQuadrantArrays("values.npy").front(), folder + "forest", quadrants);
    const std::size_t record =
      static_cast<std::size_t>(file.field().components) * payloadTypeSize(file.field().type);
    unsigned sum = 0;
    file.records().visit(0, quadrants, [&](const std::byte* values) {
      for (std::size_t i = 0; i < record; ++i)
      {
        sum += std::to_integer<unsigned>(values[i]); // which a sanitizer watches
      }
    });
    fuzz::require(sum <= 255 * size, "values are those of the file");
  }
  catch (const Error&)
  {
    // of a file that is none
  }
  return 0;
}
