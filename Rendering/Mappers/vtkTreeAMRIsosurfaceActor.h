/**
 * @class   vtkTreeAMRIsosurfaceActor
 * @brief   actor of a vtkTreeAMRIsosurfaceMapper that VTK's exporters write
 *
 * GetActors(), which exporters (glTF, OBJ, X3D, VRML and others of vtkExporter) get their geometry by, gives
 * an actor of polygons in the place of this one: of the same matrix, property and visibility, with the
 * triangles of vtkTreeAMRContourFilter in the colours and opacities that the mapper shows. They are computed
 * when an exporter updates that actor's mapper, not before, and kept until this actor is rendered again. A
 * process that has not all of the grid may give exporters other triangles, those of all processes.
 *
 * Translucent surfaces that VTK has nothing to sort with it draws when volumes are drawn, which takes no depth peeling;
 * behind what is opaque, where such actors come last in the renderer and it has no volume. Meanwhile they are not
 * translucent polygons.
 *
 * In everything else it is a vtkActor: with another mapper, when rendered, selected or picked, and in
 * vtkRenderer::GetViewProps(). vtkRenderer::GetActors() contains the actor of polygons, which the next
 * GetActors() sets as this one is: change this one.
 */

#ifndef vtkTreeAMRIsosurfaceActor_h
#define vtkTreeAMRIsosurfaceActor_h

#include "vtkOpenGLActor.h"
#include "vtkSmartPointer.h"           // for ExportedTriangles
#include "vtkTreeAMRRenderingModule.h" // for the export macro

#include <memory> // for std::unique_ptr

class vtkAlgorithm;
class vtkPolyData;

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRIsosurfaceActor : public vtkOpenGLActor
{
public:
  static vtkTreeAMRIsosurfaceActor* New();
  vtkTypeMacro(vtkTreeAMRIsosurfaceActor, vtkOpenGLActor);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The triangles of the mapper's own grid, up to date. Null: the mapper is another, or its grid has no
  /// trees.
  vtkPolyData* GetTriangles();
  /// What exporters get in the place of those: the output of this algorithm. It is told that it is Modified()
  /// when the actor is rendered. The actor may be visible without a grid then, and draws nothing. Null, the
  /// default: their own.
  void SetExportedTriangles(vtkAlgorithm* triangles);
  /// Of the last export, for which there is no use any more.
  void ReleaseTriangles();

  /// What exporters write: an actor of the triangles, or itself where there are none.
  void GetActors(vtkPropCollection* actors) override;
  /// Releases what the last export made.
  void Render(vtkRenderer* renderer, vtkMapper* mapper) override;
  /// Whether light comes through, whatever of the frame is drawn.
  bool IsTranslucent();
  /// Not while a frame draws it behind what is opaque.
  vtkTypeBool HasTranslucentPolygonalGeometry() override;
  /// Opaque surfaces, and translucent ones of a renderer in which such actors come last.
  int RenderOpaqueGeometry(vtkViewport* viewport) override;
  /// Translucent surfaces with which VTK has nothing to sort are drawn here, in the place of its translucent pass. They
  /// are no volume: always 0.
  int RenderVolumetricGeometry(vtkViewport* viewport) override;

protected:
  vtkTreeAMRIsosurfaceActor();
  ~vtkTreeAMRIsosurfaceActor() override;

private:
  struct Polygons;

  Polygons* UpdatePolygons();

  std::unique_ptr<Polygons> Exported; // once an exporter has asked
  vtkSmartPointer<vtkAlgorithm> ExportedTriangles;
  bool IsDrawn = false; // from when a frame draws what is opaque until it draws volumes: this, too

  vtkTreeAMRIsosurfaceActor(const vtkTreeAMRIsosurfaceActor&) = delete;
  void operator=(const vtkTreeAMRIsosurfaceActor&) = delete;
};

#endif
