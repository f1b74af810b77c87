# The ParaView plugin, linked to the libraries of TreeAMRLayers.cmake.

paraview_plugin_scan(
  PLUGIN_FILES "${CMAKE_CURRENT_SOURCE_DIR}/paraview.plugin"
  PROVIDES_PLUGINS plugins
  ENABLE_BY_DEFAULT ON
  HIDE_PLUGINS_FROM_CACHE ON)
# paraview_plugin_build() adds the folder of the plugin file, which is this very project: point it to Plugin/.
# It uses nothing but the folder of this name.
set_property(GLOBAL
  PROPERTY _paraview_plugin_TreeAMR_file "${CMAKE_CURRENT_SOURCE_DIR}/Plugin/paraview.plugin")
paraview_plugin_build(
  PLUGINS ${plugins}
  PLUGINS_FILE_NAME treeamr.plugins.xml
  AUTOLOAD ${plugins}
  LIBRARY_SUBDIRECTORY "${PARAVIEW_PLUGIN_SUBDIR}")
set(TREEAMR_PLUGIN_DIR "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}")
