// Every volume kernel that a frame may be rendered by.
#pragma once

#include "Support/Targets.h"
#include "Volume/VolumeSettings.h"

#include <string>

namespace treeamr::test
{

/// Calls f with settings that ask for float lanes, where these will do, and such that ask for double ones.
template <class F>
void inFloatsAndDoubles(VolumeSettings settings, const F& f)
{
  for (const bool doubles : { false, true })
  {
    settings.doubles = doubles;
    f(settings);
  }
}

/// Calls f with the name of each kernel, of float and of double lanes on each instruction set, and settings that ask
/// for it.
template <class F>
void forEachKernel(const VolumeSettings& settings, const F& f)
{
  forEachTarget([&](const char* target) {
    inFloatsAndDoubles(settings, [&](const VolumeSettings& ofKernel) {
      f(std::string(target) + (ofKernel.doubles ? " in doubles" : " in floats"), ofKernel);
    });
  });
}

} // namespace treeamr::test
