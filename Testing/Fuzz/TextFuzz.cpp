// What users say of payloads, deal.II's blocks and arrays beside a forest.
#include "FuzzInput.h"

#include "Error.h"
#include "Forest/DealIIBlocks.h"
#include "Forest/PayloadLayout.h"
#include "Forest/QuadrantArrays.h"

#include <algorithm>
#include <string_view>

using namespace treeamr;

namespace
{

template <class Parse>
void tryTo(const Parse& parse)
{
  try
  {
    parse();
  }
  catch (const Error&)
  {
    // of a text that is none
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  // Each block of a text may describe as many values of a cell as are allowed, with their weights.
  const auto blocks = static_cast<std::size_t>(std::count(data, data + size, '='));
  const fuzz::HeapWatch watch(size, 128 * size + blocks * (std::size_t(2) << 20));
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  tryTo([&] { PayloadLayout::parse(text); });
  tryTo([&] { parseDealIIBlocks(text); });
  tryTo([&] { parseQuadrantArrays(text); });
  return 0;
}
