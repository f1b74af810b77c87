// Checkpoints of deal.II: two bytes of how many NAME.info has, two of how many NAME has, one of the payload's text; then
// NAME.info, NAME and NAME_fixed.data one after the other.
#include "FuzzInput.h"

#include "vtkTreeAMRP4estReader.h"

#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <array>

using namespace treeamr;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  constexpr std::array payloads = { "", "double u = FE_Q(1)", "double u = FE_DGQ(0)",
    "double u = FE_Q(1) corners", "double u, v = FE_Q(2); skip",
    "float u(a, b) = FESystem<3>[FE_Q<3>(2)^3-FE_Q<3>(1)]", "skip; unsigned m" };
  const fuzz::HeapWatch watch(size);
  fuzz::Bytes bytes{ data, size };
  const auto takeSize = [&] {
    const unsigned low = bytes.takeByte();
    return low + 256u * bytes.takeByte();
  };
  const std::size_t infoSize = takeSize();
  const std::size_t forestSize = takeSize();
  const char* const payload = payloads[bytes.takeByte() % payloads.size()];
  const fuzz::Bytes info = bytes.take(infoSize);
  const fuzz::Bytes forest = bytes.take(forestSize);
  const std::string folder =
    fuzz::writeFiles({ { "name.info", info }, { "name", forest }, { "name_fixed.data", bytes } });
  vtkNew<vtkTreeAMRP4estReader> reader;
  reader->SetFileName((folder + "name.info").c_str());
  reader->SetPayload(payload);
  reader->Update();
  fuzz::require((reader->GetErrorCode() == 0) == (reader->GetHyperTreeGridOutput()->GetNumberOfLeaves() > 0),
    "either an error or a grid");
  return 0;
}
