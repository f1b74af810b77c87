// What a mapper has to say, each thing once until it goes away. Private to the module.
#pragma once

#include "LostDigits.h"
#include "OnceReporter.h"
#include "UnsupportedSettings.h"

#include <exception>

class vtkObject;

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
  /// Of whatever ended a frame.
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

} // namespace treeamr
