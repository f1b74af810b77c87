#include "MapperMessages.h"

#include "HyperTreeGridConverter.h"
#include "MapperInput.h"

#include "vtkObject.h"

#include <string>

namespace treeamr
{

void MapperMessages::error(const std::exception& error)
{
  if (dynamic_cast<const NoCells*>(&error))
  {
    return;
  }
  const char* const message = describe(error);
  if (errors_.isNews(message))
  {
    vtkErrorWithObjectMacro(speaker_, << message);
  }
}

void MapperMessages::warning(const Remark& remark)
{
  if (!remark.text.empty() && warnings_.isNews(remark.about))
  {
    vtkWarningWithObjectMacro(speaker_, << remark.text);
  }
}

void MapperMessages::unsupported(const SettingNames& names)
{
  settings_.add(
    names, [this](const std::string& message) { vtkWarningWithObjectMacro(speaker_, << message); });
}

} // namespace treeamr
