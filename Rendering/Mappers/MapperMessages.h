// What a mapper has to say, each thing once until it goes away. Private to the module.
#pragma once

#include "LostDigits.h"
#include "OnceReporter.h"
#include "UnsupportedSettings.h"

#include "vtkObject.h"

#include <algorithm>
#include <exception>

namespace treeamr
{

class MapperMessages
{
public:
  /// `speaker` is named, and tells its observers; not owned.
  explicit MapperMessages(vtkObject* speaker)
    : speaker_(speaker)
  {
  }
  /// Of whatever ended a frame; nothing where there is nothing to draw.
  void error(const std::exception& error);
  /// Nothing when there is no text.
  void warning(const Remark& remark);
  /// Settings that have no effect, each but once.
  void unsupported(const SettingNames& names);

  /// What has not come up since the last call has gone away.
  void endErrors() { errors_.endRound(); }
  void endWarnings() { warnings_.endRound(); }

private:
  vtkObject* speaker_;
  OnceReporter errors_;
  OnceReporter warnings_;
  SettingWarnings settings_;
};

/// As vtkSetClampMacro, with a warning that tells what is allowed when that is something else. NaN is left for the frame to
/// refuse.
template <class Value>
void setWithin(vtkObject* owner, const char* name, Value& setting, Value value, Value least, Value most)
{
  if (value < least || value > most)
  {
    vtkWarningWithObjectMacro(owner, << name << ' ' << value << ", allowed are " << least << " to " << most
                                     << ", the nearest of which is taken");
  }
  if (const Value allowed = std::clamp(value, least, most); setting != allowed)
  {
    setting = allowed;
    owner->Modified();
  }
}

} // namespace treeamr
