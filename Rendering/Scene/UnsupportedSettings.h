// What VTK lets users set and the mappers do not do: said once, never silently left out. Private to the
// module.
#pragma once

#include <set>
#include <string>
#include <vector>

class vtkActor;
class vtkMapper;
class vtkVolume;
class vtkVolumeMapper;

namespace treeamr
{

/// VTK's names of what a scene asks for in vain; behind ": " what it would take, else there is no such thing.
using SettingNames = std::vector<std::string>;

/// What a volume mapper draws.
struct DrawnVolume
{
  bool categories;  // cells are constant, without gradients
  bool surfaces;    // isosurfaces are shown
  bool dependent;   // components of an array together: two are colour and opacity, four are these themselves
  bool independent; // each of several components by functions of its own
  bool scatters;    // light, where it is shaded
  bool table;       // by the function of two values
};

/// Empty for VTK's defaults. Selections, which pass through volumes, are no setting: one makes them for what
/// else there is.
SettingNames unsupportedSettings(vtkVolume* volume, vtkVolumeMapper* mapper, const DrawnVolume& drawn);
SettingNames unsupportedSettings(vtkActor* actor, vtkMapper* mapper);

/// Says each once.
class SettingWarnings
{
public:
  /// Calls warn(message) for each name that is new.
  template <class Warn>
  void add(const SettingNames& names, const Warn& warn)
  {
    for (const std::string& name : names)
    {
      if (said_.insert(name).second)
      {
        warn(name + (name.find(": ") == std::string::npos ? ": not implemented, without effect." : "."));
      }
    }
  }

private:
  std::set<std::string> said_;
};

} // namespace treeamr
